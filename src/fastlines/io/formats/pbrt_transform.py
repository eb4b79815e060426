"""The transforms of pbrt files, as float64 matrices (4, 4) for columns."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Matrix = npt.NDArray[np.float64]

#: So far the axes of a transform may differ from even scaling before it counts as uneven.
_EVEN = 1e-4


def translation(x: float, y: float, z: float) -> Matrix:
    """Return a translation."""
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


def scaling(x: float, y: float, z: float) -> Matrix:
    """Return a scaling along the axes."""
    return np.diag([x, y, z, 1.0])


def rotation(degrees: float, *axis: float) -> Matrix:
    """Return a rotation about an axis through the origin; NaN if the axis has no direction."""
    with np.errstate(all="ignore"):
        x, y, z = np.array(axis) / np.linalg.norm(axis)
        angle = np.radians(degrees)
        s, c = np.sin(angle), np.cos(angle)
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        along = np.outer([x, y, z], [x, y, z])
        matrix = np.eye(4)
        matrix[:3, :3] = c * np.eye(3) + s * cross + (1 - c) * along
    return matrix


def look_at(*numbers: float) -> Matrix:
    """Return the transform from the world to a left-handed camera of an eye, a target and an upward direction.

    NaN if these give no directions.
    """
    eye, target, up = np.reshape(numbers, (3, 3))
    with np.errstate(all="ignore"):
        forward = (target - eye) / np.linalg.norm(target - eye)
        right = np.cross(up / np.linalg.norm(up), forward)
        right = right / np.linalg.norm(right)
        axes = np.stack([right, np.cross(forward, right), forward])
        matrix = np.eye(4)
        matrix[:3, :3] = axes
        matrix[:3, 3] = -axes @ eye
    return matrix


def from_numbers(numbers: list[float]) -> Matrix | None:
    """Return a matrix of 16 numbers, column by column; None if it is not affine."""
    matrix = np.reshape(np.array(numbers, np.float64), (4, 4)).T
    if (matrix[3, :3] != 0).any() or matrix[3, 3] == 0 or not np.isfinite(matrix[3, 3]):
        return None
    return np.asarray(matrix / matrix[3, 3])


def width_scales(matrices: Matrix) -> tuple[Matrix, npt.NDArray[np.bool_]]:
    """Return by how much transforms, (k, 4, 4), scale widths, and which of them scale evenly in all directions.

    For the others it is the cube root of the scale of volumes.
    """
    linear = matrices[:, :3, :3]
    with np.errstate(all="ignore"):
        scale = np.cbrt(np.abs(np.linalg.det(linear)))
        squared = np.swapaxes(linear, 1, 2) @ linear
        off = np.abs(squared - scale[:, None, None] ** 2 * np.eye(3)).max(axis=(1, 2))
        is_even = off <= _EVEN * scale**2
        # Rotations scale by 1, but for rounding.
        return np.where(is_even & (np.abs(scale - 1) < 1e-12), 1.0, scale), is_even
