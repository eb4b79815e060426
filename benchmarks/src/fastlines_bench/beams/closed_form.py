"""The light that a homogeneous medium scatters once from a point light towards a ray, and what a blur makes of it.

A ray passes the light at the distance b, at t = h, and ends at t = 2h. With t = h + b·tan θ, dt/r² = dθ/b, so its
radiance is (Lecocq et al. 2000; Sun et al. 2005, "A practical analytic single scattering model")

    L(b) = Φ σ_s p / (4π b) ∫ exp(−σ_t (t + r)) dθ,     r = b / cos θ,     p = 1/(4π),

whose integrand is smooth. Beams of the light that pass the ray at the distance u lie in a plane at the angle φ, where
u = b·sin φ, and cross it as beams in the plane cross a ray at the distance b·cos φ. So the mean of the estimator with
the kernel k is

    E(b) = ∫ k(u) L(√(b² − u²)) du,

which is more than L(b) near the light. For the box of half width R and L ~ 1/b, it is L·arcsin(R/b)/(R/b).
"""

from __future__ import annotations

import numpy as np

from ..harness.arrays import Float64Array

#: The nodes of both integrals.
N_NODES = 128


def radiance(b: Float64Array, h: Float64Array, power: float, scattering: float, extinction: float) -> Float64Array:
    """Return L for rays that pass the light at distances b at t = h and end at t = 2h, arrays of one shape.

    Examples
    --------
    >>> one = np.ones(1)
    >>> bool(abs(radiance(one, 1e6 * one, 16 * np.pi**2, 1.0, 0.0)[0] - np.pi) < 1e-5)  # without extinction
    True
    """
    nodes, weights = np.polynomial.legendre.leggauss(N_NODES)
    b, h = b[..., None], h[..., None]
    end = np.arctan2(h, b)
    angle = end * nodes
    path = h + b * np.tan(angle) + b / np.cos(angle)
    integral = (end * weights * np.exp(-extinction * path)).sum(axis=-1)
    return np.asarray(power * scattering / (16 * np.pi**2) * integral / b[..., 0])


def blurred(
    b: Float64Array, h: Float64Array, radius: float, power: float, scattering: float, extinction: float
) -> Float64Array:
    """Return E for the box of half width `radius`, for distances b above 0."""
    nodes, weights = np.polynomial.legendre.leggauss(N_NODES)
    end = np.arcsin(np.minimum(radius / b, 1.0))[:, None]
    angle = end * nodes
    near = b[:, None] * np.cos(angle)
    light = radiance(near, np.broadcast_to(h[:, None], near.shape), power, scattering, extinction)
    return np.asarray((end * weights * near * light).sum(axis=1) / (2 * radius))
