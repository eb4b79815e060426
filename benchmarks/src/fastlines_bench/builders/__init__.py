"""``fastlines-bench builders`` and ``calibrate``: build times, costs and query times of trees, and their predictors."""

from .calibrate import CalibratePreset, run_calibrate
from .calibrate_table import print_calibration
from .run import BuildersPreset, run_builders
from .show import draw_builders, print_builders

__all__ = [
    "BuildersPreset",
    "CalibratePreset",
    "draw_builders",
    "print_builders",
    "print_calibration",
    "run_builders",
    "run_calibrate",
]
