"""``fastlines-bench engine``: queries of our trees beside Embree's, in turn, on the same rays."""

from .run import EnginePreset, run_engine
from .show import draw, print_tables

__all__ = ["EnginePreset", "draw", "print_tables", "run_engine"]
