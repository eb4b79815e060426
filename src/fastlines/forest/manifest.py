"""The manifest of a forest: what `forest.json` says of the whole and of each tile."""

from __future__ import annotations

import errno
import hashlib
import json
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..errors import FileFormatError
from ..support.atomic_write import atomic_write
from ..support.immutable import Immutable, frozen
from ..support.metadata import read_only, to_json
from ..support.named_errors import naming
from ..support.texts import in_one_line

#: The file of a manifest in the folder of its forest, that of what a build was begun with, and the folder of what it
#: has not finished.
FILE, BUILD, BUILDING = "forest.json", "build.json", ".building"

FORMAT = "fastlines forest 1"

#: What to do where files of a forest are not what they were.
ADVICE = "call fl.build_forest with the same source again, which repairs it"

#: The errors that are raised where what JSON holds does not make a manifest.
UNUSABLE = (KeyError, TypeError, ValueError, AttributeError, OverflowError, RecursionError)


@dataclass(frozen=True, eq=False)
class TileFacts:
    """What a manifest says of a tile.

    Attributes
    ----------
    file : str
        The name of its tree file in the folder.
    n_prims, n_refs : int
        The numbers of its primitives and references.
    box : (2, 3) float32
        The box of its axes, without their radii.
    min_radius, max_radius : float
        The least and the largest radius of its own; 0 without any.
    total_length : float
        The length of its lines together.
    n_bytes : int
        The size of its file.
    digest : str
        Identifies the content of its file: `container.digest`.
    """

    file: str
    n_prims: int
    n_refs: int
    box: FloatArray
    min_radius: float
    max_radius: float
    total_length: float
    n_bytes: int
    digest: str

    def __post_init__(self) -> None:
        _require(isinstance(self.file, str) and Path(self.file).name == self.file, "a tile's file is not a name")
        for name in ("n_prims", "n_refs", "n_bytes"):
            _require(type(getattr(self, name)) is int and getattr(self, name) >= 0, f"{name} is not a count")
        for name in ("min_radius", "max_radius", "total_length"):
            object.__setattr__(self, name, float(getattr(self, name)))
            _require(math.isfinite(getattr(self, name)), f"{name} is not a number")
        object.__setattr__(self, "box", _box(self.box))
        _require(isinstance(self.digest, str), "a tile's digest is not a text")

    def as_json(self) -> dict[str, Any]:
        """Return the facts as JSON holds them; floats keep all their bits."""
        return {of.name: getattr(self, of.name) for of in fields(self)} | {"box": self.box.tolist()}


