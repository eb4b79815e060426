"""Files of lines: a module for each format, and `read` and `write`, which pick one by the file's extension."""

from __future__ import annotations

from .format import AnyLines, Format
from .reading import format_of, read
from .table import FORMATS, extension_of, to_write
from .writing import write

__all__ = ["FORMATS", "AnyLines", "Format", "extension_of", "format_of", "read", "to_write", "write"]
