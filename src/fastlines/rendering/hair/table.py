"""Tables of a material's azimuthal scattering, averaged over all rays that meet a fibre's width.

A ray meets the fibre at an offset h, which is uniform in -1…1 if the fibre is thinner than a pixel. For each lobe

    N̄_p(φ; θo) = ½ ∫ A_p(h; θo) D_s(φ - Φ_p(h; θo)) dh,    with h = sin γ, dh = cos γ dγ,

where D_s is the trimmed logistic. The energies A_p are summed into narrow bins of Φ_p; then one convolution with D_s,
by FFT, spreads them. N̄_p is even in φ, because -h mirrors h, and in θo.

The rows of the tables are equal steps of x = (c + c²) / 2, with c = cos θo. All energies are smooth in c, and x has
shorter steps near c = 1, where the peaks of TRT move fast. The columns are equal steps of |φ| from 0 to π.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...arrays import AnyArray, FloatArray
from .attenuation import attenuation, refracted_sine
from .azimuthal import exit_azimuth, trimmed_logistic
from .material import HairMaterial

#: The number of steps of x from 0 to 1, for rows.
N_INCLINATIONS = 128
#: Steps of φ in a logistic scale, at least.
STEPS_PER_SCALE = 8
#: The least and the most steps of φ from 0 to π. The most blur peaks if the azimuthal roughness is below 0.06.
MIN_AZIMUTHS, MAX_AZIMUTHS = 128, 2048
#: Rays for each step of φ; R turns by twice the angle γ, so that each bin gets half as many or more.
RAYS_PER_AZIMUTH = 4


@dataclass(frozen=True)
class AzimuthTable:
    """N̄_p of one material.

    Attributes
    ----------
    n_azimuths : int
        The number of steps of φ from 0 to π.
    values : (7, rows, columns) float32
        N̄ of R, then of TT and of TRT for red, green and blue, per radian. Rows are steps of x from 0 to 1, columns
        are steps of |φ| from 0 to π, both ends included.
    rest : (3, rows) float32
        N̄ of the remaining lobes, for red, green and blue; it is the same for all φ.
    """

    n_azimuths: int
    values: FloatArray
    rest: FloatArray


def azimuth_table(material: HairMaterial) -> AzimuthTable:
    """Average a material over the width of its fibre."""
    # Choose rays and bins.
    wanted = math.pi * STEPS_PER_SCALE / material.logistic_scale
    n_azimuths = 2 ** math.ceil(math.log2(min(max(wanted, MIN_AZIMUTHS), MAX_AZIMUTHS)))
    n_rays = RAYS_PER_AZIMUTH * n_azimuths
    gamma = (np.arange(n_rays) + 0.5) * (math.pi / n_rays) - 0.5 * math.pi
    share = np.cos(gamma) * (0.5 * math.pi / n_rays)
    h = np.sin(gamma)

    # Spread the kernel over the circle as the bins lie.
    n_bins = 2 * n_azimuths
    kernel = trimmed_logistic(np.arange(n_bins) * (2.0 * math.pi / n_bins), material.logistic_scale)
    kernel /= kernel.sum() * (2.0 * math.pi / n_bins)
    spectrum = np.fft.rfft(kernel)

    values = np.empty((7, N_INCLINATIONS + 1, n_azimuths + 1), np.float32)
    rest = np.empty((3, N_INCLINATIONS + 1), np.float32)
    for row, cos_o in enumerate(0.5 * np.sqrt(1.0 + 8.0 * np.linspace(0.0, 1.0, N_INCLINATIONS + 1)) - 0.5):
        sin_o = np.full(n_rays, math.sqrt(1.0 - cos_o**2))
        cosines = np.full(n_rays, cos_o)
        energies = attenuation(material, sin_o, cosines, h)
        gamma_t = np.arcsin(refracted_sine(material, sin_o, cosines, h))
        # Sum each lobe's energy where it leaves the fibre, and spread it.
        bins = np.stack(
            [
                _binned(exit_azimuth(p, gamma, gamma_t), energy * share, n_bins)
                for p in range(3)
                for energy in energies[p].T
            ]
        )
        spread = np.fft.irfft(np.fft.rfft(bins) * spectrum, n_bins)
        values[:, row] = 0.5 * (spread + np.roll(spread[:, ::-1], 1, axis=1))[:, : n_azimuths + 1]
        rest[:, row] = (energies[3] * share[:, None]).sum(axis=0) * (0.5 / math.pi)
    return AzimuthTable(n_azimuths, np.maximum(values, 0.0), rest)


def _binned(phi: AnyArray, energy: AnyArray, n_bins: int) -> AnyArray:
    """Sum energies into the two bins of a circle that each angle lies between."""
    place = phi * (n_bins / (2.0 * math.pi))
    low = np.floor(place)
    part = place - low
    left = low.astype(np.int64) % n_bins
    right = (left + 1) % n_bins
    found = np.bincount(left, energy * (1.0 - part), n_bins) + np.bincount(right, energy * part, n_bins)
    return np.asarray(found)
