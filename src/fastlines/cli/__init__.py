"""The command line, ``fastlines``: a module a command; ``demo`` and ``report`` share one."""

from .app import app, main

# Each import adds a command; the help lists them in this order.
from . import demo, scene, info, build, validate, query, render  # isort: skip  # noqa: F401

__all__ = ["app", "main"]
