"""Files that appear whole or not at all."""

from __future__ import annotations

import os
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def whole(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Give a new file beside the real one to write to; it takes the real one's place once it is whole."""
    target = Path(path)
    partial = target.with_name(f"{target.name}.{uuid.uuid4().hex[:12]}.partial")
    try:
        partial.touch(exist_ok=False)  # says why not if it can not be written
        yield partial
        partial.replace(target)
    finally:
        partial.unlink(missing_ok=True)
