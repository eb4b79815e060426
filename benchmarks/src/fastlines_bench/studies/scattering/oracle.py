"""Mitsuba 3's BSDF ``hair`` as the oracle: its values, and its approximation of the Bessel function I0.

Mitsuba has the y axis of its frame along the fibre and z along the normal at the hit, and its ``wi`` is our ``wo``. It
computes in float32. Its I0, like that of pbrt, is off by up to 0.6 %: ten terms of the series up to 12, and above it
x - ½ ln(2πx) + 1/(16x) for ln I0(x), where the asymptotic series has 1/(8x). So our model can be evaluated on that I0.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import numpy.typing as npt

from fastlines.rendering.hair import HairMaterial

from ...harness.arrays import Float64Array
from ...harness.internals import longitudinal


def mitsuba_values(
    mitsuba: Any, material: HairMaterial, wo: Float64Array, wi: Float64Array, pigments: tuple[float, float] | None
) -> Float64Array:
    """Return Mitsuba's values and densities, as (n, 4), for directions in its frame and either way to give colour."""
    colour: dict[str, Any] = {"sigma_a": {"type": "rgb", "value": list(material.sigma_a)}}
    if pigments:
        colour = dict(zip(("eumelanin", "pheomelanin"), pigments, strict=True))
    bsdf = mitsuba.load_dict(
        {
            "type": "hair",
            "int_ior": material.eta,
            "ext_ior": 1.0,
            **colour,
            "longitudinal_roughness": material.longitudinal_roughness,
            "azimuthal_roughness": material.azimuthal_roughness,
            "scale_tilt": material.scale_tilt,
        }
    )
    context, at = mitsuba.BSDFContext(), mitsuba.SurfaceInteraction3f()
    found = np.empty((len(wo), 4))
    for i, (towards, away) in enumerate(zip(wo.tolist(), wi.tolist(), strict=True)):
        at.wi = towards
        found[i, :3], found[i, 3] = bsdf.eval_pdf(context, at, away)
    return found


def mitsuba_scaled_i0(x: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return exp(-x) I0(x) by Mitsuba's approximations."""
    low, high = np.minimum(x, 12.0), np.maximum(x, 12.0)
    term, total = np.ones_like(x), np.ones_like(x)
    for k in range(1, 11):
        term = term * (low / (2 * k)) ** 2
        total = total + term
    above = np.exp(1 / (16 * high)) / np.sqrt(2 * np.pi * high)
    return np.asarray(np.where(x > 12.0, above, total * np.exp(-low)))


@contextmanager
def bessel_of(whose: str) -> Iterator[None]:
    """Let our model use I0 as Mitsuba approximates it, or with "ours" its own."""
    ours = longitudinal.scaled_i0
    if whose != "ours":
        longitudinal.scaled_i0 = mitsuba_scaled_i0
    try:
        yield
    finally:
        longitudinal.scaled_i0 = ours
