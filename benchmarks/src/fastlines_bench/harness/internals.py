"""The private names of fastlines that the benchmarks use: the only place to change when they move."""

from __future__ import annotations

from fastlines.arrays import did_you_mean
from fastlines.cli.app import Group, app
from fastlines.cli.files import SCENE, check_output, note, open_lines, show_progress
from fastlines.cli.options import Effort
from fastlines.cuda import program as cuda_program
from fastlines.cuda.backend import CudaBackend
from fastlines.cuda.choice import device as cuda_device
from fastlines.cuda.device import Device as CudaDevice
from fastlines.cuda.program import TUNING
from fastlines.cuda.scene import scene_of
from fastlines.cuda.scene import upload as upload_scene
from fastlines.engines import engine as compiled_engine
from fastlines.engines import use_engine
from fastlines.errors import FastlinesError
from fastlines.forest.writing import write_forest
from fastlines.geometry.collection import as_geometry
from fastlines.io import known_formats
from fastlines.query.proximity.pair_query import check_pairs
from fastlines.query.proximity.pair_sets import row_arrays
from fastlines.query.proximity.strand_places import strand_places
from fastlines.query.queries import check_query
from fastlines.query.ray_arguments import RayArguments
from fastlines.rendering.color.tone import filmic, srgb, to_bytes
from fastlines.rendering.hair import HairMaterial, longitudinal
from fastlines.rendering.path_tracing.path_tracer import PathTracer
from fastlines.rendering.path_tracing.path_vertices import seen_vertices
from fastlines.rendering.sampling.sampler import Sampler
from fastlines.rendering.sampling.sobol import hashed
from fastlines.rendering.shading.depth_tone import grey
from fastlines.rendering.shading.fragments import Surfaces
from fastlines.rendering.shading.lighting import Light, Rig, Sky
from fastlines.rendering.shading.shading_context import ShadingContext
from fastlines.report import page
from fastlines.report.measure import describe_machine
from fastlines.report.tables import format_3_digits
from fastlines.scenes.beams import EXTINCTION as CUBE_EXTINCTION
from fastlines.scenes.beams import G as CUBE_G
from fastlines.settings.methods import DEFAULT_METHOD, METHOD_NOTES, THESIS_METHODS, best_settings, method_settings
from fastlines.settings.settings import REF_LIMIT, limit_notes
from fastlines.structure import tree_file
from fastlines.structure.layout import Layout
from fastlines.support import container
from fastlines.support.atomic_write import atomic_write
from fastlines.support.immutable import own
from fastlines.support.optional import optional
from fastlines.support.texts import counted
from fastlines.threads import MAX_THREADS, map_in_threads, num_threads

__all__ = [
    "CUBE_EXTINCTION",
    "CUBE_G",
    "DEFAULT_METHOD",
    "MAX_THREADS",
    "METHOD_NOTES",
    "REF_LIMIT",
    "SCENE",
    "THESIS_METHODS",
    "TUNING",
    "CudaBackend",
    "CudaDevice",
    "Effort",
    "FastlinesError",
    "Group",
    "HairMaterial",
    "Layout",
    "Light",
    "PathTracer",
    "RayArguments",
    "Rig",
    "Sampler",
    "ShadingContext",
    "Sky",
    "Surfaces",
    "app",
    "as_geometry",
    "atomic_write",
    "best_settings",
    "check_output",
    "check_pairs",
    "check_query",
    "compiled_engine",
    "container",
    "counted",
    "cuda_device",
    "cuda_program",
    "describe_machine",
    "did_you_mean",
    "filmic",
    "format_3_digits",
    "grey",
    "hashed",
    "known_formats",
    "limit_notes",
    "longitudinal",
    "map_in_threads",
    "method_settings",
    "note",
    "num_threads",
    "open_lines",
    "optional",
    "own",
    "page",
    "row_arrays",
    "scene_of",
    "seen_vertices",
    "show_progress",
    "srgb",
    "strand_places",
    "to_bytes",
    "tree_file",
    "upload_scene",
    "use_engine",
    "write_forest",
]
