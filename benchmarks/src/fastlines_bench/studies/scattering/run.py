"""Our scattering of hair beside Mitsuba's, in the same directions, and the tables of averaged hair beside sums."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from fastlines.rendering.hair import AveragedHair, HairMaterial, evaluate, evaluate_angles, pdf, sample

from ...harness import machine
from ...harness.arrays import Float64Array
from ...harness.clock import best_in_turn, timed
from ...harness.preset import Preset, sized
from ...peers.mitsuba import load
from .oracle import bessel_of, mitsuba_values

#: Concentrations of eumelanin and pheomelanin, which Mitsuba is given instead of the absorption.
PIGMENTS = {"brown": (1.3, 0.2), "black": (8.0, 0.0)}

#: The materials, by name.
MATERIALS: dict[str, HairMaterial] = {
    "brown": HairMaterial.from_pigments(*PIGMENTS["brown"]),
    "smooth, dyed": HairMaterial((0.2, 0.5, 1.3), 0.1, 0.15, scale_tilt=0.0),
    "very smooth": HairMaterial.from_pigments(0.3, 0.1, longitudinal_roughness=0.05, azimuthal_roughness=0.08),
    "rough, red": HairMaterial((0.05, 0.9, 2.5), 0.8, 0.9, scale_tilt=5.0),
    "black": HairMaterial.from_pigments(*PIGMENTS["black"], longitudinal_roughness=0.2, scale_tilt=3.0),
    "no absorption": HairMaterial((0.0, 0.0, 0.0), 0.25, 0.4, eta=1.4, scale_tilt=5.0),
}

#: Errors are relative to the value, or to this value per steradian where it is less: a hundredth of 1 / 4π, about that
#: of a white fibre that scatters evenly.
FLOOR = 1e-3

#: Mitsuba has the angle γo as an arc cosine in float32, which is off by up to 3e-4 radians where the angle is small. So
#: the largest error is also reported for the offsets of at least this.
OFF_AXIS = 0.01


@dataclass(frozen=True, kw_only=True)
class HairPreset(Preset):
    """How many directions are compared.

    Parameters
    ----------
    n_pairs : int
        The number of pairs of directions for each material. Half of the incident directions are even on the sphere, and
        half are drawn by `sample`, where the value is large.
    seed : int
    n_averages : int
        The number of values of averaged hair that are compared with sums over all offsets.
    n_timed : int
        The number of values that are timed.
    """

    n_pairs: int = sized(100_000, 2_000)
    seed: int = 0
    n_averages: int = sized(2_000, 100)
    n_timed: int = sized(1 << 20, 1 << 14)


@dataclass(frozen=True)
class HairCell:
    """The errors of one quantity for one material.

    Attributes
    ----------
    bessel : str
        Whose I0 our model uses, "ours" or "Mitsuba's".
    quantity : str
        "value" or "pdf".
    max, max_off_axis, p999, median : float
        The largest relative error, of all and with an offset of at least `OFF_AXIS`; the error that 99.9 % do not
        exceed; the median.
    """

    material: str
    bessel: str
    quantity: str
    max: float
    max_off_axis: float
    p999: float
    median: float


@dataclass(frozen=True)
class AverageCell:
    """Averaged hair of one material.

    Attributes
    ----------
    build_ms : float
        Milliseconds to make the tables.
    averaged_ns, single_ns : float
        Nanoseconds for a value in float32: of averaged hair, and of one offset; the best of three rounds.
    max, p99, median : float
        The errors of averaged hair, relative to sums over all offsets.
    """

    material: str
    build_ms: float
    averaged_ns: float
    single_ns: float
    max: float
    p99: float
    median: float


@dataclass(frozen=True)
class HairResult:
    """All errors, and some of Mitsuba's values."""

    machine: dict[str, Any]
    mitsuba: str
    preset: HairPreset
    seconds: float
    cells: list[HairCell]
    averages: list[AverageCell]
    examples: list[dict[str, Any]]

    def to_json(self) -> dict[str, Any]:
        """Return all figures, ready for JSON."""
        return {"format": "fastlines-bench hair 1", **asdict(self)}


