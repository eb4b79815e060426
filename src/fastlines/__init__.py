"""fastlines: acceleration trees for queries on lines.

Build a tree over hair, fibres, beams, streamlines or wires, and find what rays hit and what is near, with the radius
given at query time.

>>> import fastlines as fl
>>> tree = fl.build([[[-1, -1, -1], [1, 1, 1]]])
>>> tree.first_hit([0, 0, -5], [0, 0, 1], radius=0.5).prim
array(0)
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from .support.painter import draw_with

if TYPE_CHECKING:
    from . import beams as beams
    from . import drawing as drawing
    from . import inspection as inspection
    from . import scenes as scenes
    from . import theory as theory
    from . import trimesh as trimesh
    from .builder import build as build
    from .camera import Camera as Camera
    from .cuda.choice import get_backend as get_backend
    from .cuda.choice import set_backend as set_backend
    from .engines import available_simd as available_simd
    from .engines import set_simd as set_simd
    from .engines import simd as simd
    from .errors import FastlinesError as FastlinesError
    from .errors import FileFormatError as FileFormatError
    from .errors import FileWarning as FileWarning
    from .errors import InputError as InputError
    from .errors import InvalidTreeError as InvalidTreeError
    from .errors import MissingExtraError as MissingExtraError
    from .errors import PrecisionWarning as PrecisionWarning
    from .errors import QueryWarning as QueryWarning
    from .errors import WorkerError as WorkerError
    from .exchange.neurons import to_neurons as to_neurons
    from .exchange.tractograms import to_tractogram as to_tractogram
    from .forest.building.build_forest import build_forest as build_forest
    from .forest.forest import Forest as Forest
    from .forest.mapping.parquet import query_parquet as query_parquet
    from .geometry.boxes import Boxes as Boxes
    from .geometry.collection import Geometry as Geometry
    from .geometry.curves import Curves as Curves
    from .geometry.foreign import lines as lines
    from .geometry.lines import Lines as Lines
    from .geometry.mitsuba_shapes import curves as curves
    from .geometry.spheres import Spheres as Spheres
    from .geometry.triangles import Triangles as Triangles
    from .geometry.user_primitives import Primitives as Primitives
    from .geometry.user_primitives import Rays as Rays
    from .io import read as read
    from .io import read_chunks as read_chunks
    from .io import write as write
    from .pyvista_plugin.readers import to_polydata as to_polydata
    from .query.gather import Gathered as Gathered
    from .query.hits import AllHits as AllHits
    from .query.hits import FirstHits as FirstHits
    from .query.proximity.along import Along as Along
    from .query.proximity.box_queries import brute_force_in_box as brute_force_in_box
    from .query.proximity.brute_force import brute_force_points as brute_force_points
    from .query.proximity.in_box import InBox as InBox
    from .query.proximity.nearest import Nearest as Nearest
    from .query.proximity.pair_queries import brute_force_pairs as brute_force_pairs
    from .query.proximity.pairs import Pairs as Pairs
    from .query.proximity.within import Within as Within
    from .query.queries import brute_force as brute_force
    from .query.queries import brute_force_gather as brute_force_gather
    from .refit import RebuildPolicy as RebuildPolicy
    from .rendering import default_camera as default_camera
    from .rendering import render as render
    from .rendering.hair.material import HairMaterial as HairMaterial
    from .rendering.looks.surface_material import SurfaceMaterial as SurfaceMaterial
    from .rendering.pictures.picture import Picture as Picture
    from .rendering.shading.lighting import RIGS as RIGS
    from .rendering.shading.lighting import Light as Light
    from .rendering.shading.lighting import Rig as Rig
    from .rendering.shading.lighting import Sky as Sky
    from .settings.methods import METHODS as METHODS
    from .settings.settings import Cost as Cost
    from .settings.settings import Limits as Limits
    from .settings.settings import Presplit as Presplit
    from .settings.settings import Settings as Settings
    from .settings.splits import BinnedPlanes as BinnedPlanes
    from .settings.splits import Median as Median
    from .settings.splits import Midpoint as Midpoint
    from .settings.splits import ObjectSweep as ObjectSweep
    from .settings.splits import PlaneEvents as PlaneEvents
    from .settings.splits import PlaneGrid as PlaneGrid
    from .support.library import get_cmake_dir as get_cmake_dir
    from .support.library import get_include as get_include
    from .support.library import get_lib as get_lib
    from .threads import get_num_threads as get_num_threads
    from .threads import set_num_threads as set_num_threads
    from .tree import Tree as Tree
    from .tree import load as load
    from .viewer.view import view as view

    __version__: str

#: The public names, by the modules that have them. Each module is imported when a name of it is first used.
_NAMES = {
    "builder": ("build",),
    "camera": ("Camera",),
    "cuda.choice": ("get_backend", "set_backend"),
    "engines": ("available_simd", "set_simd", "simd"),
    "errors": (
        "FastlinesError",
        "FileFormatError",
        "FileWarning",
        "InputError",
        "InvalidTreeError",
        "MissingExtraError",
        "PrecisionWarning",
        "QueryWarning",
        "WorkerError",
    ),
    "exchange.neurons": ("to_neurons",),
    "exchange.tractograms": ("to_tractogram",),
    "forest.building.build_forest": ("build_forest",),
    "forest.forest": ("Forest",),
    "forest.mapping.parquet": ("query_parquet",),
    "geometry.boxes": ("Boxes",),
    "geometry.collection": ("Geometry",),
    "geometry.curves": ("Curves",),
    "geometry.foreign": ("lines",),
    "geometry.lines": ("Lines",),
    "geometry.mitsuba_shapes": ("curves",),
    "geometry.spheres": ("Spheres",),
    "geometry.triangles": ("Triangles",),
    "geometry.user_primitives": ("Primitives", "Rays"),
    "io": ("read", "read_chunks", "write"),
    "pyvista_plugin.readers": ("to_polydata",),
    "query.gather": ("Gathered",),
    "query.hits": ("AllHits", "FirstHits"),
    "query.proximity.along": ("Along",),
    "query.proximity.box_queries": ("brute_force_in_box",),
    "query.proximity.brute_force": ("brute_force_points",),
    "query.proximity.in_box": ("InBox",),
    "query.proximity.nearest": ("Nearest",),
    "query.proximity.pair_queries": ("brute_force_pairs",),
    "query.proximity.pairs": ("Pairs",),
    "query.proximity.within": ("Within",),
    "query.queries": ("brute_force", "brute_force_gather"),
    "refit": ("RebuildPolicy",),
    "rendering": ("default_camera", "render"),
    "rendering.hair.material": ("HairMaterial",),
    "rendering.looks.surface_material": ("SurfaceMaterial",),
    "rendering.pictures.picture": ("Picture",),
    "rendering.shading.lighting": ("RIGS", "Light", "Rig", "Sky"),
    "settings.methods": ("METHODS",),
    "settings.settings": ("Cost", "Limits", "Presplit", "Settings"),
    "settings.splits": ("BinnedPlanes", "Median", "Midpoint", "ObjectSweep", "PlaneEvents", "PlaneGrid"),
    "support.library": ("get_cmake_dir", "get_include", "get_lib"),
    "threads": ("get_num_threads", "set_num_threads"),
    "tree": ("Tree", "load"),
    "viewer.view": ("view",),
}

#: Modules with names of their own, such as `fl.scenes.make`.
_SHOWN = ("beams", "drawing", "inspection", "scenes", "theory", "trimesh")
_MODULES = (*_SHOWN, "io", "rendering")

_MODULE_OF = {name: module for module, names in _NAMES.items() for name in names}

__all__ = sorted([*_MODULE_OF, *_SHOWN])

draw_with(lambda: import_module(".rendering.card.card", __name__))


def __getattr__(name: str) -> Any:
    """Import the module of a public name when the name is first used."""
    if name == "__version__":
        from importlib.metadata import version

        return version("fastlines")
    if name in _MODULES:
        return import_module(f".{name}", __name__)
    if name in _MODULE_OF:
        found = globals()[name] = getattr(import_module(f".{_MODULE_OF[name]}", __name__), name)
        return found
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*__all__, "__version__", *(name for name in globals() if name.startswith("__"))})
