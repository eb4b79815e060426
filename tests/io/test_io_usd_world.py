"""USD: where curves are in the world, and how often; what is hidden."""

from __future__ import annotations

import numpy as np
import pytest
from support.line_files import message_of
from support.usd_files import SEVEN, curves, instancer, usda, warned, xform

import fastlines.io.formats.usd_scene

pytest.importorskip("pxr")


# --- The world ---


def test_transforms_scale_widths(load):
    inner = xform(curves(widths=("constant", [2])), move=(1, 2, 3), scale=(3, 3, 3))
    lines = load(usda(xform(inner, name="outer", move=(10, 0, 0), scale=(-1, 1, 1))), "a.usda")
    np.testing.assert_array_equal(lines.segments[0], [[9, 2, 3], [6, 2, 3]])
    np.testing.assert_allclose(lines.radius, 3)
    lines, text = warned(load, usda(xform(curves(widths=("constant", [2])), scale=(1, 2, 4))))
    np.testing.assert_allclose(lines.radius, 2)
    assert "scaled by different factors along its axes; its radius is scaled by their geometric mean (/x/c)" in text
    assert warned(load, usda(xform(curves(), scale=(1, 2, 4))))[1] == ""


def test_reset_of_the_transform(load):
    order = 'uniform token[] xformOpOrder = ["!resetXformStack!", "xformOp:translate"]'
    more = f"double3 xformOp:translate = (5, 0, 0)\n{order}"
    lines = load(usda(xform(curves(more=more), move=(100, 0, 0))), "a.usda")
    np.testing.assert_array_equal(lines.segments[0, 0], [5, 0, 0])


def test_instances(load):
    asset = f'class Xform "_asset" {{\n{curves(widths=("constant", [2]))}}}\n'
    places = "".join(
        xform(
            "", name=f"i{i}", move=(10 * i, 0, 0), scale=(i, i, i), more="(instanceable = true; inherits = </_asset>)"
        )
        for i in (1, 2)
    )
    lines = load(usda(asset, places), "a.usda")
    np.testing.assert_array_equal(lines.segments[[0, 3], 1, 0], [11, 22])
    np.testing.assert_allclose(lines.radius[:, 0], [1] * 3 + [2] * 3)
    np.testing.assert_array_equal(lines.attributes["prim"], [0] * 3 + [1] * 3)


def test_point_instancer(load):
    scales = "float3[] scales = [(1, 1, 1), (2, 2, 2), (3, 3, 3)]"
    a = xform(curves(widths=("constant", [2])), name="a", move=(0, 5, 0))
    data = usda(
        xform(instancer(a + curves(SEVEN[:2], name="b"), more=scales), move=(0, 0, 7)).replace("</p/", "</x/p/")
    )
    lines, text = warned(load, data)
    assert "radius 0" in text
    np.testing.assert_array_equal(lines.strands, [0] * 3 + [1] * 3 + [2])
    np.testing.assert_array_equal(lines.segments[[0, 3, 6], 0], [[10, 5, 7], [30, 15, 7], [20, 0, 7]])
    np.testing.assert_allclose(lines.radius[:, 0], [1] * 3 + [3] * 3 + [0])
    np.testing.assert_array_equal(lines.attributes["prim"], [0] * 3 + [1] * 3 + [2])


def test_point_instancer_in_a_point_instancer(load):
    inner = instancer(curves(SEVEN[:2], name="a"), name="q", indices=(0, 0), targets="</p/q/a>")
    lines = load(usda(instancer(inner, indices=(0, 0), targets="</p/q>")), "a.usda")
    np.testing.assert_array_equal(lines.segments[:, 0, 0], [20, 30, 30, 40])
    np.testing.assert_array_equal(lines.strands, range(4))


MOTION = {
    "velocities": "vector3f[] velocities.timeSamples = { 3: [(0, 0, 1), (0, 7, 0)] }",
    "accelerations": "vector3f[] accelerations.timeSamples = { 3: [(0, 1, 0), (9, 0, 0)] }",
    "angularVelocities": "vector3f[] angularVelocities.timeSamples = { 3: [(0, 0, 50), (20, 0, 0)] }",
    "values without samples": "vector3f[] velocities = [(0, 0, 1), (0, 7, 0)]",
}


