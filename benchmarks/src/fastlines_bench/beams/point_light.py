"""A point light in a homogeneous medium: beams beside the closed form, long and short beams, energy, and cut beams."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

import fastlines as fl

from ..harness.arrays import Float64Array, FloatArray
from ..harness.figures import Figures
from ..harness.findings import Check
from .closed_form import blurred, radiance

#: The medium: absorption and scattering per unit of length. The light is in the middle of a cube of side 2.
ABSORPTION, SCATTERING = 0.4, 0.8
EXTINCTION = ABSORPTION + SCATTERING

#: The distances at which rays pass the light; they begin and end on the sphere of radius 1.
DISTANCES = (0.015, 0.025, 0.04, 0.06, 0.1, 0.15, 0.25, 0.4, 0.6, 0.8, 0.95)

#: The rays of each distance, in random directions around the light.
N_RAYS = 64

#: How many standard errors are wanted at most.
MOST_ERRORS = 3.0

#: The largest fraction of the power that may be lost, and by which pictures of cut beams may differ.
MOST_LOST, MOST_CUT = 1e-6, 1e-4


@dataclass(frozen=True)
class Measured:
    """The mean of independent passes at each distance, and its standard error; as fractions of the closed form."""

    mean: Float64Array
    error: Float64Array


def run_point_light(
    n_beams: int,
    n_passes: int,
    radii: tuple[float, float],
    n_cut: int,
    progress: Callable[[str, float], None],
) -> Figures:
    """Estimate the closed form with `n_beams` beams in `n_passes` passes, with two radii, by long and by short beams.

    Parameters
    ----------
    radii : (float, float)
        The smaller one converges to the closed form, the other one to its blur.
    n_cut : int
        The number of beams that are cut into pieces.
    """
    b = np.array(DISTANCES)
    h = np.sqrt(1 - b * b)
    constants = 1.0, SCATTERING, EXTINCTION
    exact = radiance(b, h, *constants)
    theory = {radius: blurred(b, h, radius, *constants) / exact for radius in radii}
    measured: dict[tuple[str, float], Measured] = {}
    lost = 0.0
    for i, kind in enumerate(("long", "short")):
        sums: dict[float, list[Float64Array]] = {radius: [] for radius in radii}
        for j in range(n_passes):
            progress(f"{kind} beams, pass {j + 1} of {n_passes}", (i + j / n_passes) / 2)
            beams = _beams(n_beams // n_passes, kind, seed=i * n_passes + j)
            tree = fl.build(beams.lines, "bvh-cl")
            rays = _rays(b, h, i * n_passes + j)
            ends = np.repeat(2 * h, N_RAYS).astype(np.float32)
            for radius in radii:
                found = _sums(tree, rays, radius, _values(beams), beams, "box", ends)
                sums[radius].append(found.reshape(len(b), N_RAYS).mean(axis=1) / exact)
        for radius, passes in sums.items():
            every = np.stack(passes)
            measured[kind, radius] = Measured(every.mean(axis=0), every.std(axis=0, ddof=1) / np.sqrt(n_passes))
    for kind in ("long", "short"):
        lost = max(lost, _lost(kind, n_beams // n_passes))
    progress("cut beams", 1.0)
    cut = _cut_difference(n_cut, radii[1])
    return _figures(b, exact, theory, measured, lost, cut, n_beams, n_passes)


def _scene() -> Any:
    fog = fl.beams.HomogeneousMedium(ABSORPTION, SCATTERING)
    return fl.beams.BeamScene(fog, [fl.beams.PointLight((0, 0, 0), power=1)], box=[[-1, -1, -1], [1, 1, 1]])


def _beams(n_paths: int, kind: str, seed: int) -> Any:
    """Return beams of the light that comes from the light itself."""
    return fl.beams.trace_photons(_scene(), n_paths, kind=kind, seed=seed, max_scatterings=0)


def _values(beams: Any) -> FloatArray:
    """Return the light that each beam scatters per length."""
    return np.asarray(beams.power[:, 0] * (SCATTERING / beams.n_paths), np.float32)


def _sums(
    tree: fl.Tree,
    rays: tuple[FloatArray, FloatArray],
    radius: float,
    values: FloatArray,
    beams: Any,
    blur: str,
    ends: FloatArray | float,
) -> Float64Array:
    """Gather along rays that end at t = `ends`."""
    decay = float(beams.decay[0])
    gathered = tree.gather(*rays, radius, values, blur=blur, sigma=EXTINCTION, line_sigma=decay, phase=0.0, t_max=ends)
    return gathered.sum


def _rays(b: Float64Array, h: Float64Array, seed: int) -> tuple[FloatArray, FloatArray]:
    """Return rays that pass the light at distances b at t = h, `N_RAYS` each, in random directions."""
    rng = np.random.default_rng([seed, 4])
    away, other = rng.standard_normal((2, len(b) * N_RAYS, 3))
    away /= np.linalg.norm(away, axis=1, keepdims=True)
    direction = np.cross(away, other)
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    origins = np.repeat(b, N_RAYS)[:, None] * away - np.repeat(h, N_RAYS)[:, None] * direction
    return origins.astype(np.float32), direction.astype(np.float32)


def _lost(kind: str, n_paths: int) -> float:
    """Return the fraction of the power that is neither absorbed nor leaves the scene."""
    energy = fl.beams.trace_photons(_scene(), n_paths, kind=kind).energy
    kept = energy.absorbed_by_medium + energy.absorbed_by_surfaces + energy.escaped
    return float(np.abs(kept / energy.emitted - 1).max())


def _cut_difference(n_beams: int, radius: float) -> float:
    """Return how much sums differ when beams are cut into 50 pieces: all absolute differences by all sums.

    The kernel is that of Epanechnikov. With the box, a crossing whose distance is the radius up to rounding would
    count on one side only.
    """
    beams = _beams(n_beams, "long", 0)
    b = np.array(DISTANCES)
    rays = _rays(b, np.sqrt(1 - b * b), 0)
    sums = []
    for n_pieces in (1, 50):
        share = np.linspace(0, 1, n_pieces + 1)
        start, end = beams.lines.segments.astype(np.float64).swapaxes(0, 1)
        points = start[:, None] + share[:, None] * (end - start)[:, None]
        pieces = np.stack([points[:, :-1], points[:, 1:]], axis=2).reshape(-1, 2, 3)
        lengths = np.linalg.norm(end - start, axis=1)[:, None]
        values = _values(beams)[:, None] * np.exp(-float(beams.decay[0]) * lengths * share[:-1])
        tree = fl.build(pieces.astype(np.float32), "bvh-cl")
        given = values.astype(np.float32).ravel()
        sums.append(_sums(tree, rays, radius, given, beams, "epanechnikov", np.inf))
    return float(np.abs(sums[0] - sums[1]).sum() / np.abs(sums[0]).sum())


def _figures(
    b: Float64Array,
    exact: Float64Array,
    theory: dict[float, Float64Array],
    measured: dict[tuple[str, float], Measured],
    lost: float,
    cut: float,
    n_beams: int,
    n_passes: int,
) -> Figures:
    small, large = theory
    rows, points = [], []
    for i in range(len(b)):
        row: list[Any] = [f"{b[i]:.3f}", f"{exact[i]:.5f}"]
        for radius in theory:
            for kind in ("long", "short"):
                found = measured[kind, radius]
                row += [f"{found.mean[i]:.4f} ± {found.error[i]:.4f}"]
            row += [f"{theory[radius][i]:.4f}"]
        rows.append(tuple(row))
        points.append(
            {
                "b": float(b[i]),
                **{
                    f"{kind} {radius:g}": [float(each.mean[i]), float(each.error[i])]
                    for (kind, radius), each in measured.items()
                },
                **{f"theory {radius:g}": float(theory[radius][i]) for radius in theory},
            }
        )
    far = b >= 20 * small  # where the blur changes the closed form by less than 0.05 %
    checks = []
    for (kind, radius), each in measured.items():
        errors = float((np.abs(each.mean - theory[radius]) / each.error).max())
        what = f"{kind} beams, R = {radius:g}: standard errors off the blurred closed form, largest"
        checks.append(Check(what, errors, MOST_ERRORS, scene="point light"))
    for kind in ("long", "short"):
        each = measured[kind, small]
        errors = float((np.abs(each.mean - 1) / each.error)[far].max())
        what = f"{kind} beams, R = {small:g}, b ≥ {20 * small:g}: standard errors off the closed form, largest"
        checks.append(Check(what, errors, MOST_ERRORS, scene="point light"))
    one, other = measured["long", large], measured["short", large]
    errors = float((np.abs(one.mean - other.mean) / np.hypot(one.error, other.error)).max())
    checks += [
        Check("long beams beside short ones: standard errors, largest", errors, MOST_ERRORS, scene="point light"),
        Check("power that is lost", lost, MOST_LOST, scene="point light"),
        Check("difference of beams in 1 and in 50 pieces", cut, MOST_CUT, scene="point light"),
    ]
    heads = ["distance", "closed form"]
    for radius in theory:
        heads += [f"R = {radius:g}: long", "short", "theory"]
    notes = [
        f"{n_beams:,} beams of each kind in {n_passes} passes, {N_RAYS} rays a distance. Figures are fractions of the "
        "closed form, with the standard error of the mean of passes; theory is the closed form, blurred by the box. "
        f"Power lost: {lost:.1e}. Beams cut into 50 pieces: sums differ by {cut:.1e}."
    ]
    return Figures("point-light", "a point light in a medium", tuple(heads), rows, notes, checks, points)
