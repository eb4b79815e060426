"""USD: curves of every type, basis and wrap, their widths and primvars, options and units."""

from __future__ import annotations

import re

import numpy as np
import pytest
from support.line_files import message_of
from support.usd_files import SEVEN, SQUARE, curves, usda, warned, xform

import fastlines as fl
from fastlines.errors import InputError

pytest.importorskip("pxr")


# --- Types, bases, wraps ---


def test_linear_curves(load):
    lines = load(usda(curves(SQUARE + SEVEN, [4, 7])), "a.usda")
    assert isinstance(lines, fl.Lines)
    np.testing.assert_array_equal(lines.segments[:3], np.float32([SQUARE[:-1], SQUARE[1:]]).swapaxes(0, 1))
    np.testing.assert_array_equal(lines.strands, [0] * 3 + [1] * 6)
    assert (lines.radius, lines.up, lines.unit, dict(lines.attributes)) == (None, "y", None, {})
    lines = load(usda(curves(SQUARE, [1, 3], wrap="pinned")), "a.usda")
    np.testing.assert_array_equal(lines.segments[0], [SQUARE[0]] * 2)
    assert len(lines) == 3


def test_closed_linear_curves(load):
    lines = load(usda(curves(SQUARE + SEVEN, [4, 0, 7], wrap="periodic", widths=("vertex", list(range(11))))), "a.usda")
    np.testing.assert_array_equal(lines.segments[3], [SQUARE[3], SQUARE[0]])
    np.testing.assert_array_equal(lines.segments[10], [SEVEN[6], SEVEN[0]])
    np.testing.assert_array_equal(lines.radius[3], [1.5, 0])
    np.testing.assert_array_equal(lines.strands, [0] * 4 + [2] * 7)


@pytest.mark.parametrize(
    ("basis", "wrap", "n"),
    [(basis, wrap, 7) for basis in ("bspline", "catmullRom") for wrap in ("nonperiodic", "periodic", "pinned")]
    + [("bezier", "nonperiodic", 7), ("bezier", "periodic", 6), ("bezier", "pinned", 7)],
)
def test_cubic_curves_are_those_of_from_strands(load, basis, wrap, n):
    points = np.array(SEVEN[:n] * 2, "f4") * 1.1 + 0.3
    width = np.linspace(0.1, 2, 2 * n, dtype="f4")
    more = f'float[] primvars:age = {list(range(2 * n))} (interpolation = "vertex")'
    data = usda(
        curves(points, [n, n], kind="cubic", basis=basis, wrap=wrap, widths=("vertex", [*map(float, width)]), more=more)
    )
    made = load(data, "a.usda")
    name = {"catmullRom": "catmull-rom"}.get(basis, basis)
    age = np.arange(2 * n, dtype="f4")
    expected = fl.Curves.from_strands(points, [n, n], basis=name, wrap=wrap, radius=width / 2, attributes={"age": age})
    np.testing.assert_array_equal(made.control, expected.control)
    np.testing.assert_array_equal(made.radius, expected.radius)
    np.testing.assert_array_equal(made.strands, expected.strands)
    np.testing.assert_array_equal(made.end_attributes["age"], expected.end_attributes["age"])


@pytest.mark.filterwarnings("ignore:.*its radius is up to:fastlines.FileWarning")
def test_hermite_curves(load):
    more = f"vector3f[] tangents = {[tuple(map(float, point)) for point in SQUARE]}"
    data = usda(curves(of="HermiteCurves", more=more, widths=("vertex", [2, 4, 6, 8])))
    made = load(data, "a.usda")
    expected = fl.Curves.from_strands(SQUARE, [4], basis="hermite", tangents=SQUARE, radius=[1, 2, 3, 4])
    np.testing.assert_array_equal(made.control, expected.control)
    np.testing.assert_array_equal(made.radius, expected.radius)
    made, text = warned(load, usda(curves(of="HermiteCurves")))
    assert len(made) == 0
    assert "left out, as it does not have one tangent for each point (/c)" in text


def test_lines_and_curves_make_a_geometry(load):
    made = load(usda(curves(name="a"), curves(SEVEN, name="b", kind="cubic"), curves(name="c")), "a.usda")
    assert [type(part) for part in made.parts] == [fl.Lines, fl.Curves]
    np.testing.assert_array_equal(made.parts[0].strands, [0] * 3 + [2] * 3)
    np.testing.assert_array_equal(made.parts[0].attributes["prim"], [0] * 3 + [2] * 3)
    np.testing.assert_array_equal(made.parts[1].strands, [1, 1])
    np.testing.assert_array_equal(made.parts[1].attributes["prim"], [1, 1])


def test_no_curves(load):
    made, text = warned(load, usda('def Mesh "m" {}\ndef Sphere "s" {}\ndef Xform "x" {}\ndef BasisCurves "c" {}'))
    assert (type(made), len(made)) == (fl.Lines, 0)
    assert "are not read: 1 Mesh, 1 Sphere" in text
    made, text = warned(load, usda('def NurbsCurves "n" {}', curves()))
    assert len(made) == 3
    assert "1 NurbsCurves" in text