@pytest.mark.parametrize("time", [None, 3])
@pytest.mark.parametrize("names", [*([name] for name in MOTION), ["velocities", "accelerations", "angularVelocities"]])
def test_moving_point_instancers_stand_still_at_the_default_time(load, names, time):
    places = (
        "point3f[] positions.timeSamples = { 3: [(5, 0, 0), (0, 6, 0)], 4: [(6, 0, 0), (0, 6, 0)] }\n"
        "quath[] orientations.timeSamples = { 3: [(1, 0, 0, 0), (0, 0, 0, 1)] }\n"
        "float3[] scales.timeSamples = { 3: [(1, 1, 1), (2, 2, 2)] }\n"
    )
    inside = places + "\n".join(MOTION[name] for name in names) + "\n" + curves([(0, 0, 0), (1, 0, 0)], name="a")
    data = instancer("", indices=(0, 0), targets="</p/a>").replace("point3f[] positions", "point3f[] unused")
    lines, text = warned(load, usda(data.removesuffix("}\n") + inside + "}\n"), time=time)
    assert time or not text  # at a time, USD asks for velocities with the same samples as positions
    # The second instance is turned by half a turn about z.
    np.testing.assert_array_equal(lines.segments, np.float32([[[5, 0, 0], [6, 0, 0]], [[0, 6, 0], [-2, 6, 0]]]))


@pytest.mark.parametrize("before", ["held", "linear", "sloped(2)", "loop repeat", "none"])
def test_splines_are_read_at_their_first_knot_at_the_default_time(load, before):
    pytest.importorskip("pxr.Ts")
    spline = f"{{ bezier, pre: {before}, 1: 5; post linear, 2: 10; post linear }}"
    more = (
        f"double xformOp:translateX.spline = {spline}\ndouble primvars:q.spline = {spline}\n"
        'uniform token[] xformOpOrder = ["xformOp:translateX"]'
    )
    data = usda(xform(curves(SEVEN[:2], more=more), move=(0, 0, 7), scale=(2, 2, 2)))
    lines = load(data, "a.usda")
    np.testing.assert_array_equal(lines.segments, np.float32([[[10, 0, 7], [12, 2, 9]]]))
    np.testing.assert_array_equal(lines.attributes["q"], [5])
    np.testing.assert_array_equal(load(data, "a.usda", time=1.5).segments[0, 0], [15, 0, 7])


def test_odd_point_instancers(load):
    masked = "int64[] invisibleIds = [1]\nint64[] ids = [4, 1, 5]\n"
    lines, text = warned(load, usda(instancer(curves(SEVEN[:2], name="a"), more=masked, indices=(0, 0, 7))))
    np.testing.assert_array_equal(lines.segments[:, 0, 0], [10])
    assert "some instances are left out, as they are inactive or invisible (/p)" in text
    assert "some instances are left out, as they have no prototype (/p)" in text
    data = usda(instancer(curves(name="a"))).replace(b"[0, 1, 0]", b"[0, 1]")
    assert "left out: it does not have one position for each instance (/p)" in warned(load, data)[1]
    lines, text = warned(load, usda(instancer(curves(SEVEN[:2], name="a"), targets="</p>, </p/a>")))
    assert "left out, as it is among its own prototypes (/p)" in text
    assert len(lines) == 1


def test_what_is_invisible(load):
    hidden = 'token visibility = "invisible"'
    data = usda(xform(curves(name="a") + curves(name="b")).replace("{", "{" + hidden, 1), curves(name="c"))
    lines, text = warned(load, data)
    assert len(lines) == 3
    assert "left out, as it is invisible (2 prims, such as /x/a)" in text
    lines, text = warned(
        load, usda(curves(more='uniform token purpose = "guide"'), 'over "o" {}', curves(name="i") + "\n")
    )
    assert len(lines) == 6
    assert "is read, though its purpose is 'guide'; prim= reads a part (/c)" in text
    assert len(load(usda(curves().replace('"c"', '"c" (active = false)')), "a.usda")) == 0


def test_instances_without_end_are_refused(load, monkeypatch):
    monkeypatch.setattr(fastlines.io.formats.usd_scene, "UNPACK_BYTES", 1 << 18)
    levels = "".join(
        f'class "l{i}" {{\n'
        + "".join(f'def "c{j}" (instanceable = true; inherits = </l{i + 1}>) {{}}\n' for j in range(10))
        + "}\n"
        for i in range(8)
    )
    data = usda(levels, f'class "l8" {{\n{curves()}}}\n', 'def "top" (inherits = </l0>) {}')
    assert "its instances make more than" in message_of(load, data, "a.usda")
    many = "[" + ", ".join(["0"] * 300) + "]"
    places = "[" + ", ".join(["(0, 0, 0)"] * 300) + "]"
    nested = curves(name="a")
    for _ in range(4):
        nested = (
            f'def PointInstancer "a" {{\nint[] protoIndices = {many}\npoint3f[] positions = {places}\n'
            f"rel prototypes = <a>\n{nested}}}\n"
        )
    assert "its instances make more than" in message_of(load, usda(nested), "a.usda")
