"""The file that a tree is kept in: named arrays behind a JSON header, mapped into memory when read.

The layout is that of safetensors: 8 bytes with the length of the header (little-endian), the header as JSON, then the
bytes of the arrays without gaps. The header has the dtype, shape, first and last byte of each array, and strings of the
writer under ``__metadata__``. It is padded with spaces so that the arrays start at a multiple of 64 bytes. The header
is checked against the length of the file before it is used.

The last section holds checksums (CRC-32), four bytes each: of the header with its length, then of each section before,
in their order. So whichever bit of a file is flipped, a checksum differs.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
import stat
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from ..errors import FileFormatError, InputError
from .atomic_write import atomic_write
from .named_errors import naming
from .texts import in_one_line

Arrays: TypeAlias = dict[str, npt.NDArray[Any]]

ALIGNMENT = 64
MAX_HEADER = 1 << 20
DTYPES: dict[str, np.dtype[Any]] = {
    "BOOL": np.dtype("?"),
    **{f"{kind.upper()}{8 * n}": np.dtype(f"<{kind}{n}") for kind in "iu" for n in (1, 2, 4, 8)},
    **{f"F{8 * n}": np.dtype(f"<f{n}") for n in (2, 4, 8)},
}
NAMES = {dtype: name for name, dtype in DTYPES.items()}

#: The section of checksums.
CHECKSUMS = "crc32"

#: Checksums of larger files are verified only on request: verification takes up to a second a gigabyte.
VERIFIED_BYTES = 1 << 30

#: What to do where a file is damaged.
ADVICE = "build and save the tree again"

#: How many bytes are checked at a time; Ctrl-C acts in between.
BLOCK = 1 << 26


def write(
    path: str | os.PathLike[str],
    arrays: Mapping[str, npt.NDArray[Any]],
    metadata: Mapping[str, str],
    alignment: int = ALIGNMENT,
    *,
    durable: bool = True,
) -> None:
    """Write arrays (of the types in `DTYPES`), strings and checksums; the file appears whole or not at all.

    The first array begins at a multiple of `alignment`, which is one of `ALIGNMENT`. Whether the file is `durable` is
    explained by `atomic_write`.
    """
    arrays = {name: array for name, array in arrays.items() if name != CHECKSUMS}
    checksums = np.zeros(1 + len(arrays), "<u4")
    header: dict[str, Any] = {"__metadata__": dict(metadata)}
    position = 0
    in_bytes = checksums.view(np.uint8).reshape(-1, 4)  # so that it is aligned wherever it begins
    for name, array in {**arrays, CHECKSUMS: in_bytes}.items():
        end = position + array.nbytes
        header[name] = {"dtype": NAMES[array.dtype], "shape": array.shape, "data_offsets": [position, end]}
        position = end
    text = json.dumps(header).encode()
    text += b" " * (-(8 + len(text)) % alignment)
    if len(text) > MAX_HEADER:
        raise InputError(
            f"{path}: the names of its sections and its metadata take {len(text)} bytes, more than {MAX_HEADER}; "
            "shorten them"
        )
    with atomic_write(path, durable=durable) as partial, partial.open("wb") as file:
        for i, part in enumerate([len(text).to_bytes(8, "little") + text, *arrays.values()]):
            data = part if isinstance(part, bytes) else np.ascontiguousarray(part).data
            checksums[i] = checksum(data)
            file.write(data)
        file.write(checksums.data)


def checksum(data: Any) -> int:
    """Compute the CRC-32 of bytes or of a contiguous array."""
    found = 0
    view = memoryview(data)
    if view.nbytes:
        view = view.cast("B")
        for start in range(0, len(view), BLOCK):
            found = zlib.crc32(view[start : start + BLOCK], found)
    return found


def digest_of(arrays: Mapping[str, npt.NDArray[Any]]) -> str:
    """Return what identifies the content of a file whose arrays were read: a hash of its checksums."""
    return hashlib.blake2b(arrays[CHECKSUMS].tobytes(), digest_size=8).hexdigest()


def digest(path: str | os.PathLike[str]) -> str:
    """Return what identifies the content of a file, as its checksums say, which are not verified."""
    return digest_of(read(path, verify=False)[0])


def read(
    path: str | os.PathLike[str], verify: bool | None = None, *, advice: str = ADVICE
) -> tuple[Arrays, dict[str, str]]:
    """Map the arrays of a file into memory, read-only; its checksums are one of them.

    The checksums are verified by default if the file has at most `VERIFIED_BYTES`. A FileFormatError is raised if the
    file contradicts its header or its checksums; it ends with the advice.
    """
    facts = Path(path).stat()
    size = facts.st_size

    def refuse(why: str) -> FileFormatError:
        return FileFormatError(f"{path} is not a whole tree file: {in_one_line(why)}; {advice}")

    if not (stat.S_ISREG(facts.st_mode) or stat.S_ISDIR(facts.st_mode)):
        raise FileFormatError(f"{path} is not a regular file; expected a tree file, which can be mapped into memory")
    if size < 8:
        raise refuse(f"it has {size} bytes")
    with naming(path):
        raw = np.memmap(path, np.uint8, "r")
    length = int.from_bytes(raw[:8].tobytes(), "little")
    if length > min(MAX_HEADER, size - 8):
        raise refuse("it does not begin like one (if it holds lines, fl.read reads it)")
    if (8 + length) % ALIGNMENT:
        raise refuse(f"its sections start at byte {8 + length}, which is not a multiple of {ALIGNMENT}")
    try:
        header = json.loads(raw[8 : 8 + length].tobytes())
        metadata = header.pop("__metadata__")
        if not all(isinstance(text, str) for text in metadata.values()):
            raise TypeError
        sections: dict[str, tuple[np.dtype[Any], list[int], int, int]] = {}
        for name, entry in header.items():
            begin, end = map(int, entry["data_offsets"])
            sections[name] = DTYPES[entry["dtype"]], [int(n) for n in entry["shape"]], begin, end
    except (ValueError, TypeError, KeyError, AttributeError, OverflowError, RecursionError):
        raise refuse("its header cannot be read") from None

    # The sections follow each other and fill the file.
    arrays: Arrays = {}
    position = 0
    for name, (dtype, shape, begin, end) in sections.items():
        fits = end - begin == dtype.itemsize * math.prod(shape)
        if begin != position or not fits or len(shape) > 3 or not all(0 <= n <= size for n in shape):
            raise refuse(f"the section {name!r} does not have the size of its array")
        if begin % dtype.itemsize:
            raise refuse(f"the section {name!r} starts between two of its numbers")
        position = end
        if 8 + length + end > size:
            break
        arrays[name] = raw[8 + length + begin : 8 + length + end].view(dtype).reshape(shape)
    promised = 8 + length + max((end for *_, end in sections.values()), default=0)
    if promised != size:
        raise refuse(f"its header promises {promised} bytes, but it has {size}")
    if CHECKSUMS not in arrays:
        raise refuse("it has no checksums")
    if verify or (verify is None and size <= VERIFIED_BYTES):
        *parts, last = [raw[: 8 + length], *arrays.values()]
        if last is not arrays[CHECKSUMS] or last.dtype != np.uint8 or last.shape != (len(parts), 4):
            raise refuse("its checksums are not one for the header and each section before")
        for name, part, expected in zip(["header", *arrays], parts, last, strict=False):
            if checksum(part) != int.from_bytes(expected.tobytes(), "little"):
                raise refuse(f"it has changed since it was written: the checksum of its {name} differs")
    return arrays, metadata
