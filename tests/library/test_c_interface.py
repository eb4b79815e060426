"""The C interface by ctypes: the trees and answers of Python, bit for bit, and files that both read."""

from __future__ import annotations

import ctypes as c
import os
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import fastlines as fl
from fastlines.settings.methods import THESIS_METHODS

METHODS = ("best", *THESIS_METHODS)
FloatPointer = c.POINTER(c.c_float)


class Options(c.Structure):
    _fields_ = (
        ("method", c.c_int),
        ("has_effort", c.c_int),
        ("effort", c.c_float),
        ("n_threads", c.c_uint),
        ("progress", c.c_void_p),
        ("user_data", c.c_void_p),
    )


class Ray(c.Structure):
    _fields_ = (("origin", c.c_float * 3), ("direction", c.c_float * 3), ("t_min", c.c_float), ("t_max", c.c_float))


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
        self.dll.fl_get_lists.restype = Lists

    def call(self, name: str, *arguments: Any) -> None:
        if getattr(self.dll, name)(*arguments):
            raise RuntimeError(self.dll.fl_error_message().decode())

    def build(self, geometry: fl.Lines, method: str = "best") -> CTree:
        options = Options(method=METHODS.index(method))
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

    def first_hits(self, rays: Rays) -> tuple[npt.NDArray[Any], ...]:
        columns = [np.empty(rays.n, dtype) for dtype in (np.float32, np.int64, np.float32, np.float32, np.float32)]
        self.library.call(
            "fl_first_hits", self.tree, c.byref(rays), *(column.ctypes.data_as(c.c_void_p) for column in columns)
        )
        return tuple(columns)

    def all_hits(self, rays: Rays, at: int) -> dict[str, npt.NDArray[Any]]:
        lists = c.c_void_p()
        self.library.call("fl_list_hits", self.tree, c.byref(rays), c.c_size_t(-1), at, c.byref(lists))
        found = self.library.dll.fl_get_lists(lists)
        lengths = {"offsets": found.n_rays + 1} | dict.fromkeys(("t", "prim", "u", "distance"), found.n_hits)
        arrays = {
            name: np.ctypeslib.as_array(getattr(found, name), (n,)).copy() for name, n in lengths.items() if n > 0
        }
        self.library.dll.fl_free_lists(lists)
        return arrays


def pointer(array: npt.NDArray[np.float32]) -> Any:
    assert array.flags.c_contiguous
    assert array.dtype == np.float32
    return array.ctypes.data_as(FloatPointer)


@pytest.fixture(scope="module")
def library() -> Library:
    try:
        fl.get_lib()
    except fl.FastlinesError as error:
        pytest.skip(f"this is not an installation: {error}")
    return Library()


@pytest.fixture(scope="module", params=["segments", "round cones"])
def lines(request: pytest.FixtureRequest) -> fl.Lines:
    made = fl.scenes.make("spaghetti", 300).lines
    if request.param == "segments":
        return made
    rng = np.random.default_rng(5)
    return made.with_radius(rng.uniform(0, 0.01, (len(made), 2)).astype(np.float32))


@pytest.mark.parametrize("method", METHODS)
def test_trees_and_answers_are_those_of_python(library: Library, lines: fl.Lines, method: str, tmp_path: Path) -> None:
    tree, mine = library.build(lines, method), fl.build(lines, method)
    tree.save(tmp_path / "c.flt")
    theirs = fl.load(tmp_path / "c.flt")
    for ours, other in zip(mine.words(), theirs.words(), strict=True):
        np.testing.assert_array_equal(ours, other)
    assert theirs.method == method
    assert theirs.settings == mine.settings
    assert theirs.limits_hit == mine.limits_hit
    np.testing.assert_array_equal(theirs.geometry.segments, lines.segments)

    camera = fl.Camera.framing(lines)
    origins, directions = (np.ascontiguousarray(a.reshape(-1, 3)) for a in camera.rays(width=40, height=30))
    rays = Rays(len(origins), pointer(origins), pointer(directions), None, None, None, 0.01, 2)
    expected = mine.first_hit(origins, directions, radius=0.01, at="surface")
    t, prim, u, distance, t_out = tree.first_hits(rays)
    for name, found in {"t": t, "prim": prim, "u": u, "distance": distance, "t_out": t_out}.items():
        np.testing.assert_array_equal(found, getattr(expected, name), err_msg=name)
    lists = mine.all_hits(origins, directions, radius=0.01)
    for name, found in tree.all_hits(rays, at=0).items():
        np.testing.assert_array_equal(found, getattr(lists, name), err_msg=name)
    for i in range(0, len(origins), 37):
        hit = tree.first_hit(origins[i], directions[i], 0.01, at=1)
        assert (hit.t, hit.prim, hit.t_out) == (expected.t[i], expected.prim[i], expected.t_out[i])


