"""fastlines: acceleration trees for ray queries on lines.

Build a tree over hair, fibres, beams, streamlines or wires, and ask what rays hit, with the radius given at query time.

>>> import fastlines as fl
>>> tree = fl.build([[[-1, -1, -1], [1, 1, 1]]])
>>> tree.first_hit([0, 0, -5], [0, 0, 1], radius=0.5).prim
array(0)
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from .builder import build
from .camera import Camera
from .cuda.choice import get_backend, set_backend
from .engines import available_simd, set_simd, simd
from .errors import (
    FastlinesError,
    FileFormatError,
    FileWarning,
    InputError,
    InvalidTreeError,
    MissingExtraError,
    PrecisionWarning,
)
from .geometry.boxes import Boxes
from .geometry.collection import Geometry
from .geometry.curves import Curves
from .geometry.foreign import lines
from .geometry.lines import Lines
from .geometry.spheres import Spheres
from .geometry.triangles import Triangles
from .geometry.user_primitives import Primitives, Rays
from .query.hits import AllHits, FirstHits
from .query.queries import brute_force
from .refit import RebuildPolicy
from .settings.methods import METHODS
from .settings.settings import Cost, Limits, Presplit, Settings
from .settings.splits import BinnedPlanes, Median, Midpoint, ObjectSweep, PlaneEvents, PlaneGrid
from .support.display import draw_with
from .support.library import get_cmake_dir, get_include, get_lib
from .threads import get_num_threads, set_num_threads
from .tree import Tree, load

if TYPE_CHECKING:
    from . import scenes, theory
    from .io import read, write
    from .rendering import render

    __version__: str


__all__ = [
    "METHODS",
    "AllHits",
    "BinnedPlanes",
    "Boxes",
    "Camera",
    "Cost",
    "Curves",
    "FastlinesError",
    "FileFormatError",
    "FileWarning",
    "FirstHits",
    "Geometry",
    "InputError",
    "InvalidTreeError",
    "Limits",
    "Lines",
    "Median",
    "Midpoint",
    "MissingExtraError",
    "ObjectSweep",
    "PlaneEvents",
    "PlaneGrid",
    "PrecisionWarning",
    "Presplit",
    "Primitives",
    "Rays",
    "RebuildPolicy",
    "Settings",
    "Spheres",
    "Tree",
    "Triangles",
    "available_simd",
    "brute_force",
    "build",
    "get_backend",
    "get_cmake_dir",
    "get_include",
    "get_lib",
    "get_num_threads",
    "lines",
    "load",
    "read",
    "render",
    "scenes",
    "set_backend",
    "set_num_threads",
    "set_simd",
    "simd",
    "theory",
    "write",
]


draw_with(lambda: import_module(".rendering.card.card", __name__))


def __getattr__(name: str) -> Any:
    """Import slow modules on first use."""
    if name == "__version__":
        from importlib.metadata import version

        return version("fastlines")
    if name in ("io", "rendering", "scenes", "theory"):
        return import_module(f".{name}", __name__)
    for module, names in {"io": ("read", "write"), "rendering": ("render",)}.items():
        if name in names:
            return getattr(import_module(f".{module}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*__all__, "__version__", *(name for name in globals() if name.startswith("__"))})
