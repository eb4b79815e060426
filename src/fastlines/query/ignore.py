"""What queries leave out: primitives and strands, for all rays or for each ray."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ..arrays import IntArray, to_integers
from ..errors import InputError
from ..geometry.any_geometry import AnyGeometry
from ..support.distinct import is_among
from ..support.texts import singular


@dataclass(frozen=True)
class Ignored:
    """Numbers to leave out, (k,) for all rays or (n_rays, m) for each ray; -1 names nothing."""

    numbers: IntArray
    #: Whether they are those of strands, not of primitives.
    are_strands: bool = False

    @property
    def is_per_ray(self) -> bool:
        """Whether each ray has numbers of its own."""
        return self.numbers.ndim == 2

    def some(self, rows: IntArray | slice) -> Ignored:
        """Return what the rays in these rows leave out."""
        return replace(self, numbers=self.numbers[rows]) if self.is_per_ray else self

    def compared(self, geometry: AnyGeometry, prim: IntArray) -> IntArray:
        """Return the number of each of some primitives that these are compared with."""
        return strand_numbers(geometry, prim) if self.are_strands else prim

    def drops(self, geometry: AnyGeometry, prim: IntArray, ray: IntArray) -> npt.NDArray[np.bool_]:
        """Return whether each hit of a primitive by a ray is left out; a prim of -1 is none."""
        dropped, found = np.zeros(len(prim), np.bool_), np.flatnonzero(prim >= 0)
        number = self.compared(geometry, prim[found])
        if self.is_per_ray:
            same = (self.numbers[ray[found]] == number[:, None]).any(axis=1)
        else:
            same = is_among(number, self.numbers)
        dropped[found] = same & (number >= 0)
        return dropped


def ignored_of(
    geometry: AnyGeometry, shape: tuple[int, ...], ignore: Any, ignore_strands: Any, nouns: str = "rays"
) -> tuple[Ignored, ...]:
    """Check the arguments `ignore` and `ignore_strands` for rays of some shape, or for what else `nouns` says."""
    found = []
    if ignore is not None:
        numbers = _numbers("ignore", ignore, shape, nouns)
        _check_range("ignore", numbers, len(geometry), "primitives")
        found.append(Ignored(numbers))
    if ignore_strands is not None:
        numbers = _numbers("ignore_strands", ignore_strands, shape, nouns)
        if _is_hits(ignore_strands):
            _check_range("ignore_strands", numbers, len(geometry), "primitives")
            named = numbers >= 0
            numbers = np.array(numbers)
            numbers[named] = strand_numbers(geometry, numbers[named])
        else:
            _check_range("ignore_strands", numbers, end_of_strands(geometry), "strands")
        found.append(Ignored(numbers, are_strands=True))
    return tuple(found)


def _is_hits(given: Any) -> bool:
    return hasattr(given, "prim") and hasattr(given, "part")


def _numbers(name: str, given: Any, shape: tuple[int, ...], nouns: str) -> IntArray:
    """Return what was given as (k,), or as (n_rays, m) if it is per ray."""
    if _is_hits(given):
        if hasattr(given, "offsets"):
            raise InputError(
                f"{name} are lists of hits; expected first hits, one for each of the {nouns} {shape}, or numbers of "
                "primitives, such as hits.prim_number[…]"
            )
        numbers = given.prim_number[..., None]
    else:
        numbers = np.atleast_1d(to_integers(given, name))
        if numbers.ndim == 1:
            return numbers
    m = numbers.shape[-1]
    try:
        per_ray = np.broadcast_to(numbers, (*shape, m))
    except ValueError:
        expected = f"that of the {nouns} {shape}, or one that broadcasts to it"
        if _is_hits(given):
            raise InputError(
                f"{name} are hits of shape {given.prim.shape}; expected {expected}; for some of them pass "
                "hits.prim_number[…]"
            ) from None
        raise InputError(
            f"{name} has shape {numbers.shape}; expected (k,) for all {nouns}, or (…, m) with m numbers for each "
            f"{singular(nouns)}, where … is {expected}"
        ) from None
    return per_ray.reshape(math.prod(shape), m)


def _check_range(name: str, numbers: IntArray, n: int, what: str) -> None:
    if numbers.size and (numbers.max() >= n or numbers.min() < -1):
        wrong = numbers.max() if numbers.max() >= n else numbers.min()
        raise InputError(f"{name} names {wrong}; there are {n} {what}, which count from 0, and -1 is none")


def strand_numbers(geometry: AnyGeometry, prim: IntArray) -> IntArray:
    """Return the strand of each of some primitives, different for each part; -1 for none."""
    part, number = geometry.split(prim)
    if part is None:
        return geometry.strands_of(number)
    found, used = np.full(len(prim), -1), 0
    for i, each in enumerate(geometry.each_part()):
        here = np.flatnonzero(part == i)
        of_part = each.strands_of(number[here])
        found[here] = np.where(of_part < 0, -1, of_part + used)
        used += each.end_of_strands
    return found


def end_of_strands(geometry: AnyGeometry) -> int:
    """Return one more than the greatest number of a strand."""
    return sum(part.end_of_strands for part in geometry.each_part())