# --- Widths and primvars ---


@pytest.mark.parametrize(
    ("widths", "radius"),
    [
        (("constant", [3]), [[1.5, 1.5]] * 4),
        (("uniform", [2, 4]), [[1, 1]] * 3 + [[2, 2]]),
        (("vertex", [0, 2, 4, 6, 8, 10]), [[0, 1], [1, 2], [2, 3], [4, 5]]),
        (("varying", [0, 2, 4, 6, 8, 10]), [[0, 1], [1, 2], [2, 3], [4, 5]]),
    ],
)
def test_widths_of_linear_curves_are_diameters(load, widths, radius):
    lines = load(usda(curves(SEVEN[:6], [4, 2], widths=widths)), "a.usda")
    np.testing.assert_array_equal(lines.radius, radius)


@pytest.mark.filterwarnings("ignore:.*its radius is up to:fastlines.FileWarning")
def test_varying_widths_of_cubic_curves_are_linear(load):
    data = usda(curves(SEVEN + SEVEN[:4], [7, 4], kind="cubic", widths=("varying", [0, 6, 18, 2, 8])))
    np.testing.assert_array_equal(load(data, "a.usda").radius, [[0, 1, 2, 3], [3, 5, 7, 9], [1, 2, 3, 4]])
    data = usda(curves(SEVEN[:6], kind="cubic", wrap="periodic", widths=("varying", [0, 6])))
    np.testing.assert_array_equal(load(data, "a.usda").radius, [[0, 1, 2, 3], [3, 2, 1, 0]])
    data = usda(curves(SEVEN[:5], kind="cubic", basis="bspline", wrap="pinned", widths=("varying", [0, 6, 0, 6, 0])))
    np.testing.assert_array_equal(load(data, "a.usda").radius, [[0, 1, 2, 3], [3, 2, 1, 0]] * 2)


def test_widths_whose_number_says_what_they_are(load):
    for values, found in [([3], "constant"), ([2, 4], "uniform")]:
        made, text = warned(load, usda(curves(SEVEN[:6], [4, 2], widths=("vertex", values))))
        assert f"its widths are {found} by their number, though called vertex (/c)" in text
        assert made.radius[0, 0] == values[0] / 2
    made, text = warned(load, usda(curves(SEVEN[:6], [4, 2], widths=("vertex", [1, 2, 3]))))
    assert made.radius is None
    assert "its widths are not read: their number does not fit the interpolation 'vertex' (/c)" in text


@pytest.mark.filterwarnings("ignore:.*its radius is up to:fastlines.FileWarning")
def test_primvars_come_before_widths(load):
    more = 'float[] primvars:widths = [8] (interpolation = "constant")'
    lines = load(usda(curves(widths=("constant", [2]), more=more)), "a.usda")
    np.testing.assert_array_equal(lines.radius, [[4, 4]] * 3)


@pytest.mark.parametrize("values", [[1, -1, 1, 1], ["nan"] * 4, [1, 1, 1, "inf"]])
def test_bad_widths(load, values):
    data = usda(curves(widths=("vertex", values))).replace(b"'", b"")
    assert re.search("widths of /c must be finite and not negative .see row", message_of(load, data, "a.usda"))


def test_primvars(load):
    more = """
        color3f[] primvars:displayColor = [(1, 0.5, 0)] (interpolation = "constant")
        float primvars:gain = 2
        int[] primvars:id = [7, 9] (interpolation = "uniform")
        double[] primvars:u = [0, 1, 2, 3, 4, 5] (interpolation = "varying")
        float[] primvars:pairs = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11] (elementSize = 2; interpolation = "vertex")
        half[] primvars:my:value = [0.5, 1] (interpolation = "vertex")
        int[] primvars:my:value:indices = [0, 1, 0, 1, 0, 1]
        string[] primvars:names = ["a", "b"] (interpolation = "uniform")
        float[] primvars:odd = [1, 2, 3] (interpolation = "vertex")
        float[] primvars:list = [1, 2, 3]
        float[] primvars:lost = [1] (interpolation = "vertex")
        int[] primvars:lost:indices = [0, 1, 0, 0, 0, 0]
        normal3f[] normals = [(1, 0, 0)] (interpolation = "constant")
    """
    lines, text = warned(load, usda(curves(SEVEN[:6], [4, 2], more=more)))
    assert sorted(lines.attributes) == ["displayColor", "gain", "id", "my:value", "pairs", "u"]
    np.testing.assert_array_equal(lines.attributes["displayColor"], [[1, 0.5, 0]] * 4)
    np.testing.assert_array_equal(lines.attributes["gain"], [2] * 4)
    np.testing.assert_array_equal(lines.attributes["id"], [7, 7, 7, 9])
    assert lines.attributes["id"].dtype == np.int32
    np.testing.assert_array_equal(lines.end_attributes["u"], [[0, 1], [1, 2], [2, 3], [4, 5]])
    np.testing.assert_array_equal(lines.end_attributes["pairs"][3], [[8, 9], [10, 11]])
    np.testing.assert_array_equal(lines.end_attributes["my:value"], [[0.5, 1], [1, 0.5], [0.5, 1], [0.5, 1]])
    for name in ("names", "lost"):
        assert f"primvar '{name}' is not read: it is not made of numbers, or its indices are wrong (/c)" in text
    assert "primvar 'odd' is not read: its number of values does not fit 'vertex'" in text
    assert "primvar 'list' is not read: its number of values does not fit 'constant'" in text
    assert "normals are not read (/c)" in text


