"""Pages about trees: the five scenes side by side (``fastlines demo``), and which tree suits some lines."""

from .run import FULL, QUICK, Preset, demo_page, report_page

__all__ = ["FULL", "QUICK", "Preset", "demo_page", "report_page"]
