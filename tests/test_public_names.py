"""The public names of the package, each of which a module of it has."""

from __future__ import annotations

import ast
import importlib
import types
from pathlib import Path

import pytest

import fastlines as fl

#: What `import fastlines as fl` gives; docs/versions.md says what may become of them.
NAMES = [
    "METHODS",
    "RIGS",
    "AllHits",
    "Along",
    "BinnedPlanes",
    "Boxes",
    "Camera",
    "Cost",
    "Curves",
    "FastlinesError",
    "FileFormatError",
    "FileWarning",
    "FirstHits",
    "Forest",
    "Gathered",
    "Geometry",
    "HairMaterial",
    "InBox",
    "InputError",
    "InvalidTreeError",
    "Light",
    "Limits",
    "Lines",
    "Median",
    "Midpoint",
    "MissingExtraError",
    "Nearest",
    "ObjectSweep",
    "Pairs",
    "Picture",
    "PlaneEvents",
    "PlaneGrid",
    "PrecisionWarning",
    "QueryWarning",
    "Presplit",
    "Primitives",
    "Rays",
    "RebuildPolicy",
    "Rig",
    "Settings",
    "Sky",
    "Spheres",
    "SurfaceMaterial",
    "Tree",
    "Triangles",
    "Within",
    "WorkerError",
    "available_simd",
    "beams",
    "brute_force",
    "brute_force_gather",
    "brute_force_in_box",
    "brute_force_pairs",
    "brute_force_points",
    "build",
    "build_forest",
    "curves",
    "default_camera",
    "drawing",
    "get_backend",
    "get_cmake_dir",
    "get_include",
    "get_lib",
    "get_num_threads",
    "inspection",
    "lines",
    "load",
    "query_parquet",
    "read",
    "read_chunks",
    "render",
    "scenes",
    "set_backend",
    "set_num_threads",
    "set_simd",
    "simd",
    "theory",
    "to_neurons",
    "to_polydata",
    "to_tractogram",
    "trimesh",
    "view",
    "write",
]


def test_all_lists_the_public_names() -> None:
    assert sorted(fl.__all__) == sorted(NAMES)
    assert {name for name in dir(fl) if not name.startswith("__")} == set(NAMES)
    assert {"__version__", "__doc__"} <= set(dir(fl))


@pytest.mark.parametrize("name", NAMES)
def test_the_module_of_each_name_has_it(name: str) -> None:
    found = getattr(fl, name)
    module = getattr(found, "__module__", None)
    if isinstance(found, types.ModuleType):
        assert importlib.import_module(f"fastlines.{name}") is found
    elif isinstance(module, str) and module.startswith("fastlines."):
        assert getattr(importlib.import_module(module), name) is found
    else:
        assert name in ("METHODS", "RIGS")


def test_type_checkers_see_the_same_names() -> None:
    text = Path(fl.__file__).read_text(encoding="utf-8")
    block = next(node for node in ast.parse(text).body if isinstance(node, ast.If))
    seen = {
        alias.asname: imported.module
        for imported in block.body
        if isinstance(imported, ast.ImportFrom)
        for alias in imported.names
    }
    assert {name: module for name, module in seen.items() if module} == fl._MODULE_OF
    assert {name for name, module in seen.items() if not module} == set(fl._SHOWN)


def test_a_name_that_is_not_there() -> None:
    with pytest.raises(AttributeError, match="no attribute 'octrees'"):
        fl.octrees  # noqa: B018
