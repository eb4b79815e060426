"""Curves of scenes of the renderer pbrt, versions 3 and 4 (``.pbrt``).

Format: https://pbrt.org/fileformat-v4, section "Shapes", and https://pbrt.org/fileformat-v3. Each ``Shape "curve"`` is
a strand of cubic Bezier curves. B-splines are converted, and curves of degree 2 raised to degree 3, both exactly.
``width0`` and ``width1`` are widths: the radius is half of them, linear along the shape.

Transforms move curves and scale their widths. A transform that scales unevenly would make cross-sections elliptic; the
width is then scaled by the cube root of the scale of volumes, with a warning. Objects are read where their instances
are. Included files are read if they are in the folder of the scene or below.

Flat and cylindrical curves are read alike, and so are ribbons, with a warning. Other shapes are counted in a warning.
Cameras, lights, materials, media, textures and motion are not read. The format defines no unit and no axes.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...arrays import FloatArray, IntArray
from ...geometry.curves import Curves
from ...support.texts import kinds_text
from ..source import UNPACK_BYTES, UNPACK_FACTOR, Source
from .number_text import Float64Array, number_lines
from .pbrt_scene import KINDS, Scene
from .pbrt_transform import width_scales

#: So many curves are transformed at once.
_ROWS = 1 << 16
#: The bytes that a curve needs at least.
_CURVE_BYTES = 64


def read(source: Source, invalid: str) -> Curves:
    """Read all curves of a ``.pbrt`` file, those of instances too; each shape is a strand."""
    scene = Scene(source)
    scene.read()
    if scene.others:
        source.warn(f"its shapes that are not curves ({kinds_text(dict(scene.others.most_common(4)))}) are not read")
    if scene.n_ribbons:
        source.warn(f"its {scene.n_ribbons} ribbons are read as round curves of the same width, without their normals")
    control, n_curves = _bezier(source, scene)

    # Find the shapes that appear, with the transform of each and of its instance.
    runs = np.array(scene.runs, np.int64).reshape(-1, 3)
    first, last, instance = runs.T
    _check_size(source, scene, runs, n_curves)
    shape = _ranges(first, last - first)
    own, of_instance = np.array(scene.rows, np.int64)[shape], np.repeat(instance, last - first)
    known = np.stack([*scene.matrices, np.eye(4)])  # row -1 is the identity
    pairs, which = np.unique((of_instance + 1) * len(known) + own, return_inverse=True)
    which = which.reshape(-1)
    with np.errstate(all="ignore"):
        matrices = known[pairs // len(known) - 1] @ known[pairs % len(known)]
    scales, is_even = width_scales(matrices)
    n_uneven = int((~is_even[which]).sum())
    if n_uneven:
        source.warn(
            f"its transforms scale {n_uneven} curves unevenly; their widths are scaled by the cube root of the scale "
            "of volumes"
        )

    # Make the curves of each shape; its width is linear all along.
    n = n_curves[shape]
    rows = _ranges((np.cumsum(n_curves) - n_curves)[shape], n)
    owner = np.repeat(np.arange(len(shape)), n)
    at = (np.arange(len(rows)) - np.repeat(np.cumsum(n) - n, n))[:, None] + np.array([0, 1])
    widths = np.array(scene.widths, np.float64).reshape(-1, 2)[shape]
    along = at / n[owner][:, None]
    with np.errstate(all="ignore"):
        width = (1 - along) * widths[owner, :1] + along * widths[owner, 1:]
        radius: FloatArray = source.radius("widths of curves", width * scales[which[owner]][:, None] / 2)
    moved = _moved(control, rows, matrices, which[owner], np.float32 if source.offset is None else np.float64)
    return Curves.from_bezier(moved, radius, strands=owner, offset=source.offset, invalid=invalid)


def _bezier(source: Source, scene: Scene) -> tuple[Float64Array, IntArray]:
    """Return the Bezier control points of all shapes, (n, 4, 3), and how many curves each shape has."""
    text = b"".join([line + b"\n" for line in scene.points])
    scene.points.clear()
    numbers, counts = number_lines(source, text, what="curve")
    points = numbers[: len(numbers) // 3 * 3].reshape(-1, 3)
    kinds = np.array(scene.kinds, np.int64)
    n_points, rest = np.divmod(counts, 3)
    first = (np.cumsum(counts) - counts) // 3
    degree = np.array([degree for _, degree in KINDS])[kinds]
    step = np.where(np.array([basis == b"bezier" for basis, _ in KINDS])[kinds], degree, 1)
    bad = np.flatnonzero((rest != 0) | (n_points <= degree) | ((n_points - 1 - degree) % step != 0))
    if len(bad):
        i = bad[0]
        raise source.error(
            f"curve {i + 1} has {counts[i]} numbers in its P; expected 3 for each point, {degree[i] + 1} points, and "
            f"{step[i]} more for each further piece; fix the file"
        )
    n_curves = (n_points - degree - 1) // step + 1
    control = np.empty((int(n_curves.sum()), 4, 3))
    begin = np.cumsum(n_curves) - n_curves
    for kind, (basis, order) in enumerate(KINDS):
        shapes = np.flatnonzero(kinds == kind)
        if not len(shapes):
            continue
        rows = _ranges(begin[shapes], n_curves[shapes])
        local = rows - np.repeat(begin[shapes], n_curves[shapes])
        start = np.repeat(first[shapes], n_curves[shapes]) + local * (order if basis == b"bezier" else 1)
        with np.errstate(all="ignore"):
            control[rows] = _to_bezier(points[start[:, None] + np.arange(order + 1)], basis, order)
    return control, n_curves


def _to_bezier(w: Float64Array, basis: bytes, degree: int) -> Float64Array:
    """Return the cubic Bezier control points of each curve."""
    if degree == 3:
        if basis == b"bezier":
            return w
        w0, w1, w2, w3 = np.moveaxis(w, 1, 0)
        return np.stack([(w0 + 4 * w1 + w2) / 6, (2 * w1 + w2) / 3, (w1 + 2 * w2) / 3, (w1 + 4 * w2 + w3) / 6], axis=1)
    w0, w1, w2 = np.moveaxis(w, 1, 0)
    if basis == b"bspline":
        w0, w2 = (w0 + w1) / 2, (w1 + w2) / 2
    return np.stack([w0, (w0 + 2 * w1) / 3, (2 * w1 + w2) / 3, w2], axis=1)


def _check_size(source: Source, scene: Scene, runs: IntArray, n_curves: IntArray) -> None:
    """Refuse instances that would make far more curves than the files have bytes."""
    total = np.append(0, np.cumsum(n_curves))
    is_instance = runs[:, 2] >= 0
    n_made = sum((total[runs[is_instance, 1]] - total[runs[is_instance, 0]]).tolist())
    if n_made * _CURVE_BYTES > UNPACK_FACTOR * scene.includes.n_unique + UNPACK_BYTES:
        raise source.error(f"its instances would make {n_made} curves, far more than it describes; write fewer of them")


def _ranges(first: IntArray, sizes: IntArray) -> IntArray:
    """Return ranges of `sizes` numbers that begin at `first`, one after the other."""
    return np.asarray(np.arange(int(sizes.sum())) + np.repeat(first - (np.cumsum(sizes) - sizes), sizes))


def _moved(
    control: Float64Array, rows: IntArray, matrices: Float64Array, which: IntArray, dtype: type[np.floating]
) -> npt.NDArray[np.floating]:
    """Return some curves as floats of a type, each transformed by one of the matrices."""
    moved = np.empty((len(rows), 4, 3), dtype)
    for start in range(0, len(rows), _ROWS):
        part = slice(start, start + _ROWS)
        matrix = matrices[which[part]]
        with np.errstate(all="ignore"):
            moved[part] = control[rows[part]] @ np.swapaxes(matrix[:, :3, :3], 1, 2) + matrix[:, None, :3, 3]
    return moved
