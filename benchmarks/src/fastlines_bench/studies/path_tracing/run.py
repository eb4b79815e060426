"""Renders hair on both sides, compares the pictures, and times the rays."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

import fastlines as fl

from ...harness import machine
from ...harness.arrays import FloatArray
from ...harness.clock import best_in_turn, timed
from ...harness.internals import HairMaterial, Light, Sky, num_threads
from ...harness.preset import Preset, sized
from ...harness.subjects import Subject
from ...peers.hair_scene import HairScene, geometry_of, normalised
from .ours import OurScene

#: The names of the sides.
OURS, THEIRS = "fastlines", "Mitsuba"
#: Towards the light, from the camera: right, up, backwards. Its irradiance, and the radiance of the sky.
TOWARDS, SUN, SKY = (-0.55, 0.75, 0.75), (4.0, 3.8, 3.5), (0.4, 0.45, 0.5)
#: Pictures are compared by the means of square blocks of this many pixels a side.
BLOCK = 16
#: Of how many samples the rays are recorded, to time the rays alone.
RECORDED = 8
#: Positions of hits agree if they differ by less than this fraction of the radius.
SAME_T = 0.1


@dataclass(frozen=True, kw_only=True)
class PathsPreset(Preset):
    """How large the pictures are.

    Parameters
    ----------
    size : int
        The width and the height in pixels.
    samples : int
        The samples of each pixel, an even number.
    shape : str
        One of `SHAPES`.
    tolerance : float or None
        How far the pieces of our curves are off at most, as a fraction of the radius; None = as `fl.Curves`.
    melanin : float
        The colour of the hair, from 0 to 1: white, blond, brown, black.
    max_bounces : int
    n_threads : int
    rounds : int
        How often rays are timed; the best times count.
    variant : str
        That of Mitsuba.
    """

    size: int = sized(256, 48)
    samples: int = sized(64, 4)
    shape: str = "bspline"
    tolerance: float | None = None
    melanin: float = 0.3
    max_bounces: int = sized(64, 16)
    n_threads: int = 2
    rounds: int = sized(5, 2)
    variant: str = "llvm_ad_rgb"


@dataclass(frozen=True)
class RaysCell:
    """The rays of one kind, on both sides."""

    kind: str
    n_rays: int
    ours: float
    theirs: float
    agree: float


@dataclass(frozen=True)
class PathsResult:
    """The pictures of both sides, and the times."""

    machine: dict[str, Any]
    preset: PathsPreset
    subject: str
    radius: float
    n_prims: int
    version: str
    seconds: dict[str, float]
    build_seconds: dict[str, float]
    means: dict[str, list[float]]
    noise: dict[str, float]
    difference: float
    query_seconds: dict[str, float]
    query_rays: dict[str, int]
    rays: list[RaysCell]
    pictures: dict[str, FloatArray]

    def to_json(self) -> dict[str, Any]:
        """Return all figures, ready for JSON, without the pictures."""
        return {"format": "fastlines-bench mitsuba 1", **asdict(self), "pictures": None}


def run_paths(
    subject: Subject, preset: PathsPreset, progress: Callable[[str, float], None] = lambda what, share: None
) -> PathsResult:
    """Render hair on both sides.

    Each picture is two halves of the samples, so that their difference shows the noise.
    """
    from ...peers.mitsuba import MitsubaScene

    with num_threads(preset.n_threads), tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "hair.curves"
        lines, radius, camera = normalised(subject.lines, subject.middle_radius, subject.camera)
        scene = HairScene(
            geometry_of(lines, radius, preset.shape, path, preset.tolerance),
            path,
            preset.shape,
            radius,
            camera,
            HairMaterial.from_melanin(preset.melanin),
            Light(TOWARDS, SUN, 0.0),
            Sky(SKY, SKY, SKY),
            preset.size,
            preset.max_bounces,
        )
        start = perf_counter()
        ours = OurScene(scene, fl.build(scene.geometry))
        built = perf_counter() - start
        theirs = MitsubaScene(scene, preset.variant, preset.n_threads)
        sides: dict[str, Any] = {OURS: ours, THEIRS: theirs}
        for side in sides.values():
            side.render(1, 99)  # compile, and lay out the tree
        for counts in (ours.tree.seconds, ours.tree.rays):
            counts.clear()
        halves: dict[str, list[FloatArray]] = {name: [] for name in sides}
        seconds = dict.fromkeys(sides, 0.0)
        for half in range(2):
            for i, (name, side) in enumerate(sides.items()):
                progress(f"{subject.name}: {name}", (2 * half + i) / 5)
                picture, taken = side.render(preset.samples // 2, half)
                halves[name].append(picture)
                seconds[name] += taken
        query = dict(ours.tree.seconds), dict(ours.tree.rays)
        progress(f"{subject.name}: rays", 4 / 5)
        rays = _time_rays(ours, theirs, preset) if theirs.is_array else []
    pictures = {name: np.asarray((one + other) / 2, np.float32) for name, (one, other) in halves.items()}
    blocks = {name: _blocks(picture) for name, picture in pictures.items()}
    return PathsResult(
        machine.describe(),
        preset,
        subject.name,
        subject.middle_radius,
        len(scene.geometry),
        theirs.version,
        seconds,
        {OURS: built, THEIRS: theirs.load_seconds},
        {name: picture.mean(axis=(0, 1), dtype=np.float64).tolist() for name, picture in pictures.items()},
        {name: _rms(_blocks(one) - _blocks(other)) / 2 for name, (one, other) in halves.items()},
        _rms(blocks[OURS] - blocks[THEIRS]),
        *query,
        rays,
        pictures,
    )


def _time_rays(ours: OurScene, theirs: Any, preset: PathsPreset) -> list[RaysCell]:
    """Time the rays of some samples on both sides, in turn, and compare the answers."""
    tree, radius = ours.tree, ours.scene.query_radius
    tree.records = True
    ours.render(min(RECORDED, preset.samples), 7)
    tree.records = False
    cells = []
    for recorded, kind in (("camera first_surface", "camera"), ("first_surface", "bounce"), ("any_hit", "shadow")):
        origins, directions = (np.concatenate(each) for each in zip(*tree.recorded[recorded], strict=True))
        # Mitsuba's curves cannot be hit from inside.
        outside = tree.first_surface(origins, directions, radius).t > 0
        origins, directions = origins[outside], directions[outside]
        rays = origins, directions
        if kind == "shadow":
            calls = timed(partial(tree.any_hit, *rays, radius)), partial(theirs.any_hits, *rays)
        else:
            calls = timed(partial(_first_t, tree, *rays, radius)), partial(theirs.first_hits, *rays)
        (taken, mine), (their, other) = best_in_turn(preset.rounds, *calls)
        same = mine == other if kind == "shadow" else np.isclose(mine, other, 1e-6, SAME_T * ours.scene.radius)
        cells.append(RaysCell(kind, len(origins), taken, their, float(np.mean(same))))
    return cells


def _first_t(tree: Any, origins: FloatArray, directions: FloatArray, radius: float) -> FloatArray:
    """Return t of the first hits of surfaces."""
    return np.asarray(tree.first_surface(origins, directions, radius).t)


def _blocks(picture: FloatArray) -> FloatArray:
    """Return the means of blocks; what is left over at the right and at the bottom does not count."""
    n = max(1, len(picture) // BLOCK)
    side = min(BLOCK, len(picture))
    parts = picture[: n * side, : n * side].reshape(n, side, n, side, 3)
    return np.asarray(parts.mean(axis=(1, 3), dtype=np.float64), np.float32)


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(np.square(values, dtype=np.float64))))
