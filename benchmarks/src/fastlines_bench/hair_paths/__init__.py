"""Path-traced hair beside Mitsuba 3: the same picture, and the time of it and of its rays."""

from .report import draw_paths, print_paths
from .run import PathsPreset, PathsResult, run_paths

__all__ = ["PathsPreset", "PathsResult", "draw_paths", "print_paths", "run_paths"]
