"""Pictures: known depths, lighter = nearer, thin lines as an expectation, whole files, and where to look from."""

from __future__ import annotations

import dataclasses
import math
import sys

import numpy as np
import pytest
from PIL import Image
from support.line_files import SAMPLES
from support.slow import few_of

import fastlines as fl
from fastlines.rendering import default_camera, default_view, depth_image, level_sheet, write_depth, write_picture
from fastlines.rendering.color.tone import linear
from fastlines.rendering.pictures import images
from fastlines.rendering.shading.depth import MAX_BATCH, MAX_PIXELS, View, bands
from fastlines.rendering.shading.depth_tone import DARKEST, GAMMA, Tone, grey
from fastlines.support.atomic_write import atomic_write

CAMERA = fl.Camera(origin=(0, 0, 4), target=(0, 0, 0))
#: Across the view at the depths 4 (upper half), 6 (lower half).
TWO_LINES = [[[-9, 0.5, 0], [9, 0.5, 0]], [[-9, -0.5, -2], [9, -0.5, -2]]]


def grey_depths(tree, camera, width, height, radius, progress=False, samples=9):
    options = {"width": width, "height": height, "radius": radius, "progress": progress, "samples": samples}
    return grey(fl.render(tree, camera, look="depth", **options))


@pytest.fixture(scope="module")
def two_lines():
    return fl.build(TWO_LINES)


# --- Depth ---


def test_one_segment_has_its_depth_in_the_middle():
    tree = fl.build([[[-1, 0, 0], [1, 0, 0]]])
    depth = depth_image(tree, CAMERA, 65, 65, 0.05)
    assert depth.shape == (65, 65)
    assert depth.dtype == np.float32
    assert depth[32, 32] == 4
    # The segment and its round ends reach 1.05 to each side, where the picture is 2·4·tan 15° wide.
    n_hit = 65 * 1.05 / (4 * math.tan(math.radians(15)))
    assert abs(np.isfinite(depth[32]).sum() - n_hit) <= 1
    assert np.isinf(depth[:30]).all()
    assert np.isinf(depth[35:]).all()


def test_depth_is_along_the_ray(two_lines):
    depth = depth_image(two_lines, CAMERA, 31, 31, 0.05)
    origins, directions = CAMERA.rays(31, 31)
    expected = two_lines.first_hit(origins, directions, 0.05).t.reshape(31, 31)
    assert (np.isfinite(depth) == np.isfinite(expected)).all()
    assert np.allclose(depth[np.isfinite(depth)], expected[np.isfinite(depth)])


@pytest.mark.parametrize(("width", "height"), [(7, 4), (1, 9), (5, 1)])
def test_rays_agree_with_the_camera(two_lines, width, height):
    camera = fl.Camera(origin=(1, 2, 3), target=(-1, 0.5, -2), up=(0.2, 1, 0), fov_degrees=40)
    origins, directions = camera.rays(width, height)
    view = View(two_lines, camera, width, height)
    mine = [view.rays(rows) for rows in bands(width, height, 2 * width)]
    assert (np.concatenate([d for _, d in mine]).reshape(-1, 3) == directions).all()
    assert (mine[0][0] == origins[0]).all()


def test_bands_cover_each_row_once_and_bound_the_batch():
    rows = list(bands(5000, 777))
    assert [row for band in rows for row in range(band.start, band.stop)] == list(range(777))
    assert max(5000 * (band.stop - band.start) for band in rows) <= MAX_BATCH
    assert [band.stop - band.start for band in bands(10 * MAX_BATCH, 2)] == [1, 1]


def test_progress_reaches_one(two_lines):
    for draw in (depth_image, grey_depths):
        said = []
        draw(two_lines, CAMERA, 16, 16, 0.1, progress=said.append)
        assert said == sorted(said)
        assert said[-1] == 1


@pytest.mark.parametrize(
    ("width", "height", "radius", "words"),
    [
        (0, 5, 0.1, "width=0"),
        (5, -1, 0.1, "height=-1"),
        (5, 2.5, 0.1, "height=2.5"),
        (10**9, 1, 0.1, f"width=1000000000; expected a whole number, 1 to {MAX_PIXELS}"),
        (MAX_PIXELS, 2, 0.1, f"{MAX_PIXELS:,}"),
        (5, 5, -1.0, "radius=-1.0"),
        (5, 5, math.nan, "radius=nan"),
        (5, 5, math.inf, "radius=inf"),
        (5, 5, [0.1], "radius"),
    ],
)
def test_refuses_what_is_no_picture(two_lines, width, height, radius, words):
    for draw in (depth_image, grey_depths):
        with pytest.raises(fl.InputError, match=words):
            draw(two_lines, CAMERA, width, height, radius)


# --- Tone ---


def test_lighter_is_nearer_strictly():
    seen = np.random.default_rng(1).random(5000) ** 3 + 2
    tone = Tone(seen)
    depths = np.linspace(*np.quantile(seen, [0.011, 0.989]), 500)
    brightness = tone.brightness(depths)
    assert (np.diff(brightness) < 0).all()
    assert brightness.min() > DARKEST > 0
    assert tone.brightness(np.array([np.inf, 0.0, 99.0])).tolist() == [0, 1, pytest.approx(DARKEST)]
    assert np.allclose(tone.light(depths), brightness**GAMMA)


