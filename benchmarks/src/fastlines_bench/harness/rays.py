"""The rays that are timed: those of a camera, random ones, and those of ambient occlusion."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from fastlines import Camera, InputError, Lines

from .arrays import FloatArray

#: The kinds of rays and the queries that are asked of each.
KINDS: dict[str, tuple[str, ...]] = {
    "camera": ("first", "all"),
    "tiled": ("first", "all"),
    "random": ("first", "all"),
    "ao": ("any",),
}

#: What is asked where a table is to hold it all: the kind of rays, and the query.
QUESTIONS = tuple((kind, query) for kind in ("camera", "random") for query in KINDS[kind])

#: What each kind is, in a line.
KIND_NOTES = {
    "camera": "a square picture that the lines fill, row by row",
    "tiled": "the same in tiles of 4×4 within tiles of 8×8 pixels",
    "random": "through a uniform point of the box, in an isotropic direction, from outside",
    "ao": "from the points that a camera sees, over the sphere, t from 2.5 radii to a tenth of the box's diagonal",
}

#: Of a picture, windows of so many rows of at most so many pixels stay together where a part is taken: no larger, for
#: what rays meet differs a lot from place to place, and few of them may be asked.
WINDOW = (8, 32)

#: Ambient occlusion: t_min in radii, so that a ray does not hit where it starts; t_max in diagonals of the box.
AO_T_MIN = 2.5
AO_T_MAX = 0.1


@dataclass(frozen=True, eq=False)
class RayBatch:
    """Rays of unit direction with common bounds.

    Attributes
    ----------
    kind : str
        One of `KINDS`.
    origins, directions : (n, 3) float32
    t_min, t_max : float
    block : int
        So many neighbours stay together where the rays are divided: of a picture, eight whole rows.
    width : int
        Of a whole picture that comes row by row: the length of a row; else 0.
    """

    kind: str
    origins: FloatArray
    directions: FloatArray
    t_min: float = 0.0
    t_max: float = float("inf")
    block: int = 4096
    width: int = 0

    def __len__(self) -> int:
        return len(self.origins)

    @property
    def coherent(self) -> bool:
        """Whether neighbours are alike."""
        return self.kind in ("camera", "tiled")

    def take(self, rows: slice | npt.NDArray[np.int64]) -> RayBatch:
        """Some of the rays."""
        origins, directions = (np.ascontiguousarray(a[rows]) for a in (self.origins, self.directions))
        return replace(self, origins=origins, directions=directions, width=0)

    def part(self, n_rays: int) -> RayBatch:
        """So many of the rays, or some more: whole blocks from the middles of equal shares, so that means stay true.

        Of a picture it is windows, which make a narrow picture, one below the other: from anywhere in their shares,
        for the middle of a share of windows is at its edge.
        """
        if self.width:
            blocks = _windows(self.width, len(self) // self.width)
        else:
            blocks = np.arange(len(self) // self.block * self.block).reshape(-1, self.block)
        n_taken = max(1, -(-n_rays // blocks.shape[1]))
        if n_taken >= len(blocks):
            return self
        bounds = np.arange(n_taken + 1) * len(blocks) // n_taken
        where = np.random.default_rng(3).random(n_taken) if self.width else 0.5
        taken = blocks[bounds[:-1] + (np.diff(bounds) * where).astype(np.int64)]
        return replace(self.take(taken.ravel()), block=blocks.shape[1])

    def slices(self, n_rays: int) -> list[RayBatch]:
        """All rays, about so many at a time: whole blocks that follow each other, one at least."""
        size = max(1, n_rays // self.block) * self.block
        return [self.take(slice(i, i + size)) for i in range(0, len(self), size)]


def camera_rays(camera: Camera, n_rays: int) -> RayBatch:
    """The rays of a square picture of about so many pixels, as `Camera.rays` gives them: row by row."""
    size = max(1, round(n_rays**0.5))
    return RayBatch("camera", *camera.rays(size, size), block=8 * size, width=size)


def tiled_rays(camera: Camera, n_rays: int) -> RayBatch:
    """The same rays, for a caller who walks the picture in tiles of 4×4 pixels within tiles of 8×8."""
    size = max(8, round(n_rays**0.5 / 8) * 8)
    origins, directions = camera.rays(size, size)
    order = np.arange(size * size).reshape(size // 8, 2, 4, size // 8, 2, 4).transpose(0, 3, 1, 4, 2, 5).ravel()
    return RayBatch("tiled", origins[order], directions[order])


def random_rays(lines: Lines, n_rays: int, seed: int = 0) -> RayBatch:
    """Rays through a uniform point of the lines' box, of isotropic direction, that start outside the box."""
    rng = np.random.default_rng([seed, 1])
    low, high = lines.bounds.astype(np.float64)
    target = low + rng.random((n_rays, 3)) * (high - low)
    directions = _sphere(rng, n_rays)
    diagonal = float(np.sqrt(((high - low) ** 2).sum())) or 1.0
    return RayBatch("random", (target - 1.01 * diagonal * directions).astype(np.float32), directions)


def ao_rays(lines: Lines, camera: RayBatch, t: FloatArray, radius: float, n_rays: int, seed: int = 0) -> RayBatch:
    """Ambient occlusion: from the points that camera rays hit first, a few directions each, uniform over the sphere.

    Parameters
    ----------
    camera : RayBatch
        The camera's rays, and
    t : (n,) float32
        where each of them hits; inf = nowhere.
    """
    seen = np.isfinite(t)
    if not seen.any():
        raise InputError("no camera ray hits anything, so there is nowhere for ambient occlusion to start")
    points = (camera.origins + np.where(seen, t, 0)[:, None] * camera.directions)[seen]
    points = np.repeat(points, -(-n_rays // len(points)), axis=0)
    rng = np.random.default_rng([seed, 2])
    low, high = lines.bounds.astype(np.float64)
    t_max = AO_T_MAX * float(np.sqrt(((high - low) ** 2).sum()))
    rays = RayBatch("ao", points.astype(np.float32), _sphere(rng, len(points)), AO_T_MIN * radius, t_max)
    if rays.t_min >= t_max:
        raise InputError(f"radius {radius:g} is too large for ambient occlusion: rays would end at {t_max:g}")
    return rays.part(n_rays)


def _windows(width: int, height: int) -> npt.NDArray[np.int64]:
    """The pixels of each window of a picture, in an order in which those that follow each other lie near."""
    rows, n_across = WINDOW[0], -(-width // WINDOW[1])
    # Of whole groups of 8 × 8 pixels, as they are asked, where there is more than one window beside another.
    columns = width if n_across == 1 else -(-width // n_across // 8) * 8
    # Windows of the last rows and columns share some with those before.
    tops = np.minimum(np.arange(0, height, rows), height - rows) if height >= rows else np.arange(0)
    lefts = np.linspace(0, width - columns, n_across).astype(np.int64)
    top, left = (a.ravel() for a in np.meshgrid(tops, lefts))
    # Morton order: the bits of both in turn.
    order = np.argsort(sum((left >> i & 1) << 2 * i | (top >> i & 1) << 2 * i + 1 for i in range(31)))
    first = (top * width + left)[order]
    window = np.arange(rows)[:, None] * width + np.arange(columns)
    return first[:, None] + window.ravel()


def _sphere(rng: np.random.Generator, n: int) -> FloatArray:
    """Isotropic unit vectors."""
    vectors = rng.standard_normal((n, 3))
    return np.asarray(vectors / np.sqrt((vectors**2).sum(axis=1, keepdims=True)), np.float32)