def test_varying_primvars_of_cubic_curves(load):
    more = 'float[] primvars:u = [0, 1, 2, 5, 6] (interpolation = "varying")'
    made = load(usda(curves(SEVEN + SEVEN[:4], [7, 4], kind="cubic", more=more)), "a.usda")
    np.testing.assert_array_equal(made.end_attributes["u"], [[0, 1], [1, 2], [5, 6]])


def test_primvars_of_several_prims(load):
    a = 'float[] primvars:u = [1] (interpolation = "constant")\nfloat2[] primvars:v = [(1, 2)]\nint primvars:n = 1'
    b = 'float[] primvars:u = [0, 1, 2, 3] (interpolation = "vertex")\nfloat[] primvars:v = [1]\nint primvars:prim = 5'
    parent = xform(curves(name="a", more=a) + curves(name="b", more=b), more="").replace(
        "{", "{\ncolor3f[] primvars:displayColor = [(1, 2, 3)]\n", 1
    )
    lines, text = warned(load, usda(parent))
    np.testing.assert_array_equal(lines.end_attributes["u"], [[1, 1]] * 3 + [[0, 1], [1, 2], [2, 3]])
    np.testing.assert_array_equal(lines.attributes["n"], [1] * 3 + [np.nan] * 3)
    np.testing.assert_array_equal(lines.attributes["displayColor"], [[1, 2, 3]] * 6)
    np.testing.assert_array_equal(lines.attributes["prim"], [np.nan] * 3 + [5] * 3)
    assert "primvar 'n' is NaN on the prims that do not have it: 1" in text
    assert "primvar 'v' is not read: its values have different shapes on different prims" in text
    assert "primvar 'prim' is NaN on the prims that do not have it: 1" in text


def test_prims_without_widths_beside_others(load):
    lines, text = warned(load, usda(curves(name="a"), curves(name="b", widths=("constant", [2]))))
    np.testing.assert_array_equal(lines.radius, [[0, 0]] * 3 + [[1, 1]] * 3)
    assert "prims without widths have the radius 0 beside those with widths: 1" in text


# --- Options, units ---


def test_time(load):
    samples = "point3f[] points.timeSamples = {3: [(3, 0, 0), (0, 0, 0)], 5: [(5, 0, 0), (0, 0, 0)]}"
    data = usda(curves(SEVEN[:2], more=samples))
    for time, x in [(None, 3), (1, 3), (3, 3), (4, 4), (5, 5), (9.5, 5)]:
        assert load(data, "a.usda", time=time).segments[0, 0, 0] == x
    for time in ("1", np.nan, True):
        with pytest.raises(InputError, match=r"time=.*; expected a time code of the file"):
            load(data, "a.usda", time=time)


def test_prim(load):
    data = usda(xform(curves(name="a") + curves(SEVEN, name="b"), move=(1, 0, 0)), curves(name="c"))
    assert len(load(data, "a.usda", prim="/x/b")) == 6
    assert load(data, "a.usda", prim="/x/b").segments[0, 0, 0] == 1
    assert len(load(data, "a.usda", prim="/x")) == 9
    for prim in ("/y", "x", "", "/x/b.points", "not a path", "/"):
        if prim == "/":
            assert len(load(data, "a.usda", prim=prim)) == 12
            continue
        with pytest.raises(InputError, match=r"there is no prim '.*'; at the top of the file there is /x, /c"):
            load(data, "a.usda", prim=prim)
    with pytest.raises(InputError, match="prim=5; expected the path of a prim"):
        load(data, "a.usda", prim=5)
    with pytest.raises(InputError, match="the format 'usd' has no option 'frame'; known: time, prim"):
        load(data, "a.usda", frame=5)


@pytest.mark.parametrize(
    ("meters", "unit"),
    [("1", "m"), ("0.01", "cm"), ("0.001", "mm"), ("0.0254", "in"), ("0.5", "0.5 m"), ("1e-6", "µm")],
)
def test_units(load, meters, unit):
    lines = load(usda(curves(), head=f'metersPerUnit = {meters}\nupAxis = "Z"'), "a.usda")
    assert (lines.unit, lines.up) == (unit, "z")


@pytest.mark.parametrize("head", ["metersPerUnit = -1", "metersPerUnit = 0", 'upAxis = "X"'])
def test_units_that_are_none(load, head):
    lines, text = warned(load, usda(curves(), head=head))
    assert (lines.unit, lines.up) == (None, "y")
    assert "is not used" in text