@pytest.mark.parametrize("depths", [[], [np.inf], [3.0], [3.0, 3.0]])
def test_tone_of_one_depth_is_white(depths):
    assert Tone(depths).brightness(np.array([3.0, np.inf])).tolist() == [1, 0]


def test_grey_is_made_lighter_until_its_lightest_part_is_white(two_lines):
    thin = fl.render(two_lines, CAMERA, width=50, height=50, look="depth", radius=0.003)
    shown = thin.to_bytes()[..., 0]
    assert shown.max() < 200
    assert grey(thin).max() == 255
    assert (grey(thin) >= shown).all()
    nothing = fl.render(np.empty((0, 2, 3)), CAMERA, width=8, height=8, look="depth", radius=0.1)
    assert grey(nothing).max() == 0


# --- Pictures ---


@pytest.mark.parametrize("radius", [0.1, 0.003])  # thick lines, and lines thinner than a pixel
def test_picture_is_lighter_where_lines_are_nearer(two_lines, radius):
    picture = grey_depths(two_lines, CAMERA, 200, 200, radius)
    assert picture.dtype == np.uint8
    assert picture[:100].max() == 255
    assert 0 < picture[100:].max() < 100
    assert picture[100].max() == 0


def test_thin_lines_are_what_many_samples_converge_to():
    lines = fl.scenes.make("spaghetti", 150).lines
    tree, camera = fl.build(lines), default_camera(lines)
    size, radius = 24, 0.004
    thin = linear(grey_depths(tree, camera, size, size, radius) / 255)
    many = linear(grey_depths(tree, camera, size * 16, size * 16, radius, samples=1) / 255)
    light = many.reshape(size, 16, size, 16).mean(axis=(1, 3))
    # The same light up to the blur of the spot and one factor: compare blocks of pixels.
    blocks = [x.reshape(4, 6, 4, 6).mean(axis=(1, 3)) for x in (thin, light)]
    assert np.corrcoef(blocks[0].ravel(), blocks[1].ravel())[0, 1] > 0.9


def test_odd_geometry_is_drawn():
    point = fl.build([[[1, 1, 1], [1, 1, 1]]])
    assert grey_depths(point, default_camera(point.geometry), 33, 33, 0.1).max() == 255
    nothing = fl.build(np.empty((0, 2, 3)))
    assert grey_depths(nothing, default_camera(nothing.geometry), 8, 8, 0.1).max() == 0
    assert np.isinf(depth_image(nothing, default_camera(nothing.geometry), 8, 8, 0.1)).all()
    line = fl.build(TWO_LINES)
    assert grey_depths(line, CAMERA, 8, 8, 0.0).max() == 0
    for tree in (point, nothing):
        assert level_sheet(tree, default_camera(tree.geometry), 0.1, panel=32).shape[2] == 3


# --- Levels ---


@pytest.mark.parametrize("method", few_of(["bvh-d2", "kd-d2"], n=1))
def test_level_sheet_has_a_panel_for_each_level(method):
    scene = fl.scenes.make("spaghetti", 200)
    tree = fl.build(scene.lines, method)
    one, three, six = (level_sheet(tree, scene.camera, 0.003, n, panel=64) for n in (1, 3, 6))
    assert one.dtype == np.uint8
    assert one.shape[0] == three.shape[0] < six.shape[0]
    assert one.shape[1] < three.shape[1] == six.shape[1]
    picked = level_sheet(tree, scene.camera, 0.003, [2], panel=64)
    assert picked.shape == one.shape
    # Boxes have colours, the lines behind them have none.
    assert (six.max(axis=2) > six.min(axis=2)).any()
    assert level_sheet(tree, scene.camera, 0.003, 1000, panel=16).shape[0] > 16


def test_level_sheet_shows_the_whole_root_box():
    tree = fl.build([[[0, 0, 0], [1, 1, 1]]])
    sheet = level_sheet(tree, fl.Camera((0.5, 0.5, 1.5), (0.5, 0.5, 0)), 0.01, 1, panel=100)
    box = sheet[:, :, 0].astype(int) - sheet[:, :, 2]  # orange
    rows, columns = np.nonzero(box > 60)
    assert 4 < rows.max() - rows.min() < 99
    assert 4 < columns.max() - columns.min() < 99


# --- Files ---


def test_png_round_trip(tmp_path):
    picture = np.arange(12, dtype=np.uint8).reshape(3, 4)
    write_picture(tmp_path / "a.PNG", picture)
    assert (np.asarray(Image.open(tmp_path / "a.PNG")) == picture).all()
    assert [path.name for path in tmp_path.iterdir()] == ["a.PNG"]


def test_exr_round_trip(tmp_path):
    openexr = pytest.importorskip("OpenEXR")
    depth = np.array([[1.5, np.inf, 3e-8], [4e8, 2.0, np.inf]], np.float32)
    write_depth(tmp_path / "a.exr", depth)
    with openexr.File(str(tmp_path / "a.exr")) as file:
        channels = file.channels()
        assert list(channels) == ["Z"]
        assert (channels["Z"].pixels == depth).all()
        assert channels["Z"].pixels.dtype == np.float32


