"""The timed rays: camera rays, random rays, and ambient-occlusion rays."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from fastlines import Camera, InputError, Lines

from .arrays import FloatArray

#: The kinds of rays, and the queries that are timed on each.
KINDS: dict[str, tuple[str, ...]] = {
    "camera": ("first", "all"),
    "tiled": ("first", "all"),
    "random": ("first", "all"),
    "ao": ("any",),
}

#: The questions of a table: pairs of a kind of rays and a query.
QUESTIONS = tuple((kind, query) for kind in ("camera", "random") for query in KINDS[kind])

#: A description of each kind.
KIND_NOTES = {
    "camera": "a square picture that the lines fill, row by row",
    "tiled": "the same in tiles of 4×4 within tiles of 8×8 pixels",
    "random": "through a uniform point of the box, in an isotropic direction, from outside",
    "ao": "from the points that a camera sees, over the sphere, t from 2.5 radii to a tenth of the box's diagonal",
}

#: The rows and maximum columns of a window. A part of a picture consists of whole windows. They are small, because the
#: cost of rays differs much between places of a picture and the part may have few windows.
WINDOW = (8, 32)

#: Ambient occlusion: t_min in radii, so that a ray misses the segment where it starts; t_max in diagonals of the box.
AO_T_MIN = 2.5
AO_T_MAX = 0.1


@dataclass(frozen=True, eq=False)
class RayBatch:
    """Rays of unit direction with the same bounds.

    Attributes
    ----------
    kind : str
        One of `KINDS`.
    origins, directions : (n, 3) float32
    t_min, t_max : float
    block : int
        The number of neighbouring rays that are never divided: eight whole rows of a picture.
    width : int
        The length of a row of a whole picture in row order; 0 for other rays.
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
        """Whether neighbouring rays are coherent."""
        return self.kind in ("camera", "tiled")

    def take(self, rows: slice | npt.NDArray[np.int64]) -> RayBatch:
        """Return the rays at some indices."""
        origins, directions = (np.ascontiguousarray(a[rows]) for a in (self.origins, self.directions))
        return replace(self, origins=origins, directions=directions, width=0)

    def part(self, n_rays: int) -> RayBatch:
        """Return about `n_rays` or somewhat more rays that represent all: one whole block from each of equal shares.

        A part of a picture consists of windows, one below the other. A window is at a random place in its share,
        because the middle of a share of windows in Morton order is at the share's edge. Other blocks are from the
        middle.
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
        """Return all rays as batches of about `n_rays`: consecutive whole blocks, at least one."""
        size = max(1, n_rays // self.block) * self.block
        return [self.take(slice(i, i + size)) for i in range(0, len(self), size)]


def camera_rays(camera: Camera, n_rays: int) -> RayBatch:
    """Return the rays of a square picture of about `n_rays` pixels in row order, as `Camera.rays` does."""
    size = max(1, round(n_rays**0.5))
    return RayBatch("camera", *camera.rays(size, size), block=8 * size, width=size)


def tiled_rays(camera: Camera, n_rays: int) -> RayBatch:
    """Return camera rays in the order of tiles of 4×4 pixels within tiles of 8×8."""
    size = max(8, round(n_rays**0.5 / 8) * 8)
    origins, directions = camera.rays(size, size)
    order = np.arange(size * size).reshape(size // 8, 2, 4, size // 8, 2, 4).transpose(0, 3, 1, 4, 2, 5).ravel()
    return RayBatch("tiled", origins[order], directions[order])


def random_rays(lines: Lines, n_rays: int, seed: int = 0) -> RayBatch:
    """Return rays that start outside the box of the lines: through uniform points of it, in isotropic directions."""
    return rays_through(lines.bounds, n_rays, seed)


def rays_through(bounds: FloatArray, n_rays: int, seed: int = 0) -> RayBatch:
    """Return rays that start outside a box, (2, 3), as `random_rays` does."""
    rng = np.random.default_rng([seed, 1])
    low, high = bounds.astype(np.float64)
    target = low + rng.random((n_rays, 3)) * (high - low)
    directions = _sphere(rng, n_rays)
    diagonal = float(np.sqrt(((high - low) ** 2).sum())) or 1.0
    return RayBatch("random", (target - 1.01 * diagonal * directions).astype(np.float32), directions)


def ao_rays(lines: Lines, camera: RayBatch, t: FloatArray, radius: float, n_rays: int, seed: int = 0) -> RayBatch:
    """Return ambient-occlusion rays: from the first hits of camera rays, with a few isotropic directions each.

    Parameters
    ----------
    camera : RayBatch
        The camera rays.
    t : (n,) float32
        The first hits of the camera rays; inf = miss.
    """
    hit = np.isfinite(t)
    if not hit.any():
        raise InputError("no camera ray hits anything, so there is nowhere for ambient occlusion to start")
    points = (camera.origins + np.where(hit, t, 0)[:, None] * camera.directions)[hit]
    points = np.repeat(points, -(-n_rays // len(points)), axis=0)
    rng = np.random.default_rng([seed, 2])
    low, high = lines.bounds.astype(np.float64)
    t_max = AO_T_MAX * float(np.sqrt(((high - low) ** 2).sum()))
    rays = RayBatch("ao", points.astype(np.float32), _sphere(rng, len(points)), AO_T_MIN * radius, t_max)
    if rays.t_min >= t_max:
        raise InputError(f"radius {radius:g} is too large for ambient occlusion: rays would end at {t_max:g}")
    return rays.part(n_rays)


def _windows(width: int, height: int) -> npt.NDArray[np.int64]:
    """Return the pixels of each window of a picture; the windows are in Morton order."""
    rows, n_across = WINDOW[0], -(-width // WINDOW[1])
    # Use whole groups of 8 × 8 pixels, as the kernels do, if a row has more than one window.
    columns = width if n_across == 1 else -(-width // n_across // 8) * 8
    # Let the windows of the last rows and columns overlap those before.
    tops = np.minimum(np.arange(0, height, rows), height - rows) if height >= rows else np.arange(0)
    lefts = np.linspace(0, width - columns, n_across).astype(np.int64)
    top, left = (a.ravel() for a in np.meshgrid(tops, lefts))
    # Sort into Morton order: interleave the bits of both.
    order = np.argsort(sum((left >> i & 1) << 2 * i | (top >> i & 1) << 2 * i + 1 for i in range(31)))
    first = (top * width + left)[order]
    window = np.arange(rows)[:, None] * width + np.arange(columns)
    return first[:, None] + window.ravel()


def _sphere(rng: np.random.Generator, n: int) -> FloatArray:
    """Return n isotropic unit vectors."""
    vectors = rng.standard_normal((n, 3))
    return np.asarray(vectors / np.sqrt((vectors**2).sum(axis=1, keepdims=True)), np.float32)
