"""The frame of a fibre: inclinations from its cross section, and azimuths around its tangent.

For a tangent t and an outgoing direction o, e is the part of o across t, normalised, and b = t × e. A direction w has
the inclination θ with sin θ = w·t, and the azimuth φ = atan2(w·b, w·e): that of o is 0.

A ray towards -o that meets the fibre beside its axis has the offset h = n·(e × t), where n is the normal at its hit:
the distance from the axis to the side o × t, in radii. So the normal is at the azimuth -γo, with sin γo = h.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ...arrays import AnyArray, refuse_masked
from ...errors import InputError
from ...threads import map_in_threads

#: So many rows are computed at a time, which takes some tens of MB in float64.
ROWS = 1 << 15


@dataclass(frozen=True)
class FibreFrame:
    """The axes of n fibres and the inclination of their outgoing directions.

    Attributes
    ----------
    tangent, across, side : (n, 3) floats
        t, e and b; unit vectors.
    sin_o, cos_o : (n,) floats
        The inclination of the outgoing direction.
    """

    tangent: AnyArray
    across: AnyArray
    side: AnyArray
    sin_o: AnyArray
    cos_o: AnyArray

    @classmethod
    def of(cls, wo: AnyArray, tangent: AnyArray) -> FibreFrame:
        """Return the frame for outgoing directions (n, 3); any direction across replaces e where wo is along t."""
        sin_o = np.clip(np.einsum("ij,ij->i", wo, tangent), -1.0, 1.0)
        across = wo - sin_o[:, None] * tangent
        cos_o = np.sqrt(np.einsum("ij,ij->i", across, across))
        along = cos_o < 4.0 * np.finfo(wo.dtype).eps
        if along.any():
            least = np.abs(tangent[along]).argmin(axis=1)
            other = np.cross(tangent[along], np.eye(3, dtype=wo.dtype)[least])
            across[along] = other
        length = np.sqrt(np.einsum("ij,ij->i", across, across))
        across /= length[:, None]
        return cls(tangent, across, np.cross(tangent, across), sin_o, np.minimum(cos_o, 1.0))

    def angles(self, wi: AnyArray) -> tuple[AnyArray, AnyArray, AnyArray]:
        """Return sin θ, cos θ and the azimuth φ of other directions (n, 3)."""
        x = np.einsum("ij,ij->i", wi, self.across)
        y = np.einsum("ij,ij->i", wi, self.side)
        sine = np.clip(np.einsum("ij,ij->i", wi, self.tangent), -1.0, 1.0)
        return sine, np.minimum(np.hypot(x, y), 1.0), np.arctan2(y, x)

    def direction(self, sine: AnyArray, phi: AnyArray) -> AnyArray:
        """Return the unit vectors (n, 3) with these inclinations and azimuths."""
        cosine = np.sqrt(1.0 - sine**2)
        round_it = (cosine * np.cos(phi))[:, None] * self.across + (cosine * np.sin(phi))[:, None] * self.side
        return np.asarray(sine[:, None] * self.tangent + round_it)


def same_length(
    vectors: dict[str, npt.ArrayLike], numbers: dict[str, npt.ArrayLike], columns: int = 0
) -> tuple[tuple[int, ...], list[AnyArray]]:
    """Broadcast vectors (…, 3) and numbers (…) against each other, in float32 if all are, and else in float64.

    Parameters
    ----------
    vectors, numbers : dict of array_like
        By their names in error messages.
    columns : int
        If it is not 0, the last of `numbers` is (…, columns).

    Returns
    -------
    shape, arrays
        The common shape, and all arrays with this shape made flat and contiguous: (n, 3), (n,) and (n, columns).
    """
    given = {name: _floats(name, value) for name, value in (vectors | numbers).items()}
    ends = dict.fromkeys(vectors, 3)
    if columns:
        ends[list(numbers)[-1]] = columns
    for name, end in ends.items():
        if given[name].ndim == 0 or given[name].shape[-1] != end:
            raise InputError(f"{name} has shape {given[name].shape}; expected (…, {end})")
    kind = np.result_type(*given.values())
    heads = [array.shape[:-1] if name in ends else array.shape for name, array in given.items()]
    try:
        shape = np.broadcast_shapes(*heads)
    except ValueError:
        shapes = ", ".join(f"{name} {array.shape}" for name, array in given.items())
        raise InputError(f"the shapes do not fit together: {shapes}") from None
    flat = []
    for name, array in given.items():
        row = (ends[name],) if name in ends else ()
        flat.append(np.ascontiguousarray(np.broadcast_to(array, shape + row).reshape(-1, *row), kind))
    return shape, flat


def in_batches(function: Callable[..., tuple[AnyArray, ...]], arrays: Iterable[AnyArray]) -> tuple[AnyArray, ...]:
    """Call a function with some rows of arrays of one length at a time, and join what it returns.

    There are several calls at a time. Between them, Ctrl-C ends the work.
    """
    given = tuple(arrays)
    if len(given[0]) <= ROWS:
        return function(*given)
    batches = [[each[first : first + ROWS] for each in given] for first in range(0, len(given[0]), ROWS)]
    found = map_in_threads(lambda batch: function(*batch), batches)
    return tuple(np.concatenate(parts) for parts in zip(*found, strict=True))


def _floats(name: str, values: npt.ArrayLike) -> AnyArray:
    refuse_masked(values, name)
    try:
        array = np.asarray(values)
    except ValueError as error:
        raise InputError(f"{name} cannot be read as an array: {error}") from None
    if array.dtype.kind not in "fiub":
        raise InputError(f"{name} is of dtype {array.dtype}; expected numbers")
    return array if array.dtype == np.float32 else array.astype(np.float64, copy=False)