def run_hair(preset: HairPreset, progress: Callable[[str, float], None] = lambda what, share: None) -> HairResult:
    """Compare all materials.

    Parameters
    ----------
    preset : HairPreset
    progress : callable
        Called with the current material and the share of all work that is done.
    """
    mitsuba = load("scalar_rgb", 1)
    began = time.perf_counter()
    cells: list[HairCell] = []
    averages: list[AverageCell] = []
    examples: list[dict[str, Any]] = []
    for i, (name, material) in enumerate(MATERIALS.items()):
        progress(name, i / len(MATERIALS))
        wo, wi, h = _directions(material, preset)
        theirs = mitsuba_values(mitsuba, material, wo, wi, PIGMENTS.get(name))
        for bessel in ("ours", "Mitsuba's"):
            with bessel_of(bessel):
                ours = evaluate(material, wo, wi, (0, 1, 0), h), pdf(material, wo, wi, (0, 1, 0), h)
            for quantity, our, their in zip(("value", "pdf"), ours, (theirs[:, :3], theirs[:, 3]), strict=True):
                error = _relative(our, their)
                off_axis = error[np.abs(h) >= OFF_AXIS].max()
                figures = (error.max(), off_axis, np.quantile(error, 0.999), np.median(error))
                cells.append(HairCell(name, bessel, quantity, *(float(each) for each in figures)))
        averages.append(_averaged(name, material, preset))
        some = [0, 1, len(wo) // 2, len(wo) // 2 + 1]
        examples += [
            {
                "material": asdict(material),
                "wo": list(o),
                "wi": list(w),
                "h": at,
                "value": list(value[:3]),
                "pdf": value[3],
            }
            for o, w, at, value in zip(wo[some], wi[some], h[some], theirs[some], strict=True)
        ]
    seconds = time.perf_counter() - began
    return HairResult(machine.describe(), mitsuba.__version__, preset, seconds, cells, averages, examples)


def _directions(material: HairMaterial, preset: HairPreset) -> tuple[Float64Array, Float64Array, Float64Array]:
    """Return wo, wi and h, where the normal is z, the tangent is y and each h in -1…1 is as likely."""
    rng = np.random.default_rng(preset.seed)
    n = preset.n_pairs
    h, sine = rng.uniform(-1, 1, n), rng.uniform(-1, 1, n)
    cosine = np.sqrt(1 - sine**2)
    wo = np.stack([h * cosine, sine, np.sqrt(1 - h**2) * cosine], axis=1)
    wi, _, _ = sample(material, wo, (0, 1, 0), h, rng.random((n, 4)))
    even = rng.normal(size=(n // 2, 3))
    wi[: n // 2] = even / np.linalg.norm(even, axis=1, keepdims=True)
    # Mitsuba rounds directions to float32: round them before both sides see them.
    wo, wi = (each.astype(np.float32).astype(np.float64) for each in (wo, wi))
    return wo, wi, wo[:, 0] / np.hypot(wo[:, 0], wo[:, 2])


def _averaged(name: str, material: HairMaterial, preset: HairPreset) -> AverageCell:
    """Compare averaged hair with sums over offsets, and time both."""
    began = time.perf_counter()
    hair = AveragedHair(material)
    build = time.perf_counter() - began

    # Sum over the offsets h = sin γ, in steps of γ.
    rng = np.random.default_rng(preset.seed)
    angles = rng.uniform(-1, 1, (3, preset.n_averages)) * np.array([[1], [1], [np.pi]])
    gamma = (np.arange(2000) + 0.5) * (np.pi / 2000) - np.pi / 2
    sums = []
    for sin_o, sin_i, phi in np.array_split(angles[:, :, None], max(1, preset.n_averages // 100), axis=1):
        value = evaluate_angles(material, sin_o, sin_i, phi, np.sin(gamma))
        sums.append(np.einsum("abc,b->ac", value, np.cos(gamma)) * (np.pi / 4000))
    expected = np.concatenate(sums)
    error = _relative(hair.evaluate(angles[0], angles[1], angles[2]), expected)

    # Time both in float32.
    sin_o, sin_i, phi = (rng.uniform(-1, 1, (3, preset.n_timed)) * np.array([[1], [1], [np.pi]])).astype(np.float32)
    wo, wi = rng.normal(size=(2, preset.n_timed, 3))
    wo, wi = ((each / np.linalg.norm(each, axis=1, keepdims=True)).astype(np.float32) for each in (wo, wi))
    tangent, h = np.array([0, 1, 0], np.float32), sin_o
    (averaged, _), (single, _) = best_in_turn(
        3,
        timed(lambda: hair.evaluate(sin_o, sin_i, phi)),
        timed(lambda: evaluate(material, wo, wi, tangent, h)),
    )
    times = (build * 1e3, averaged * 1e9 / preset.n_timed, single * 1e9 / preset.n_timed)
    figures = (*times, error.max(), np.quantile(error, 0.99), np.median(error))
    return AverageCell(name, *(float(figure) for figure in figures))


def _relative(values: npt.NDArray[Any], expected: Float64Array) -> Float64Array:
    """Return the errors of values, relative to what is expected or to `FLOOR`."""
    return np.asarray(np.abs(values - expected) / np.maximum(np.abs(expected), FLOOR))
