"""The C interface by ctypes."""

from __future__ import annotations

import ctypes as c
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

import fastlines as fl
from fastlines.settings.methods import THESIS_METHODS

METHODS = ("best", *THESIS_METHODS, "beams")
FloatPointer, DoublePointer = c.POINTER(c.c_float), c.POINTER(c.c_double)


class Options(c.Structure):
    _fields_ = (
        ("method", c.c_int),
        ("has_effort", c.c_int),
        ("effort", c.c_float),
        ("n_threads", c.c_uint),
        ("progress", c.c_void_p),
        ("user_data", c.c_void_p),
        ("strands", c.POINTER(c.c_int64)),
    )


#: What rays leave out: arrays, and how many numbers each has.
IGNORE = (
    ("ignore", c.POINTER(c.c_int64)),
    ("n_ignore", c.c_size_t),
    ("ignore_strands", c.POINTER(c.c_int64)),
    ("n_ignore_strands", c.c_size_t),
)


class Ray(c.Structure):
    _fields_ = (
        ("origin", c.c_float * 3),
        ("direction", c.c_float * 3),
        ("t_min", c.c_float),
        ("t_max", c.c_float),
        ("spread", c.c_float),
        *IGNORE,
    )


class Hit(c.Structure):
    _fields_ = (
        ("t", c.c_float),
        ("u", c.c_float),
        ("distance", c.c_float),
        ("t_out", c.c_float),
        ("prim", c.c_int64),
    )


class Rays(c.Structure):
    _fields_ = (
        ("n", c.c_size_t),
        ("origins", FloatPointer),
        ("directions", FloatPointer),
        ("t_min", FloatPointer),
        ("t_max", FloatPointer),
        ("radii", FloatPointer),
        ("radius", c.c_float),
        ("n_threads", c.c_uint),
        ("spreads", FloatPointer),
        ("spread", c.c_float),
        *IGNORE,
    )


class Lists(c.Structure):
    _fields_ = (
        ("n_rays", c.c_size_t),
        ("n_hits", c.c_size_t),
        ("offsets", c.POINTER(c.c_int64)),
        ("t", FloatPointer),
        ("prim", c.POINTER(c.c_int64)),
        ("u", FloatPointer),
        ("distance", FloatPointer),
        ("t_out", FloatPointer),
    )


class Point(c.Structure):
    _fields_ = (("position", c.c_double * 3), *IGNORE)


class NearLine(c.Structure):
    _fields_ = (("distance", c.c_float), ("u", c.c_float), ("prim", c.c_int64))


class Points(c.Structure):
    _fields_ = (
        ("n", c.c_size_t),
        ("positions", DoublePointer),
        ("radii", FloatPointer),
        ("to", c.c_int),
        ("n_threads", c.c_uint),
        *IGNORE,
    )


class PairOptions(c.Structure):
    _fields_ = (
        ("to", c.c_int),
        ("has_skip_neighbours", c.c_int),
        ("skip_neighbours", c.c_size_t),
        ("skip_strand", c.c_int),
        ("n_threads", c.c_uint),
        ("progress", c.c_void_p),
        ("user_data", c.c_void_p),
    )


class GatherOptions(c.Structure):
    _fields_ = (
        ("blur", c.c_int),
        ("n_channels", c.c_size_t),
        ("values", FloatPointer),
        ("sigma", c.c_float * 8),
        ("line_sigma", c.c_float * 8),
        ("optical_depth", FloatPointer),
        ("n_depths", c.c_size_t),
        ("has_depth_channels", c.c_int),
        ("has_phase", c.c_int),
        ("phase", c.c_float),
        ("with_ends", c.c_int),
        ("progress", c.c_void_p),
        ("user_data", c.c_void_p),
    )


class NearArrays(c.Structure):
    _fields_ = (
        ("n_points", c.c_size_t),
        ("n_lines", c.c_size_t),
        ("offsets", c.POINTER(c.c_int64)),
        ("distance", FloatPointer),
        ("prim", c.POINTER(c.c_int64)),
        ("u", FloatPointer),
    )


class PairArrays(c.Structure):
    _fields_ = (
        ("n", c.c_size_t),
        ("i", c.POINTER(c.c_int64)),
        ("j", c.POINTER(c.c_int64)),
        ("s", FloatPointer),
        ("t", FloatPointer),
        ("distance", FloatPointer),
    )


class LineArrays(c.Structure):
    _fields_ = (
        ("n", c.c_size_t),
        ("has_radii", c.c_int),
        ("lines", FloatPointer),
        ("strands", c.POINTER(c.c_int64)),
        ("offset", c.c_double * 3),
    )


class Place(c.Structure):
    _fields_ = tuple((name, c.c_double * 3) for name in ("point", "normal", "tangent", "outside"))


