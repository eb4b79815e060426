"""Files of lines: a module for each format, and `read` and `write`, which pick one by the file's extension."""

from __future__ import annotations

from .format import AnyLines, Format
from .formats import FORMATS
from .reading import read
from .writing import write

__all__ = ["FORMATS", "AnyLines", "Format", "read", "write"]
