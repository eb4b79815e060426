"""``fastlines-bench growth``: what a ray costs as the scene grows, and whether threads help."""

from .run import GrowthPreset, run_growth
from .show import draw_growth, print_growth

__all__ = ["GrowthPreset", "draw_growth", "print_growth", "run_growth"]