class Library:
    """The shared library; calls raise what `fl_error_message` says."""

    def __init__(self) -> None:
        shared = [
            p.resolve() for p in Path(fl.get_lib()).glob("*fastlines.*") if {".so", ".dylib", ".dll"} & {*p.suffixes}
        ]
        (path,) = set(shared)  # the file, without the links to it
        self.dll = c.CDLL(str(path))
        self.dll.fl_error_message.restype = self.dll.fl_version.restype = self.dll.fl_simd.restype = c.c_char_p
        self.dll.fl_free_tree.argtypes = self.dll.fl_free_lists.argtypes = self.dll.fl_get_lists.argtypes = [c.c_void_p]
        self.dll.fl_get_lists.restype, self.dll.fl_get_lines.restype = Lists, LineArrays
        self.dll.fl_get_near_lists.restype, self.dll.fl_get_pairs.restype = NearArrays, PairArrays
        for name in ("get_lines", "get_near_lists", "free_near_lists", "get_pairs", "free_pairs"):
            getattr(self.dll, f"fl_{name}").argtypes = [c.c_void_p]

    def call(self, name: str, *arguments: Any) -> None:
        if getattr(self.dll, name)(*arguments):
            raise RuntimeError(self.dll.fl_error_message().decode())

    def build(self, geometry: fl.Lines, method: str = "best") -> CTree:
        strands = np.ascontiguousarray(geometry.strands).ctypes.data_as(c.POINTER(c.c_int64))
        options = Options(method=METHODS.index(method), strands=strands)
        rows = geometry.segments.reshape(-1, 6)
        name = "fl_build"
        if geometry.radius is not None:
            rows, name = np.hstack([rows, geometry.radius]), "fl_build_round_cones"
        tree = c.c_void_p()
        self.call(name, pointer(np.ascontiguousarray(rows)), c.c_size_t(len(rows)), c.byref(options), c.byref(tree))
        return CTree(self, tree)

    def load(self, path: Path) -> CTree:
        tree = c.c_void_p()
        self.call("fl_load", str(path).encode(), c.byref(tree))
        return CTree(self, tree)


