"""The scattering of light by a fibre: its value, importance sampling, and the density of the samples.

The value is the sum over the lobes p of A_p M_p N_p: energy, longitudinal and azimuthal density. It is what Mitsuba's
``hair`` returns from ``eval``, the scattering function times cos θi. Light from all directions wi on one point of the
fibre leaves it towards wo as

    L(wo) = ∫ evaluate(wo, wi) L(wi) dwi     over the whole sphere of solid angles,

so the integral of the value over wi is the albedo: 1 without absorption. No further cosine is multiplied.

The energies depend on the outgoing inclination alone, and the scales turn it. So the value is not reciprocal, like that
of pbrt and Mitsuba: swapping wo and wi gives another value.

Compiled code computes `evaluate`, `pdf` and `sample` in float32, and the formulas here in float64.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from ...arrays import AnyArray
from ...engines import engine
from .attenuation import N_LOBES, attenuation, lobe_shares, refracted_sine
from .azimuthal import exit_azimuth, sample_trimmed_logistic, trimmed_logistic
from .frame import FibreFrame, in_batches, same_length
from .longitudinal import longitudinal, sample_longitudinal
from .material import HairMaterial


def evaluate(
    material: HairMaterial, wo: npt.ArrayLike, wi: npt.ArrayLike, tangent: npt.ArrayLike, h: npt.ArrayLike
) -> AnyArray:
    """Return how much of the light from wi a fibre scatters towards wo, cos θi included.

    Parameters
    ----------
    material : HairMaterial
    wo, wi : (…, 3) array_like
        The directions towards the camera and towards the light, from the fibre outwards; unit vectors.
    tangent : (…, 3) array_like
        The direction along the fibre; unit vectors. Only the scales' tilt depends on its sign.
    h : (…) array_like
        The offset from the fibre's axis to the side wo × tangent, in radii, from -1 to 1; beyond, it is ±1. With the
        normal n at the hit it is n·(wo × tangent) / ‖wo × tangent‖.

    Returns
    -------
    (…, 3) floats
        Linear RGB per steradian; float32 if all arrays are, and else float64.

    Raises
    ------
    InputError
        If the shapes do not fit together.

    Examples
    --------
    >>> value = evaluate(HairMaterial(), wo=(0, 0, 1), wi=(0, 0, -1), tangent=(1, 0, 0), h=0.0)  # from behind
    >>> value.round(4).tolist()
    [1.7445, 0.8468, 0.1472]
    """
    return _of_directions(engine.hair_evaluate, FibrePoints.evaluate, material, wo, wi, tangent, h)


def evaluate_angles(
    material: HairMaterial,
    sin_theta_o: npt.ArrayLike,
    sin_theta_i: npt.ArrayLike,
    phi: npt.ArrayLike,
    h: npt.ArrayLike,
) -> AnyArray:
    """Return what `evaluate` does, for directions in the fibre's frame.

    Parameters
    ----------
    material : HairMaterial
    sin_theta_o, sin_theta_i : (…) array_like
        Sines of the inclinations of the directions towards the camera and the light: wo·tangent and wi·tangent.
    phi : (…) array_like
        The azimuth of wi around the tangent, counted from wo, in radians.
    h : (…) array_like
        The offset, as in `evaluate`.

    Examples
    --------
    >>> evaluate_angles(HairMaterial(), 0.0, 0.0, np.pi, 0.0).round(4).tolist()
    [1.7445, 0.8468, 0.1472]
    """
    numbers = {"sin_theta_o": sin_theta_o, "sin_theta_i": sin_theta_i, "phi": phi, "h": h}
    shape, arrays = same_length({}, numbers)

    def of_rows(sin_o: AnyArray, sin_i: AnyArray, turn: AnyArray, offset: AnyArray) -> tuple[AnyArray]:
        sin_o, sin_i = np.clip(sin_o, -1.0, 1.0), np.clip(sin_i, -1.0, 1.0)
        cos_o, cos_i = np.sqrt(1.0 - sin_o**2), np.sqrt(1.0 - sin_i**2)
        lobes = _Lobes(material, sin_o, cos_o, offset)
        return (lobes.value(lobes.densities(sin_i, cos_i, turn)),)

    (values,) = in_batches(of_rows, arrays)
    return values.reshape(*shape, 3)


def pdf(
    material: HairMaterial, wo: npt.ArrayLike, wi: npt.ArrayLike, tangent: npt.ArrayLike, h: npt.ArrayLike
) -> AnyArray:
    """Return the density per steradian with which `sample` draws wi, given wo; arguments as in `evaluate`.

    Examples
    --------
    >>> grey = HairMaterial(sigma_a=(0, 0, 0))  # the density is the value itself
    >>> rays = (0, 0, 1), (0.6, 0.0, 0.8), (1, 0, 0), 0.5
    >>> float(pdf(grey, *rays) / evaluate(grey, *rays)[0]).__round__(6)
    1.0
    """
    return _of_directions(engine.hair_pdf, FibrePoints.pdf, material, wo, wi, tangent, h)


def sample(
    material: HairMaterial, wo: npt.ArrayLike, tangent: npt.ArrayLike, h: npt.ArrayLike, u4: npt.ArrayLike
) -> tuple[AnyArray, AnyArray, AnyArray]:
    """Draw directions wi with a density near to the value.

    Parameters
    ----------
    material : HairMaterial
    wo, tangent : (…, 3) array_like
    h : (…) array_like
        As in `evaluate`.
    u4 : (…, 4) array_like
        Uniform random numbers from 0 to 1: they choose the lobe, the inclination by two, and the azimuth.

    Returns
    -------
    wi : (…, 3) floats
        Unit vectors towards the light.
    weight : (…, 3) floats
        ``evaluate(…) / pdf(…)``: the mean of weight times light is the light that leaves towards wo. It is bounded, and
        1 without absorption.
    pdf : (…) floats
        The density, per steradian.

    Examples
    --------
    >>> u4 = np.random.default_rng(0).random((10_000, 4))
    >>> wi, weight, density = sample(HairMaterial(sigma_a=(0, 0, 1)), (0, 0, 1), (1, 0, 0), 0.3, u4)
    >>> weight.mean(axis=0).round(2).tolist()  # the albedo
    [1.0, 1.0, 0.17]
    """
    shape, arrays = same_length({"wo": wo, "tangent": tangent}, {"h": h, "u4": u4}, columns=4)

    def of_rows(out: AnyArray, along: AnyArray, offset: AnyArray, u: AnyArray) -> tuple[AnyArray, AnyArray, AnyArray]:
        if u.dtype == np.float32:
            return engine.hair_sample(material.numbers, out, along, offset, u)
        return FibrePoints(material, out, along, offset).sample(u)

    wi, weight, density = in_batches(of_rows, arrays)
    return wi.reshape(*shape, 3), weight.reshape(*shape, 3), density.reshape(shape)


def _of_directions(
    compiled: Callable[..., AnyArray],
    formula: Callable[[FibrePoints, AnyArray], AnyArray],
    material: HairMaterial,
    wo: npt.ArrayLike,
    wi: npt.ArrayLike,
    tangent: npt.ArrayLike,
    h: npt.ArrayLike,
) -> AnyArray:
    """Return values of pairs of directions: of compiled code in float32, and else of the formula."""
    shape, arrays = same_length({"wo": wo, "wi": wi, "tangent": tangent}, {"h": h})

    def of_rows(out: AnyArray, into: AnyArray, along: AnyArray, offset: AnyArray) -> tuple[AnyArray]:
        if into.dtype == np.float32:
            return (compiled(material.numbers, out, along, offset, into),)
        return (formula(FibrePoints(material, out, along, offset), into),)

    (values,) = in_batches(of_rows, arrays)
    return values.reshape(shape + values.shape[1:])


class FibrePoints:
    """The formulas at points of fibres, each with the direction in which light leaves it."""

    def __init__(self, material: HairMaterial, wo: AnyArray, tangent: AnyArray, h: AnyArray) -> None:
        self._frame = FibreFrame.of(wo, tangent)
        self._lobes = _Lobes(material, self._frame.sin_o, self._frame.cos_o, h)

    def evaluate(self, wi: AnyArray) -> AnyArray:
        """Return how much of the light from wi each point scatters, (n, 3)."""
        return self._lobes.value(self._densities(wi))

    def pdf(self, wi: AnyArray) -> AnyArray:
        """Return the density with which each point draws wi, (n,)."""
        return self._lobes.density(self._densities(wi))

    def sample(self, u4: AnyArray) -> tuple[AnyArray, AnyArray, AnyArray]:
        """Draw a direction wi at each point; return directions (n, 3), weights (n, 3) and densities (n,)."""
        wi = self._frame.direction(*self._lobes.draw(u4))
        # Weigh the direction as it is rounded.
        each = self._densities(wi)
        density = self._lobes.density(each)
        return wi, self._lobes.value(each) / np.maximum(density, np.finfo(density.dtype).tiny)[:, None], density

    def _densities(self, wi: AnyArray) -> list[AnyArray]:
        return self._lobes.densities(*self._frame.angles(wi))


class _Lobes:
    """What all directions wi have in common at n points of fibres."""

    def __init__(self, material: HairMaterial, sin_o: AnyArray, cos_o: AnyArray, h: AnyArray) -> None:
        h = np.clip(h, -1.0, 1.0)
        self.material = material
        self.turned = [_turned(sin_o, cos_o, tilt) for tilt in material.tilts]
        self.gamma_o = np.arcsin(h)
        self.gamma_t = np.arcsin(refracted_sine(material, sin_o, cos_o, h))
        self.perfect = [exit_azimuth(p, self.gamma_o, self.gamma_t) for p in range(N_LOBES)]
        self.energies = attenuation(material, sin_o, cos_o, h)
        self.shares = lobe_shares(self.energies)

    def draw(self, u: AnyArray) -> tuple[AnyArray, AnyArray]:
        """Draw the sine of the inclination and the azimuth of a direction, (n,) each, given u (n, 4)."""
        # Choose a lobe by its energy.
        p = (u[:, :1] > np.cumsum(self.shares, axis=1)[:, :N_LOBES]).sum(axis=1)
        # Draw both angles.
        sines, cosines = (np.choose(p, [each[part] for each in self.turned]) for part in (0, 1))
        variances = np.asarray(self.material.variances, u.dtype)[p]
        sin_i = sample_longitudinal(sines, cosines, variances, u[:, 1], u[:, 2])
        spread = sample_trimmed_logistic(u[:, 3], self.material.logistic_scale)
        perfect = exit_azimuth(p, self.gamma_o, self.gamma_t).astype(u.dtype)
        return sin_i, np.where(p < N_LOBES, perfect + spread, 2.0 * math.pi * u[:, 3])

    def densities(self, sin_i: AnyArray, cos_i: AnyArray, phi: AnyArray) -> list[AnyArray]:
        """Return M_p N_p of each lobe, as densities per steradian."""
        found = []
        for p, variance in enumerate(self.material.variances):
            along = longitudinal(sin_i, cos_i, *self.turned[p], variance)
            if p < N_LOBES:
                found.append(along * trimmed_logistic(phi - self.perfect[p], self.material.logistic_scale))
            else:
                found.append(along * (0.5 / math.pi))
        return found

    def value(self, densities: list[AnyArray]) -> AnyArray:
        """Return the sum of all lobes, (n, 3)."""
        return np.asarray(sum(a * each[:, None] for a, each in zip(self.energies, densities, strict=True)))

    def density(self, densities: list[AnyArray]) -> AnyArray:
        """Return the density with which `draw` draws, (n,)."""
        return np.asarray(sum(self.shares[:, p] * each for p, each in enumerate(densities)))


def _turned(sin_o: AnyArray, cos_o: AnyArray, tilt: float) -> tuple[AnyArray, AnyArray]:
    """Return the sine and the cosine of the outgoing inclination as the scales turn it for a lobe."""
    sine, cosine = math.sin(tilt), math.cos(tilt)
    # Past the tangent's direction, the azimuth stays, as in pbrt and Mitsuba.
    return sin_o * cosine + cos_o * sine, np.abs(cos_o * cosine - sin_o * sine)
