"""``fastlines-bench growth``: the cost of a ray as the scene grows, and the speed-up by threads."""

from .run import GrowthPreset, run_growth
from .show import draw_growth, print_growth

__all__ = ["GrowthPreset", "draw_growth", "print_growth", "run_growth"]
