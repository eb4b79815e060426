"""Libraries that only some functions need, and that an extra adds."""

from __future__ import annotations

import importlib
from typing import Any

from ..errors import MissingExtraError


def optional(library: str, what: str, extra: str) -> Any:
    """Import a library, or say which extra has it."""
    try:
        return importlib.import_module(library)
    except ImportError:
        raise MissingExtraError(what, extra) from None
