"""Mitsuba's integrator ``volpath`` as a peer of photon beams: a glass sphere in fog below a small bright rectangle."""

from __future__ import annotations

from time import perf_counter
from typing import Any

import numpy as np

from ..harness.arrays import FloatArray
from .fog_scene import FogScene
from .mitsuba import load


class VolpathScene:
    """The scene in Mitsuba.

    Parameters
    ----------
    scene : FogScene
    variant : str
        One of `mitsuba.VARIANTS`.
    n_threads : int
    """

    def __init__(self, scene: FogScene, variant: str, n_threads: int) -> None:
        self.mi = load(variant, n_threads)
        self.version = str(self.mi.__version__)
        self.scene = scene
        self._loaded = self.mi.load_dict(self._description())

    def _description(self) -> dict[str, Any]:
        scene, transform = self.scene, self.mi.ScalarTransform4f
        camera = scene.camera
        extinction = scene.absorption + scene.scattering
        fog = {
            "type": "homogeneous",
            "sigma_t": extinction,
            "albedo": scene.scattering / extinction,
            "phase": {"type": "hg", "g": scene.g} if scene.g else {"type": "isotropic"},
        }
        corner, edge_u, edge_v = (np.array(each) for each in (scene.light_corner, scene.light_u, scene.light_v))
        # Mitsuba's rectangle is [-1, 1]² and emits along z.
        middle, normal = corner + (edge_u + edge_v) / 2, np.cross(edge_u, edge_v)
        columns = [edge_u / 2, edge_v / 2, normal / np.linalg.norm(normal), middle]
        to_light = np.concatenate([np.stack(columns, axis=1), [[0, 0, 0, 1]]])
        radiance = scene.power / (np.pi * np.linalg.norm(normal))
        return {
            "type": "scene",
            "integrator": {"type": "volpath", "max_depth": 256, "rr_depth": 8},
            "sensor": {
                "type": "perspective",
                "fov": camera.fov_degrees,
                "fov_axis": "y",
                "near_clip": 1e-3,
                "to_world": transform().look_at(
                    origin=list(camera.origin), target=list(camera.target), up=list(camera.up)
                ),
                "film": {
                    "type": "hdrfilm",
                    "width": scene.size,
                    "height": scene.size,
                    "rfilter": {"type": "box"},
                    "component_format": "float32",
                },
                "sampler": {"type": "independent"},
            },
            "fog": fog,
            "box": {
                "type": "cube",
                "to_world": transform().scale(scene.half_side),
                "bsdf": {"type": "null"},
                "interior": {"type": "ref", "id": "fog"},
            },
            "ball": {
                "type": "sphere",
                "center": list(scene.ball_centre),
                "radius": scene.ball_radius,
                "bsdf": {"type": "dielectric", "int_ior": scene.ior, "ext_ior": 1.0},
                "exterior": {"type": "ref", "id": "fog"},
            },
            "light": {
                "type": "rectangle",
                "to_world": transform(to_light),
                "bsdf": {"type": "diffuse", "reflectance": 0.0},
                "emitter": {"type": "area", "radiance": {"type": "rgb", "value": [float(radiance)] * 3}},
            },
        }

    def render(self, samples: int, seed: int) -> tuple[FloatArray, float]:
        """Render a picture, (size, size, 3), and return the seconds too."""
        start = perf_counter()
        image = self.mi.render(self._loaded, spp=samples, seed=seed)
        pixels = np.array(image, np.float32)[..., :3]
        return pixels, perf_counter() - start
