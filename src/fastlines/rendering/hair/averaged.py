"""Hair seen from afar: the scattering of a fibre thinner than a pixel, from tables.

What a pixel receives is the mean over the fibre's width, A_p N_p averaged over h, times M_p. The mean is a bilinear
lookup in (θo, |φ|); M_p is evaluated as it is. The tables are in `table`.

Dual scattering (Zinke et al. 2008, "Dual Scattering Approximation for Fast Multiple Scattering in Hair", eq. 6 and 12)
counts with two attenuations of a fibre, averages over the half space that light comes from:

    a_f(θ) = 1/π ∫ ∫ f(θ, φ; ω) dω dφ     over φ in a half plane and ω in the half space on the other side,

and a_b(θ) with ω on the same side. For a fibre that is round, only the azimuth between both counts. Of all pairs at an
azimuth φ, the part |φ|/π is on opposite sides, so a_f(θ) = Σ_p ∫ N̄_p(φ; θ) |φ|/π dφ, and a_b has 1 - |φ|/π.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from ...arrays import AnyArray, FloatArray
from .frame import batches, same_length
from .longitudinal import longitudinal
from .material import HairMaterial
from .table import N_INCLINATIONS, AzimuthTable, azimuth_table


@dataclass(frozen=True)
class AveragedHair:
    """The scattering of fibres thinner than a pixel, averaged over their width.

    Parameters
    ----------
    material : HairMaterial

    Examples
    --------
    >>> hair = AveragedHair(HairMaterial.from_melanin(0.6, redness=0.2))
    >>> hair.evaluate(0.1, [0.0, 0.3], 0.5).shape
    (2, 3)
    >>> sums = hair.forward(0.2) + hair.backward(0.2)
    >>> bool((sums < 1).all()), bool(sums[0] > sums[2])  # brown hair absorbs blue
    (True, True)
    """

    material: HairMaterial
    _table: AzimuthTable = field(init=False, repr=False, compare=False)
    _attenuations: FloatArray = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        table = azimuth_table(self.material)
        object.__setattr__(self, "_table", table)
        object.__setattr__(self, "_attenuations", _attenuations(table))

    def evaluate(self, sin_theta_o: npt.ArrayLike, sin_theta_i: npt.ArrayLike, phi: npt.ArrayLike) -> FloatArray:
        """Return the mean of `evaluate_angles` over all offsets h from -1 to 1.

        Parameters
        ----------
        sin_theta_o, sin_theta_i : (…) array_like
            Sines of the inclinations of the directions towards the camera and the light: wo·tangent and wi·tangent.
        phi : (…) array_like
            The azimuth between both around the tangent, in radians, of any turn and sign.

        Returns
        -------
        (…, 3) float32
            Linear RGB per steradian. The light from wi, times the solid angle that it fills, times this value, is the
            light that leaves towards wo: cos θi is included.
        """
        numbers = {"sin_theta_o": sin_theta_o, "sin_theta_i": sin_theta_i, "phi": phi}
        shape, (sin_o, sin_i, turn) = same_length({}, numbers)
        result = np.empty((len(turn), 3), np.float32)
        for part in batches(len(turn)):
            result[part] = self._batch(*(each[part].astype(np.float32, copy=False) for each in (sin_o, sin_i, turn))).T
        return result.reshape(*shape, 3)

    def forward(self, sin_theta: npt.ArrayLike) -> FloatArray:
        """Return a_f: the share of the light at an inclination that one fibre scatters onwards.

        Parameters
        ----------
        sin_theta : (…) array_like
            The sine of the inclination.

        Returns
        -------
        (…, 3) float32
            Linear RGB, from 0 to 1.
        """
        return self._attenuation(0, sin_theta)

    def backward(self, sin_theta: npt.ArrayLike) -> FloatArray:
        """Return a_b: the share of the light at an inclination that one fibre scatters back; see `forward`."""
        return self._attenuation(1, sin_theta)

    def _batch(self, sin_o: FloatArray, sin_i: FloatArray, phi: FloatArray) -> AnyArray:
        """Return the values of float32 samples as (3, n)."""
        cos_o = np.sqrt(np.maximum(1.0 - sin_o * sin_o, 0.0))
        cos_i = np.sqrt(np.maximum(1.0 - sin_i * sin_i, 0.0))
        around = self._lookup(cos_o, phi)
        along = []
        for tilt, variance in zip(self.material.tilts, self.material.variances, strict=True):
            sine, cosine = math.sin(tilt), math.cos(tilt)
            tilted = sin_o * cosine + cos_o * sine
            along.append(longitudinal(sin_i, cos_i, tilted, np.abs(cos_o * cosine - sin_o * sine), variance))
        value = around[1:4] * along[1]
        value += around[4:7] * along[2]
        value += around[7:10] * along[3]
        value += around[0] * along[0]
        return value

    def _lookup(self, cos_o: FloatArray, phi: FloatArray) -> AnyArray:
        """Return N̄ of all lobes, as (10, n)."""
        n = self._table.n_azimuths
        # Find the cells.
        turned = np.abs(phi - np.float32(2.0 * math.pi) * np.rint(phi * np.float32(0.5 / math.pi)))
        x = np.minimum(turned * np.float32(n / math.pi), np.float32(n))
        y = (cos_o + cos_o * cos_o) * np.float32(0.5 * N_INCLINATIONS)
        column = np.fmin(x, n - 1).astype(np.int32)  # NaN stays in x
        row = np.fmin(y, N_INCLINATIONS - 1).astype(np.int32)
        x -= column
        y -= row
        # Interpolate in each table.
        result = np.empty((10, len(phi)), np.float32)
        corner = row * (n + 1) + column
        right, down, over = (1.0 - y) * x, y * (1.0 - x), x * y
        here = 1.0 - x - down
        for channel, values in enumerate(self._table.values.reshape(7, -1)):
            mixed = values.take(corner) * here
            mixed += values[1:].take(corner) * right
            mixed += values[n + 1 :].take(corner) * down
            mixed += values[n + 2 :].take(corner) * over
            result[channel] = mixed
        for channel, values in enumerate(self._table.rest):
            result[7 + channel] = values.take(row) * (1.0 - y) + values[1:].take(row) * y
        return result

    def _attenuation(self, side: int, sin_theta: npt.ArrayLike) -> FloatArray:
        shape, (sine,) = same_length({}, {"sin_theta": sin_theta})
        cosine = np.sqrt(np.maximum(1.0 - sine**2, 0.0))
        at = np.linspace(0.0, 1.0, N_INCLINATIONS + 1)
        row = 0.5 * (cosine + cosine**2)
        channels = [np.interp(row, at, each) for each in self._attenuations[side]]
        return np.stack(channels, axis=-1).astype(np.float32).reshape(*shape, 3)


def _attenuations(table: AzimuthTable) -> FloatArray:
    """Integrate the tables over φ; return a_f and a_b as (2, 3, rows)."""
    part = np.linspace(0.0, 1.0, table.n_azimuths + 1)
    weight = np.full(table.n_azimuths + 1, 2.0 * math.pi / table.n_azimuths)
    weight[[0, -1]] *= 0.5
    found = []
    for share in (part, 1.0 - part):
        lobes = table.values @ (share * weight)
        found.append(lobes[0] + lobes[1:4] + lobes[4:7] + table.rest * math.pi)
    return np.asarray(found, np.float32)
