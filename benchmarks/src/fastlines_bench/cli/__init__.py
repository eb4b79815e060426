"""The command line ``fastlines-bench``: one module for each command."""

from .app import app, main

# Each import adds a command; the help lists them in this order.
from . import engine, builders, growth, refit, sweep, gap, steps, thesis, files, hair, mitsuba, copies, study  # isort: skip  # noqa: F401
from . import cuda  # isort: skip  # noqa: F401

__all__ = ["app", "main"]
