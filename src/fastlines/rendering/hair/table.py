"""Tables of a material's azimuthal scattering, averaged over all rays that meet a fibre's width.

A ray meets the fibre at an offset h, which is uniform in -1…1 if the fibre is thinner than a pixel. For each lobe

    N̄_p(φ; θo) = ½ ∫ A_p(h; θo) D_s(φ - Φ_p(h; θo)) dh,    with h = sin γ, dh = cos γ dγ,

where D_s is the trimmed logistic. The energies A_p are summed into narrow bins of Φ_p; then one convolution with D_s,
by FFT, spreads them. N̄_p is even in φ, because -h mirrors h: rays of one half are enough. It is even in θo too.

The rows of the tables are equal steps of x = (c + c²) / 2, with c = cos θo. All energies are smooth in c, and x has
shorter steps near c = 1, where the peaks of TRT move fast. The columns are equal steps of |φ| from 0 to π.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...arrays import AnyArray, FloatArray
from .attenuation import N_LOBES, attenuation, refracted_sine
from .azimuthal import exit_azimuth, trimmed_logistic
from .material import HairMaterial

#: The number of steps of x from 0 to 1, for rows.
N_INCLINATIONS = 128
#: Steps of φ in a logistic scale, at least.
STEPS_PER_SCALE = 8
#: The least and the most steps of φ from 0 to π. The most blur peaks if the azimuthal roughness is below 0.06.
MIN_AZIMUTHS, MAX_AZIMUTHS = 128, 2048
#: Rays on half a fibre for each step of φ; R turns by twice the angle γ, so that each bin gets half as many or more.
RAYS_PER_AZIMUTH = 2
#: How many rays are followed at once, so that they stay in the cache.
BATCH = 8192


@dataclass(frozen=True)
class AzimuthTable:
    """N̄_p of one material.

    Attributes
    ----------
    n_azimuths : int
        The number of steps of φ from 0 to π.
    values : (rows, columns, 8) float32
        N̄ of R, then of TT and of TRT for red, green and blue, per radian; the last value is 0. Rows are steps of x
        from 0 to 1, columns are steps of |φ| from 0 to π, both ends included.
    rest : (rows, 3) float32
        N̄ of the remaining lobes, for red, green and blue; it is the same for all φ.
    """

    n_azimuths: int
    values: FloatArray
    rest: FloatArray


def azimuth_table(material: HairMaterial) -> AzimuthTable:
    """Average a material over the width of its fibre."""
    # Choose rays and bins.
    wanted = math.pi * STEPS_PER_SCALE / material.logistic_scale
    n_azimuths = 32 * math.ceil(min(max(wanted, MIN_AZIMUTHS), MAX_AZIMUTHS) / 32)  # FFTs of primes are slow
    n_bins, n_rays = 2 * n_azimuths, RAYS_PER_AZIMUTH * n_azimuths
    gamma = (np.arange(n_rays) + 0.5) * (0.5 * math.pi / n_rays)
    share = np.cos(gamma) * (0.25 * math.pi / n_rays)

    # Spread the kernel over the circle as the bins lie.
    kernel = trimmed_logistic(np.arange(n_bins) * (2.0 * math.pi / n_bins), material.logistic_scale)
    kernel /= kernel.sum() * (2.0 * math.pi / n_bins)
    spectrum = np.fft.rfft(kernel)

    values = np.zeros((N_INCLINATIONS + 1, n_azimuths + 1, 8), np.float32)
    rest = np.empty((N_INCLINATIONS + 1, 3), np.float32)
    cos_o = 0.5 * np.sqrt(1.0 + 8.0 * np.linspace(0.0, 1.0, N_INCLINATIONS + 1)) - 0.5
    step = max(1, BATCH // n_rays)
    for rows in (slice(first, first + step) for first in range(0, N_INCLINATIONS + 1, step)):
        n_rows = len(cos_o[rows])
        cosines = np.repeat(cos_o[rows], n_rays)
        rays = np.sqrt(1.0 - cosines**2), cosines, np.tile(np.sin(gamma), n_rows)
        energies = [each * np.tile(share, n_rows)[:, None] for each in attenuation(material, *rays)]
        gamma_t = np.arcsin(refracted_sine(material, *rays))
        # Sum each lobe's energy where it leaves the fibre, spread it, and add what the other half mirrors.
        turns = (exit_azimuth(p, np.tile(gamma, n_rows), gamma_t) for p in range(N_LOBES))
        binned = np.concatenate([_binned(*lobe, n_rows, n_bins) for lobe in zip(turns, energies, strict=False)])
        spread = np.fft.irfft(np.fft.rfft(binned) * spectrum, n_bins)
        half = spread[..., : n_azimuths + 1] + np.roll(spread[..., ::-1], 1, axis=-1)[..., : n_azimuths + 1]
        values[rows, :, :7] = np.maximum(half, 0.0).transpose(1, 2, 0)
        rest[rows] = energies[N_LOBES].reshape(n_rows, n_rays, 3).sum(axis=1) * (1.0 / math.pi)
    return AzimuthTable(n_azimuths, values, rest)


def _binned(phi: AnyArray, energies: AnyArray, n_rows: int, n_bins: int) -> AnyArray:
    """Sum energies into the two bins of a circle that each angle lies between; return (channels, rows, bins).

    `phi` has all rays of the first row, then those of the next, and so has `energies`, with a column for each channel.
    """
    place = phi * (n_bins / (2.0 * math.pi))
    low = np.floor(place)
    part = place - low
    circle = np.repeat(np.arange(n_rows) * n_bins, len(phi) // n_rows)
    left, right = (circle + (low.astype(np.int64) + side) % n_bins for side in (0, 1))
    n = n_rows * n_bins
    found = [np.bincount(left, each * (1.0 - part), n) + np.bincount(right, each * part, n) for each in energies.T]
    return np.reshape(found, (-1, n_rows, n_bins))
