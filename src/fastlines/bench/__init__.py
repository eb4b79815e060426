"""Benchmarks: fastlines beside its peers, on the same rays, answers compared while the clock runs."""

from .engine import Case, Cell, Plan, Result, Side, run_engine

__all__ = ["Case", "Cell", "Plan", "Result", "Side", "run_engine"]
