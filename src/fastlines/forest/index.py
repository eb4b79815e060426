"""The index of a forest: the tile and the strand of each primitive, mapped, and a sample of the lines."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..arrays import IntArray
from ..errors import FileFormatError, InvalidTreeError
from ..geometry.any_geometry import AnyGeometry
from ..geometry.lines import Lines
from ..structure.geometry_file import from_sections, to_sections
from ..support import container
from .manifest import ADVICE, UNUSABLE
from .verified_files import is_verified, set_verified

#: The file of an index in the folder of its forest.
FILE = "index.fli"

FORMAT = "fastlines forest index 1"

#: What the names of the sections of the sample begin with.
SAMPLE = "sample/"

#: The most primitives of the sample.
SAMPLE_PRIMS = 100_000


@dataclass(frozen=True, eq=False)
class Index:
    """What is known of each primitive of a forest; the arrays are mapped.

    Attributes
    ----------
    tile_of : (n_prims,) uint32
        The tile of each primitive.
    strands : None or (n_prims,) int32 or int64
        The strand of each primitive, -1 for none; None if there are no strands.
    skipped : (k,) int64
        Rows of the input that were left out, rising.
    closed : (k, 2) int64
        The number of each closed strand, rising, and how many primitives it has. A strand is closed if its last
        primitive ends where its first one starts.
    sample : Lines
        Up to 100,000 primitives, with all that is known of them.
    """

    tile_of: npt.NDArray[np.uint32]
    strands: npt.NDArray[Any] | None
    skipped: IntArray
    closed: IntArray
    sample: AnyGeometry

    def holds(self, number: int, ids: IntArray | None) -> bool:
        """Return whether a tile holds the primitives with these numbers, rising, and no others."""
        if ids is None or (ids[1:] <= ids[:-1]).any():
            return False
        if len(ids) and not 0 <= ids[0] <= ids[-1] < len(self.tile_of):
            return False
        return bool((self.tile_of[ids] == number).all())

    def write(self, folder: str | os.PathLike[str]) -> str:
        """Write the file into a folder, whole or not at all; return its digest."""
        sections, facts, _ = to_sections(self.sample)
        arrays: dict[str, npt.NDArray[Any]] = {
            "tile_of": self.tile_of,
            "skipped": self.skipped,
            "closed": self.closed,
            **({} if self.strands is None else {"strands": self.strands}),
            **{SAMPLE + name: array for name, array in sections.items()},
        }
        # Write larger numbers first, so that each section is aligned for its type.
        kept = dict(sorted(arrays.items(), key=lambda item: -item[1].dtype.itemsize))
        facts = {name: facts[name] for name in ("kind", "up", "unit") if facts.get(name) is not None}
        path = Path(folder) / FILE
        container.write(path, kept, {"format": FORMAT, "sample": json.dumps(facts)})
        return container.digest(path)

    @classmethod
    def read(cls, folder: str | os.PathLike[str], n_prims: int, digest: str, verify: bool | None = None) -> Index:
        """Map the index of a forest.

        Raises
        ------
        FileFormatError
            If it is missing, damaged, or of another build than the digest is.
        """
        path = Path(folder) / FILE

        def refuse(why: str) -> FileFormatError:
            return FileFormatError(f"{path} is not the index of this forest: {why}; {ADVICE}")

        try:
            trusted = verify is not True and is_verified(path, verify)
            arrays, metadata = container.read(path, False if trusted else verify, advice=ADVICE)
        except FileNotFoundError:
            raise refuse("it is missing") from None
        if metadata.get("format") != FORMAT:
            raise refuse(f"its format is {metadata.get('format')!r}, expected {FORMAT!r}")
        if container.digest_of(arrays) != digest:
            raise refuse("it is of another build than its manifest")
        try:
            arrays = {name: np.asarray(array) for name, array in arrays.items()}  # memory maps index slowly
            tile_of, strands = arrays["tile_of"], arrays.get("strands")
            shapes = {tile_of.shape} | (set() if strands is None else {strands.shape})
            if shapes != {(n_prims,)} or tile_of.dtype != np.uint32 or arrays["closed"].shape[1:] != (2,):
                raise refuse(f"its columns do not have a row for each of {n_prims} primitives")
            facts: dict[str, Any] = {"kind": Lines.__name__, **json.loads(metadata["sample"])}
            own = {name.removeprefix(SAMPLE): array for name, array in arrays.items() if name.startswith(SAMPLE)}
            sample = from_sections(own, facts, refuse)
            set_verified(path, verify)
            return cls(tile_of, strands, arrays["skipped"], arrays["closed"], sample)
        except FileFormatError:
            raise
        except (*UNUSABLE, InvalidTreeError) as error:
            raise refuse(f"{error}") from None
