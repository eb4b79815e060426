"""Coordinates less an offset: what is stored is small and exact, and all that is public is where the input is."""

from __future__ import annotations

import importlib
import json
import pickle
import warnings
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from support.command_line import done, refused

import fastlines as fl
from fastlines.errors import FileFormatError, InputError, PrecisionWarning
from fastlines.geometry.offsets import check_offset
from fastlines.io import known_formats
from fastlines.rendering import depth_image, level_sheet, plan_picture
from fastlines.rendering.default_view import turntable_camera
from fastlines.rendering.plan import PictureOptions
from fastlines.rendering.suitable_radius import suitable_radius

PLACE = np.array([5.3e6, 4.1e5, 200.0])
RNG = np.random.default_rng(3)
POINTS = PLACE + np.cumsum(RNG.normal(size=(40, 3)), axis=0)
PARTS = np.split(POINTS, [10, 25])
MIDDLE = tuple(np.round((POINTS.min(axis=0) + POINTS.max(axis=0)) / 2).tolist())
#: The error of float32 in a scene of some 20 units.
SMALL = 2e-6
WRITTEN = [name for name, row in known_formats().items() if row.writes]


@pytest.fixture
def lines():
    return fl.lines(PARTS, offset="auto")


@pytest.fixture
def near():
    """The same lines, made less the offset by hand."""
    return fl.Lines.from_strands([part - MIDDLE for part in PARTS])


# --- Making lines ---


@pytest.mark.parametrize("offset", ["auto", MIDDLE, np.array(MIDDLE)])
def test_every_way_to_make_lines(near, offset):
    flat = POINTS[np.repeat(np.arange(39), 2).reshape(39, 2) + np.array([0, 1])]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        made = [
            fl.lines(PARTS, offset=offset),
            fl.lines([part.tolist() for part in PARTS], offset=offset),
            fl.lines((POINTS, [0, 10, 25, 40]), offset=offset),
            fl.Lines.from_points(POINTS, [10, 15, 15], offset=offset),
            fl.Lines.from_strands(PARTS, offset=offset),
            fl.lines(fl.lines(PARTS, offset=offset), offset=offset),
        ]
        segments = fl.Lines.from_segments(flat.reshape(39, 6), offset=offset)
    for lines in made:
        assert lines.offset == lines.metadata["offset"] == MIDDLE
        assert lines.segments.tobytes() == near.segments.tobytes()
        assert np.abs(np.concatenate(lines.to_strands()) - POINTS).max() < SMALL
    assert np.abs(segments.segments.astype(np.float64) + segments.offset - flat).max() < SMALL


def test_curves():
    curves = fl.Curves.from_strands(POINTS, [40], basis="bspline", offset="auto")
    expected = fl.Curves.from_strands(POINTS - curves.offset, [40], basis="bspline")
    assert curves.control.tobytes() == expected.control.tobytes()
    assert curves.pieces.lines.offset == curves.offset == curves.as_lines().offset
    assert np.abs(curves.evaluate(3, 0.5).points - curves.offset - expected.evaluate(3, 0.5).points).max() < 1e-8
    bezier = fl.Curves.from_bezier(POINTS[:8].reshape(2, 4, 3), offset=MIDDLE)
    assert np.abs(bezier.control.astype(np.float64) + MIDDLE - POINTS[:8].reshape(2, 4, 3)).max() < SMALL
    hits = fl.build(curves).first_hit(curves.evaluate(3, 0.5).points - [0, 0, 9], [0, 0, 1], 1e-3)
    assert np.abs(hits.points() - curves.evaluate(3, hits.u).points).max() < 1e-3


def test_no_offset_has_a_negative_zero():
    assert str(check_offset((-0.0, -0.0, -0.0))) == "(0.0, 0.0, 0.0)"
    assert str(fl.Lines.from_segments([[[0, 0, 0], [1, 1, 1]]], offset=(-0.0, 5, -0.0)).offset) == "(0.0, 5.0, 0.0)"


