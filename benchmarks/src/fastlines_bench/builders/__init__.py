"""``fastlines-bench builders``: the build time, cost and query times of each builder's tree."""

from .run import BuildersPreset, run_builders
from .show import draw_builders, print_builders

__all__ = ["BuildersPreset", "draw_builders", "print_builders", "run_builders"]
