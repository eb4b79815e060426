"""Paths from the camera through a scene of Mitsuba: its surfaces, as its path tracer sees them, and beams between.

Each path of light either scatters in the medium or does not. If it does, its last scattering is on one leg of the path
from the camera: the beams along that leg have all of this light. If it does not, the legs only attenuate it: the
emitters and the direct light at each surface have it, by multiple importance sampling (Veach 1997).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from ..beams.camera_paths import Legs
from ..beams.scene import BeamScene
from ..support.counter_random import Float64Array
from .conversion import colours, flags, numbers, triples, unit_triples
from .packages import dr, mi

#: Returns the light that the medium scatters along legs of rays, (n, 3).
LightAlong: TypeAlias = Callable[[Legs], Float64Array]


@dataclass(frozen=True)
class CameraPaths:
    """Traces paths from the camera.

    Parameters
    ----------
    scene : mitsuba.Scene
    volume : BeamScene
        Where its medium is.
    light_along : callable
        The light that the medium scatters along legs of rays.
    max_depth : int
        The most bounces of a path at surfaces; those that let it pass straight on do not count.
    rr_depth : int
        After how many bounces Russian roulette begins.
    hide_emitters : bool
        Whether the camera looks through emitters.
    """

    scene: Any
    volume: BeamScene
    light_along: LightAlong
    max_depth: int
    rr_depth: int
    hide_emitters: bool

    def radiance(self, sampler: Any, ray: Any, in_medium: bool, active: Any) -> tuple[Any, Any]:
        """Return the radiance along rays, and whether each met a surface or the medium."""
        n = dr.width(ray)
        light, throughput, eta = dr.zeros(mi.Spectrum, n), dr.full(mi.Spectrum, 1, n), dr.full(mi.Float, 1, n)
        inside, active = dr.full(mi.Bool, in_medium, n), mi.Bool(active) & dr.full(mi.Bool, True, n)
        depth, met = dr.zeros(mi.UInt32, n), inside & active
        last_bounce = dr.zeros(mi.Interaction3f, n)
        # The density of the direction by which a path came; 0 stands for one that emitters cannot be sampled by.
        density = dr.zeros(mi.Float, n)
        ray = mi.Ray3f(ray)
        while dr.any(active):
            found = self.scene.ray_intersect(ray, active)
            scattered, passed = self._through_medium(ray, found, inside & active, self.light_along)
            light += throughput * scattered
            throughput *= passed

            # Add the light of emitters that are hit.
            emitter = found.emitter(self.scene, active)
            seen = active & (emitter != None)  # noqa: E711
            # The camera looks through hidden emitters.
            hidden = seen & found.is_valid() & (depth == 0) & self.hide_emitters
            seen &= ~((depth == 0) & self.hide_emitters)
            sampled = mi.DirectionSample3f(self.scene, found, last_bounce)
            by_emitter = seen & (density > 0)
            other = dr.select(by_emitter, self.scene.pdf_emitter_direction(last_bounce, sampled, by_emitter), 0)
            light[seen] += throughput * emitter.eval(found, seen) * _share(density, other)
            active &= found.is_valid()
            met |= active & ~hidden

            # Add direct light, and scatter.
            bsdf, shows = found.bsdf(), active & ~hidden
            smooth = shows & (depth < self.max_depth) & mi.has_flag(bsdf.flags(), mi.BSDFFlags.Smooth)
            light[smooth] += throughput * self._direct(sampler, found, bsdf, inside, smooth)
            sample, value = bsdf.sample(mi.BSDFContext(), found, sampler.next_1d(shows), sampler.next_2d(shows), shows)
            shows &= sample.pdf > 0
            active = shows | hidden
            throughput[shows] *= value
            eta[shows] *= sample.eta
            ray[active] = found.spawn_ray(dr.select(hidden, ray.d, found.to_world(sample.wo)))
            inside = _inside_after(found, ray.d, inside, active)
            bounces = shows & ~mi.has_flag(sample.sampled_type, mi.BSDFFlags.Null)
            depth[bounces] += 1
            last_bounce[bounces] = found
            density[bounces] = dr.select(mi.has_flag(sample.sampled_type, mi.BSDFFlags.Delta), 0, sample.pdf)

            active &= (depth <= self.max_depth) & dr.any(throughput != 0)
            survival = dr.minimum(dr.max(throughput) * dr.square(eta), 0.95)
            in_roulette = active & (depth >= self.rr_depth)
            active &= ~in_roulette | (sampler.next_1d(in_roulette) < survival)
            throughput[in_roulette & active] /= survival
            sampler.schedule_state()
            dr.eval(light, throughput, eta, inside, active, depth, met, last_bounce, density, ray)
        return light, met

    def _through_medium(
        self, ray: Any, found: Any, inside: Any, light_along: LightAlong | None = None
    ) -> tuple[Any, Any]:
        """Return the light that the medium scatters along rays that are inside, and their transmittance."""
        n = dr.width(found)
        light, passed = np.zeros((n, 3), np.float32), np.ones((n, 3), np.float32)
        rows = np.flatnonzero(flags(inside, n))
        origins, directions = triples(ray.o, n)[rows], unit_triples(ray.d, n)[rows]
        begin, end = self.volume.in_box(origins, directions)
        end = np.minimum(end, numbers(dr.select(found.is_valid(), found.t, ray.maxt), n)[rows])
        some = np.flatnonzero(begin < end)
        rows, directions, lengths = rows[some], directions[some], (end - begin)[some]
        if len(rows):
            start = origins[some] + begin[some, None] * directions
            passed[rows] = self.volume.medium.transmittance(start, directions, lengths)
            if light_along:
                light[rows] = light_along(Legs(rows, start, directions, lengths, np.ones((len(rows), 3))))
        return colours(light), colours(passed)

    def _direct(self, sampler: Any, found: Any, bsdf: Any, inside: Any, active: Any) -> Any:
        """Return the light of a sampled emitter that surfaces scatter into paths."""
        sampled, emitted = self.scene.sample_emitter_direction(found, sampler.next_2d(active), False, active)
        active = active & (sampled.pdf > 0)
        value, density = bsdf.eval_pdf(mi.BSDFContext(), found, found.to_local(sampled.d), active)
        share = _share(sampled.pdf, dr.select(sampled.delta, 0, density))

        # Attenuate the light by the medium, and by surfaces that let it pass straight on.
        ray, passed = found.spawn_ray_to(sampled.p), dr.full(mi.Spectrum, 1, dr.width(found))
        inside = _inside_after(found, ray.d, inside, active)
        while dr.any(active):
            met = self.scene.ray_intersect(ray, active)
            passed *= self._through_medium(ray, met, inside & active)[1]
            active = active & met.is_valid()
            passed[active] *= met.bsdf().eval_null_transmission(met, active)
            inside = _inside_after(met, ray.d, inside, active)
            rest = ray.maxt - met.t
            ray[active] = met.spawn_ray(ray.d)
            ray.maxt = rest
            active &= (rest > 0) & dr.any(passed != 0)
            dr.eval(ray, passed, inside, active)
        return dr.select(sampled.pdf > 0, value * emitted * passed * share, 0)


def _inside_after(found: Any, direction: Any, inside: Any, active: Any) -> Any:
    """Return whether light is in the medium once it has left a surface in a direction."""
    crossing = active & found.is_medium_transition()
    return dr.select(crossing, found.target_medium(direction) != None, inside)  # noqa: E711


def _share(density: Any, other: Any) -> Any:
    """Return the weight of a sample by the power heuristic; 1 where the density is 0, as nothing else samples it."""
    square = dr.square(density)
    return dr.select(density > 0, square / (square + dr.square(other)), 1)
