"""The C interface by ctypes: the trees and answers of Python, bit for bit, and files that both read."""

from __future__ import annotations

import ctypes as c
import os
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from support.c_library import IGNORE, METHODS, Hit, Library, Ray, Rays, pointer

import fastlines as fl
from fastlines.structure import tree_file


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
    for each in (tree, library.load(tmp_path / "c.flt")):
        rows, strands = each.lines()
        np.testing.assert_array_equal(rows, lines.core_rows)
        np.testing.assert_array_equal(strands, lines.strands)
    np.testing.assert_array_equal(theirs.geometry.segments, lines.segments)
    np.testing.assert_array_equal(theirs.geometry.strands, lines.strands)

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


def test_rays_that_start_in_lines_enter_others(library: Library, lines: fl.Lines) -> None:
    rng = np.random.default_rng(2)
    ends = lines.segments[rng.integers(0, len(lines), 500)]
    origins = ends.mean(axis=1)
    directions = rng.normal(size=origins.shape).astype(np.float32)
    radius = 0.05
    tree, mine = library.build(lines), fl.build(lines)
    rays = Rays(len(origins), pointer(origins), pointer(directions), radius=radius)
    entries = mine.all_hits(origins, directions, radius, at="entry")
    assert 100 < len(entries) < len(mine.all_hits(origins, directions, radius)) - 400
    for name, found in tree.all_hits(rays, at=2).items():
        np.testing.assert_array_equal(found, getattr(entries, name), err_msg=name)
    np.testing.assert_array_equal(tree.counts(rays, at=2), entries.counts)
    np.testing.assert_array_equal(tree.any_hits(rays, at=2), entries.counts > 0)
    np.testing.assert_array_equal(tree.counts(rays, at=1), tree.counts(rays, at=0))
    first = mine.first_hit(origins, directions, radius, at="entry")
    for name, found in zip(("t", "prim", "u", "distance", "t_out"), tree.first_hits(rays, at=2), strict=True):
        np.testing.assert_array_equal(found, getattr(first, name), err_msg=name)
    assert np.isinf(tree.first_hits(rays, at=0)[-1]).all()
    with pytest.raises(RuntimeError, match="unknown fl_at; expected FL_CLOSEST, FL_SURFACE or FL_ENTRY"):
        tree.counts(rays, at=3)


def test_a_file_has_the_offset_of_its_lines(library: Library, tmp_path: Path) -> None:
    lines = fl.Lines.from_segments([[[5e5, 4e6, 0], [5e5 + 2, 4e6, 0]]], offset="auto")
    fl.build(lines).save(tmp_path / "far.flt")
    tree = library.load(tmp_path / "far.flt")
    assert tuple(tree.offset()) == lines.offset == (500_001, 4_000_000, 0)
    tree.save(tmp_path / "again.flt")
    assert fl.load(tmp_path / "again.flt").geometry.offset == lines.offset
    assert not any(library.build(lines).offset())


def test_the_frame_of_a_file_counts(library: Library, lines: fl.Lines, tmp_path: Path) -> None:
    mine = fl.build(lines, frame=lines.bounds + np.array([[-1], [2]]))
    mine.save(tmp_path / "frame.flt")
    camera = fl.Camera.framing(lines)
    origins, directions = (np.ascontiguousarray(a.reshape(-1, 3)) for a in camera.rays(width=40, height=30))
    rays = Rays(len(origins), pointer(origins), pointer(directions), None, None, None, 0.01, 2)
    expected = mine.all_hits(origins, directions, radius=0.01)
    assert (expected.t != fl.build(lines).all_hits(origins, directions, radius=0.01).t).any()
    tree = library.load(tmp_path / "frame.flt")
    tree.save(tmp_path / "again.flt")
    np.testing.assert_array_equal(fl.load(tmp_path / "again.flt").frame, mine.frame)
    for each in (tree, library.load(tmp_path / "again.flt")):
        for name, found in each.all_hits(rays, at=0).items():
            np.testing.assert_array_equal(found, getattr(expected, name), err_msg=name)
    rows = np.array(lines.core_rows)
    rows[:, :6] += 9
    with pytest.raises(RuntimeError, match="the lines leave the frame of the tree"):
        tree.refit(rows)


