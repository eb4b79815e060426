"""Subjects of measurements: lines, a camera that shows them, and the radii of queries."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fastlines import Camera, InputError, Lines, Tree, build
from fastlines.scenes import NAMES, RADII, make

from .arrays import IntArray
from .internals import SCENE, open_lines
from .rays import RayBatch, ao_rays, camera_rays, random_rays

#: The scenes and radii of a quick run.
QUICK_SCENES = ("spaghetti:1000", "straight-hair:10000")
QUICK_RADII = (0.001,)


@dataclass(frozen=True, eq=False)
class Subject:
    """Lines, with a camera and radii.

    Attributes
    ----------
    name, title : str
        The name of the scene on the command line and in the thesis; or the name of the file.
    lines : Lines
    camera : Camera
        A camera for square pictures.
    radii : tuple of float
    """

    name: str
    lines: Lines
    camera: Camera
    radii: tuple[float, ...] = tuple(RADII.values())
    title: str = ""

    @cached_property
    def best(self) -> Tree:
        """The default tree over the lines."""
        return build(self.lines)

    @cached_property
    def digest(self) -> str:
        """The hash of the lines, the camera and the radii."""
        what = hashlib.sha256(np.ascontiguousarray(self.lines.segments).tobytes())
        what.update(repr((self.camera, self.radii)).encode())
        return what.hexdigest()[:16]

    @property
    def diagonal(self) -> float:
        """The length of the diagonal of the box around the lines."""
        low, high = self.lines.bounds.astype(np.float64)
        return float(np.sqrt(((high - low) ** 2).sum()))

    @property
    def by_letter(self) -> Mapping[str, float]:
        """The radii by the thesis's letters W, M, N."""
        return dict(zip(RADII, self.radii, strict=True))

    @property
    def middle_radius(self) -> float:
        """The median radius, for measurements with one radius."""
        return sorted(self.radii)[len(self.radii) // 2]

    def rays(self, kind: str, n_rays: int) -> RayBatch:
        """Return camera or random rays."""
        return camera_rays(self.camera, n_rays) if kind == "camera" else random_rays(self.lines, n_rays)

    def occlusion_rays(self, tree: Tree, radius: float, n_rays: int) -> RayBatch:
        """Return ambient-occlusion rays from the first hits of camera rays."""
        small = camera_rays(self.camera, min(n_rays, 1 << 16))
        t = tree.first_hit(small.origins, small.directions, radius).t
        return ao_rays(self.lines, small, t, radius, n_rays)


def strands_of(lines: Lines) -> tuple[IntArray, IntArray]:
    """Return the first segment of each strand, and the number of its segments."""
    strands = np.where(lines.strands < 0, -1 - np.arange(len(lines)), lines.strands)
    starts = np.flatnonzero(np.diff(strands, prepend=strands[:1] - 1)) if len(lines) else np.zeros(0, np.int64)
    return starts, np.diff(starts, append=len(lines))


def tapered(lines: Lines, radius: float, ratio: float = 0.2) -> Lines:
    """Return lines that are thick: of this radius where a strand begins, and of `ratio` times as much where it ends."""
    starts, counts = strands_of(lines)
    position = np.arange(len(lines)) - np.repeat(starts, counts)
    share = (position[:, None] + np.arange(2)) / np.repeat(counts, counts)[:, None]
    return replace(lines, radius=(radius * (1 - (1 - ratio) * share)).astype(np.float32))


def scene_subject(name: str, n_segments: int | None = None) -> Subject:
    """Return a scene of the thesis, with its camera and radii."""
    scene = make(name, n_segments)
    return Subject(name, scene.lines, scene.camera, title=scene.title)


def subjects_of(scene: list[str], file: list[str], radius: str | None, quick: bool) -> Iterator[Subject]:
    """Yield the subjects of the options --scene, --file and --radius; the five scenes without --scene and --file."""
    if not scene and not file:
        scene = list(QUICK_SCENES if quick else NAMES)
    for name, is_scene in [*((name, True) for name in scene), *((name, False) for name in file)]:
        source = open_lines(f"{SCENE}{name}" if is_scene else name)
        radii: tuple[float, ...] = QUICK_RADII if quick else tuple(RADII.values())
        if radius is not None:
            radii = tuple(_radius(part) for part in radius.split(","))
        elif not is_scene:
            low, high = source.lines.bounds
            radii = tuple(share * (float((high - low).max()) or 1.0) for share in radii)
        yield Subject(name, source.lines, source.camera(), radii)


def _radius(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0 < value < float("inf"):
        raise InputError(f"--radius {text!r} is not a number above 0; expected one or more, such as 0.005,0.001")
    return value
