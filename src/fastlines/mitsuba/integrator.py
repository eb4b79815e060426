"""The integrator `photonbeams`: our beams for Mitsuba's media, its path tracer for its surfaces.

Each pass traces photons of its own, builds a tree over their beams, and traces its share of the samples of all pixels.
Its radius is less than that of the pass before (see `fastlines.beams.passes`). The picture is the mean of the passes.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache, partial
from typing import Any

import numpy as np

from ..arrays import count
from ..beams.passes import PassSettings, map_pass
from ..beams.render import PASSES
from ..beams.scene import BeamScene
from ..errors import InputError
from .camera_paths import CameraPaths
from .packages import mi, require_variant
from .volume import beam_scene

NAME = "photonbeams"
#: How many rays of the camera are traced at a time.
RAYS = 1 << 21
#: The parameters of the integrator that are fields of `PassSettings`.
PASS_PARAMETERS = ("n_paths", "radius", "adapt", "alpha", "kind", "blur", "max_scatterings", "method")


@cache
def integrator_class(variant: str) -> Any:
    """Return the class of the integrator for a variant of Mitsuba, which is to be the current one."""
    require_variant()

    class PhotonBeams(mi.SamplingIntegrator):  # type: ignore[misc]
        """Draws media by photon beams; see `fastlines.mitsuba`."""

        def __init__(self, props: Any) -> None:
            super().__init__(props)
            given = {name: props[name] for name in PASS_PARAMETERS if name in props}
            # Mitsuba writes "any number" as -1.
            if given.get("max_scatterings") == -1:
                del given["max_scatterings"]
            self.settings = PassSettings(**given)
            self.passes = count("passes", props.get("passes", PASSES), 1)
            max_depth = props.get("max_depth", 8)
            self.max_depth = 2**32 - 1 if max_depth == -1 else count("max_depth", max_depth, 0)
            self.rr_depth = count("rr_depth", props.get("rr_depth", 5), 0)
            self._paths: CameraPaths | None = None

        def render(
            self,
            scene: Any,
            sensor: Any = 0,
            seed: Any = 0,
            spp: int = 0,
            develop: bool = True,
            evaluate: bool = True,
        ) -> Any:
            """Render all passes, and return their mean."""
            if self._paths is not None:
                # Mitsuba calls this method again for each pass.
                return super().render(scene, sensor, seed, spp, develop, evaluate)
            if not develop:
                raise InputError(f"{NAME} returns the mean of passes; call render with develop=True")
            sensor = scene.sensors()[sensor] if isinstance(sensor, int) else sensor
            sampler = sensor.sampler()
            asked = sampler.sample_count()
            samples = spp or asked
            passes = min(self.passes, samples)
            seed, done = int(np.array(seed).item()), 0
            most = max(RAYS // int(np.prod(sensor.film().crop_size())), 1)
            volume, total = beam_scene(scene), 0.0
            try:
                for i in range(passes):
                    self._paths = self._trace(scene, volume, seed, i)
                    end = samples * (i + 1) // passes
                    while done < end:
                        some = min(end - done, most)
                        part = super().render(scene, sensor, (seed * samples + done) % 2**32, some)
                        total += part * (some / samples)
                        done += some
            finally:
                self._paths = None
                sampler.set_sample_count(asked)
            return total

        def sample(
            self, scene: Any, sampler: Any, ray: Any, medium: Any = None, active: Any = True
        ) -> tuple[Any, Any, list[Any]]:
            """Return the radiance along rays; within another integrator, all of one pass."""
            paths = self._paths
            if paths is None:
                volume = beam_scene(scene)
                paths = self._trace(scene, volume, self.settings.seed, 0)
            return *paths.radiance(sampler, ray, medium is not None, active), []

        def to_string(self) -> str:
            return f"PhotonBeams[passes = {self.passes}, max_depth = {self.max_depth}, {self.settings}]"

        def _trace(self, scene: Any, volume: BeamScene, seed: int, pass_number: int) -> CameraPaths:
            """Trace the photons of a pass, and prepare paths that gather their light."""
            beam_map, radius = map_pass(volume, replace(self.settings, seed=seed), pass_number)
            light_along = partial(beam_map.light_along, radius=radius, blur=self.settings.blur)
            return CameraPaths(scene, volume, light_along, self.max_depth, self.rr_depth, self.hide_emitters)

    return PhotonBeams


def make(props: Any) -> Any:
    """Make the integrator for the current variant, from the parameters of a scene file."""
    require_variant()
    return integrator_class(mi.variant())(props)
