"""The command line ``fastlines-bench``: one module for each command."""

from .app import app, main

# Each import adds a command; the help lists them in this order.
from . import engine, nearest, pairs, beams, scale, builders, growth, refit, sweep, gap, steps, thesis  # isort: skip  # noqa: F401
from . import files, hair, mitsuba, pictures, copies, soak, faults, mutation, study, cuda  # isort: skip  # noqa: F401

__all__ = ["app", "main"]
