"""Files of lines: a module for each format, and `read` and `write`, which pick one by the file's extension."""

from __future__ import annotations

from .chunks import read_chunks
from .format import AnyLines, Format
from .reading import format_of, read
from .source import Source
from .table import extension_of, known_formats, to_write
from .writing import write

__all__ = [
    "AnyLines",
    "Format",
    "Source",
    "extension_of",
    "format_of",
    "known_formats",
    "read",
    "read_chunks",
    "to_write",
    "write",
]
