"""One plan for Python and the command line: the look, the size, the camera and the radius of a picture."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from PIL import Image
from support.command_line import done

import fastlines as fl
from fastlines.rendering import PictureOptions, ViewOptions, default_camera, plan_picture, turntable, turntable_camera

LINES = fl.scenes.make("spaghetti", 3000).lines
TREE = fl.build(LINES)


def test_a_plan_chooses_what_is_not_given():
    plan = plan_picture(LINES, PictureOptions(width=300))
    assert (plan.width, plan.height, plan.is_suitable) == (300, 300, True)
    assert plan.camera == default_camera(LINES)
    given = plan_picture(TREE, PictureOptions(camera=plan.camera, radius=0.1, height=20, look="tube"))
    assert (given.tree, given.camera, given.radius, given.is_suitable) == (TREE, plan.camera, 0.1, False)
    assert (given.width, given.height, given.look.has_ground) == (20, 20, True)
    turns = plan_picture(TREE, PictureOptions(camera=ViewOptions(turns=True, fov_degrees=20), width=30, height=10))
    assert turns.camera == turntable_camera(LINES, fov_degrees=20, aspect=3)
    assert plan_picture(TREE, PictureOptions(), radii=(0.3, 0.4)).radius == 0.3


@pytest.mark.usefixtures("in_own_folder")
@pytest.mark.parametrize("source", ["scene:spaghetti:3000", "tree.flt"])
def test_pictures_of_the_command_line_are_those_of_python(source):
    TREE.save("tree.flt")
    done("render", source, "--width", 24, "-s", 1, "-o", "one.png")
    assert (np.asarray(Image.open("one.png")) == fl.render(TREE, width=24, samples=1).to_bytes()).all()
    done("render", source, "--width", 24, "-s", 1, "--turntable", 2, "-o", "turn.png")
    for i, picture in enumerate(turntable(TREE, 2, width=24, samples=1)):
        assert (np.asarray(Image.open(f"turn_000{i + 1}.png")) == picture.to_bytes()).all()
    radius = plan_picture(TREE, PictureOptions()).radius
    assert f"radius for pictures {radius:g}\n" in done("info", "scene:spaghetti:3000")


def test_warnings_name_the_line_of_the_caller():
    lines = fl.Lines.from_segments(LINES.segments[:9], attributes={"strand": np.arange(9)})
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        fl.render(lines, look="tube", color="strand", width=8, height=8, samples=1)
        turntable(lines, 2, look="tube", color="strand", width=8, height=8)
    assert [each.filename for each in caught] == [__file__] * 2
