"""The medium of a scene of Mitsuba, as one of ours.

Mitsuba has media inside and outside of shapes, around lights and around cameras. Photon beams take one of them, which
may be in any number of places; elsewhere is nothing.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..beams.coefficients import BoolArray
from ..beams.grid_medium import GridMedium
from ..beams.medium import HomogeneousMedium, Medium
from ..errors import InputError
from ..support.counter_random import Float64Array
from .conversion import flags, numbers, points, triples
from .packages import mi

#: The voxels of a heterogeneous medium along each axis, where it is not a grid itself.
VOXELS = 64
#: Coefficients that differ by less than this fraction of the largest one count as the same.
SAME = 1e-5


def medium_of(scene: Any) -> tuple[Medium, list[Any]]:
    """Return the one medium of a scene of Mitsuba as ours, and the shapes that it is inside of.

    Raises
    ------
    InputError
        If the scene has no medium or several, or its phase function is neither isotropic nor Henyey–Greenstein.
    """
    shapes = scene.shapes()
    found = [shape.interior_medium() for shape in shapes] + [shape.exterior_medium() for shape in shapes]
    found += [place.get_medium() for place in (*scene.sensors(), *scene.emitters())]
    media = [medium for i, medium in enumerate(found) if medium is not None and medium not in found[:i]]
    if len(media) != 1:
        raise InputError(
            f"the scene has {len(media)} media; photon beams are drawn in one: give one medium an id, and refer to it "
            "in the shapes, lights and cameras that are in it"
        )
    (medium,) = media
    enclosing = [shape for shape in shapes if shape.interior_medium() == medium]
    g = _mean_cosine(medium.phase_function())
    box = bounds_of(enclosing or shapes)
    varies = not medium.is_homogeneous() or any(name.endswith(".data") for name, _ in mi.traverse(medium))
    return (_heterogeneous if varies else _homogeneous)(medium, box, g), enclosing


def bounds_of(places: list[Any]) -> Float64Array:
    """Return the box of shapes, lights and cameras, (2, 3); those without a place do not count."""
    boxes = [place.bbox() for place in places]
    corners = np.array([[np.asarray(box.min), np.asarray(box.max)] for box in boxes if box.valid()], np.float64)
    if not len(corners):
        raise InputError("nothing in the scene has a place; add a shape that encloses the medium")
    return np.array([corners[:, 0].min(axis=0), corners[:, 1].max(axis=0)])


def _homogeneous(medium: Any, box: Float64Array, g: float) -> HomogeneousMedium:
    scattering, extinction = _coefficients(medium, box.mean(axis=0)[None])
    return HomogeneousMedium(np.maximum(extinction - scattering, 0)[0], scattering[0], g)


def _heterogeneous(medium: Any, box: Float64Array, g: float) -> GridMedium:
    """Look up the voxels of the grid itself, or else of one over the box."""
    data = mi.traverse(medium).get("sigma_t.data")
    shape = (VOXELS,) * 3 if data is None else tuple(data.shape[2::-1])
    centres = box[0] + (np.indices(shape).reshape(3, -1).T + 0.5) / shape * (box[1] - box[0])
    scattering, extinction = _coefficients(medium, centres)
    density = extinction.sum(axis=1) * _within(medium, centres)
    density /= max(density.max(), np.finfo(np.float64).tiny)
    densest = density.argmax()
    for name, values in (("scattering", scattering), ("extinction", extinction)):
        if np.abs(values - density[:, None] * values[densest])[density > 0].max(initial=0) > SAME * extinction.max():
            raise InputError(
                f"the colour of the medium's {name} varies from place to place; photon beams take a density that "
                "varies, times one colour: give albedo and the colour of sigma_t one value each"
            )
    absorption = np.maximum(extinction[densest] - scattering[densest], 0)
    return GridMedium(density.reshape(shape), box, absorption, scattering[densest], g)


def _within(medium: Any, places: Float64Array) -> BoolArray:
    """Return whether points are in the box of the medium's own grid, beyond which is nothing."""
    n = len(places)
    hit, begin, end = medium.intersect_aabb(mi.Ray3f(points(places), mi.Vector3f(1, 1, 1)))
    return flags(hit, n) & (numbers(begin, n) <= 0) & (numbers(end, n) >= 0)


def _coefficients(medium: Any, places: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Return scattering and extinction at points, (n, 3) each."""
    at = mi.MediumInteraction3f()
    at.p = points(places)
    scattering, _, extinction = medium.get_scattering_coefficients(at, True)
    return triples(scattering, len(places)), triples(extinction, len(places))


def _mean_cosine(phase: Any) -> float:
    kind = phase.class_name()
    if kind == "HGPhaseFunction":
        return float(np.asarray(mi.traverse(phase)["g"]).item())
    if kind == "IsotropicPhaseFunction":
        return 0.0
    raise InputError(f"the medium has a phase function of the kind {kind}; expected isotropic or hg")