@pytest.mark.parametrize("at", ["closest", "surface"])
def test_a_hit_has_the_place_of_python(library: Library, lines: fl.Lines, at: str) -> None:
    tree, mine = library.build(lines), fl.build(lines)
    origins, directions = (a.reshape(-1, 3) for a in fl.Camera.framing(lines).rays(width=40, height=30))
    rng = np.random.default_rng(7)
    inside = lines.segments[::3].mean(axis=1)  # rays that start within reach of a line
    origins = np.concatenate([origins, inside]).astype(np.float32)
    directions = np.concatenate([3 * directions, rng.normal(size=inside.shape)]).astype(np.float32)
    hits = mine.first_hit(origins, directions, 0.01, at=at)
    nan = np.full(hits.points().shape, np.nan)
    expected = {"point": hits.points(), "tangent": hits.tangents()}
    is_surface = at == "surface"
    expected |= {"normal": hits.normals() if is_surface else nan}
    expected |= {"outside": hits.points(outside=True) if is_surface else nan}
    assert 100 < hits.hit.sum() < len(hits.hit)
    for i in range(len(origins)):
        hit = tree.first_hit(origins[i], directions[i], 0.01, at=int(is_surface))
        place = tree.place(origins[i], directions[i], 0.01, hit)
        for name, values in expected.items():
            np.testing.assert_array_equal(getattr(place, name), values[i], err_msg=f"{name} of ray {i}")
    with pytest.raises(RuntimeError, match="there is no line 300; expected an index below 300"):
        tree.place(origins[0], directions[0], 0.01, Hit(prim=len(lines)))


def assert_same_lists(found: dict[str, npt.NDArray[Any]], expected: fl.AllHits) -> None:
    assert len(expected) > 100
    for name, values in found.items():
        np.testing.assert_array_equal(values, getattr(expected, name), err_msg=name)


def test_special_rays_have_the_answers_of_python(library: Library, lines: fl.Lines) -> None:
    tree, mine = library.build(lines), fl.build(lines)
    origins, directions = (
        np.ascontiguousarray(a.reshape(-1, 3)) for a in fl.Camera.framing(lines).rays(width=40, height=30)
    )
    ignore, strands = np.array([5, -1, 60]), np.array([0, 7, 21])
    given = tuple(a.ctypes.data_as(c.POINTER(c.c_int64)) for a in (ignore, strands))
    left_out = dict(zip((name for name, _ in IGNORE), (given[0], 3, given[1], 3), strict=True))
    rays = Rays(len(origins), pointer(origins), pointer(directions), radius=0.02, **left_out)
    options: dict[str, Any] = {"ignore": ignore, "ignore_strands": strands}
    assert_same_lists(tree.all_hits(rays, at=1), mine.all_hits(origins, directions, 0.02, at="surface", **options))
    first = mine.first_hit(origins, directions, 0.02, at="surface", **options)
    np.testing.assert_array_equal(tree.first_hits(rays)[1], first.prim)

    spreads = np.linspace(0, 0.01, len(origins), dtype=np.float32)
    rays.spreads = pointer(spreads)
    options["spread"] = spreads
    assert_same_lists(tree.all_hits(rays, at=0), mine.all_hits(origins, directions, 0.02, **options))
    nearest = mine.next_hits(origins, directions, 0.02, k=3, rank="distance", **options)
    assert_same_lists(tree.all_hits(rays, 0, k=3, by_distance=True), nearest)
    plain = Rays(len(origins), pointer(origins), pointer(directions), radius=0.02)
    nearest = mine.next_hits(origins, directions, 0.02, k=3, rank="distance")
    assert_same_lists(tree.all_hits(plain, 0, k=3, by_distance=True), nearest)
    with pytest.raises(RuntimeError, match="At::surface has no meaning with a spread"):
        tree.all_hits(rays, at=1)
    with pytest.raises(RuntimeError, match="is for next_hits"):
        tree.all_hits(plain, at=0, by_distance=True)
    rays.n_ignore, ignore[0] = 1, 300
    with pytest.raises(RuntimeError, match="ignore names 300; there are 300 lines"):
        tree.all_hits(rays, at=0)


