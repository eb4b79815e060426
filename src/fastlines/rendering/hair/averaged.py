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

from ...arrays import FloatArray
from ...engines import engine
from .frame import in_batches, same_length
from .material import HairMaterial
from .table import AzimuthTable, azimuth_table


@dataclass(frozen=True)
class AveragedHair:
    """The scattering of fibres thinner than a pixel, averaged over their width.

    Parameters
    ----------
    material : HairMaterial

    Attributes
    ----------
    tables : tuple of two float32 arrays
        What compiled code looks up: N̄ by inclination and azimuth, and N̄ of the rest, a_f and a_b by inclination.

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
    tables: tuple[FloatArray, FloatArray] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        table = azimuth_table(self.material)
        object.__setattr__(self, "tables", (table.values, _inclinations(table)))

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
        shape, angles = same_length({}, numbers)
        (values,) = in_batches(
            lambda *rows: (engine.averaged_hair(self.material.numbers, *self.tables, *rows),),
            (each.astype(np.float32, copy=False) for each in angles),
        )
        return values.reshape(*shape, 3)

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
        return self.attenuations(sin_theta)[0]

    def backward(self, sin_theta: npt.ArrayLike) -> FloatArray:
        """Return a_b: the share of the light at an inclination that one fibre scatters back; see `forward`."""
        return self.attenuations(sin_theta)[1]

    def attenuations(self, sin_theta: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return `forward` and `backward`."""
        shape, (sine,) = same_length({}, {"sin_theta": sin_theta})
        forward, backward = in_batches(
            lambda rows: engine.averaged_attenuations(self.material.numbers, *self.tables, rows),
            (sine.astype(np.float32, copy=False),),
        )
        return forward.reshape(*shape, 3), backward.reshape(*shape, 3)


def _inclinations(table: AzimuthTable) -> FloatArray:
    """Integrate the tables over φ; return N̄ of the remaining lobes, a_f and a_b as (rows, 9)."""
    part = np.linspace(0.0, 1.0, table.n_azimuths + 1)
    weight = np.full(table.n_azimuths + 1, 2.0 * math.pi / table.n_azimuths)
    weight[[0, -1]] *= 0.5
    columns = [table.rest]
    for share in (part, 1.0 - part):
        lobes = np.einsum("rck,c->rk", table.values, share * weight)
        columns.append(lobes[:, :1] + lobes[:, 1:4] + lobes[:, 4:7] + table.rest * math.pi)
    return np.concatenate(columns, axis=1).astype(np.float32)
