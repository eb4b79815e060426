"""The random numbers that fragments are shaded with, each pair of them a point of a Sobol sequence."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ...arrays import FloatArray
from ...engines import engine
from .sobol import Words, hashed


class Sampler:
    """Uniform random numbers for the fragments of one sample: a pair of them at a time.

    Examples
    --------
    >>> sampler = Sampler(0, hashed(np.arange(5, dtype=np.uint32)))
    >>> [numbers.shape for numbers in sampler.next_2d()]
    [(5,), (5,)]
    """

    def __init__(self, index: int, seeds: Words, dimension: int = 2) -> None:
        # Dimensions 0 and 1 are the place in the pixel; reusing them would tie what is drawn to that place.
        self.index, self.seeds, self.dimension = index, seeds, dimension

    def next_2d(self) -> tuple[FloatArray, FloatArray]:
        """Return the next pair of uniform numbers, (n,) each, in [0, 1)."""
        first, second = engine.sample_numbers(self.index, self.seeds, self.dimension, 2)
        self.dimension += 2
        return first, second

    @classmethod
    def of_fragments(cls, index: int, pixels: Words, ray: npt.NDArray[np.int64]) -> Sampler:
        """Seed by the pixel of each fragment's ray and the fragment's place behind it."""
        first = np.flatnonzero(np.concatenate([[True], ray[1:] != ray[:-1]]))
        rank = np.arange(len(ray)) - np.repeat(first, np.diff(np.append(first, len(ray)))) if len(ray) else ray
        return cls(index, hashed(pixels[ray] + hashed(rank.astype(np.uint32), 1), 2))
