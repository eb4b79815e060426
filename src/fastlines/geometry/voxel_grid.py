"""The voxel grid of an image in the world, which files of streamlines name: programs compare it with their image.

*Voxel millimetres* are voxel sizes times voxel indices, from the corner of the first voxel, along the axes that
``voxel_order`` names. ``voxel_to_rasmm`` takes voxel indices, which count from the centre of the first voxel, to world
millimetres, axes to the Right, Anterior and Superior ("RASMM"). Where the directions of its axes differ from
``voxel_order``, axes are swapped and mirrored first.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from ..arrays import FloatArray, box_of
from ..errors import InputError

Matrix: TypeAlias = npt.NDArray[np.float64]

#: Where `Lines.metadata` keep the grid.
GRID = "grid"
#: The voxel order that TrackVis assumes if it is missing.
DEFAULT_ORDER = "LPS"
#: The directions of an axis: towards more and towards less of x, y and z in the world.
_DIRECTIONS = ("RL", "AP", "SI")
#: A grid around lines has no more voxels than these along an axis.
_MOST_VOXELS = 512
#: How far outside of a grid a point may be for rounding, in voxels.
_ROUNDING = 1e-4


@dataclass(frozen=True, eq=False)
class VoxelGrid:
    """The voxel grid of an image.

    Attributes
    ----------
    dimensions : (3,) array of int
        The numbers of voxels.
    voxel_sizes : (3,) array of float
        In millimetres.
    voxel_order : str
        The directions of the axes, such as ``"RAS"``.
    voxel_to_rasmm : (4, 4) float64, or None
        None where a file has no transform to the world.
    """

    dimensions: npt.NDArray[np.int64]
    voxel_sizes: Matrix
    voxel_order: str
    voxel_to_rasmm: Matrix | None

    @classmethod
    def from_mapping(cls, given: Any, name: str) -> VoxelGrid:
        """Return the grid of metadata or of the header of a tractogram; `name` is what errors call it.

        Examples
        --------
        >>> given = {"dimensions": [4, 5, 6], "voxel_to_rasmm": np.diag([-2, 2, 2, 1])}
        >>> VoxelGrid.from_mapping(given, "grid").voxel_order
        'LAS'
        """
        if not isinstance(given, Mapping) or not ({"dimensions", "DIMENSIONS"} & given.keys()):
            raise InputError(f"{name}: expected a mapping with 'dimensions' and 'voxel_to_rasmm', the grid of an image")
        matrix = given.get("voxel_to_rasmm", given.get("VOXEL_TO_RASMM"))
        order = given.get("voxel_order")
        return cls.from_parts(
            name, given.get("dimensions", given.get("DIMENSIONS")), matrix, given.get("voxel_sizes"), order
        )

    @classmethod
    def of_tractogram(cls, obj: Any, name: str) -> VoxelGrid | None:
        """Return the grid of a ``StatefulTractogram`` or of the header of a file; None if there is none."""
        if hasattr(obj, "space_attributes"):
            matrix, shape, sizes, order = obj.space_attributes
            return cls.from_parts(name, shape, matrix, sizes, order)
        header = getattr(obj, "header", None)
        if not isinstance(header, Mapping) or not ({"dimensions", "DIMENSIONS"} & header.keys()):
            return None
        return cls.from_mapping(header, name)

    @classmethod
    def from_parts(cls, name: str, dimensions: Any, matrix: Any, sizes: Any = None, order: Any = None) -> VoxelGrid:
        """Check the parts of a grid; sizes and order are by default those of the matrix."""
        shape = _whole(dimensions)
        if shape is None or (shape < 1).any():
            raise InputError(f"{name}: its dimensions are {dimensions!r}; expected three numbers of voxels, 1 or more")
        to_world = None if matrix is None else _numbers(name, "voxel_to_rasmm", matrix, (4, 4))
        if to_world is not None and np.linalg.matrix_rank(to_world[:3, :3]) < 3:
            raise InputError(f"{name}: its voxel_to_rasmm, {matrix!r}, cannot be inverted")
        if sizes is None and to_world is not None:
            sizes = np.linalg.norm(to_world[:3, :3], axis=0)
        checked = _numbers(name, "voxel_sizes", sizes, (3,))
        if to_world is not None and not checked.all():
            raise InputError(f"{name}: its voxel_sizes are {sizes!r}; expected three numbers that are not 0")
        text = order.decode("latin-1") if isinstance(order, bytes) else order
        if text is None and to_world is not None:
            text = axis_directions(to_world[:3, :3])
        if not isinstance(text, str) or not is_order(text.strip().upper()):
            raise InputError(f"{name}: its voxel_order is {order!r}; expected three directions, such as 'RAS'")
        return cls(shape, checked, text.strip().upper(), to_world)

    @classmethod
    def around(cls, points: FloatArray) -> VoxelGrid:
        """Return a grid that holds points (n, 3), with voxels of 1 mm, or larger ones where there would be many.

        It begins at 0 along axes whose coordinates are from 0 to 512, which keep their bits in voxel millimetres.

        Examples
        --------
        >>> grid = VoxelGrid.around(np.array([[-3.5, 0, 1], [9, 2, 1]], np.float32))
        >>> grid.dimensions, grid.voxel_to_rasmm[:3, 3]
        (array([15,  3,  2]), array([-4.5,  0.5,  0.5]))
        """
        some = points if len(points) else np.zeros((1, 3), np.float32)
        low, high = some.min(axis=0).astype(np.float64), some.max(axis=0).astype(np.float64)
        from_0 = (low >= 0) & (high <= _MOST_VOXELS)
        low[from_0] = 0
        far = max(float((high - low).max()) / _MOST_VOXELS, float(np.maximum(high, -low).max()) * 2.0**-20)
        size = 2.0 ** max(0, math.ceil(math.log2(far))) if far else 1.0
        corner = np.where(from_0, 0, (np.floor(low / size) - 1) * size)
        shape = np.ceil((high - corner) / size).astype(np.int64) + 1
        to_world = np.diag([size, size, size, 1.0])
        to_world[:3, 3] = corner + size / 2
        return cls(shape, np.full(3, size), "RAS", to_world)

    @property
    def is_usable(self) -> bool:
        """Whether there are voxels, of finite sizes."""
        return bool((self.dimensions >= 1).all() and np.isfinite(self.voxel_sizes).all())

    def to_metadata(self) -> dict[str, Any]:
        """Return the grid as metadata of lines."""
        transform = {} if self.voxel_to_rasmm is None else {"voxel_to_rasmm": self.voxel_to_rasmm}
        rest = {"dimensions": self.dimensions, "voxel_sizes": self.voxel_sizes, "voxel_order": self.voxel_order}
        return transform | rest

    def to_rasmm(self) -> Matrix:
        """Return the matrix (3, 4) from voxel millimetres to RASMM."""
        if self.voxel_to_rasmm is None:
            return np.eye(3, 4)
        # Pair each axis of the transform with one of the points, mirrored where their directions differ.
        rotation, order = self.voxel_to_rasmm[:3, :3], self.voxel_order
        indices = np.zeros((3, 4))
        for row, letter in enumerate(axis_directions(rotation)):
            column = [_axis_of(other) for other in order].index(_axis_of(letter))
            indices[row, column], indices[row, 3] = 1 / self.voxel_sizes[column], -0.5
            if order[column] != letter:
                indices[row] *= -1
                indices[row, 3] += self.dimensions[column] - 1
        matrix: Matrix = rotation @ indices
        matrix[:, 3] += self.voxel_to_rasmm[:3, 3]
        return matrix

    def count_outside(self, points: FloatArray) -> int:
        """Return how many points in RASMM lie outside of the voxels."""
        # Mostly the whole box of the points is inside.
        corners = np.array(list(product(*box_of(points).T)))
        return self._count_outside(points) if len(points) and self._count_outside(corners) else 0

    def _count_outside(self, points: FloatArray) -> int:
        if self.voxel_to_rasmm is None:
            return 0
        at = transform(inverse(self.voxel_to_rasmm[:3]), points) + 0.5
        return int(((at < -_ROUNDING) | (at > self.dimensions + _ROUNDING)).any(axis=1).sum())


def transform(matrix: Matrix, points: FloatArray) -> npt.NDArray[np.floating]:
    """Transform points in float64, or return them as they are if the matrix changes nothing."""
    if np.array_equal(matrix, np.eye(3, 4)):
        return points  # bit for bit, signs of zeros included
    with np.errstate(invalid="ignore", over="ignore"):  # NaN and Inf are reported with their rows
        return np.asarray(points @ matrix[:, :3].T + matrix[:, 3])


def inverse(matrix: Matrix) -> Matrix:
    """Return the inverse of a matrix (3, 4)."""
    return np.asarray(np.linalg.inv(np.vstack([matrix, [0, 0, 0, 1]]))[:3], np.float64)


def is_order(text: str) -> bool:
    """Return whether a text names three directions, each axis once.

    Examples
    --------
    >>> is_order("LPS"), is_order("LRS")
    (True, False)
    """
    return sorted(_axis_of(letter) for letter in text) == [0, 1, 2]


def axis_directions(matrix: Matrix) -> str:
    """Name the direction of each column of a matrix (3, 3): the nearest of R L, A P, S I, each axis once."""
    # Remove shear by the nearest rotation; then let the clearest column choose first.
    u, _, vt = np.linalg.svd(matrix / np.linalg.norm(matrix, axis=0))
    rotation = u @ vt
    directions = [""] * 3
    for column in np.argsort(-np.abs(rotation).max(axis=0), kind="stable"):
        axis = int(np.abs(rotation[:, column]).argmax())
        directions[column] = _DIRECTIONS[axis][int(rotation[axis, column] < 0)]
        rotation[axis] = 0
    return "".join(directions)


def _axis_of(letter: str) -> int:
    """Return which axis of the world a letter names; -1 if none."""
    return next((axis for axis, letters in enumerate(_DIRECTIONS) if letter in letters), -1)


def _whole(dimensions: Any) -> npt.NDArray[np.int64] | None:
    """Return three whole numbers of voxels, which JSON may have as 9.0; None if they are something else."""
    try:
        shape = np.asarray(dimensions)[:3]
    except (ValueError, IndexError):  # lists of different lengths, or a single number
        return None
    if shape.shape != (3,) or shape.dtype.kind not in "iuf" or not (np.abs(shape) < 2**62).all():
        return None
    whole = shape.astype(np.int64)
    return whole if (whole == shape).all() else None


def _numbers(name: str, part: str, values: Any, shape: tuple[int, ...]) -> Matrix:
    """Return finite numbers of a shape in float64."""
    try:
        array = np.asarray(values, np.float64)
    except (TypeError, ValueError, OverflowError):
        array = np.empty(0)
    if array.shape != shape or not np.isfinite(array).all():
        raise InputError(f"{name}: its {part} are {values!r}; expected finite numbers of shape {shape}")
    return array
