"""Files with random damage, of which a reader may only say that they are damaged."""

from __future__ import annotations

import numpy as np

from fastlines.errors import FastlinesError

#: What text is damaged with.
WORDS = [
    b"-1",
    b"0",
    b"9" * 30,
    b"1e400",
    b"nan",
    b"x",
    b"\n",
    b" ",
    b"",
    b"[",
    b"]",
    b'"',
    b"#",
    b"\0",
    b"\xff",
    b"/",
    b"\\",
]


def damaged(data: bytes, rng: np.random.Generator, *, text: bool) -> bytes:
    """Return data with one to three bytes changed; of text, some words and bytes cut out, doubled or replaced."""
    changed = bytearray(data)
    for _ in range(rng.integers(1, 4)):
        at = int(rng.integers(len(changed))) if changed else 0
        if not text:
            changed[at] = rng.integers(256) if rng.random() < 0.5 else changed[at] ^ 1 << rng.integers(8)
            continue
        n = int(rng.integers(0, 12))
        kind = rng.integers(4)
        if kind == 0:
            del changed[at : at + n]
        elif kind == 1:
            changed[at:at] = changed[at : at + n]
        elif kind == 2:
            changed[at : at + min(n, 3)] = WORDS[rng.integers(len(WORDS))]
        else:
            changed[at : at + 1] = bytes([rng.integers(256)])
    return bytes(changed) or b"\n"


def mutate(load, data: bytes, name: str, *, text: bool = False, n: int = 300, seed: int = 2024, **options) -> int:
    """Read damaged files; return how many could be read. Errors other than the package's own fall through."""
    rng = np.random.default_rng(seed)
    n_read = 0
    for trial in range(n):
        try:
            load(damaged(data, rng, text=text), name, invalid=("error", "skip")[trial % 2], **options)
            n_read += 1
        except FastlinesError as error:
            message = str(error)
            if "\n" in message:
                raise ValueError(f"trial {trial}: the error has several lines: {message!r}") from None
    return n_read
