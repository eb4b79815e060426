"""Photons, traced through a scene, and the beams of light that their flights are.

A photon flies from a light, a surface or a scattering to the next one. Each flight through the medium is a beam. A
*short* beam ends where the photon collides with the medium, so it carries the same power everywhere; in a channel with
more extinction than the least, what is more attenuates it. A *long* beam goes on to the next surface or to the end of
the medium, and carries the power less the transmittance from its beginning.

After a collision a photon goes on with the probability of the albedo σ_s / σ_t, and after a surface with that of the
reflectance (Russian roulette). All random numbers of a photon are hashes of the seed, the pass, its number and the
number of its flight: the beams do not depend on how many photons are traced at a time.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import FloatArray, IntArray, choice, count
from ..errors import InputError
from ..geometry.lines import Lines
from ..progress import ProgressOption, reporting
from ..support.counter_random import Float64Array, UInt64Array, random_bits, uniform
from ..support.phase_function import scattering_cosine
from ..support.texts import counted
from ..support.unit_directions import turned
from .coefficients import BoolArray
from .medium import fly
from .scene import BeamScene, check_scene

#: How many photons are traced at a time.
BATCH = 1 << 16
#: The kinds of beams.
KINDS = ("short", "long")
#: The flights after which a path is cut off.
MAX_FLIGHTS = 256
#: Random numbers of a flight: the first is the key of the medium's, the second of the surface's.
IN_MEDIUM, AT_SURFACE, ROULETTE, ANGLE, AZIMUTH = range(5)


@dataclass(frozen=True)
class Energy:
    """What has become of the power of the lights, RGB each: ``emitted`` is the sum of all others.

    Attributes
    ----------
    emitted : (3,) float64
    absorbed_by_medium, absorbed_by_surfaces : (3,) float64
    escaped : (3,) float64
        What has left the scene.
    cut_off : (3,) float64
        What photons carried when they had flown or scattered as often as is allowed.
    """

    emitted: Float64Array
    absorbed_by_medium: Float64Array
    absorbed_by_surfaces: Float64Array
    escaped: Float64Array
    cut_off: Float64Array


@dataclass(frozen=True, eq=False, repr=False)
class Beams:
    """Beams of light: the flights of photons through a medium.

    Attributes
    ----------
    lines : Lines
        From the start of each beam to its end, in the order of paths and of the flights of each. Strands are paths.
    power : (n, 3) float32
        The power at the start: that of all lights, if the photon were their only one. So it is to be divided by
        ``n_paths``.
    n_paths : int
        How many photons were emitted. Some may have no beam.
    kind : {"short", "long"}
    decay : (3,) float64
        The extinction along the beams, per column depth.
    energy : Energy
    """

    lines: Lines
    power: FloatArray
    n_paths: int
    kind: str
    decay: Float64Array
    energy: Energy

    def __len__(self) -> int:
        return len(self.lines)

    def __repr__(self) -> str:
        return f"<Beams: {counted(len(self), f'{self.kind} beams')} of {counted(self.n_paths, 'photons')}>"

    @property
    def path(self) -> IntArray:
        """The number of the photon of each beam, (n,) int64."""
        return np.asarray(self.lines.strands, np.int64)


def trace_photons(
    scene: BeamScene,
    n_paths: int,
    *,
    kind: str = "short",
    seed: int = 0,
    pass_number: int = 0,
    max_scatterings: int | None = None,
    max_flights: int = MAX_FLIGHTS,
    batch: int = BATCH,
    progress: ProgressOption = False,
) -> Beams:
    """Emit photons from the lights of a scene, follow them, and return their flights through the medium.

    Parameters
    ----------
    scene : BeamScene
    n_paths : int
        How many photons to emit.
    kind : {"short", "long"}
        Where beams end: at a collision with the medium, or at the next surface or the end of the medium.
    seed, pass_number : int
        Others give other photons.
    max_scatterings : int, optional
        How often the medium may scatter a photon before a beam; 0 makes beams of the light that comes from the lights
        alone. By default, chance alone ends paths.
    max_flights : int
        How many flights a photon may have; the power of those that go on is `Energy.cut_off`.
    batch : int
        How many photons are traced at a time; the beams do not depend on it.
    progress : bool or callable
        Show a bar, or call back with the fraction that is done.

    Raises
    ------
    InputError
        If a number is out of range, or no photon flies through the medium.

    Examples
    --------
    >>> import fastlines as fl
    >>> fog = fl.beams.HomogeneousMedium(absorption=0.5, scattering=0.5)
    >>> scene = fl.beams.BeamScene(fog, [fl.beams.PointLight((0, 0, 0), power=1)], box=[[-1, -1, -1], [1, 1, 1]])
    >>> beams = trace_photons(scene, 1000, kind="long", max_scatterings=0)
    >>> beams, bool((beams.lines.segments[:, 0] == 0).all())
    (<Beams: 1,000 long beams of 1,000 photons>, True)
    """
    check_scene(scene)
    count("n_paths", n_paths, 1, 2**40), count("max_flights", max_flights, 1), count("batch", batch, 1)
    choice("kind", kind, KINDS)
    most = 2**62 if max_scatterings is None else count("max_scatterings", max_scatterings, 0)
    key = random_bits(count("seed", seed, 0), count("pass_number", pass_number, 0))
    traced = []
    with reporting(progress, "photons") as callback:
        for first in range(0, n_paths, batch):
            path = np.arange(first, min(first + batch, n_paths))
            traced.append(_Tracer(scene, kind, most).trace(random_bits(key, path), path, max_flights))
            if callback:
                callback(min(first + batch, n_paths) / n_paths)
    segments, power, path = (np.concatenate(columns) for columns in zip(*(one[:3] for one in traced), strict=True))
    if not len(segments):
        raise InputError(
            f"none of {counted(n_paths, 'photons')} flies through the medium, whose box is {scene.box.tolist()}; move "
            "the lights, or give another box="
        )
    energy = Energy(*(sum(parts) / n_paths for parts in zip(*(one[3] for one in traced), strict=True)))
    extinction = scene.medium.extinction
    decay = extinction - extinction.min() if kind == "short" else extinction
    return Beams(Lines.from_segments(segments, strands=path), power, n_paths, kind, decay, energy)


@dataclass
class _Photons:
    """Photons in flight, one a row."""

    path: IntArray
    keys: UInt64Array
    origins: Float64Array
    directions: Float64Array
    power: Float64Array
    in_medium: BoolArray
    scatterings: IntArray

    def some(self, rows: IntArray | BoolArray) -> _Photons:
        columns = {name: values[rows] for name, values in vars(self).items()}
        return replace(self, **columns)


class _Tracer:
    """Traces a batch of photons, and keeps account of beams and of energy."""

    def __init__(self, scene: BeamScene, kind: str, max_scatterings: int) -> None:
        self.scene, self.kind, self.max_scatterings = scene, kind, max_scatterings
        with np.errstate(invalid="ignore"):
            albedo = np.asarray(scene.medium.scattering) / scene.medium.extinction
        self.albedo = np.nan_to_num(albedo)
        self.beams: list[tuple[FloatArray, FloatArray, IntArray]] = []
        self.emitted, self.by_medium, self.by_surfaces, self.escaped, self.cut_off = np.zeros((5, 3))

    def trace(
        self, keys: UInt64Array, path: IntArray, max_flights: int
    ) -> tuple[FloatArray, FloatArray, IntArray, tuple[Float64Array, ...]]:
        """Return the segments, power and path of the beams, sorted by path, and the parts of `Energy`."""
        emission = self.scene.emit(random_bits(keys, 0))
        # Copy the columns: lights may repeat one row.
        origins, directions, power = np.array(emission[:3])
        photons = _Photons(
            path, keys, origins, directions, power, np.array(emission.in_medium), np.zeros(len(path), np.int64)
        )
        self.emitted += photons.power.sum(axis=0)
        for flight in range(max_flights):
            if not len(photons.path):
                break
            photons = self._fly(photons, random_bits(photons.keys, flight + 1))
        self.cut_off += photons.power.sum(axis=0)
        segments, power, path = (np.concatenate(columns) for columns in zip(*self.beams, strict=True))
        order = np.argsort(path, kind="stable")
        energy = self.emitted, self.by_medium, self.by_surfaces, self.escaped, self.cut_off
        return segments[order], power[order], path[order], energy

    def _fly(self, photons: _Photons, keys: UInt64Array) -> _Photons:
        """Let all photons fly once; return those that go on."""
        hits = self.scene.surfaces.intersect(photons.origins, photons.directions)
        collided = self._through_medium(photons, hits.t, random_bits(keys, IN_MEDIUM))
        arrives = np.isfinite(hits.t) & ~collided
        self.escaped += photons.power[~arrives & ~collided].sum(axis=0)
        goes_on = np.zeros(len(keys), np.bool_)

        # Scatter at the surfaces.
        if len(rows := np.flatnonzero(arrives)):
            scattered = hits.scatter(rows, photons.in_medium[rows], random_bits(keys[rows], AT_SURFACE))
            before = photons.power[rows]
            for column, values in (
                (photons.origins, scattered.origins),
                (photons.directions, scattered.directions),
                (photons.in_medium, scattered.in_medium),
            ):
                column[rows] = values
            goes_on[rows] = self._roulette(photons, rows, scattered.weight, keys)
            self.by_surfaces += (before - photons.power[rows]).sum(axis=0)

        # Scatter in the medium.
        if len(rows := np.flatnonzero(collided)):
            before = photons.power[rows]
            goes_on[rows] = self._roulette(photons, rows, self.albedo, keys)
            self.by_medium += (before - photons.power[rows]).sum(axis=0)
            cosine = scattering_cosine(self.scene.medium.g, uniform(keys[rows], ANGLE))
            photons.directions[rows] = turned(photons.directions[rows], cosine, uniform(keys[rows], AZIMUTH))
            photons.scatterings[rows] += 1
            too_often = photons.scatterings > self.max_scatterings
            self.cut_off += photons.power[too_often].sum(axis=0)
            goes_on &= ~too_often
        return photons.some(goes_on)

    def _through_medium(self, photons: _Photons, to_surface: Float64Array, keys: UInt64Array) -> BoolArray:
        """Fly through the medium, and keep the beams; return which photons collide, and move these there."""
        begin, end = self.scene.in_box(photons.origins, photons.directions)
        end = np.minimum(end, to_surface)
        collided = np.zeros(len(keys), np.bool_)
        rows = np.flatnonzero(photons.in_medium & (begin < end))
        directions, lengths = photons.directions[rows], (end - begin)[rows]
        start = photons.origins[rows] + begin[rows, None] * directions
        flights = fly(self.scene.medium, start, directions, lengths, keys[rows])
        beam_lengths = lengths if self.kind == "long" else flights.beam_length
        ends = np.stack([start, start + beam_lengths[:, None] * directions], axis=1).astype(np.float32)
        self.beams.append((ends, photons.power[rows].astype(np.float32), photons.path[rows]))

        after = photons.power[rows] * flights.weight
        self.by_medium += (photons.power[rows] - after).sum(axis=0)
        photons.power[rows] = after
        at = rows[flights.collides]
        photons.origins[at] = (start + flights.t[:, None] * directions)[flights.collides]
        collided[at] = True
        return collided

    def _roulette(self, photons: _Photons, rows: IntArray, weight: Float64Array, keys: UInt64Array) -> BoolArray:
        """Multiply the power of some photons by a weight, and let chance end paths rather than make them dim."""
        before = photons.power[rows]
        after = before * weight
        with np.errstate(invalid="ignore", divide="ignore"):
            chance = np.nan_to_num(np.minimum(after.max(axis=1) / before.max(axis=1), 1))
        lives = np.asarray(uniform(keys[rows], ROULETTE) < chance, np.bool_)
        photons.power[rows] = np.where(lives[:, None], after / np.where(lives, chance, 1)[:, None], 0)
        return lives
