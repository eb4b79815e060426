"""``fastlines-bench engine``: queries of our trees and of Embree, alternated on the same rays."""

from .preset import EnginePreset
from .run import run_engine
from .show import draw, print_tables

__all__ = ["EnginePreset", "draw", "print_tables", "run_engine"]
