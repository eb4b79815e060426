"""Shapes of a scene of Mitsuba as surfaces that our photons hit: its ray casts and its BSDFs."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import IntArray
from ..beams.coefficients import BoolArray
from ..beams.surfaces import Scattered
from ..support.counter_random import Float64Array, UInt64Array
from .conversion import flags, numbers, pairs_of_samples, points, samples, triples, unit_triples, vectors
from .packages import dr, mi


class MitsubaSurfaces:
    """The shapes of a scene of Mitsuba, as `beams.Surfaces`.

    Parameters
    ----------
    scene : mitsuba.Scene
    """

    def __init__(self, scene: Any) -> None:
        self.scene = scene
        box = scene.bbox()
        corners = np.array([np.asarray(box.min), np.asarray(box.max)], np.float64)
        self.bounds = corners if scene.shapes() and np.isfinite(corners).all() else None

    def intersect(self, origins: Float64Array, directions: Float64Array) -> MitsubaHits:
        """See `beams.Surfaces`."""
        found = self.scene.ray_intersect(mi.Ray3f(points(origins), vectors(directions)))
        t = dr.select(found.is_valid(), found.t, dr.inf)
        dr.eval(found, t)
        return MitsubaHits(numbers(t, len(origins)), found)

    def fingerprint(self) -> str:
        """See `beams.Surfaces`; of the whole scene, with its lights and cameras."""
        checksum = hashlib.blake2b(str(self.scene).encode(), digest_size=20)
        for name, value in mi.traverse(self.scene):
            checksum.update(name.encode() + np.array(value).tobytes())
        return checksum.hexdigest()


@dataclass(frozen=True, eq=False)
class MitsubaHits:
    """What rays have hit of `MitsubaSurfaces`; see `beams.SurfaceHits`."""

    t: Float64Array
    #: The interaction of Mitsuba.
    found: Any

    def scatter(self, rows: IntArray, in_medium: BoolArray, keys: UInt64Array, *, camera: bool = False) -> Scattered:
        """See `beams.SurfaceHits`."""
        n = len(rows)
        found = dr.gather(mi.SurfaceInteraction3f, self.found, mi.UInt32(rows.astype(np.uint32)))
        mode = mi.TransportMode.Radiance if camera else mi.TransportMode.Importance
        sample, value = found.bsdf().sample(mi.BSDFContext(mode), found, samples(keys, 0), pairs_of_samples(keys, 1))
        direction = found.to_world(sample.wo)
        value = dr.select(sample.pdf > 0, value, 0)
        if not camera:
            value *= shading_correction(found, sample.wo, direction)
        in_front = found.target_medium(direction) != None  # noqa: E711 (each ray is compared)
        inside = dr.select(found.is_medium_transition(), in_front, mi.Bool(in_medium))
        begin = found.spawn_ray(direction)
        is_specular = mi.has_flag(sample.sampled_type, mi.BSDFFlags.Delta | mi.BSDFFlags.Null)
        dr.eval(begin, value, inside, is_specular)  # in one kernel
        return Scattered(
            triples(begin.o, n), unit_triples(begin.d, n), triples(value, n), flags(inside, n), flags(is_specular, n)
        )


def shading_correction(found: Any, turned: Any, direction: Any) -> Any:
    """Return what corrects a BSDF for photons where shading normals differ from the surface's own (Veach 1997, §5.3).

    It is 0 where light would leak through the surface.
    """
    before, after = dr.dot(found.n, found.to_world(found.wi)), dr.dot(found.n, direction)
    shaded_before, shaded_after = mi.Frame3f.cos_theta(found.wi), mi.Frame3f.cos_theta(turned)
    same_side = (before * shaded_before > 0) & (after * shaded_after > 0)
    return dr.select(same_side, dr.abs(shaded_before * after / (shaded_after * before)), 0)
