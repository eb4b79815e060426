"""The report: the thesis's chapter 6 made again and checked, or the same questions about lines of somebody's own."""

from .plan import FULL, QUICK, Plan
from .run import missing_peer, report_lines, report_thesis

__all__ = ["FULL", "QUICK", "Plan", "missing_peer", "report_lines", "report_thesis"]
