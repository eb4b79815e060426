"""The command line, ``fastlines``: a module for each command or two."""

from .app import app, main

# Each import adds a command; the help lists them in this order.
from . import demo, build, info, convert, query, render  # isort: skip  # noqa: F401

__all__ = ["app", "main"]
