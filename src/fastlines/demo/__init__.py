"""The demonstration: the thesis's five trees over its five scenes, checked, timed, drawn, and written up as a page."""

from .plan import FULL, QUICK, Plan
from .run import run_demo

__all__ = ["FULL", "QUICK", "Plan", "run_demo"]