def test_files_of_python_keep_everything(library: Library, tmp_path: Path) -> None:
    points = [[0, 0, 0], [0, 1, 0], [0.2, 2, 0], [1, 0, 0], [1, 2, 0]]
    lines = fl.Lines.from_points(points, [3, 2], radius=[0.1, 0.2, 0.1, 0.3, 0], attributes={"π": [1.5, 2, 2.5, 3, 4]})
    fl.build(lines).save(tmp_path / "python.flt")
    library.load(tmp_path / "python.flt").save(tmp_path / "c.flt")
    again = fl.load(tmp_path / "c.flt", verify=True).geometry
    assert isinstance(again, fl.Lines)
    for name in ("segments", "strands"):
        np.testing.assert_array_equal(getattr(again, name), getattr(lines, name))
    np.testing.assert_array_equal(again.end_radii, lines.end_radii)
    np.testing.assert_array_equal(again.attributes["π"], lines.attributes["π"])


def test_files_that_c_cannot_use_are_refused(library: Library, tmp_path: Path) -> None:
    fl.build(fl.Triangles(np.eye(3, dtype=np.float32)[None])).save(tmp_path / "mesh.flt")
    with pytest.raises(RuntimeError, match="Triangles"):
        library.load(tmp_path / "mesh.flt")
    with pytest.raises(RuntimeError, match="cannot be read"):
        library.load(tmp_path / "none.flt")
    (tmp_path / "text.flt").write_text("lines of text, not a tree")
    with pytest.raises(RuntimeError, match="does not begin like one"):
        library.load(tmp_path / "text.flt")


def test_saving_keeps_links_and_modes_and_replaces_only_files(
    library: Library, lines: fl.Lines, tmp_path: Path
) -> None:
    tree, target, link = library.build(lines), tmp_path / "target.flt", tmp_path / "link.flt"
    target.touch(0o600)
    link.symlink_to(target)
    tree.save(link)
    assert link.is_symlink()
    assert len(fl.load(target).geometry) == len(fl.load(link).geometry) == len(lines)
    assert target.stat().st_mode & 0o777 == 0o600
    (tmp_path / "to_new.flt").symlink_to("new.flt")
    tree.save(tmp_path / "to_new.flt")
    assert (tmp_path / "to_new.flt").is_symlink()
    assert len(fl.load(tmp_path / "new.flt").geometry) == len(lines)
    tree.save(tmp_path / f"{'n' * 240}.flt")
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "loop").symlink_to("loop")
    for path, why in (("pipe", "not a regular file"), ("", "not a regular file"), ("loop", "a loop of symbolic links")):
        with pytest.raises(RuntimeError, match=f"is {why}; expected the path of a file"):
            tree.save(tmp_path / path)
    with pytest.raises(RuntimeError, match="the path is empty"):
        library.call("fl_save", tree.tree, b"")
    with pytest.raises(RuntimeError, match="a folder that exists"):
        tree.save(tmp_path / "none" / "a.flt")
    names = sorted(path.name for path in tmp_path.iterdir())
    assert names == ["link.flt", "loop", "new.flt", f"{'n' * 240}.flt", "pipe", "target.flt", "to_new.flt"]


