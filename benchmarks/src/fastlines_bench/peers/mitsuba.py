"""Mitsuba 3 as a peer: hair as its curves with the scattering of Chiang et al., and the integrator ``path``.

Source: Jakob et al., "Dr.Jit: A Just-In-Time Compiler for Differentiable Rendering", 2022; https://mitsuba-renderer.org.
The package is ``mitsuba``. Its variant ``llvm_ad_rgb`` needs the library LLVM, whose path the environment variable
DRJIT_LIBLLVM_PATH gives; the variant ``scalar_rgb`` needs nothing, but cannot be timed ray by ray.
"""

from __future__ import annotations

import importlib
from time import perf_counter
from typing import Any

import numpy as np

from ..harness.arrays import FloatArray
from ..harness.internals import FastlinesError
from .hair_scene import HairScene

VARIANTS = ("llvm_ad_rgb", "scalar_rgb")


def load(variant: str, n_threads: int) -> Any:
    """Load Mitsuba with a variant, and limit its threads.

    Raises
    ------
    FastlinesError
        If it is not installed, or the variant does not run here.
    """
    try:
        mi = importlib.import_module("mitsuba")
        dr = importlib.import_module("drjit")
    except ImportError:
        raise FastlinesError("Mitsuba is not installed: run  pip install mitsuba") from None
    try:
        mi.set_variant(variant)
        if variant.startswith("llvm"):
            dr.eval(dr.sin(mi.Float([1.0, 2.0])))
    except (ImportError, AttributeError, RuntimeError) as error:
        raise FastlinesError(
            f"Mitsuba's variant {variant} does not run: {error}. Set DRJIT_LIBLLVM_PATH to a libLLVM.so of version 15 "
            "or later, or choose scalar_rgb"
        ) from None
    dr.set_thread_count(n_threads)
    return mi


class MitsubaScene:
    """A scene of hair in Mitsuba.

    Parameters
    ----------
    scene : HairScene
    variant : str
        One of `VARIANTS`.
    n_threads : int
    """

    def __init__(self, scene: HairScene, variant: str, n_threads: int) -> None:
        self.mi = load(variant, n_threads)
        self.version = str(self.mi.__version__)
        self.is_array = variant.startswith("llvm")
        self.scene = scene
        start = perf_counter()
        self._loaded = self.mi.load_dict(self._description())
        self.load_seconds = perf_counter() - start

    def _description(self) -> dict[str, Any]:
        scene, mi = self.scene, self.mi
        camera, material = scene.camera, scene.material

        def rgb(value: Any) -> dict[str, Any]:
            return {"type": "rgb", "value": [float(each) for each in value]}

        look_at = mi.ScalarTransform4f().look_at(
            origin=list(camera.origin), target=list(camera.target), up=list(camera.up)
        )
        hair = {
            "type": "hair",
            "sigma_a": rgb(material.sigma_a),
            "longitudinal_roughness": material.longitudinal_roughness,
            "azimuthal_roughness": material.azimuthal_roughness,
            "scale_tilt": material.scale_tilt,
            "int_ior": material.eta,
            "ext_ior": 1.0,
        }
        film = {
            "type": "hdrfilm",
            "width": scene.size,
            "height": scene.size,
            "rfilter": {"type": "box"},
            "component_format": "float32",
        }
        sensor = {
            "type": "perspective",
            "fov": camera.fov_degrees,
            "fov_axis": "y",
            "to_world": look_at,
            "near_clip": 1e-4,
            "film": film,
            "sampler": {"type": "independent"},
        }
        return {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": scene.max_bounces + 1},
            "sensor": sensor,
            "curves": {"type": f"{scene.shape}curve", "filename": str(scene.path), "bsdf": hair},
            "sun": {
                "type": "directional",
                "direction": [-float(each) for each in scene.towards],
                "irradiance": rgb(scene.light.color),
            },
            "sky": {"type": "constant", "radiance": rgb(scene.sky.horizon)},
        }

    def render(self, samples: int, seed: int) -> tuple[FloatArray, float]:
        """Render a picture, (size, size, 3), and return the seconds too."""
        start = perf_counter()
        image = self.mi.render(self._loaded, spp=samples, seed=seed)
        pixels = np.array(image, np.float32)[..., :3]
        return pixels, perf_counter() - start

    def first_hits(self, origins: FloatArray, directions: FloatArray) -> tuple[FloatArray, float]:
        """Return t of the first hits, and the seconds; for variants with arrays."""
        rays = self._rays(origins, directions)
        start = perf_counter()
        t = np.array(self._loaded.ray_intersect_preliminary(rays, coherent=False).t)
        return t, perf_counter() - start

    def any_hits(self, origins: FloatArray, directions: FloatArray) -> tuple[FloatArray, float]:
        """Return whether rays hit, and the seconds; for variants with arrays."""
        rays = self._rays(origins, directions)
        start = perf_counter()
        hit = np.array(self._loaded.ray_test(rays))
        return hit, perf_counter() - start

    def _rays(self, origins: FloatArray, directions: FloatArray) -> Any:
        mi, dr = self.mi, importlib.import_module("drjit")
        rays = mi.Ray3f(mi.Point3f(np.ascontiguousarray(origins.T)), mi.Vector3f(np.ascontiguousarray(directions.T)))
        dr.eval(rays)
        dr.sync_thread()
        return rays
