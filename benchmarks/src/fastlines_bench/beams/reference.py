"""A reference picture that has noise of its own, and errors beside it that do not count this noise."""

from __future__ import annotations

import math

from ..harness.arrays import BoolArray, Float64Array


class Reference:
    """Two independent halves of a reference.

    The differences of a picture from both halves have noise that is independent. So the mean of their products is the
    mean squared error of the picture alone. It is known up to what such products of the halves' noise add up to.

    Parameters
    ----------
    one, other : (height, width, 3) float64
        The halves.
    counted : (height, width) bool
        The pixels that count.

    Attributes
    ----------
    picture : (height, width, 3) float64
        The mean of both halves.
    mean : float
        Its mean radiance.
    floor : float
        The least error that can be told from 0, as a fraction of the mean radiance. It depends on the halves alone.
    """

    def __init__(self, one: Float64Array, other: Float64Array, counted: BoolArray) -> None:
        self._one, self._other, self._counted = one, other, counted
        self.picture = (one + other) / 2
        self.mean = float(self.picture[counted].mean())
        # A product of the halves' noise has the variance of a half as its standard deviation.
        variance = ((one - other)[counted] ** 2).mean(axis=1) / 2
        self.floor: float = float((variance**2).mean() / len(variance)) ** 0.25 / self.mean

    def error(self, picture: Float64Array) -> float:
        """Return the root mean squared error of a picture, as a fraction of the mean radiance; at least `floor`."""
        squared = float(((picture - self._one) * (picture - self._other))[self._counted].mean())
        return max(self.floor, math.sqrt(max(squared, 0.0)) / self.mean)
