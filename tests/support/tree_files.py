"""Tree files to break, and what must come of it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support import nasty

import fastlines as fl
from fastlines.support import container

RNG = np.random.default_rng(0)
SEGMENTS = nasty.crossing(RNG, 20).astype(np.float32)
RAYS = nasty.from_distance(1)(RNG, SEGMENTS.astype(float), 60, 2.0)


def saved(path: Path, **settings: Any) -> tuple[fl.Tree, bytes]:
    lines = fl.Lines.from_segments(
        SEGMENTS,
        strands=np.arange(20) // 3,
        radius=np.linspace(0.1, 1, 40).reshape(20, 2),
        attributes={"id": range(20)},
    )
    tree = fl.build(lines, **{"splits": fl.PlaneGrid(16), "limits": fl.Limits(max_refs=100), **settings})
    tree.save(path)
    return tree, path.read_bytes()


def split(data: bytes) -> tuple[dict[str, Any], bytes]:
    """Return the header and the body of a file."""
    length = int.from_bytes(data[:8], "little")
    return json.loads(data[8 : 8 + length]), data[8 + length :]


def joined(header: Any, body: bytes) -> bytes:
    text = header if isinstance(header, bytes) else json.dumps(header).encode()
    text += b" " * (-(8 + len(text)) % 64)
    return len(text).to_bytes(8, "little") + text + body


def same_answers(a: fl.Tree, b: fl.Tree) -> bool:
    one, other = (tree.all_hits(*RAYS, 0.1, at="surface") for tree in (a, b))
    return all(
        getattr(one, name).tobytes() == getattr(other, name).tobytes()
        for name in ("offsets", "t", "prim", "u", "distance", "t_out")
    )


def refused(path: Path, data: bytes) -> None:
    """Whether checksums are verified or not."""
    path.write_bytes(data)
    for verify in (False, None):
        with pytest.raises(fl.FileFormatError) as caught:
            fl.load(path, verify=verify)
        text = str(caught.value)
        assert path.name in text
        assert "\n" not in text
        assert len(text) < 1000


def with_metadata(header: dict[str, Any], **changed: Any) -> dict[str, Any]:
    return {**header, "__metadata__": {**header["__metadata__"], **changed}}


def rewritten(tree: fl.Tree, path: Path, **arrays: Any) -> Path:
    """Save a tree with some of its arrays changed."""
    tree.save(path)
    found, metadata = container.read(path)
    container.write(path, {**found, **arrays}, metadata)
    return path
