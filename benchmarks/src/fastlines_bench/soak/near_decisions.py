"""Checks what is near points, near each other and in boxes of space against float64: decisions, and distances."""

from __future__ import annotations

from typing import Any

import numpy as np

import fastlines as fl

from .exact_pairs import distance_of_pairs, factor_of_tapers
from .exact_points import POINT_BAND, distance_from_boxes, distance_from_cones, distance_from_triangles
from .exact_regions import decide_in_boxes
from .rays import random_boxes, random_points, random_radii_of_rays
from .scenes import Array, Random
from .tally import Tally
from .trees import on
from .values import Values

#: The band of pairs, as a fraction of the size of the scene and of both radii.
PAIR_BAND = 2.0**-20
#: Neighbours of each point, primitives that are paired, and boxes of space.
N_NEAREST, N_PAIRED, N_BOXES = 3, 64, 64


def of_whole(geometry: Any, of_rows: Array) -> Array:
    """Return the values of primitives, from those of rows of the core: of a curve, the least of its pieces."""
    if not geometry.in_pieces:
        return of_rows
    first = np.flatnonzero(np.diff(geometry.owner, prepend=-1))
    return np.asarray(np.minimum.reduceat(of_rows, first, axis=1))


def distances(points: Array, kind: str, geometry: Any, centre: Array) -> Array:
    """Return the distances of points from primitives, or from surfaces, relative to the centre of the scene."""
    if kind in ("triangles", "boxes"):
        corners = geometry.corners.astype(np.float64) - centre
        return (distance_from_triangles if kind == "triangles" else distance_from_boxes)(points, corners)
    lines = geometry.straight
    ends, radii = lines.segments.astype(np.float64) - centre, lines.end_radii.astype(np.float64)
    return of_whole(geometry, distance_from_cones(points, ends, radii))


def check_points(rng: Random, kind: str, shape: str, tree: Any, axes: Array, size: float, n_points: int) -> Tally:
    """Decide which primitives are within a radius of points; some radii just reach a primitive."""
    geometry = tree.geometry
    centre = np.asarray(geometry.bounds, np.float64).mean(axis=0)
    points = random_points(rng, axes, n_points)
    exact = distances(points - centre, kind, geometry, centre)
    radius = random_radii_of_rays(rng, n_points, size)
    touched = rng.random(n_points) < 0.5
    place = exact[np.arange(n_points), rng.integers(0, exact.shape[1], n_points)]
    aside = POINT_BAND * (size + np.abs(place)) * rng.choice([0, 1, 20], n_points) * rng.uniform(-1, 1, n_points)
    radius[touched] = np.maximum(place + aside, 0)[touched]
    is_within, band = exact <= radius[:, None], POINT_BAND * (size + np.abs(exact))
    certain = np.abs(exact - radius[:, None]) > band
    tally = Tally(n_in_band=int((~certain).sum()))
    ranked = np.sort(exact, axis=1)[:, :N_NEAREST]
    for simd in fl.available_simd():
        try:
            with on(simd, int(rng.integers(1, 3))):
                within, nearest = tree.within(points, radius), tree.nearest(points, k=N_NEAREST)
        except fl.InputError:
            return Tally(n_refused=1)
        found = np.zeros(exact.shape, np.bool_)
        found[within.point, within.prim] = True
        tally.count((f"{kind}, points", shape, simd), certain, found != is_within, 0)
        of_listed = exact[within.point, within.prim]
        tally.values.check(
            f"{kind}, distance of points", simd, within.distance - of_listed, POINT_BAND * (size + np.abs(of_listed))
        )
        n_ranks = ranked.shape[1]
        error = nearest.distance.reshape(n_points, N_NEAREST)[:, :n_ranks] - ranked
        tally.values.check(f"{kind}, nearest of points", simd, error, POINT_BAND * (size + np.abs(ranked)))
    return tally


def check_pairs(rng: Random, kind: str, shape: str, geometry: Any, size: float) -> Tally:
    """Decide which of some lines, round cones or spheres are within a radius of each other."""
    ends, radii = geometry.segments[:N_PAIRED].astype(np.float64), geometry.end_radii[:N_PAIRED].astype(np.float64)
    tree = fl.build(geometry[: len(ends)])
    i, j = np.triu_indices(len(ends), 1)
    ends = ends - ends.reshape(-1, 3).mean(axis=0)
    exact = distance_of_pairs(ends[i], radii[i], ends[j], radii[j])
    band = PAIR_BAND * (size + radii[i].max(axis=1) + radii[j].max(axis=1))
    band *= factor_of_tapers(ends[i], radii[i], ends[j], radii[j])
    radius = np.float32(max(0.0, float(rng.choice(exact))) if rng.random() < 0.7 else size * 10 ** rng.uniform(-3, 0))
    certain, tally = np.abs(exact - radius) > band, Tally()
    tally.n_in_band = int((~certain).sum())
    for simd in fl.available_simd():
        with on(simd, int(rng.integers(1, 3))):
            pairs = tree.pairs(float(radius), skip_neighbours=0)
        found = np.zeros((len(ends), len(ends)), bool)
        found[pairs.i, pairs.j] = True
        differs = found[i, j] != (exact <= radius)
        tally.count((f"{kind}, pairs", shape, simd), certain[:, None], differs[:, None], 0)
        place = np.zeros(found.shape, np.int64)
        place[i, j] = np.arange(len(i))
        at = place[pairs.i, pairs.j]
        tally.values.check(f"{kind}, distance of pairs", simd, pairs.distance - exact[at], band[at])
        _check_places(tally.values, kind, simd, pairs, ends, radii, band[at])
    return tally


def _check_places(values: Values, kind: str, simd: str, pairs: Any, ends: Array, radii: Array, band: Array) -> None:
    """Check that the places s and t are as far from each other as the distance says."""
    places = []
    for of, at in ((pairs.i, pairs.s), (pairs.j, pairs.t)):
        s = at.astype(np.float64)[:, None]
        places.append(
            (ends[of, 0] + s * (ends[of, 1] - ends[of, 0]), radii[of, 0] + s[:, 0] * np.diff(radii[of])[:, 0])
        )
    (a, r), (b, q) = places
    away = np.sqrt(((a - b) ** 2).sum(axis=1)) - r - q
    values.check(f"{kind}, places of pairs", simd, away - pairs.distance, band)


def check_boxes(rng: Random, kind: str, shape: str, tree: Any, axes: Array) -> Tally:
    """Decide which primitives are in boxes of space, many of which touch them."""
    geometry, asked = tree.geometry, random_boxes(rng, axes, N_BOXES)
    if kind in ("triangles", "boxes"):
        corners, radii = geometry.corners, None
    else:
        corners, radii = geometry.segments, geometry.end_radii
    exact, certain = decide_in_boxes(kind, corners, radii, **asked)
    tally = Tally(n_in_band=int((~certain).sum()))
    for simd in fl.available_simd():
        with on(simd, int(rng.integers(1, 3))):
            listed = tree.in_box(**asked)
        found = np.zeros(exact.shape, np.bool_)
        found[listed.box, listed.prim] = True
        tally.count((f"{kind}, boxes of space", shape, simd), certain, found != exact, 0)
    return tally
