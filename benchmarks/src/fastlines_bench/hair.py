"""The scattering of hair beside Mitsuba's: the same directions, and the relative error of each value.

Mitsuba 3's BSDF ``hair`` has the y axis of its frame along the fibre and z along the normal at the hit, and its ``wi``
is our ``wo``. It computes in float32, with approximations of the Bessel function I0 that are off by up to half a
percent (as pbrt's): ten terms of its series up to 12, and above it x - ½ ln(2πx) + 1/(16x) for ln I0(x), where the
asymptotic series has 1/(8x). So it is compared twice: with our model as it is, and with our model on Mitsuba's I0.
"""

from __future__ import annotations

import importlib
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from fastlines.rendering.hair import HairMaterial, evaluate, pdf, sample

from .harness import machine
from .harness.preset import Preset, sized
from .harness.tables import new_table, print_table, wide_console
from .package import FastlinesError, longitudinal

Float64Array = npt.NDArray[np.float64]

#: The materials, by name. Each has the parameters of Mitsuba's ``hair``; ``sigma_a`` replaces the pigments.
MATERIALS: dict[str, HairMaterial] = {
    "brown": HairMaterial.from_pigments(1.3, 0.2),
    "smooth, dyed": HairMaterial((0.2, 0.5, 1.3), 0.1, 0.15, scale_tilt=0.0),
    "very smooth": HairMaterial.from_pigments(0.3, 0.1, longitudinal_roughness=0.05, azimuthal_roughness=0.08),
    "rough, red": HairMaterial((0.05, 0.9, 2.5), 0.8, 0.9, scale_tilt=5.0),
    "black": HairMaterial.from_pigments(8.0, longitudinal_roughness=0.2, azimuthal_roughness=0.3, scale_tilt=3.0),
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
    """

    n_pairs: int = sized(100_000, 2_000)
    seed: int = 0


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
class HairResult:
    """All errors, and some of Mitsuba's values."""

    machine: dict[str, Any]
    mitsuba: str
    preset: HairPreset
    seconds: float
    cells: list[HairCell]
    examples: list[dict[str, Any]]

    def to_json(self) -> dict[str, Any]:
        """Return all figures, ready for JSON."""
        return {"format": "fastlines-bench hair 1", **asdict(self)}


def load_mitsuba() -> Any:
    """Import Mitsuba in its scalar variant, or say how to install it."""
    try:
        mitsuba = importlib.import_module("mitsuba")
    except ImportError:
        raise FastlinesError("fastlines-bench hair compares with Mitsuba 3: run  pip install mitsuba") from None
    mitsuba.set_variant("scalar_rgb")
    return mitsuba


def mitsuba_values(mitsuba: Any, material: HairMaterial, wo: Float64Array, wi: Float64Array) -> Float64Array:
    """Return Mitsuba's values and densities, as (n, 4), for directions in its frame."""
    bsdf = mitsuba.load_dict(
        {
            "type": "hair",
            "int_ior": material.eta,
            "ext_ior": 1.0,
            "sigma_a": {"type": "rgb", "value": list(material.sigma_a)},
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
def _bessel(function: Callable[[npt.NDArray[Any]], npt.NDArray[Any]]) -> Iterator[None]:
    """Let our model use another approximation of exp(-x) I0(x)."""
    ours = longitudinal.scaled_i0
    longitudinal.scaled_i0 = function  # type: ignore[assignment]
    try:
        yield
    finally:
        longitudinal.scaled_i0 = ours


def run_hair(preset: HairPreset, progress: Callable[[str, float], None] = lambda what, share: None) -> HairResult:
    """Compare all materials.

    Parameters
    ----------
    preset : HairPreset
    progress : callable
        Called with the current material and the share of all work that is done.
    """
    mitsuba = load_mitsuba()
    began = time.perf_counter()
    cells: list[HairCell] = []
    examples: list[dict[str, Any]] = []
    for i, (name, material) in enumerate(MATERIALS.items()):
        progress(name, i / len(MATERIALS))
        wo, wi, h = _directions(material, preset)
        theirs = mitsuba_values(mitsuba, material, wo, wi)
        for bessel, function in (("ours", longitudinal.scaled_i0), ("Mitsuba's", mitsuba_scaled_i0)):
            with _bessel(function):
                ours = evaluate(material, wo, wi, (0, 1, 0), h), pdf(material, wo, wi, (0, 1, 0), h)
            for quantity, our, their in zip(("value", "pdf"), ours, (theirs[:, :3], theirs[:, 3]), strict=True):
                error = np.abs(our - their) / np.maximum(np.abs(their), FLOOR)
                off_axis = error[np.abs(h) >= OFF_AXIS].max()
                figures = (error.max(), off_axis, np.quantile(error, 0.999), np.median(error))
                cells.append(HairCell(name, bessel, quantity, *(float(each) for each in figures)))
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
    return HairResult(machine.describe(), mitsuba.__version__, preset, seconds, cells, examples)


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


def print_hair(result: HairResult) -> None:
    """Print a row for each material and quantity."""
    console = wide_console()
    title = f"relative error beside Mitsuba {result.mitsuba}: {result.preset.n_pairs:,} pairs of directions each"
    table = new_table(title, ["material", "I0", "of"], ["max", "max off axis", "99.9 %", "median"])
    for cell in result.cells:
        figures = (f"{each:.1e}" for each in (cell.max, cell.max_off_axis, cell.p999, cell.median))
        table.add_row(cell.material, cell.bessel, cell.quantity, *figures)
    print_table(console, table)
    console.print(
        f"Relative to Mitsuba's value, or to {FLOOR:g} per steradian where it is less. Mitsuba computes in float32, we "
        "in float64. I0: whose approximation of the Bessel function our model uses. "
        f"Off axis: offsets of at least {OFF_AXIS:g}. The comparison took {result.seconds:.0f} s.",
        highlight=False,
    )
