"""The command line, ``fastlines``: one module a command."""

from .app import app, main

# Each import adds a command; the help lists them in this order.
from . import demo, report, scene, info, build, validate, query, render  # isort: skip  # noqa: F401

__all__ = ["app", "main"]
