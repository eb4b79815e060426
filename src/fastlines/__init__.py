"""fastlines: acceleration trees for ray queries on lines.

Build a tree over hair, fibres, beams, streamlines or wires, and ask what rays hit, with the radius given at query time.

>>> import fastlines as fl
>>> tree = fl.build([[[-1, -1, -1], [1, 1, 1]]])
>>> tree.first_hit([0, 0, -5], [0, 0, 1], radius=0.5).prim
array(0)
"""

from importlib.metadata import version as _version

from . import analytic, scenes, theory
from .backend import available_simd, set_simd, simd
from .builder import build
from .camera import Camera
from .errors import (
    FastlinesError,
    FileFormatError,
    FileWarning,
    InputError,
    InvalidTreeError,
    MissingExtraError,
    PrecisionWarning,
)
from .hits import AllHits, FirstHits
from .io import read
from .limits import Limits
from .lines import Lines
from .meshes import Boxes, Triangles
from .methods import METHODS
from .queries import brute_force
from .refit import RebuildPolicy
from .settings import Cost, Presplit, Settings
from .splits import Median, Middle, ObjectSweep, PlaneEvents, PlaneGrid, PlaneOctets
from .threads import get_num_threads, set_num_threads
from .tree import Tree, load

__version__ = _version("fastlines")

__all__ = [
    "METHODS",
    "AllHits",
    "Boxes",
    "Camera",
    "Cost",
    "FastlinesError",
    "FileFormatError",
    "FileWarning",
    "FirstHits",
    "InputError",
    "InvalidTreeError",
    "Limits",
    "Lines",
    "Median",
    "Middle",
    "MissingExtraError",
    "ObjectSweep",
    "PlaneEvents",
    "PlaneGrid",
    "PlaneOctets",
    "PrecisionWarning",
    "Presplit",
    "RebuildPolicy",
    "Settings",
    "Tree",
    "Triangles",
    "analytic",
    "available_simd",
    "brute_force",
    "build",
    "get_num_threads",
    "load",
    "read",
    "scenes",
    "set_num_threads",
    "set_simd",
    "simd",
    "theory",
]
