"""What a table of the report is about: lines, a camera that shows them, and three radii."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from .. import scenes
from ..builder import build
from ..camera import Camera
from ..demo.page import SCENE_NOTES
from ..lines import Lines
from ..scenes import RADII
from ..tree import Tree


@dataclass(frozen=True, eq=False)
class Subject:
    """Lines, and how they are looked at.

    Attributes
    ----------
    name : str
        Of a scene; "lines" if it is none.
    title, note : str
        What the report calls them, and what they are in a line.
    lines : Lines
    camera : Camera
        For square pictures.
    radii : mapping of str to float
        By the thesis's letters W, M, N.
    """

    name: str
    title: str
    note: str
    lines: Lines
    camera: Camera
    radii: Mapping[str, float]

    @cached_property
    def best(self) -> Tree:
        """The tree that draws them fastest."""
        return build(self.lines)

    @cached_property
    def digest(self) -> str:
        """What tells these lines from others."""
        what = hashlib.sha256(np.ascontiguousarray(self.lines.segments).tobytes())
        what.update(repr((self.camera, sorted(self.radii.items()))).encode())
        return what.hexdigest()[:16]

    @property
    def diagonal(self) -> float:
        """The diagonal of the box around them."""
        low, high = self.lines.bounds.astype(np.float64)
        return float(np.sqrt(((high - low) ** 2).sum()))


def scene_subject(name: str, n_segments: int | None) -> Subject:
    """Take one of the thesis's scenes."""
    scene = scenes.make(name, n_segments)
    return Subject(name, scene.title, SCENE_NOTES[name], scene.lines, scene.camera, RADII)


def lines_subject(name: str, lines: Lines, camera: Camera) -> Subject:
    """Take anybody's lines; the radii are the thesis's, in parts of the longest side of their box."""
    low, high = lines.bounds.astype(np.float64)
    side = float((high - low).max()) or 1.0
    radii = {letter: share * side for letter, share in RADII.items()}
    note = f"the radii are those of the thesis in parts of the longest side of their box, {side:.4g}"
    return Subject("lines", Path(name).name, note, lines, camera, radii)
