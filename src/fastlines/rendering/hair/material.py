"""The material of a fibre: its colour, roughness, refractive index and scales, and the shape of lobes they make.

The mappings from roughness to a variance v and a logistic scale s are the fits of Chiang et al. 2016 (§4.1):

    v_0 = (0.726 β_M + 0.812 β_M² + 3.7 β_M^20)²,   v_1 = v_0 / 4,   v_2 = v_3 = 4 v_0
    s = √(π/8) (0.265 β_N + 1.194 β_N² + 5.372 β_N^22)

The scales of the cuticle tilt the surface's normals by α. They turn θo by -2α, α and 4α for the lobes R, TT and TRT, as
in pbrt and Mitsuba. The normals of scales on real hair lean towards the root (Marschner et al. 2003, "Light Scattering
from Human Hair Fibers"). A positive α is therefore right for tangents from the tip to the root, a negative one for
tangents from the root to the tip.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self

from ...arrays import check_fields, number
from .absorption import Rgb, absorption_of_pigments, absorption_of_reflectance, concentrations, three


@dataclass(frozen=True)
class HairMaterial:
    """A hair or another dielectric fibre with a round cross section.

    Parameters
    ----------
    sigma_a : tuple of three floats
        Absorption for linear RGB, in units of one over the fibre's radius, from 0 to 1e6. The default is brown.
    longitudinal_roughness, azimuthal_roughness : float
        The roughness along the fibre and around it, perceptually uniform, from 0.001 to 1.
    eta : float
        The refractive index, from 1.001 to 4; 1.55 is that of hair.
    scale_tilt : float
        The tilt α of the scales on the fibre in degrees, from -20 to 20, with the sign of pbrt and Mitsuba. If it is
        positive, the scales' normals lean towards the tangent, so that R has θi + θo = 2α.

    Raises
    ------
    InputError
        If a value is out of range.

    Examples
    --------
    >>> material = HairMaterial.from_melanin(0.6, redness=0.2)
    >>> [round(sigma, 3) for sigma in material.sigma_a]
    [0.341, 0.584, 1.197]
    >>> HairMaterial(eta=0.5)
    Traceback (most recent call last):
    fastlines.errors.InputError: eta=0.5; expected a refractive index: a number from 1.001 to 4
    """

    sigma_a: Rgb = (0.5447, 0.9061, 1.781)
    longitudinal_roughness: float = 0.3
    azimuthal_roughness: float = 0.3
    eta: float = 1.55
    scale_tilt: float = 2.0

    def __post_init__(self) -> None:
        expected = "an absorption: three numbers, each from 0 to 1e6"
        absorbed = tuple(number("sigma_a", each, expected, 0.0, 1e6) for each in three(self.sigma_a, "sigma_a"))
        object.__setattr__(self, "sigma_a", absorbed)
        rough = ("longitudinal_roughness", "azimuthal_roughness")
        check_fields(self, rough, number, "a roughness: a number from 0.001 to 1", 0.001, 1.0)
        check_fields(self, ("eta",), number, "a refractive index: a number from 1.001 to 4", 1.001, 4.0)
        check_fields(self, ("scale_tilt",), number, "a tilt: a number of degrees from -20 to 20", -20.0, 20.0)

    @classmethod
    def from_melanin(cls, melanin: float, redness: float = 0.0, **shape: float) -> Self:
        """Return hair of a natural colour.

        Parameters
        ----------
        melanin : float
            The darkness from 0 to 1: white 0, blond 0.25, brown 0.7, black 1.
        redness : float
            The share of red pigment, from 0 to 1.
        **shape : float
            Any of the other parameters of `HairMaterial`.
        """
        return cls(absorption_of_pigments(*concentrations(melanin, redness)), **shape)

    @classmethod
    def from_pigments(cls, eumelanin: float, pheomelanin: float = 0.0, **shape: float) -> Self:
        """Return hair with these concentrations of pigments, which are not bounded.

        Examples
        --------
        >>> HairMaterial.from_pigments(2.0).sigma_a
        (0.838, 1.394, 2.74)
        """
        return cls(absorption_of_pigments(eumelanin, pheomelanin), **shape)

    @classmethod
    def from_reflectance(cls, reflectance: Rgb, **shape: float) -> Self:
        """Return fibres that have about this colour in linear RGB where they are dense, after all scattering.

        Examples
        --------
        >>> dyed = HairMaterial.from_reflectance((0.1, 0.5, 0.9), azimuthal_roughness=0.4)
        >>> dyed.sigma_a[0] > dyed.sigma_a[2]
        True
        """
        rough = shape.get("azimuthal_roughness", cls.azimuthal_roughness)
        return cls(absorption_of_reflectance(reflectance, rough), **shape)

    @property
    def variances(self) -> tuple[float, float, float, float]:
        """The longitudinal variances v_0 to v_3 of R, TT, TRT and the remaining lobes."""
        beta = self.longitudinal_roughness
        v = (0.726 * beta + 0.812 * beta**2 + 3.7 * beta**20) ** 2
        return v, 0.25 * v, 4.0 * v, 4.0 * v

    @property
    def logistic_scale(self) -> float:
        """The scale s of the logistic distribution around the fibre, in radians."""
        beta = self.azimuthal_roughness
        return math.sqrt(math.pi / 8.0) * (0.265 * beta + 1.194 * beta**2 + 5.372 * beta**22)

    @property
    def tilts(self) -> tuple[float, float, float, float]:
        """How much the scales turn the outgoing inclination for R, TT, TRT and the remaining lobes, in radians."""
        alpha = math.radians(self.scale_tilt)
        return -2.0 * alpha, alpha, 4.0 * alpha, 0.0

    @property
    def numbers(self) -> tuple[float, ...]:
        """What compiled code takes: absorption, refractive index, variances, tilts and the logistic scale."""
        return (*self.sigma_a, self.eta, *self.variances, *self.tilts, self.logistic_scale)
