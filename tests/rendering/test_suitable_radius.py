"""Every scene has a radius and a camera with which a picture shows it, however slender, small, large or far it is."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from support.command_line import run

import fastlines as fl
from fastlines.rendering import PictureOptions, ViewOptions, default_camera, default_view, plan_picture
from fastlines.rendering.renderer import draw
from fastlines.rendering.suitable_radius import suitable_radius

X = np.linspace(0, 1, 50)
SLENDER = np.c_[0.003 * np.sin(9 * X), 0.003 * np.cos(7 * X), X]
BENT = np.array([[0, 0, 0], [1, 0.5, 0.3], [0, 1, 1]])


def strand(points):
    return fl.Lines.from_strands([np.asarray(points, np.float32)])


def bundle(n):
    """Return n strands that run along each other."""
    shifts = np.random.default_rng(0).normal(0, 1e-3, (n, 1, 3))
    return fl.Lines.from_strands(list(np.float32(SLENDER + shifts)))


SCENES = {
    "along x": strand([[0, 0, 0], [1, 0, 0]]),
    "along y": strand([[0, -1, 0], [0, 3, 0]]),
    "along z": strand([[0, 0, 0], [0, 0, 1], [0, 0, 2]]),
    "from corner to corner": strand([[0, 0, 0], [1, 1, 1]]),
    "slender": strand(SLENDER),
    "slender and flat": strand(SLENDER * [1, 0, 1]),
    "bundle": bundle(100),
    "point": strand([[1, 2, 3], [1, 2, 3]]),
    "point at the origin": strand(np.zeros((2, 3))),
    "coincident points": fl.lines(np.full((5, 2, 3), 7.0)),
    "thin spheres": fl.Spheres.from_centres(np.random.default_rng(1).random((50, 3)), 0),
    "two points": fl.Spheres.from_centres([[0, 0, 0], [1e5, 0, 0]], 0),
    "far apart": fl.lines([[[0, 0, 0], [1, 0, 0]], [[1e6, 1e6, 1e6], [1e6 + 1, 1e6, 1e6]]]),
    "far from the origin": strand([[1e6, 1e6, 1e6], [1e6 + 0.5, 1e6, 1e6]]),
    "thickness of zero": strand(BENT).with_radius(0),
    "curve": fl.Curves.from_bezier(np.float32([[[0, 0, 0], [0, 0, 1], [0, 0, 2], [0, 0, 3]]])),
    "mesh and line": fl.Geometry(
        [fl.Triangles([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]]), fl.lines([[[2, 0, 0], [2, 0, 5]]])]
    ),
}
SCENES |= {f"bent, times {k:g}": strand(BENT * k) for k in (1e-42, 1e-38, 1e-30, 1e-9, 1e9, 9e29)}
SCENES |= {f"slender, times {k:g}": strand(SLENDER * k) for k in (1e-38, 1e-30, 9e29)}


@pytest.mark.parametrize("name", SCENES)
def test_a_picture_needs_no_options(name):
    scene = SCENES[name]
    plan = plan_picture(scene, PictureOptions(width=96, samples=1))
    assert plan.is_suitable
    assert plan.radius > 0
    picture = fl.render(scene, width=96, samples=1)
    assert picture.alpha.any()
    # Where the middle of each line is, there is something.
    middles = scene.bounds.mean(axis=0) if name == "mesh and line" else scene.span()[0]
    pixels, depth = plan.camera.project(middles, plan.width, plan.height)
    assert (depth > 0).all()
    assert ((pixels >= 0) & (pixels <= [plan.width, plan.height])).all()


def test_one_line_is_a_few_pixels_thick_and_a_point_is_a_dot():
    for name in ("along x", "along y", "along z", "slender", "from corner to corner"):
        size = float(np.ptp(SCENES[name].bounds, axis=0).max())
        plan = plan_picture(SCENES[name], PictureOptions())
        assert 1 / 1000 <= plan.radius / size <= 1 / 300, name
    for name in ("point", "point at the origin", "coincident points"):
        assert 0.002 < (fl.render(SCENES[name], width=200, samples=1).alpha > 0).mean() < 0.02


def test_the_radius_grows_with_the_scene():
    camera = default_camera(strand(BENT))
    assert suitable_radius(fl.build(strand(BENT)), camera) == 0.002
    for power in (-30, -3, 3, 29):
        lines = strand(BENT * 10.0**power)
        assert suitable_radius(fl.build(lines), default_camera(lines)) == pytest.approx(0.002 * 10.0**power)


def test_hair_is_at_most_two_pixels_thick():
    strands = fl.scenes.make("bun-hair", 2000).lines
    size = float(np.ptp(strands.bounds, axis=0).max())
    hair, fibres = (plan_picture(strands, PictureOptions(look=look)) for look in ("hair", "fibre"))
    assert hair.radius <= 1.5 / 1000 * size
    assert hair.radius < fibres.radius


@pytest.mark.parametrize("name", ["bent, times 1e+09", "slender", "along x", "point", "mesh and line"])
@pytest.mark.parametrize("turns", [False, True])
def test_a_camera_frames_lines_of_any_radius(name, turns):
    scene = SCENES[name]
    size = float(np.ptp(scene.bounds, axis=0).max()) or 1.0
    for share in (0.01, 0.3, 2.0):
        options = PictureOptions(camera=ViewOptions(turns=turns), width=160, radius=share * size, look="id", samples=1)
        alpha = draw(plan_picture(scene, options)).alpha
        edges = np.concatenate([alpha[0], alpha[-1], alpha[:, 0], alpha[:, -1]])
        assert not edges.any()
        assert alpha.any()


def test_lines_are_not_seen_end_on():
    for corner in ([1, 1, 1], [-1, 1, 1], [1, -1, 1], [1, 1, -1]):
        direction, _ = default_view(strand([[0, 0, 0], corner]))
        along = np.dot(direction, corner) / np.linalg.norm(direction) / np.linalg.norm(corner)
        assert abs(along) < 0.6


@pytest.mark.usefixtures("in_own_folder")
@pytest.mark.parametrize("name", ["along z", "slender", "point", "far apart"])
def test_the_command_line_needs_no_options_either(name):
    fl.write("a.npz", SCENES[name])
    for options in ((), ("--levels", 2), ("--look", "depth"), ("--turntable", 2), ("--look", "hits")):
        size = () if "--levels" in options else ("--width", 24)
        assert run("render", "a.npz", "-o", "a.png", *size, *options).exit_code == 0, options
    told = run("info", "a.npz", "--picture")
    assert told.exit_code == 0
    assert f"radius for pictures {plan_picture(SCENES[name], PictureOptions()).radius:g}\n" in told.stdout


@pytest.mark.usefixtures("in_own_folder")
@pytest.mark.filterwarnings("default")
def test_a_track_is_a_map_in_pictures():
    points = "".join(
        f'<trkpt lat="{46.5 + i * 1e-4}" lon="{13.7 + i * 2e-4}"><ele>{900 + 7 * i}</ele></trkpt>' for i in range(40)
    )
    with open("walk.gpx", "w") as file:
        file.write(f'<gpx version="1.1" creator="x"><trk><trkseg>{points}</trkseg></trk></gpx>')
    flat = fl.read("walk.gpx", elevation=False)
    shortened = np.cos(np.radians(float(flat.bounds[:, 1].mean())))
    flat = dataclasses.replace(flat, segments=flat.segments * np.float32([shortened, 1, 1]))
    made = run("render", "walk.gpx", "-o", "walk.png", "--width", 32)
    assert made.exit_code == 0
    assert "pictures shorten degrees of longitude to 0.69 of their length, as at latitude 46.5°" in made.stderr
    assert "pictures leave z at 0, because x and y are in degrees, and z is in metres" in made.stderr
    assert f"radius {plan_picture(flat, PictureOptions(width=32)).radius:g}, which suits them" in made.stdout


@pytest.mark.usefixtures("in_own_folder")
@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize(("latitude", "is_noted"), [(5, False), (-9, True)])
def test_a_map_near_the_equator_is_not_said_to_be_shortened(latitude, is_noted):
    points = "".join(f'<trkpt lat="{latitude}" lon="{13.7 + i * 1e-3}"/>' for i in range(40))
    with open("walk.gpx", "w") as file:
        file.write(f'<gpx version="1.1" creator="x"><trk><trkseg>{points}</trkseg></trk></gpx>')
    made = run("render", "walk.gpx", "-o", "walk.png", "--width", 8)
    assert made.exit_code == 0
    assert ("degrees of longitude to 0.99 of their length, as at latitude -9°" in made.stderr) == is_noted
    assert ("longitude" in made.stderr) == is_noted


@pytest.mark.usefixtures("in_own_folder")
def test_the_help_of_the_radius_says_when_it_is_needed():
    texts = {name: " ".join(run(name, "--help").stdout.replace("│", " ").split()) for name in ("render", "query")}
    assert "by default 0, or for lines without one what suits them" in texts["render"]
    assert "lines without one need it" in texts["query"]
