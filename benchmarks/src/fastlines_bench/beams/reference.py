"""A reference picture that has noise of its own, and errors beside it that do not count this noise."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..harness.arrays import BoolArray, Float64Array


class Reference:
    """The mean of four independent quarters, two in each half.

    The differences of a picture from both halves have noise that is independent. So the mean of their products is the
    mean squared error of the picture alone. Half the difference of two quarters has the noise of their mean, a half,
    without the picture: products of these say how uncertain that is.

    Parameters
    ----------
    quarters : sequence of four (height, width, 3) float64
    counted : (height, width) bool
        The pixels that count.

    Attributes
    ----------
    picture : (height, width, 3) float64
        The mean of all.
    mean : float
        Its mean radiance.
    floor : float
        The least error that can be told from 0, as a fraction of the mean radiance: its square is two standard errors.
        It depends on the quarters alone.
    """

    def __init__(self, quarters: Sequence[Float64Array], counted: BoolArray) -> None:
        first, second, third, fourth = quarters
        self._halves, self._counted = ((first + second) / 2, (third + fourth) / 2), counted
        self.picture: Float64Array = np.mean(quarters, axis=0)
        self.mean = float(self.picture[counted].mean())
        products = ((first - second) / 2 * (third - fourth) / 2)[counted].mean(axis=1)
        standard_error = math.sqrt((products**2).mean() / len(products))
        self.floor = math.sqrt(2 * standard_error) / self.mean

    def error(self, picture: Float64Array) -> float:
        """Return the root mean squared error of a picture, as a fraction of the mean radiance; at least `floor`."""
        one, other = self._halves
        squared = float(((picture - one) * (picture - other))[self._counted].mean())
        return max(self.floor, math.sqrt(max(squared, 0.0)) / self.mean)