def test_bad_input_has_a_message(library: Library, lines: fl.Lines) -> None:
    tree = library.build(lines)
    with pytest.raises(RuntimeError, match="direction of length zero"):
        tree.first_hit((0, 0, 0), (0, 0, 0), 0.1, at=0)
    with pytest.raises(RuntimeError, match="radius"):
        tree.first_hit((0, 0, 0), (0, 0, 1), -1, at=0)
    with pytest.raises(RuntimeError, match="tree is NULL"):
        library.call("fl_save", None, b"a.flt")
    bad = lines.segments.copy()
    bad[7, 0, 0] = np.nan
    made = c.c_void_p()
    with pytest.raises(RuntimeError, match="line 7"):
        library.call("fl_build", pointer(bad.reshape(-1, 6)), c.c_size_t(len(bad)), None, c.byref(made))
    assert not made


def test_null_pointers_are_refused_by_name(library: Library, lines: fl.Lines) -> None:
    built, point = library.build(lines), pointer(np.zeros(3, np.float32))
    tree = built.tree
    ray, rays, made = Ray((c.c_float * 3)(), (c.c_float * 3)(0, 0, 1), 0, 1), Rays(1, point, point), c.c_void_p()
    room, radius, n = c.byref(c.create_string_buffer(64)), c.c_float(0.1), c.c_size_t(1)
    calls: list[tuple[str, list[Any], dict[int, str]]] = [
        ("fl_build", [point, n, None, room], {0: "the array of lines", 3: "tree"}),
        ("fl_build_round_cones", [point, n, None, room], {0: "the array of lines", 3: "tree"}),
        ("fl_load", [b"none.flt", c.byref(made)], {0: "path", 1: "tree"}),
        ("fl_save", [tree, b"none/none.flt"], {0: "tree", 1: "path"}),
        ("fl_get_facts", [tree, room], {0: "tree", 1: "facts"}),
        ("fl_first_hit", [tree, c.byref(ray), radius, 0, room], {0: "tree", 1: "ray", 4: "hit"}),
        ("fl_any_hit", [tree, c.byref(ray), radius, room], {0: "tree", 1: "ray", 3: "found"}),
        ("fl_count_hits", [tree, c.byref(ray), radius, room], {0: "tree", 1: "ray", 3: "n"}),
        ("fl_all_hits", [tree, c.byref(ray), radius, 0, room, n, room], {0: "tree", 1: "ray", 4: "hits", 6: "n"}),
        ("fl_next_hits", [tree, c.byref(ray), radius, 0, n, room, room], {0: "tree", 1: "ray", 5: "hits", 6: "n"}),
        ("fl_first_hits", [tree, c.byref(rays), *[None] * 5], {0: "tree", 1: "rays"}),
        ("fl_any_hits", [tree, c.byref(rays), room], {0: "tree", 1: "rays", 2: "found"}),
        ("fl_counts", [tree, c.byref(rays), room], {0: "tree", 1: "rays", 2: "n"}),
        ("fl_list_hits", [tree, c.byref(rays), n, 0, c.byref(made)], {0: "tree", 1: "rays", 4: "lists"}),
    ]
    for name, arguments, pointers in calls:
        for place, what in pointers.items():
            given = [*arguments[:place], None, *arguments[place + 1 :]]
            with pytest.raises(RuntimeError, match=f"^{what} is NULL"):
                library.call(name, *given)
    for nothing in (Rays(1, None, point), Rays(1, point, None), Rays(2**64 - 1, point, point)):
        with pytest.raises(RuntimeError, match=r"is NULL|2\^32"):
            library.call("fl_counts", tree, c.byref(nothing), room)
    for count in (2**64 - 1, 2**63):
        with pytest.raises(RuntimeError, match="more than a tree can index"):
            library.call("fl_build", point, c.c_size_t(count), None, c.byref(made))
    assert library.dll.fl_get_lists(None).n_rays == 0
    library.dll.fl_free_tree(None)
    library.dll.fl_free_lists(None)
    library.call("fl_set_simd", None)


def test_versions_agree(library: Library) -> None:
    assert library.dll.fl_version().decode() == fl.__version__


def test_folders_hold_what_they_promise(library: Library) -> None:
    assert (Path(fl.get_include()) / "fastlines" / "fastlines.hpp").is_file()
    assert (Path(fl.get_include()) / "fastlines" / "fastlines.h").is_file()
    assert (Path(fl.get_cmake_dir()) / "fastlines-config.cmake").is_file()
    assert list(Path(fl.get_lib()).glob("libfastlines.a"))
