"""Queries of the command line take what those of Python take: files of lines, and all options of rays."""

from __future__ import annotations

import inspect

import numpy as np
import pytest
from support.command_line import done, refused, run

import fastlines as fl
from fastlines.cli.query import query
from fastlines.query.ray_arguments import RayOptions

pytestmark = pytest.mark.usefixtures("in_own_folder")

LINES = fl.scenes.make("spaghetti", 300).lines
THICK = fl.Lines.from_strands(
    [np.float32([[0, i, 0], [1, i, 0], [2, i, 1]]) for i in range(3)], invalid="error"
).with_radius(0.2)
TREE, THICK_TREE = fl.build(LINES), fl.build(THICK)


@pytest.fixture(autouse=True)
def files(in_own_folder):
    """Write lines, lines with a radius, a tree over them, and rays."""
    fl.write("lines.npz", LINES)
    fl.write("thick.npz", THICK)
    THICK_TREE.save("thick.flt")
    rng = np.random.default_rng(3)
    rays = np.float32(np.concatenate([rng.random((50, 3)), rng.normal(size=(50, 3))], axis=1))
    np.save("rays.npy", rays)
    return rays[:, :3], rays[:, 3:]


def answer(*args):
    """Run a query, and return its arrays."""
    done("query", *args, "-o", "out.npz")
    with np.load("out.npz") as out:
        return dict(out)


def same(told, hits):
    return all(np.array_equal(told[name], getattr(hits, name)) for name in told) and "prim" in told


def test_a_file_of_lines_and_a_scene_are_queried_without_a_tree_file(files):
    assert same(answer("lines.npz", "rays.npy", "-r", 0.1), TREE.first_hit(*files, 0.1))
    scene = fl.build(fl.scenes.make("spaghetti", 300).lines)
    assert same(answer("scene:spaghetti:300", "rays.npy", "-r", 0.1, "-k", "all"), scene.all_hits(*files, 0.1))
    assert done("query", "lines.npz", "--camera", "8x6", "-r", 0.1).startswith("lines.npz: 48 rays, ")
    assert "lines have no radius of their own" in refused("query", "lines.npz", "rays.npy")[1]


def test_options_are_those_of_python(files):
    strands = np.arange(100) % 7
    np.save("each.npy", strands.reshape(50, 2))
    common = "lines.npz", "rays.npy", "-r", 0.1
    for given, of_python in (
        (("--spread", 0.05), {"spread": 0.05}),
        (("--ignore", "3,17,-1"), {"ignore": [3, 17, -1]}),
        (("--ignore-strands", "0"), {"ignore_strands": [0]}),
        (("--ignore-strands", "each.npy"), {"ignore_strands": strands.reshape(50, 2)}),
        (("--t-min", 0.1, "--t-max", 0.9), {"t_min": 0.1, "t_max": 0.9}),
    ):
        assert same(answer(*common, "-k", "all", *given), TREE.all_hits(*files, 0.1, **of_python)), given
    entered = answer("thick.npz", "rays.npy", "-r", 0.1, "-k", "all", "--at", "entry", "--t-min", 0.5)
    assert same(entered, THICK_TREE.all_hits(*files, 0.1, at="entry", t_min=0.5))
    nearest = TREE.next_hits(*files, 0.1, k=2, rank="distance")
    assert same(answer(*common, "-k", "next", "--nearest", 2, "--rank", "distance"), nearest)
    merged = THICK_TREE.all_hits(*files, 0.1, at="surface", merge="strand")
    assert len(merged) < len(THICK_TREE.all_hits(*files, 0.1, at="surface"))
    whole = "thick.npz", "rays.npy", "-r", 0.1, "-k", "all", "--at", "surface", "--merge", "strand"
    assert same(answer(*whole), merged)
    assert same(answer("lines.npz", "rays.npy", "--spread", 0.05), TREE.first_hit(*files, spread=0.05))


