"""Files of the stages of a build: arrays and facts, in the container of tree files."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ...arrays import AnyArray
from ...support import container

#: Where a container keeps the facts.
FACTS = "facts"


def write_stage(path: Path, arrays: Mapping[str, AnyArray], facts: Mapping[str, Any], *, durable: bool = True) -> None:
    """Write a file, whole or not at all; if it is durable, it outlives a power failure once this returns."""
    # Write larger numbers first, so that each section is aligned for its type.
    kept = dict(sorted(arrays.items(), key=lambda item: -item[1].dtype.itemsize))
    container.write(path, kept, {FACTS: json.dumps(facts)}, durable=durable)


def read_stage(path: Path, *, verify: bool = False) -> tuple[dict[str, AnyArray], dict[str, Any]]:
    """Map the arrays of a file, and read its facts; raise a FileFormatError if it is damaged."""
    arrays, metadata = container.read(path, verify)
    return {name: values for name, values in arrays.items() if name != container.CHECKSUMS}, json.loads(metadata[FACTS])


def same_rows(path: Path, arrays: Mapping[str, AnyArray]) -> bool:
    """Return whether a file holds these arrays, by their checksums."""
    known, _ = container.read(path, verify=False)
    sums = known.pop(container.CHECKSUMS)[1:].reshape(-1).view("<u4")
    expected = {
        name: (values.dtype, values.shape, int(found))
        for (name, values), found in zip(known.items(), sums, strict=True)
    }
    return expected == {
        name: (values.dtype, values.shape, container.checksum(np.ascontiguousarray(values)))
        for name, values in arrays.items()
    }