@dataclass(frozen=True, eq=False)
class Manifest(Immutable):
    """What is known of a forest without its tiles.

    Attributes
    ----------
    frame : (2, 3) float32
        The box that defines the coordinates in which queries compute: that of all axes, without their radii.
    n_prims, n_strands : int
    tiles : tuple of TileFacts
        In the order of their numbers.
    index : str
        The digest of the file of the index.
    method : str
        The name of the settings that the tiles were built with.
    facts : mapping
        ``up``, ``unit`` and ``metadata`` of the lines; the offset is in the metadata.
    version : str
        The version of fastlines that wrote it.
    """

    frame: FloatArray
    n_prims: int
    n_strands: int
    tiles: tuple[TileFacts, ...]
    index: str
    method: str
    facts: Mapping[str, Any] = field(default_factory=dict)
    version: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "frame", _box(self.frame))
        object.__setattr__(self, "facts", read_only(self.facts))
        for name in ("n_prims", "n_strands"):
            _require(type(getattr(self, name)) is int and getattr(self, name) >= 0, f"{name} is not a count")
        for name in ("index", "method", "version"):
            _require(isinstance(getattr(self, name), str), f"{name} is not a text")
        n_in_tiles = sum(tile.n_prims for tile in self.tiles)
        _require(n_in_tiles == self.n_prims, f"its tiles hold {n_in_tiles} primitives, and n_prims is {self.n_prims}")
        n_files = len({tile.file for tile in self.tiles})
        _require(n_files == len(self.tiles), "several tiles have the same file")

    @property
    def boxes(self) -> FloatArray:
        """The box of each tile, (n_tiles, 2, 3)."""
        return np.array([tile.box for tile in self.tiles], np.float32).reshape(-1, 2, 3)

    @property
    def max_radius(self) -> FloatArray:
        """The largest radius of each tile, (n_tiles,)."""
        return np.array([tile.max_radius for tile in self.tiles], np.float32)

    @property
    def bounds(self) -> FloatArray:
        """The box of all axes, (2, 3); zeros if there are none."""
        filled = self.boxes[[tile.n_prims > 0 for tile in self.tiles]]
        if not len(filled):
            return np.zeros((2, 3), np.float32)
        return np.stack([filled[:, 0].min(axis=0), filled[:, 1].max(axis=0)])

    @property
    def digest(self) -> str:
        """Identifies this manifest, and so the content of all tiles."""
        return hashlib.blake2b(self.text().encode(), digest_size=8).hexdigest()

    def text(self) -> str:
        """Return the text of the file."""
        head = {
            "format": FORMAT,
            "version": self.version,
            "method": self.method,
            "n_prims": self.n_prims,
            "n_strands": self.n_strands,
            "frame": self.frame.tolist(),
            "facts": json.loads(to_json(self.facts)),
            "index": self.index,
        }
        rows = ",\n".join(f"    {json.dumps(tile.as_json())}" for tile in self.tiles)
        return f'{json.dumps(head, indent=2)[:-2]},\n  "tiles": [\n{rows}\n  ]\n}}\n'

    def with_tile(self, number: int, facts: TileFacts) -> Manifest:
        """Return the manifest with other facts of a tile."""
        tiles: Sequence[TileFacts] = (*self.tiles[:number], facts, *self.tiles[number + 1 :])
        return replace(self, tiles=tuple(tiles))

    def write(self, folder: str | os.PathLike[str]) -> None:
        """Write the file into a folder; it appears whole or not at all."""
        with atomic_write(Path(folder) / FILE) as partial:
            partial.write_text(self.text(), encoding="utf-8")

    @classmethod
    def read(cls, folder: str | os.PathLike[str]) -> Manifest:
        """Read the manifest of a forest.

        Raises
        ------
        FileFormatError
            If the folder is none of a forest, or is half built, or its manifest is damaged or of another version.
        OSError
            If it cannot be read.
        """
        path = Path(folder) / FILE
        try:
            with naming(path):
                text = path.read_text(encoding="utf-8", errors="replace")
        except FileNotFoundError:
            if any((Path(folder) / name).exists() for name in (BUILDING, BUILD)):
                raise FileFormatError(
                    f"{folder} is a forest that is half built: it has no {FILE} yet; call fl.build_forest with the "
                    "same source again, which goes on"
                ) from None
            if Path(folder).is_dir():
                raise FileFormatError(
                    f"{folder} is not a forest: it has no {FILE}; fl.build_forest makes one"
                ) from None
            why = f"no such folder or tree file; check the path (the working directory is {Path.cwd()})"
            raise FileNotFoundError(errno.ENOENT, why, str(folder)) from None
        try:
            given = json.loads(text)
            form, version = given.pop("format"), given.get("version")
        except UNUSABLE:
            raise FileFormatError(f"{path} is damaged: it is not JSON with a format; {ADVICE}") from None
        if form != FORMAT:
            said = in_one_line(f"the format {form!r} of fastlines {version}")
            raise FileFormatError(
                f"{path} has {said}, expected {FORMAT!r}; build the forest again with this version, or read it with "
                "that one"
            )
        try:
            tiles = tuple(TileFacts(**tile) for tile in given.pop("tiles"))
            return cls(tiles=tiles, **given)
        except UNUSABLE as error:
            raise FileFormatError(f"{path} is damaged: {in_one_line(str(error))}; {ADVICE}") from None


def _box(corners: Any) -> FloatArray:
    """Return a box as an immutable array."""
    box = np.array(corners, np.float32)
    _require(box.shape == (2, 3) and bool(np.isfinite(box).all()), "a box is not two corners of three numbers")
    return np.asarray(frozen(box))


def _require(holds: bool, otherwise: str) -> None:
    if not holds:
        raise ValueError(otherwise)
