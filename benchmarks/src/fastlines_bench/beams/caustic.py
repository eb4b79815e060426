"""A caustic in fog below a glass sphere: photon beams beside Mitsuba's volpath, in turn, for as long each."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

import fastlines as fl

from ..harness.arrays import Float64Array
from ..harness.clock import clock, timed
from ..harness.figures import Figures
from ..harness.findings import Check
from ..harness.internals import num_threads
from ..peers.fog_scene import FogScene
from ..peers.volpath import VolpathScene
from .reference import Reference

OURS, THEIRS, REFERENCE = "fastlines", "Mitsuba", "reference"

#: The share of volpath's time in which its error is wanted at most.
SOONER = 0.2

#: The largest difference of the mean radiance that is wanted, as a fraction.
MOST_DIFFERENT = 0.02

#: The factor from the seconds of one figure of a curve to those of the next one.
GROWS = math.sqrt(2)


@dataclass(frozen=True)
class CausticSize:
    """How much is rendered.

    Parameters
    ----------
    size : int
        The width of the picture.
    n_paths, radius : int, float
        The photons of our passes, and the radius of the first one.
    seconds, reference_s : float
        The seconds of each side, and of the reference.
    variant : str
        That of Mitsuba.
    """

    size: int
    n_paths: int
    radius: float
    seconds: float
    reference_s: float
    variant: str
    floors: bool
    n_threads: int


class Volpath:
    """The mean of pictures of Mitsuba, with other random numbers each."""

    def __init__(self, scene: VolpathScene, samples: int, first_seed: int) -> None:
        self._scene, self._samples, self._seed = scene, samples, first_seed
        self._sum: Any = 0.0
        self.n = 0

    def add(self) -> None:
        """Render one more picture."""
        self._sum = self._sum + self._scene.render(self._samples, self._seed + self.n)[0].astype(np.float64)
        self.n += 1

    def picture(self) -> Float64Array:
        """Return the mean, (size, size, 3)."""
        return np.asarray(self._sum / self.n)


class Beams:
    """Our progressive passes."""

    def __init__(self, scene: FogScene, n_paths: int, radius: float) -> None:
        self._passes = fl.beams.Passes(
            scene.beams(), width=scene.size, height=scene.size, n_paths=n_paths, radius=radius
        )

    def add(self) -> None:
        """Add one more pass."""
        self._passes.add()

    def picture(self) -> Float64Array:
        """Return the mean, (size, size, 3)."""
        return np.asarray(self._passes.picture().radiance, np.float64)


def run_caustic(size: CausticSize, progress: Callable[[str, float], None]) -> Figures:
    """Render a reference by volpath, then both sides in turn."""
    now, scene = clock(size.n_threads), FogScene(size.size)
    with num_threads(size.n_threads):
        mitsuba = VolpathScene(scene, size.variant, size.n_threads)
        samples = _samples_a_second(mitsuba, now)
        fog = scene.beside_glass

        # Render independent quarters of the reference.
        n = max(1, round(size.reference_s / 4))
        quarters = [Volpath(mitsuba, samples, (1 + i) * 1_000_000) for i in range(4)]
        for i in range(n):
            progress(f"reference, {4 * i} of {4 * n} s", 0.7 * i / n)
            for quarter in quarters:
                quarter.add()
        reference = Reference([quarter.picture() for quarter in quarters], fog)
        sides: dict[str, Any] = {
            OURS: Beams(scene, size.n_paths, size.radius),
            THEIRS: Volpath(mitsuba, max(1, samples // 4), 0),
        }
        curves = _curves(sides, size.seconds, reference.error, now, progress)
    pictures = {name: side.picture() for name, side in sides.items()} | {REFERENCE: reference.picture}
    for picture in pictures.values():
        picture[~fog] = 0.0
    version = f"{mitsuba.version}, {size.variant}"
    return _figures(size, curves, pictures, reference, version, 4 * n * samples)


def _samples_a_second(mitsuba: VolpathScene, now: Callable[[], float]) -> int:
    """Compile, and return about how many samples of all pixels take a second."""
    mitsuba.render(4, 9_999_999)
    _, took = timed(lambda: mitsuba.render(4, 9_999_998), now)()
    return max(1, round(4 / max(took, 1e-3)))


def _curves(
    sides: dict[str, Any],
    seconds: float,
    error: Callable[[Float64Array], float],
    now: Callable[[], float],
    progress: Callable[[str, float], None],
) -> dict[str, list[tuple[float, float]]]:
    """Let the side that has had less time go on, until both have had their seconds; return their errors over time."""
    taken = dict.fromkeys(sides, 0.0)
    curves: dict[str, list[tuple[float, float]]] = {name: [] for name in sides}
    while min(taken.values()) < seconds:
        name = min(taken, key=lambda name: taken[name])
        progress(f"{name}: {taken[name]:.0f} of {seconds:.0f} s", 0.7 + 0.3 * min(1.0, taken[name] / seconds))
        taken[name] += timed(sides[name].add, now)()[1]
        curve = curves[name]
        if not curve or taken[name] >= GROWS * curve[-1][0] or taken[name] >= seconds:
            curve.append((taken[name], error(sides[name].picture())))
    return curves


def _time_of(curve: list[tuple[float, float]], error: float) -> float | None:
    """Return when a curve first reaches an error, on straight lines between its logarithms; None if it never does.

    Examples
    --------
    >>> _time_of([(1.0, 0.4), (4.0, 0.1)], 0.2), _time_of([(1.0, 0.4)], 0.5), _time_of([(1.0, 0.4)], 0.1)
    (2.0, 1.0, None)
    """
    before: tuple[float, float] | None = None
    for seconds, its_error in curve:
        if its_error <= error:
            if before is None:
                return seconds
            share = math.log(before[1] / error) / math.log(before[1] / its_error)
            return before[0] * math.pow(seconds / before[0], share)
        before = seconds, its_error
    return None


def _figures(
    size: CausticSize,
    curves: dict[str, list[tuple[float, float]]],
    pictures: dict[str, Float64Array],
    reference: Reference,
    version: str,
    n_samples: int,
) -> Figures:
    rows = [(name, took, its_error) for name, curve in curves.items() for took, its_error in curve]
    last_s, last_error = curves[THEIRS][-1]
    is_resolved = last_error > reference.floor
    reached = _time_of(curves[OURS], last_error)
    counted = pictures[REFERENCE].any(axis=2)
    ours_mean = float(pictures[OURS][counted].mean())
    if not is_resolved:
        reaches = "is the least that the reference resolves, so it is not compared"
    else:
        reaches = "fastlines " + ("never reaches" if reached is None else f"reaches after {reached:.2f} s")
    notes = [
        f"{size.size}² pixels, {size.n_threads} thread(s); {size.n_paths:,} photons a pass, the first radius "
        f"{size.radius:g}. Mitsuba {version}; the reference has {n_samples:,} samples a pixel. Errors are root mean "
        "squares over the pixels beside the sphere, by the mean radiance, less the noise of the reference. No error is "
        f"shown as less than {reference.floor:.4f}, the least that the reference resolves.",
        f"volpath's error after {last_s:.1f} s is {last_error:.4f}, which {reaches}. Our mean radiance is "
        f"{ours_mean / reference.mean:.4f} of the reference's.",
    ]
    checks = []
    if size.floors:  # the reference of a quick run is too noisy for either
        share = (curves[OURS][-1][0] if reached is None else reached) / last_s if is_resolved else None
        off = abs(ours_mean / reference.mean - 1)
        checks = [
            Check("difference of the mean radiance", off, MOST_DIFFERENT, scene="caustic"),
            Check("our time for volpath's last error by its", share, SOONER, scene="caustic"),
        ]
    points = [{"side": name, "seconds": took, "rmse": its_error} for name, took, its_error in rows]
    heads = ("side", "seconds", "error")
    return Figures("caustic", "a caustic in fog", heads, rows, notes, checks, points, pictures)
