"""Damaged copies of a file: the same ones in each run."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from fastlines.errors import FastlinesError

#: Bytes that mean something in text formats.
MARKS = b"0123456789.-+eE,;:()[]{}<>/\"' \n\t\0\xff"


def mutations(data: bytes, n: int, seed: int = 0) -> Iterator[bytes]:
    """Yield n copies in which some bytes are changed, left out, repeated, or moved elsewhere."""
    rng = np.random.default_rng(seed)
    for _ in range(n):
        copy = bytearray(data)
        for _ in range(rng.integers(1, 4)):
            start = int(rng.integers(len(copy) + 1))
            stop = min(len(copy), start + int(rng.integers(1, 1 + (1, 1, 8, 40)[rng.integers(4)])))
            part = bytes(copy[start:stop])
            match rng.integers(5):
                case 0:
                    copy[start:stop] = bytes(rng.integers(256, size=len(part), dtype=np.uint8))
                case 1:
                    copy[start:stop] = bytes(rng.choice(list(MARKS), size=len(part)).astype(np.uint8))
                case 2:
                    del copy[start:stop]
                case 3:
                    copy[start:start] = part
                case 4:
                    at = int(rng.integers(len(copy) + 1))
                    copy[at:at] = part
        yield bytes(copy) or b" "


def mutate(load, data: bytes, name: str, *, n: int = 300, seed: int = 2024, **options) -> int:
    """Read damaged files; return how many could be read. Errors other than the package's own fall through."""
    n_read = 0
    for trial, damaged in enumerate(mutations(data, n, seed)):
        try:
            load(damaged, name, invalid=("error", "skip")[trial % 2], **options)
            n_read += 1
        except FastlinesError as error:
            message = str(error)
            if "\n" in message:
                raise ValueError(f"trial {trial}: the error has several lines: {message!r}") from None
    return n_read
