"""The command line, ``fastlines``: a function for each command, in a module for one or two of them."""

from .app import app, main

__all__ = ["app", "main"]
