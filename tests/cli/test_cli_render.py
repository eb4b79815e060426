"""``fastlines render``: the view, the files, the materials and the lights."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image
from support.command_line import done, refused

pytestmark = pytest.mark.usefixtures("in_own_folder")


def test_render_looks_where_it_is_told(tree_file):
    options = ("-r", 0.01, "--width", 24, "--height", 24, "--samples", 1)
    pictures = []
    for look in (("0,0,-1", "0,1,0"), ("0,-1,0", "0,0,1")):
        done("render", tree_file, *options, "--direction", look[0], "--up", look[1], "--fov", 20, "-o", "a.png")
        pictures.append(np.asarray(Image.open("a.png")))
    assert (pictures[0] != pictures[1]).any()


def test_render_takes_materials_and_lights(tree_file):
    plain = ("-r", 0.01, "--width", 24, "--height", 24, "--samples", 1, "-o", "a.png")
    size = (*plain, "--look", "tube")
    pictures = []
    for options in (
        (),
        ("--material", "metal"),
        ("--variation", 0.9),
        ("--no-ground",),
        ("--rig", "soft"),
    ):
        done("render", tree_file, *size, *options)
        pictures.append(np.asarray(Image.open("a.png")))
    assert all((pictures[0] != other).any() for other in pictures[1:])
    done("render", tree_file, *plain, "--look", "hits", "--legend-title", "lines")
    for options, said in (
        (("--material", "gold"), "material='gold' is not a choice"),
        (("--rig", "night"), "there is no rig 'night'"),
        (("--no-legend", "--legend-title", "x"), "--no-legend and --legend-title are both given"),
        (("--legend-title", "x"), "--legend-title does not apply: such colours have no legend"),
    ):
        assert said in refused("render", tree_file, *size, *options)[1]


def test_render_exr(tree_file):
    openexr = pytest.importorskip("OpenEXR")
    done("render", tree_file, "-r", 0.02, "-o", "a.exr", "--width", 20, "--height", 10)
    with openexr.File("a.exr") as file:
        depth = file.channels()["Z"].pixels
    assert depth.shape == (10, 20)
    assert np.isfinite(depth).any()
