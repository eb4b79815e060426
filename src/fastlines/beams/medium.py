"""Media that scatter light: fog, smoke, water.

A medium absorbs σ_a and scatters σ_s of the light per unit of length; together they are the extinction σ_t. All three
are RGB. A grid multiplies them by a density ρ(x). The column depth D of a path is the integral of ρ along it, and its
length where ρ = 1. So light of a channel passes with the probability exp(−σ_t · D), the transmittance.

A photon's flight ends at the column depth −ln(1 − ξ) / σ_t. Channels may differ in σ_t: the flight is that of a channel
chosen at random, and the power is weighted by the ratio of each channel's density to the mean of all (the balance
heuristic). Where channels are the same, the weight is 1.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from ..arrays import FloatArray, IntArray, number
from ..camera import Vector
from ..errors import InputError
from ..support.counter_random import Float64Array, UInt64Array, uniform
from .coefficients import BoolArray, rgb


class Flights(NamedTuple):
    """Flights of n photons through a medium.

    Attributes
    ----------
    t : (n,) float64
        Where each ends: at a collision, or at the end of the medium.
    collides : (n,) bool
        Whether it ends at a collision.
    weight : (n, 3) float64
        By what the power is multiplied.
    beam_length : (n,) float64
        The length of its short beam, which is not less than t.
    """

    t: Float64Array
    collides: BoolArray
    weight: Float64Array
    beam_length: Float64Array


class Sources(NamedTuple):
    """The light that beams scatter.

    Attributes
    ----------
    segments : (m, 2, 3) float32
        The beams, or pieces of them.
    beam : (m,) int or None
        The beam that each is a piece of; None if no beam is cut.
    scattered : (m, 3) or (3,) float64
        σ_s there; of a piece, times the mean of what is left of the power along it.
    decay : (3,) float64
        The extinction that is left to apply along each.
    """

    segments: FloatArray
    beam: IntArray | None
    scattered: Float64Array
    decay: Float64Array


class Medium(Protocol):
    """What a scene asks of a medium; `HomogeneousMedium` and `GridMedium` are two.

    Attributes
    ----------
    absorption, scattering : (3,) float
        σ_a and σ_s per unit of length, where the density is 1.
    g : float
        The mean cosine of the angle of scattering.
    n_steps : int
        How many depths `gather_options` returns for each ray; 1 if it returns none.
    """

    @property
    def absorption(self) -> Vector:
        """σ_a."""

    @property
    def scattering(self) -> Vector:
        """σ_s."""

    @property
    def g(self) -> float:
        """The mean cosine."""

    @property
    def n_steps(self) -> int:
        """The number of depths of a ray."""

    @property
    def extinction(self) -> Float64Array:
        """σ_t, (3,) float64."""

    def distance_at(
        self, origins: Float64Array, directions: Float64Array, lengths: Float64Array, depths: Float64Array
    ) -> tuple[Float64Array, Float64Array]:
        """Return the distance at which paths have column depths, (n,), or their length; and the column depth there."""

    def gather_options(
        self, origins: Float64Array, directions: Float64Array, lengths: Float64Array
    ) -> Mapping[str, Any]:
        """Return the arguments of `Tree.gather` that tell it the transmittance along rays."""

    def transmittance(self, origins: Float64Array, directions: Float64Array, lengths: Float64Array) -> Float64Array:
        """Return the transmittance along paths, (n, 3)."""

    def sources(self, segments: FloatArray, decay: Float64Array) -> Sources:
        """Return the light that beams, (n, 2, 3) float32, scatter, from the extinction along them, (3,)."""


def fly(
    medium: Medium, origins: Float64Array, directions: Float64Array, lengths: Float64Array, keys: UInt64Array
) -> Flights:
    """Let photons fly through a medium until they collide with it, or at most a length.

    Parameters
    ----------
    origins, directions : (n, 3) float64
    lengths : (n,) float64
        To the end of the medium.
    keys : (n,) uint64
        Of their random numbers.
    """
    extinction = medium.extinction
    least = extinction.min()
    depth = -np.log1p(-uniform(keys, 0))
    if extinction.max() == least:
        t, _ = medium.distance_at(origins, directions, lengths, depth / least)
        return Flights(t, t < lengths, np.ones((len(t), 3)), t)
    # Choose a channel, and weight the power by how likely each channel is to fly so.
    chosen = np.minimum((uniform(keys, 1) * 3).astype(np.int64), 2)
    with np.errstate(divide="ignore"):
        ends = np.where(extinction > 0, depth[:, None] / extinction, np.inf)
    t, column = medium.distance_at(origins, directions, lengths, ends[np.arange(len(ends)), chosen])
    collides = t < lengths
    passed = np.exp(-column[:, None] * extinction)
    density = np.where(collides[:, None], extinction, 1.0) * passed
    weight = density / density.mean(axis=1, keepdims=True)
    beam_length, _ = medium.distance_at(origins, directions, lengths, ends.max(axis=1))
    return Flights(t, collides, weight, beam_length)


class Coefficients:
    """The checks and properties that all media share."""

    absorption: Vector
    scattering: Vector
    g: float

    def _check(self) -> None:
        for name in ("absorption", "scattering"):
            object.__setattr__(self, name, rgb(name, getattr(self, name), "per unit of length"))
        object.__setattr__(self, "g", number("g", self.g, "a mean cosine between -1 and 1", -0.999, 0.999))
        if not any(self.scattering):
            what = "has no extinction" if not any(self.absorption) else "only absorbs light"
            raise InputError(
                f"the medium {what}: scattering={self.scattering}; expected a number above 0 in a channel, as what "
                "scatters no light is not seen"
            )

    @property
    def extinction(self) -> Float64Array:
        """σ_t per unit of length, (3,) float64."""
        return np.add(self.absorption, self.scattering)


@dataclass(frozen=True)
class HomogeneousMedium(Coefficients):
    """A medium that is the same everywhere.

    Parameters
    ----------
    absorption, scattering : number or (3,) numbers
        σ_a and σ_s per unit of length: for all channels, or for red, green and blue.
    g : float
        The mean cosine of the angle of scattering (Henyey and Greenstein 1941): 0 scatters evenly, near 1 straight on.

    Raises
    ------
    InputError
        If a number is negative or not finite, g is not between -1 and 1, or nothing is scattered.

    Examples
    --------
    >>> fog = HomogeneousMedium(absorption=0.1, scattering=(0.8, 0.9, 1.0), g=0.5)
    >>> fog.extinction.round(6).tolist()
    [0.9, 1.0, 1.1]
    """

    absorption: Vector
    scattering: Vector
    g: float = 0.0
    n_steps: ClassVar[int] = 1

    def __init__(self, absorption: npt.ArrayLike, scattering: npt.ArrayLike, g: float = 0.0) -> None:
        for name, value in (("absorption", absorption), ("scattering", scattering), ("g", g)):
            object.__setattr__(self, name, value)
        self._check()

    def distance_at(
        self, origins: Float64Array, directions: Float64Array, lengths: Float64Array, depths: Float64Array
    ) -> tuple[Float64Array, Float64Array]:
        """See `Medium`; column depth is length."""
        t = np.minimum(depths, lengths)
        return t, t

    def gather_options(
        self, origins: Float64Array, directions: Float64Array, lengths: Float64Array
    ) -> Mapping[str, Any]:
        """See `Medium`."""
        return {"sigma": self.extinction}

    def transmittance(self, origins: Float64Array, directions: Float64Array, lengths: Float64Array) -> Float64Array:
        """See `Medium`."""
        return np.exp(-lengths[:, None] * self.extinction)

    def sources(self, segments: FloatArray, decay: Float64Array) -> Sources:
        """See `Medium`; no beam is cut."""
        return Sources(segments, None, np.asarray(self.scattering), decay)