def test_auto_is_rounded():
    def auto(points):
        return fl.Lines.from_points(points, [len(points)], offset="auto")

    assert auto([[16.2, 48.1, 0.2], [18.9, 48.2, 0.2]]).offset == (18.0, 48.0, 0.0)
    assert auto([[0.51234, 7, 1], [0.51238, 7, 1]]).offset == (0.51236, 7.0, 1.0)
    assert "offset" not in auto([[-1.0, 0, 0], [1, 0, 0]]).metadata
    assert "offset" not in fl.Lines.from_points([[9.0, 0, 0]], [1], offset=(0, 0, 0)).metadata
    bad = fl.Lines.from_points([[9e6, 0, 0], [np.nan, 0, 0], [9e6, 2, 0]], [3], offset="auto", invalid="skip")
    assert (bad.offset, len(bad)) == ((9e6, 1.0, 0.0), 0)
    assert len(fl.lines([], offset="auto")) == 0


@pytest.mark.parametrize("offset", ["middle", 5, (1, 2), (1, 2, np.nan), (1, 2, np.inf), ("x", 0, 0), {}, (1e31, 0, 0)])
def test_what_is_no_offset(tmp_path, offset):
    for make in (
        lambda: fl.lines(PARTS, offset=offset),
        lambda: fl.Lines.from_points(POINTS, [40], offset=offset),
        lambda: fl.read(tmp_path / "a.npy", offset=offset),
    ):
        with pytest.raises(InputError, match="expected 'auto', or three numbers that are subtracted from x, y and z"):
            make()
    with pytest.raises(InputError, match="offset"):
        fl.Lines(np.zeros((1, 2, 3), np.float32), metadata={"offset": offset})


def test_the_warning_names_the_remedy_of_its_place():
    with pytest.warns(PrecisionWarning, match="by up to 0.2.; offset='auto' where lines are read or made keeps these"):
        fl.lines(PARTS)
    with pytest.warns(PrecisionWarning, match="subtract the middle of the scene from them and from the origins of"):
        fl.Triangles(POINTS[:39].reshape(-1, 3, 3))


def test_lines_keep_their_offset(lines):
    for other in (lines[:5], lines.select(strands=[1]), lines.with_radius(1), pickle.loads(pickle.dumps(lines))):
        assert other.offset == MIDDLE
    assert np.abs(lines.select(strands=[1]).points - PARTS[1]).max() < SMALL
    assert lines.without_offset().offset == (0, 0, 0)
    other = fl.lines(lines, offset=(5.3e6, 4.1e5, 0))
    assert other.offset == (5.3e6, 4.1e5, 0)
    assert np.abs(other.points - POINTS).max() < 1e-4
    with pytest.warns(PrecisionWarning, match="up to 410003"):
        fl.lines(lines, offset=(5.3e6, 0, 200))


# --- Queries ---


def test_rays_and_points_are_where_the_input_is(lines, near):
    tree, expected = fl.build(lines), fl.build(near)
    origins = (POINTS[:9] + POINTS[1:10]) / 2 + RNG.normal(size=(9, 3)) - [0, 0, 30]
    for given in (origins, origins.tolist()):
        for query in ("first_hit", "all_hits"):
            got = getattr(tree, query)(given, [0, 0, 1], 1.5)
            same = getattr(expected, query)(origins - MIDDLE, [0, 0, 1], 1.5)
            assert got.prim.tobytes() == same.prim.tobytes()
            assert got.t.tobytes() == same.t.tobytes()
            assert got.hit.any() if query == "first_hit" else len(got)
            np.testing.assert_allclose(got.points() - MIDDLE, same.points(), atol=1e-8)
    brute = fl.brute_force(lines, origins, [0, 0, 1], 1.5, query="first_hit")
    assert brute.t.tobytes() == tree.first_hit(origins, [0, 0, 1], 1.5).t.tobytes()


def test_points_are_the_origins_of_the_next_rays(lines):
    tree = fl.build(lines.with_radius(0.5))
    hits = tree.first_hit(POINTS[4] - [0, 0, 30], [0, 0, 1], at="surface")
    start = hits.points(outside=True)
    assert np.abs(start[:2] - POINTS[4, :2]).max() < 1e-3
    assert not tree.any_hit(start, hits.normals(), t_max=0.01)
    assert tree.any_hit(start, -hits.normals(), t_max=0.01)