class CTree:
    def __init__(self, library: Library, tree: c.c_void_p) -> None:
        self.library, self.tree = library, tree

    def __del__(self) -> None:
        self.library.dll.fl_free_tree(self.tree)

    def save(self, path: Path) -> None:
        self.library.call("fl_save", self.tree, str(path).encode())

    def first_hit(self, origin: Any, direction: Any, radius: float, at: int) -> Hit:
        ray, hit = Ray((c.c_float * 3)(*origin), (c.c_float * 3)(*direction), 0, np.inf), Hit()
        self.library.call("fl_first_hit", self.tree, c.byref(ray), c.c_float(radius), at, c.byref(hit))
        return hit

    def lines(self) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
        """Return the rows of the lines, and their strands."""
        found = self.library.dll.fl_get_lines(self.tree)
        rows = np.ctypeslib.as_array(found.lines, (found.n, 8 if found.has_radii else 6)).copy()
        return rows, np.ctypeslib.as_array(found.strands, (found.n,)).copy() if found.strands else np.full(found.n, -1)

    def offset(self) -> list[float]:
        return list(self.library.dll.fl_get_lines(self.tree).offset)

    def place(self, origin: Any, direction: Any, radius: float, hit: Hit) -> Place:
        ray, place = Ray((c.c_float * 3)(*origin), (c.c_float * 3)(*direction), 0, np.inf), Place()
        self.library.call("fl_get_place", self.tree, c.byref(ray), c.c_float(radius), c.byref(hit), c.byref(place))
        return place

    def first_hits(self, rays: Rays, at: int = 1) -> tuple[npt.NDArray[Any], ...]:
        columns = [np.empty(rays.n, dtype) for dtype in (np.float32, np.int64, np.float32, np.float32, np.float32)]
        self.library.call(
            "fl_first_hits", self.tree, c.byref(rays), at, *(column.ctypes.data_as(c.c_void_p) for column in columns)
        )
        return tuple(columns)

    def any_hits(self, rays: Rays, at: int) -> npt.NDArray[np.uint8]:
        found = np.empty(rays.n, np.uint8)
        self.library.call("fl_any_hits", self.tree, c.byref(rays), at, found.ctypes.data_as(c.c_void_p))
        return found

    def counts(self, rays: Rays, at: int) -> npt.NDArray[np.int64]:
        counts = np.empty(rays.n, np.int64)
        self.library.call("fl_counts", self.tree, c.byref(rays), at, counts.ctypes.data_as(c.c_void_p))
        return counts

    def gather(self, rays: Rays, options: GatherOptions | None = None) -> tuple[npt.NDArray[Any], ...]:
        """Return sums, sums of squares and counts."""
        shape = rays.n, max(1, options.n_channels if options else 1)
        arrays = np.empty(shape), np.empty(shape), np.empty(rays.n, np.int64)
        given = c.byref(rays), None if options is None else c.byref(options)
        self.library.call("fl_gather", self.tree, *given, *(array.ctypes.data_as(c.c_void_p) for array in arrays))
        return arrays

    def refit(self, rows: npt.NDArray[np.float32]) -> CTree:
        refitted, name = c.c_void_p(), "fl_refit" if rows.shape[1] == 6 else "fl_refit_round_cones"
        self.library.call(name, self.tree, pointer(rows), c.c_size_t(len(rows)), 0, c.byref(refitted))
        return CTree(self.library, refitted)

    def all_hits(self, rays: Rays, at: int, k: int = -1, by_distance: bool = False) -> dict[str, npt.NDArray[Any]]:
        lists = c.c_void_p()
        arguments = c.byref(rays), c.c_size_t(k), at, int(by_distance), c.byref(lists)
        self.library.call("fl_list_hits", self.tree, *arguments)
        found = self.library.dll.fl_get_lists(lists)
        lengths = {"offsets": found.n_rays + 1} | dict.fromkeys(("t", "prim", "u", "distance"), found.n_hits)
        arrays = arrays_of(found, lengths)
        self.library.dll.fl_free_lists(lists)
        return arrays

    def nearest(self, point: Point, k: int, max_distance: float = np.inf, to: int = 0) -> list[NearLine]:
        """Return the k nearest lines of one point."""
        lines, n = (NearLine * k)(), c.c_size_t()
        given = c.byref(point), c.c_float(max_distance), to, c.c_size_t(k)
        self.library.call("fl_nearest", self.tree, *given, lines, c.byref(n))
        return lines[: n.value]

    def near_place(self, point: Point, line: NearLine, to: int = 0) -> list[float]:
        """Return the point of a line that is nearest to a point."""
        place = (c.c_double * 3)()
        self.library.call("fl_get_near_place", self.tree, c.byref(point), c.byref(line), to, place)
        return list(place)

    def within(self, point: Point, radius: float, to: int = 0) -> list[NearLine]:
        """Return the lines within a radius of one point."""
        n = c.c_size_t()
        given = self.tree, c.byref(point), c.c_float(radius), to
        self.library.call("fl_count_within", *given, c.byref(n))
        lines = (NearLine * n.value)()
        self.library.call("fl_within", *given, lines, n, c.byref(n))
        return list(lines)

    def nearest_batch(self, points: Points, k: int, max_distance: float = np.inf) -> dict[str, npt.NDArray[Any]]:
        columns = {"distance": np.float32, "prim": np.int64, "u": np.float32}
        found = {name: np.empty((points.n, k), dtype) for name, dtype in columns.items()}
        to = (column.ctypes.data_as(c.c_void_p) for column in found.values())
        given = c.byref(points), c.c_float(max_distance), c.c_size_t(k)
        self.library.call("fl_nearest_batch", self.tree, *given, *to)
        return found

    def count_within(self, points: Points, radius: float) -> npt.NDArray[np.int64]:
        counts = np.empty(points.n, np.int64)
        to = counts.ctypes.data_as(c.c_void_p)
        self.library.call("fl_count_within_batch", self.tree, c.byref(points), c.c_float(radius), to)
        return counts

    def list_within(self, points: Points, radius: float) -> dict[str, npt.NDArray[Any]]:
        lists = c.c_void_p()
        self.library.call("fl_list_within", self.tree, c.byref(points), c.c_float(radius), c.byref(lists))
        found = self.library.dll.fl_get_near_lists(lists)
        lengths = {"offsets": found.n_points + 1} | dict.fromkeys(("distance", "prim", "u"), found.n_lines)
        arrays = arrays_of(found, lengths)
        self.library.dll.fl_free_near_lists(lists)
        return arrays

    def pairs(
        self, radius: float, other: CTree | None = None, options: PairOptions | None = None
    ) -> dict[str, npt.NDArray[Any]]:
        pairs, second = c.c_void_p(), None if other is None else other.tree
        given = c.c_float(radius), None if options is None else c.byref(options)
        self.library.call("fl_find_pairs", self.tree, second, *given, c.byref(pairs))
        found = self.library.dll.fl_get_pairs(pairs)
        arrays = arrays_of(found, dict.fromkeys(("i", "j", "s", "t", "distance"), found.n))
        self.library.dll.fl_free_pairs(pairs)
        return arrays


def arrays_of(found: c.Structure, lengths: dict[str, int]) -> dict[str, npt.NDArray[Any]]:
    """Return copies of the arrays of a structure."""
    return {name: np.ctypeslib.as_array(getattr(found, name), (n,)).copy() for name, n in lengths.items() if n > 0}


def pointer(array: npt.NDArray[np.float32]) -> Any:
    assert array.flags.c_contiguous
    assert array.dtype == np.float32
    return array.ctypes.data_as(FloatPointer)
