"""The energy of each lobe: Fresnel reflection at the surface, and absorption on the way through the fibre.

Light that meets a smooth dielectric cylinder at the offset h = sin γo leaves it after p passes with the energy

    A_0 = F,   A_p = (1 - F)² T^p F^(p-1),   and A_3 = (1 - F)² T³ F² / (1 - TF) for all lobes from p = 3 on.

F is the Fresnel reflectance for unpolarised light at the cosine cos θo cos γo. T = exp(-2 σ_a cos γt / cos θt) is the
transmittance of one pass (Marschner et al. 2003; d'Eon et al. 2011; Chiang et al. 2016). Without absorption the
energies sum to 1.
"""

from __future__ import annotations

import math

import numpy as np

from ...arrays import AnyArray
from .material import HairMaterial

#: Lobes with a direction: reflected (R), transmitted (TT), reflected inside once (TRT). One more has what remains.
N_LOBES = 3

#: The luminance of linear RGB (Rec. 709), by whose share a lobe is sampled.
LUMINANCE = (0.212671, 0.715160, 0.072169)


def fresnel(cosine: AnyArray, eta: float) -> AnyArray:
    """Return the reflectance of unpolarised light at the outside of a dielectric.

    Examples
    --------
    >>> fresnel(np.array([0.0, 1.0]), 1.5).round(6).tolist()
    [1.0, 0.04]
    """
    inside = np.sqrt(1.0 - (1.0 - cosine**2) * (1.0 / eta**2))
    across = (cosine - eta * inside) / (cosine + eta * inside)
    along = (eta * cosine - inside) / (eta * cosine + inside)
    return np.asarray(0.5 * (across**2 + along**2))


def refracted_sine(material: HairMaterial, sin_o: AnyArray, cos_o: AnyArray, h: AnyArray) -> AnyArray:
    """Return sin γt in the fibre's cross section, by the refractive index that Bravais adapted to the inclination."""
    return np.asarray(h * cos_o / np.sqrt(material.eta**2 - sin_o**2))


def attenuation(material: HairMaterial, sin_o: AnyArray, cos_o: AnyArray, h: AnyArray) -> list[AnyArray]:
    """Return the energies A_0 to A_3.

    Parameters
    ----------
    material : HairMaterial
    sin_o, cos_o, h : (n,) floats
        The inclination of the outgoing direction, and the offset from -1 to 1.

    Returns
    -------
    list of four arrays
        A_0 is (n, 1), as reflection has no colour; the others are (n, 3) for linear RGB.

    Examples
    --------
    >>> energies = attenuation(HairMaterial(sigma_a=(0, 0, 0)), np.zeros(1), np.ones(1), np.array([0.5]))
    >>> np.round(sum(energies), 6).tolist()
    [[1.0, 1.0, 1.0]]
    """
    # Follow the ray into the fibre.
    reflected = fresnel(cos_o * np.sqrt(1.0 - h**2), material.eta)[:, None]
    cos_gamma = np.sqrt(1.0 - refracted_sine(material, sin_o, cos_o, h) ** 2)
    length = 2.0 * cos_gamma / np.sqrt(1.0 - sin_o**2 * (1.0 / material.eta**2))
    transmitted = np.exp(-length[:, None] * np.asarray(material.sigma_a, length.dtype))

    # Sum the geometric series of the lobes from p = 3 on; its first term is 0 where its ratio is 1.
    through = (1.0 - reflected) ** 2 * transmitted
    ratio = transmitted * reflected
    bounced = through * ratio
    rest = bounced * ratio / np.maximum(1.0 - ratio, np.finfo(ratio.dtype).tiny)
    return [reflected, through, bounced, rest]


def lobe_shares(energies: list[AnyArray]) -> AnyArray:
    """Return the luminance of each lobe as a share of all lobes' luminance, as an (n, 4) array."""
    first = energies[0] * math.fsum(LUMINANCE)
    weights = np.asarray(LUMINANCE, first.dtype)
    # A product of matrices would round by the number of rows, which the library of linear algebra chooses its code by.
    others = [(each * weights).sum(axis=1, keepdims=True) for each in energies[1:]]
    shares = np.concatenate([first, *others], axis=1)
    return np.asarray(shares / shares.sum(axis=1, keepdims=True))