def test_every_option_of_rays_is_on_the_command_line():
    elsewhere = {"progress", "invalid"}  # a bar if stderr is a terminal; bad rays are refused
    assert RayOptions.__annotations__.keys() - elsewhere <= inspect.signature(query).parameters.keys()


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (("--rank", "t"), "--rank does not apply: this is --kind first, and only next chooses hits"),
        (("--merge", "strand"), "--merge does not apply: this is --kind first, and only all lists what can be merged"),
        (("-k", "next", "--nearest", 1, "--rank", "x"), "rank='x'"),
        (("-k", "all", "--merge", "strand"), "at='surface'"),
        (("--ignore", "1,x"), "--ignore '1,x' is not whole numbers separated by commas"),
        (("--ignore", "300"), "ignore names 300; there are 300 primitives"),
        (("--ignore", "no.npy"), "no.npy"),
        (("--spread", "-1"), "is not a finite number that is 0 or more"),
        (("--no-own-radius",), "lines.npz: has no radius of its own; leave out --no-own-radius"),
    ],
)
def test_what_does_not_apply_is_refused(given, words):
    assert words in refused("query", "lines.npz", "rays.npy", "-r", 0.1, *given)[1]


# --- The radius that lines have of their own ---


@pytest.mark.parametrize("source", ["thick.npz", "thick.flt"])
def test_the_own_radius_can_be_left_out_or_replaced(source, files):
    bare = fl.build(THICK, own_radius=False)
    rays = *files, 0.05
    assert same(answer(source, "rays.npy", "-r", 0.05, "-k", "all"), THICK_TREE.all_hits(*rays))
    assert same(answer(source, "rays.npy", "-r", 0.05, "-k", "all", "--no-own-radius"), bare.all_hits(*rays))
    assert "have no radius of their own" in refused("query", source, "rays.npy", "--no-own-radius")[1]
    done("build", source, "--no-own-radius", "-o", "bare.flt")
    assert fl.load("bare.flt").geometry.radius is None
    told = done("info", source, "--no-own-radius")
    assert "radius              none" in told
    assert "radius for pictures" in told
    assert "radius for pictures" not in done("info", source)
    size = "--width", 24, "-s", 1, "-o", "a.png"
    assert "and their own" in done("render", source, *size)
    assert "which suits them" in done("render", source, "--no-own-radius", *size)
    assert "radius 0.01\n" in done("render", source, "--no-own-radius", "--radius", 0.01, *size) + "\n"


def test_the_own_radius_of_other_kinds():
    mesh = fl.Triangles([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]])
    curves = fl.Curves.from_bezier(np.float32([[[0, 0, 0], [0, 0, 1], [0, 1, 2], [0, 0, 3]]]), radius=0.1)
    fl.write("curves.npz", curves)
    done("build", "curves.npz", "--no-own-radius", "-o", "bare.flt")
    assert fl.load("bare.flt").geometry.radius is None
    fl.build(fl.Geometry([mesh, curves])).save("parts.flt")
    message = refused("query", "parts.flt", "rays.npy", "--no-own-radius", "-r", 1)[1]
    assert "is a tree over Geometry, whose boxes hold its radius" in message
    assert "leave out --no-own-radius" in refused("build", "bare.flt", "--no-own-radius")[1]


# --- What info finds of a large file ---


def test_info_leaves_out_what_takes_long_unless_it_is_asked_for(monkeypatch):
    small = done("info", "lines.npz")
    monkeypatch.setattr("fastlines.cli.info.QUICK", 100)
    quick, full = done("info", "lines.npz"), done("info", "lines.npz", "--full")
    assert small == full
    hidden = [line for line in full.splitlines() if line not in quick.splitlines()]
    assert [line.split()[1:-1] for line in hidden] == [["duplicates"], ["radius", "for", "pictures"]]
    assert quick.endswith("         --full counts duplicates, and finds a radius for pictures\n")
    assert done("info", "thick.npz") == done("info", "thick.npz", "--full")
    monkeypatch.setattr("fastlines.cli.info.QUICK", 1)
    assert done("info", "thick.npz").endswith("         --full counts duplicates\n")
    assert "n_duplicates" not in done("info", "lines.npz", "--json")
    assert "n_duplicates" in done("info", "lines.npz", "--json", "--full")
    assert "radius for pictures" in done("info", "lines.npz", "--picture")


def test_info_builds_no_tree_unless_it_is_asked_for(monkeypatch):
    monkeypatch.setattr("fastlines.cli.info.QUICK", 100)
    monkeypatch.setattr(fl, "build", None)
    assert "segments            300" in done("info", "lines.npz")
    assert run("info", "lines.npz", "--full").exit_code != 0
    assert "duplicates          0" in done("info", "thick.npz")
