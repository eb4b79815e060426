"""The lines of the benchmark of points: a neuron, hair, tracts and spaghetti; and points as users have them.

Hair and spaghetti are scenes of the thesis. The neuron and the tracts are published files where a folder holds these,
and otherwise made by seeded generators.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

import fastlines as fl
from fastlines import InputError, Lines

from ..harness.arrays import Float64Array
from ..harness.internals import did_you_mean, open_lines

#: The files that a folder of data may hold, by scene.
FILES = {"neuron": "Neuron.swc", "tracts": "stroke.trk.gz"}

#: All scenes, and their numbers of segments.
SIZES = {"neuron": 846, "bun-hair": 82_250, "straight-hair": 87_460, "tracts": 200_705, "spaghetti": 2_000}

#: The numbers of segments of a quick run.
QUICK_SIZES = {"neuron": 846, "bun-hair": 10_000, "straight-hair": 10_000, "tracts": 10_000, "spaghetti": 500}

#: The distance from a line of the points near lines, as a fraction of the size: the root mean square.
OFFSET = 0.01


@dataclass(frozen=True, eq=False)
class PointScene:
    """Lines to which points are near.

    Attributes
    ----------
    name : str
        One of `SIZES`, or the name of a file.
    source : str
        A file, or "generated".
    lines : Lines
        Without a radius of their own, which peers lack.
    """

    name: str
    source: str
    lines: Lines

    @property
    def size(self) -> float:
        """The length of the diagonal of the box around the lines."""
        low, high = self.lines.bounds.astype(np.float64)
        return float(np.sqrt(((high - low) ** 2).sum()))


def make(text: str, data: str | None = None, quick: bool = False) -> PointScene:
    """Return a scene.

    Parameters
    ----------
    text : str
        NAME or NAME:SEGMENTS.
    data : str, optional
        A folder with `FILES`. Scenes without a file there, or with a number of segments, are generated.
    quick : bool
        Whether the default number of segments is that of a quick run.

    Raises
    ------
    InputError
        If there is no such scene, or no such number of segments.
    """
    name, _, count = text.partition(":")
    if name not in SIZES:
        raise InputError(f"--scene {text!r} is not a scene{did_you_mean(name, tuple(SIZES))}")
    if count and not (count.isascii() and count.isdigit() and 0 < int(count) < 10**8):
        raise InputError(f"--scene {text!r} is not NAME or NAME:SEGMENTS with a whole number from 1; try {name}:1000")
    if data is not None and not count and name in FILES and (Path(data) / FILES[name]).exists():
        return PointScene(name, FILES[name], read_axes(str(Path(data) / FILES[name])))
    n = int(count) if count else (QUICK_SIZES if quick else SIZES)[name]
    if name in fl.scenes.NAMES:
        return PointScene(name, "generated", fl.scenes.make(name, n).lines)
    return PointScene(name, "generated", neuron(n) if name == "neuron" else tracts(n))


def read_axes(path: str) -> Lines:
    """Read lines, without a radius of their own."""
    return replace(open_lines(path).lines, radius=None)


def neuron(n_segments: int, seed: int = 0) -> Lines:
    """Return a tree that grows from six stems: tips go on, turn a little, and sometimes branch."""
    rng = np.random.default_rng([seed, 21])
    tips = [(np.zeros(3), direction) for direction in rng.normal(size=(6, 3))]
    segments = np.empty((n_segments, 2, 3))
    for i in range(n_segments):
        start, direction = tips.pop(0)
        direction = direction / np.sqrt(direction @ direction) + 0.3 * rng.normal(size=3)
        end = start + direction
        segments[i] = start, end
        tips += [(end, direction), (end, direction + rng.normal(size=3))] if rng.random() < 0.03 else [(end, direction)]
    return Lines.from_segments(segments.astype(np.float32))


def tracts(n_segments: int, seed: int = 0) -> Lines:
    """Return streamlines of five segments in 60 bundles, which curve through an ellipsoid."""
    rng = np.random.default_rng([seed, 22])
    bundles = rng.normal(size=(60, 4, 3))
    bundles *= np.array([65, 88, 76]) / np.sqrt((bundles**2).sum(axis=2, keepdims=True))
    bundles[:, 1:3] *= 0.5
    n = -(-n_segments // 5)
    control = bundles[rng.integers(len(bundles), size=n)] + rng.normal(scale=4, size=(n, 4, 3))
    # Take six points of a part of each cubic curve.
    first, last = rng.uniform(0, 0.4, size=(n, 1)), rng.uniform(0.6, 1, size=(n, 1))
    t = first + (last - first) * np.linspace(0, 1, 6)
    weights = np.stack([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3], axis=2)
    counts = np.full(n, 6)
    counts[-1] -= 5 * n - n_segments
    points = (weights @ control).reshape(-1, 3)[: counts.sum()]
    return Lines.from_points(points.astype(np.float32), counts)


def points_of_users(scene: PointScene, n_points: int, seed: int = 0) -> Float64Array:
    """Return points, unsorted: half of them near the lines, half of them uniform in the box.

    Points near the lines are uniform along them, and off by a normal distribution of a hundredth of the size.
    """
    rng = np.random.default_rng([seed, 23])
    segments = scene.lines.segments.astype(np.float64)
    edges = segments[:, 1] - segments[:, 0]
    lengths = np.sqrt((edges**2).sum(axis=1)) + 1e-30
    n_near = n_points // 2
    of = rng.choice(len(segments), size=n_near, p=lengths / lengths.sum())
    near = segments[of, 0] + rng.random((n_near, 1)) * edges[of]
    near += rng.normal(scale=OFFSET * scene.size / 3**0.5, size=near.shape)
    low, high = scene.lines.bounds.astype(np.float64)
    points = np.concatenate([near, low + rng.random((n_points - n_near, 3)) * (high - low)])
    rng.shuffle(points)
    return points