def test_exr_needs_an_extra(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "OpenEXR", None)
    with pytest.raises(fl.MissingExtraError, match=r"the extra 'exr'"):
        images.check_image_path(tmp_path / "a.exr")


def test_unknown_extensions_are_named(tmp_path):
    for name in ("a.jpg", "a", "a.png.bak"):
        with pytest.raises(fl.InputError, match=r"known: \.png, \.exr"):
            images.check_image_path(tmp_path / name)
    with pytest.raises(fl.InputError, match=r"\.png"):
        write_picture(tmp_path / "a.exr", np.zeros((2, 2), np.uint8))
    with pytest.raises(fl.InputError, match=r"\.exr"):
        write_depth(tmp_path / "a.png", np.zeros((2, 2), np.float32))


def test_a_failed_write_leaves_the_old_file(tmp_path):
    path = tmp_path / "a.png"
    path.write_bytes(b"old")
    with pytest.raises(FileNotFoundError), atomic_write(path) as partial:
        partial.unlink()  # a stand-in for whatever may happen before it is whole
    assert path.read_bytes() == b"old"
    assert [path.name for path in tmp_path.iterdir()] == ["a.png"]
    with pytest.raises(FileNotFoundError):
        write_picture(tmp_path / "no" / "a.png", np.zeros((2, 2), np.uint8))


def test_two_writers_of_one_file_do_not_share_a_partial_one(tmp_path):
    path = tmp_path / "a.txt"
    with atomic_write(path) as one, atomic_write(path) as other:
        one.write_text("one")
        other.write_text("other")
    assert path.read_text() == "one"  # its block ended last
    assert [entry.name for entry in tmp_path.iterdir()] == ["a.txt"]


# --- Views ---


def lines_in(low, high):
    return fl.Lines.from_segments([[low, high]])


@pytest.mark.parametrize(
    ("low", "high", "told", "up"),
    [
        ((-1, 0, -1), (1, 2, 1), None, (0, 1, 0)),  # stands on the ground
        ((-1, 5, -1), (1, 7, 1), None, (0, 1, 0)),  # hangs above it
        ((-65, -105, -77), (65, 72, 75), None, (0, 0, 1)),  # a brain
        ((-1, 0, -1), (1, 2, 1), "z", (0, 0, 1)),
        ((-1, -3, -1), (1, 2, 1), "y", (0, 1, 0)),
        ((0, 0, 0), (5, 3, 0), None, (0, 1, 0)),  # a map
        ((0, 0, 0), (5, 0, 3), None, (0, 0, 1)),
    ],
)
def test_what_is_up(low, high, told, up):
    lines = dataclasses.replace(lines_in(low, high), up=told)
    assert default_view(lines)[1] == up
    assert default_view(fl.build(lines).refit(lines.segments).geometry) == default_view(lines)


@pytest.mark.parametrize("name", ["some.trk", "some.tck", "v4.tfx", "full.hair", "points.npz", "scene"])
def test_a_file_and_a_tree_of_it_are_drawn_alike(name, tmp_path):
    if name == "scene":
        lines = fl.scenes.make("spaghetti", 20).lines
    else:
        (tmp_path / name).write_bytes(SAMPLES[name])
        lines = fl.read(tmp_path / name)
    fl.build(lines).save(tmp_path / "a.flt")
    loaded = fl.load(tmp_path / "a.flt").geometry
    assert loaded.up == lines.up == {"some.trk": "z", "some.tck": "z", "v4.tfx": "y", "scene": "y"}.get(name)
    assert default_camera(loaded) == default_camera(lines)


def test_maps_are_looked_at_from_above_and_bodies_from_the_side():
    assert default_view(lines_in((0, 0, 0), (5, 3, 0)))[0] == (0, 0, -1)
    direction, _ = default_view(lines_in((0, 0, -5), (5, 4, 5)))
    assert abs(direction[0]) > abs(direction[2]) > 0 > direction[1]


def test_slabs_are_shown_from_the_side_cubes_corner_on_and_plains_from_above():
    slab, _ = default_view(lines_in((0, 0, -5), (2, 9, 5)))
    assert slab[2] == 0 > slab[1]
    body, cube, plain = (
        default_view(lines_in((0, 0, 0), high))[0] for high in ((8, 8, 10), (10, 9.5, 10), (10, 1, 10))
    )
    assert abs(cube[0]) > abs(body[2])
    assert plain[1] < cube[1] < body[1] < 0


def test_the_view_turns_to_the_side_that_the_lines_lean_away_from():
    body = [[[0, 0, -5], [5, 4, 5]]]
    tail, head = [[[0, 0, -5], [1, 1, -4]]], [[[0, 0, 4], [1, 1, 5]]]
    to_front = default_view(fl.Lines.from_segments(body + 3 * tail))[0]
    to_back = default_view(fl.Lines.from_segments(body + 3 * head))[0]
    assert to_front[2] < 0 < to_back[2]  # the camera stands where it comes from