@pytest.mark.parametrize("method", ["best", "kd-d2"])
def test_a_refit_is_that_of_python(library: Library, lines: fl.Lines, method: str, tmp_path: Path) -> None:
    built, mine = library.build(lines, method), fl.build(lines, method)
    rows = np.array(lines.core_rows)
    rows[:, :6] *= np.linspace(1, 1.2, len(rows), dtype=np.float32)[:, None]
    tree, moved = built.refit(rows), mine.refit(rows[:, :6].reshape(-1, 2, 3))
    tree.save(tmp_path / "refitted.flt")
    library.load(tmp_path / "refitted.flt").save(tmp_path / "again.flt")
    for path in (tmp_path / "refitted.flt", tmp_path / "again.flt"):
        theirs = fl.load(path, verify=True)
        for ours, other in zip(moved.words(), theirs.words(), strict=True):
            np.testing.assert_array_equal(ours, other)
        assert (theirs.method, theirs.settings) == (moved.method, moved.settings)
        assert theirs.growth == moved.growth > 1
    with pytest.raises(RuntimeError, match="299 lines were given for a tree over 300; expected as many"):
        built.refit(rows[:-1])


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


def test_a_layout_is_made_anew_and_more_sections_are_kept(library: Library, lines: fl.Lines, tmp_path: Path) -> None:
    mine = fl.build(lines)
    tree_file.write(mine, tmp_path / "python.flt", layout=True, more={"ids": np.arange(300) * 3})
    library.load(tmp_path / "python.flt").save(tmp_path / "c.flt")
    assert "layout" not in fl.load(tmp_path / "c.flt", verify=True).__dict__
    assert tree_file.read_more(tmp_path / "c.flt")["ids"].tolist() == list(range(0, 900, 3))
    assert b"layout" not in (tmp_path / "c.flt").read_bytes()


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
        ("fl_get_place", [tree, c.byref(ray), radius, room, room], {0: "tree", 1: "ray", 3: "hit", 4: "place"}),
        ("fl_any_hit", [tree, c.byref(ray), radius, 0, room], {0: "tree", 1: "ray", 4: "found"}),
        ("fl_count_hits", [tree, c.byref(ray), radius, 0, room], {0: "tree", 1: "ray", 4: "n"}),
        ("fl_all_hits", [tree, c.byref(ray), radius, 0, room, n, room], {0: "tree", 1: "ray", 4: "hits", 6: "n"}),
        ("fl_next_hits", [tree, c.byref(ray), radius, 0, n, 0, room, room], {0: "tree", 1: "ray", 6: "hits", 7: "n"}),
        ("fl_first_hits", [tree, c.byref(rays), 0, *[None] * 5], {0: "tree", 1: "rays"}),
        ("fl_any_hits", [tree, c.byref(rays), 0, room], {0: "tree", 1: "rays", 3: "found"}),
        ("fl_counts", [tree, c.byref(rays), 0, room], {0: "tree", 1: "rays", 3: "n"}),
        ("fl_list_hits", [tree, c.byref(rays), n, 0, 0, c.byref(made)], {0: "tree", 1: "rays", 5: "lists"}),
        ("fl_refit", [tree, point, n, 0, c.byref(made)], {0: "tree", 1: "the array of lines", 4: "refitted"}),
        ("fl_refit_round_cones", [tree, point, n, 0, c.byref(made)], {0: "tree", 4: "refitted"}),
    ]
    for name, arguments, pointers in calls:
        for place, what in pointers.items():
            given = [*arguments[:place], None, *arguments[place + 1 :]]
            with pytest.raises(RuntimeError, match=f"^{what} is NULL"):
                library.call(name, *given)
    for nothing in (Rays(1, None, point), Rays(1, point, None), Rays(2**64 - 1, point, point)):
        with pytest.raises(RuntimeError, match=r"is NULL|2\^32"):
            library.call("fl_counts", tree, c.byref(nothing), 0, room)
    for count in (2**64 - 1, 2**63):
        with pytest.raises(RuntimeError, match="more than a tree can index"):
            library.call("fl_build", point, c.c_size_t(count), None, c.byref(made))
    assert library.dll.fl_get_lists(None).n_rays == library.dll.fl_get_lines(None).n == 0
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
