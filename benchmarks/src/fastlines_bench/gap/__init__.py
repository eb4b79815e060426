"""``fastlines-bench gap``: how far builders are from the optimum, on tiny inputs."""

from .run import GapPreset, run_gap
from .show import draw_gap, print_gaps

__all__ = ["GapPreset", "draw_gap", "print_gaps", "run_gap"]