def test_origins_in_float32_warn(lines):
    tree = fl.build(lines)
    for query in (tree.first_hit, partial(fl.brute_force, lines)):
        with pytest.warns(
            PrecisionWarning, match=r"origins of rays are float32.*give the origins of rays as float64"
        ) as told:
            query(POINTS[0].astype(np.float32), [0, 0, 1], 1.0)
        assert told[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        tree.first_hit(POINTS[0], [0, 0, 1], 1.0)
        tree.first_hit(POINTS[:0].astype(np.float32), [0, 0, 1], 1.0)
    with pytest.raises(InputError, match="origins have shape"):
        tree.first_hit([1.0, 2.0], [0, 0, 1], 1.0)
    for wrong in ("north", [["a", "b", "c"]], [[1], [1, 2]]):
        with pytest.raises(InputError, match="origins"):
            tree.first_hit(wrong, [0, 0, 1], 1.0)
    nothing = np.full((2, 3), np.nan, np.float32)
    assert tree.first_hit(nothing, [0, 0, 1], 1.0, invalid="skip").skipped.tolist() == [0, 1]
    assert tree.first_hit([[np.nan] * 3, POINTS[0]], [0, 0, 1], 1.0, invalid="skip").skipped.tolist() == [0]


def test_refits_take_what_has_moved_in_the_same_place(lines):
    tree = fl.build(lines)
    moved = lines.segments.astype(np.float64) + MIDDLE + [0, 0, 7]
    again = tree.refit(moved)
    assert again.geometry.offset == MIDDLE
    origin = POINTS[3] - [0, 0, 20]
    assert again.first_hit(origin, [0, 0, 1], 0.01).t == pytest.approx(27, abs=1e-4)
    with pytest.raises(InputError, match="were given for a tree with"):
        tree.refit(lines.without_offset())


def test_parts_have_one_offset(lines):
    curves = fl.Curves.from_strands(POINTS, [40], basis="bspline", offset=MIDDLE)
    ball = fl.Boxes([[[-1, -1, 40], [1, 1, 42]]])  # less the offset
    spheres = fl.Spheres.from_centres(POINTS, 0.5, offset=MIDDLE)
    assert np.abs(spheres.centres.astype(np.float64) + MIDDLE - POINTS).max() < SMALL
    tree = fl.build(fl.Geometry([ball, lines, curves, spheres]))
    assert tree.geometry.offset == MIDDLE
    hits = tree.first_hit(np.add(MIDDLE, (0, 0, 90)), [0, 0, -1], 0.0, at="surface")
    assert (hits.part, hits.points().tolist()) == (0, [MIDDLE[0], MIDDLE[1], MIDDLE[2] + 42])
    assert tree.geometry.without_offset().offset == (0, 0, 0)
    with pytest.raises(InputError, match=r"parts have different offsets, .* with the same offset="):
        fl.Geometry([lines, curves.without_offset()])


# --- Files ---


@pytest.mark.parametrize("extension", WRITTEN)
@pytest.mark.filterwarnings("ignore::fastlines.FileWarning")
def test_files_hold_the_coordinates_of_the_input(tmp_path, lines, extension):
    path = tmp_path / f"a{extension}"
    if extension == ".hair":
        with pytest.warns(PrecisionWarning, match="write a format whose coordinates are float64, such as .tck"):
            fl.write(path, lines)
        return
    fl.write(path, lines)
    for offset in ("auto", MIDDLE):
        again = fl.read(path, offset=offset)
        assert again.offset == MIDDLE
        got = again.segments.astype(np.float64) + MIDDLE
        assert np.abs(got - (lines.segments.astype(np.float64) + MIDDLE)).max() < (
            2e-5 if extension == ".trk" else 1e-6
        )
    if extension in (".npz", ".safetensors", ".parquet", ".feather", ".arrow"):
        again = fl.read(path)
        assert again.offset == MIDDLE
        assert again.segments.tobytes() == lines.segments.tobytes()
        assert fl.read(path, offset=(5.3e6, 4.1e5, 0)).offset == (5.3e6, 4.1e5, 0)
    else:
        with pytest.warns(PrecisionWarning, match="offset='auto'"):
            assert fl.read(path).offset == (0, 0, 0)


@pytest.mark.parametrize("extension", [".npz", ".safetensors", ".usda"])
@pytest.mark.filterwarnings("ignore::fastlines.FileWarning")
def test_files_of_curves(tmp_path, lines, extension):
    pytest.importorskip("pxr")
    curves = fl.Curves.from_strands(POINTS, [40], basis="bspline", offset=MIDDLE)
    given = fl.Geometry([lines, curves]) if extension == ".usda" else curves
    fl.write(tmp_path / f"a{extension}", given)
    again = fl.read(tmp_path / f"a{extension}", offset="auto")
    assert again.offset == MIDDLE
    got = next(part for part in again.each_part() if isinstance(part, fl.Curves))
    assert np.abs(got.control - curves.control).max() < 1e-6


def test_trees_in_files(tmp_path, lines):
    tree = fl.build(lines)
    tree.save(tmp_path / "a.flt")
    again = fl.load(tmp_path / "a.flt")
    assert again.geometry.offset == MIDDLE
    origin = POINTS[3] - [0, 0, 20]
    assert again.first_hit(origin, [0, 0, 1], 0.01).points().tolist() == pytest.approx(POINTS[3].tolist(), abs=1e-4)


def optional_arrow():
    try:
        return importlib.import_module("pyarrow")
    except ImportError:
        return None


def test_readers_subtract_before_they_round(tmp_path):
    """Each of these formats holds more digits than float32 in its own way."""
    west, south = 500000.123, 5300000.1
    (tmp_path / "a.csv").write_text(f'wkt\n"LINESTRING ({west} {south}, {west + 9} {south})"\n')
    (tmp_path / "a.geojson").write_text(
        json.dumps({"type": "LineString", "coordinates": [[west, south], [west + 9, south]]})
    )
    (tmp_path / "a.obj").write_text(f"v {west} {south} 0\nv {west + 9} {south} 0\nl 1 2\n")
    (tmp_path / "a.swc").write_text(f"1 0 {west} {south} 0 1 -1\n2 0 {west + 9} {south} 0 1 1\n")
    np.save(tmp_path / "a.npy", [[[west, south, 0], [west + 9, south, 0]]])
    (tmp_path / "a.pbrt").write_text(
        f"WorldBegin\nTranslate {west} {south} 0\n"
        'Shape "curve" "point3 P" [0 0 0 3 0 0 6 0 0 9 0 0] "float width" [1]\n'
    )
    if pa := optional_arrow():
        ends = [[[west, south], [west + 9, south]]]
        kind = pa.list_(pa.list_(pa.float64(), 2))
        field = pa.field("geometry", kind, metadata={"ARROW:extension:name": "geoarrow.linestring"})
        pq = pytest.importorskip("pyarrow.parquet")
        pq.write_table(pa.Table.from_arrays([pa.array(ends, kind)], schema=pa.schema([field])), tmp_path / "a.parquet")
    for name in ("a.csv", "a.geojson", "a.obj", "a.swc", "a.npy", "a.pbrt", *["a.parquet"] * (pa is not None)):
        lines = fl.read(tmp_path / name, offset="auto")
        assert lines.offset == (500005.0, 5300000.0, 0.0), name
        assert (
            np.abs(lines.ends[0].astype(np.float64) + lines.offset - [[west, south, 0], [west + 9, south, 0]]).max()
            < 1e-6
        )


def test_files_with_an_offset_that_is_none(tmp_path, lines):
    np.savez(tmp_path / "a.npz", segments=np.zeros((1, 2, 3)), metadata=json.dumps({"offset": "north"}))
    with pytest.raises(FileFormatError, match="expected 'auto', or three numbers"):
        fl.read(tmp_path / "a.npz")


# --- Pictures ---


def test_cameras_are_where_the_input_is(lines, near):
    camera, expected = fl.Camera.framing(lines), fl.Camera.framing(near)
    np.testing.assert_allclose(np.subtract(camera.origin, MIDDLE), expected.origin, atol=1e-6)
    assert camera.rays(3, 3)[0].dtype == camera.ray(1, 1, 3, 3)[0].dtype == np.float64
    assert camera.through_lens([0, 0, -1], 0.5, 0.5)[0].dtype == np.float64
    assert expected.rays(3, 3)[0].dtype == expected.ray(1, 1, 3, 3)[0].dtype == np.float32
    hits = fl.build(lines).first_hit(*camera.rays(64, 64), 0.3)
    same = fl.build(near).first_hit(*expected.rays(64, 64), 0.3)
    assert (hits.prim != same.prim).mean() < 0.01
    assert hits.hit.sum() > 100
    pixels, _ = camera.project(hits.points()[hits.hit], 64, 64)
    assert np.abs(pixels % 1 - 0.5).max() < 0.01


def test_cameras_of_what_is_small_and_far():
    """The camera of lines smaller than what float32 distinguishes at their place, and of a point."""
    for points in ((POINTS - PLACE) * 1e-3, np.zeros((2, 3))):
        near, far = fl.Lines.from_strands([points]), fl.Lines.from_strands([points + PLACE], offset=PLACE)
        for make in (fl.Camera.framing, fl.default_camera, turntable_camera):
            camera, expected = make(far), make(near)
            np.testing.assert_allclose(np.subtract(camera.origin, PLACE), expected.origin, atol=1e-6)
            np.testing.assert_allclose(np.subtract(camera.target, PLACE), expected.target, atol=1e-6)
            assert suitable_radius(fl.build(far), camera) == suitable_radius(fl.build(near), expected)


def test_pictures_are_those_of_lines_near_zero(lines, near):
    size = {"width": 48, "height": 48, "radius": 0.3, "samples": 1}
    tree, expected = fl.build(lines), fl.build(near)
    for camera in (None, fl.Camera(tuple(np.add(MIDDLE, (0, 0, 60))), MIDDLE)):
        other = None if camera is None else fl.Camera((0, 0, 60), (0, 0, 0))
        picture = fl.render(tree, camera, aovs=True, **size)
        same = fl.render(expected, other, aovs=True, **size)
        assert picture.light.tobytes() == same.light.tobytes()
        np.testing.assert_allclose(picture.aovs["position"] - MIDDLE, same.aovs["position"], atol=1e-6)
        assert picture.alpha.any()
        np.testing.assert_allclose(np.subtract(picture.camera.origin, MIDDLE), same.camera.origin, atol=1e-6)
        row, column = np.argwhere(picture.alpha > 0)[0]
        origin, direction, _ = picture.camera.ray(column + 0.5, row + 0.5, 48, 48)
        assert tree.first_hit(origin, direction, 1.0).hit
    camera, other = fl.Camera(tuple(np.add(MIDDLE, (0, 0, 60))), MIDDLE), fl.Camera((0, 0, 60), (0, 0, 0))
    assert depth_image(tree, camera, 32, 32, 0.3).tobytes() == depth_image(expected, other, 32, 32, 0.3).tobytes()
    sheets = [level_sheet(one, seen, 0.3, 2, 64) for one, seen in ((tree, camera), (expected, other))]
    assert sheets[0].tobytes() == sheets[1].tobytes()
    plan = plan_picture(tree, PictureOptions(camera=camera, width=8, height=8))
    assert plan.given_camera == camera
    assert tree._repr_png_() == expected._repr_png_()


# --- The command line ---


@pytest.mark.usefixtures("in_own_folder")
def test_the_command_line(lines):
    fl.write("a.tck", replace(lines, unit="mm"))
    told = json.loads(done("info", "a.tck", "--option", "offset=auto", "--json"))["lines"]
    assert told["offset"] == list(MIDDLE)
    np.testing.assert_allclose(told["bounds"], [POINTS.min(axis=0), POINTS.max(axis=0)], atol=SMALL)
    low = ", ".join(f"{value:.10g}" for value in (lines.bounds.astype(np.float64) + MIDDLE)[0].tolist()[:2])
    assert f"lines  bounds              ({low}, " in done("info", "a.tck", "--option", "offset=auto")
    assert "box" in lines._repr_html_()
    assert "5,299,99" in lines._repr_html_()
    done("build", "a.tck", "--option", "offset=5300000,410000,0", "-o", "a.flt")
    assert fl.load("a.flt").geometry.offset == (5.3e6, 4.1e5, 0)
    done("render", "a.tck", "--option", "offset=auto", "-o", "a.png", "--width", "16", "--radius", "0.3")
    assert (
        "--option offset is '1,2'; expected auto, or three numbers"
        in refused("info", "a.tck", "--option", "offset=1,2")[1]
    )


def test_a_mesh_beside_lines_that_keeps_its_offset_is_told():
    lines = fl.lines(np.array([[[5e6, 5e6, 0], [5e6 + 1, 5e6, 0]]]), offset="auto")
    wall = np.array([[[5e6, 5e6, -1], [5e6 + 1, 5e6 + 1, 1]]])
    with pytest.warns(fl.PrecisionWarning, match="part 1 .1 box. lies far from the lines") as told:
        fl.Geometry([lines, fl.Boxes(wall.astype(np.float32))])
    assert told[0].filename == __file__
    fl.Geometry([lines, fl.Boxes((wall - lines.offset).astype(np.float32))])


def test_warnings_show_the_line_of_the_caller():
    with pytest.warns(fl.PrecisionWarning) as told:
        fl.Lines.from_strands([[[1e7, 0, 0], [1e7 + 0.3, 0.1, 0]]])
    assert told[0].filename == __file__
