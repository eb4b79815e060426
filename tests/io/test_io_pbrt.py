"""Curves of pbrt scenes: parameters, transforms, instances and included files."""

from __future__ import annotations

import contextlib
import gzip
import time

import numpy as np
import pytest
from support.line_files import message_of
from support.mutations import mutate

import fastlines as fl
from fastlines.io.formats import pbrt_transform

POINTS = np.array([[0, 0, 0], [1, 0, 0], [2, 1, 0], [3, 0, 0]], "f4")
P = b' "point3 P" [ 0 0 0  1 0 0  2 1 0  3 0 0 ]'
CURVE = b'\nShape "curve"' + P

SCENE = (
    b"""# by hand
LookAt 0 0 5  0 0 0  0 1 0
Camera "perspective" "float fov" [ 45 ]
Film "rgb" "string filename" "a.exr" "integer xresolution" [ 9 ]
WorldBegin
LightSource "infinite" "rgb L" [ .4 .45 .5 ] "bool x" true
MakeNamedMaterial "m" "string type" [ "hair" ]
AttributeBegin
  Translate 1 2 3 Scale 2 2 2 # bigger
  Shape "curve" "string type" [ "cylinder" ] "point3 P" [ 0 0 0  1 0 0  2 1 0  3 0 0 ]
    "float width0" [ 0.5 ] "float width1" 0.1
AttributeEnd
"""
    + CURVE
    + b"\n"
)


def test_a_scene_of_version_4(load):
    curves = load(SCENE, "a.pbrt")
    np.testing.assert_array_equal(curves.control, [POINTS * 2 + np.array([1, 2, 3], "f4"), POINTS])
    np.testing.assert_allclose(curves.radius[:, [0, 3]], [[0.5, 0.1], [0.5, 0.5]], rtol=1e-6)
    np.testing.assert_array_equal(curves.strands, [0, 1])
    packed = load(gzip.compress(SCENE.replace(b"\n", b"\r\n")), "a.pbrt.gz")
    np.testing.assert_array_equal(packed.control, curves.control)


def test_a_scene_of_version_3(load):
    text = b'WorldBegin Attribute "shape" "float width" 4 Shape "curve" "point P" [0 0 0 1 0 0 2 1 0 3 0 0] WorldEnd'
    curves = load(text, "a.pbrt")
    np.testing.assert_array_equal(curves.control, [POINTS])
    np.testing.assert_array_equal(curves.radius, [[2] * 4])


@pytest.mark.parametrize(
    "parameters",
    [
        b'"float width0"[2]"float width1"[4]' + P,
        P + b' # a comment\n "float width" 2 "float width1" [ 4 # another ]\n ]',
        P + b' "float width1" 4 "float width0" [ 2e0 ] "integer depth" 3 "normal N" [] "bool b" [true] "x y" ["a" "b"]',
        P.replace(b" ", b"\n\t ").replace(b"point3\n\t P", b"point3  P") + b'"float width0" +2. "float width1" 4',
    ],
)
def test_parameters_in_any_form(load, parameters):
    curves = load(b'Shape "curve"' + parameters + CURVE, "a.pbrt")
    np.testing.assert_array_equal(curves.control, [POINTS, POINTS])
    np.testing.assert_allclose(curves.radius, [[1, 4 / 3, 5 / 3, 2], [0.5] * 4], rtol=1e-6)


def evaluate(curves: fl.Curves, u: float) -> np.ndarray:
    return curves.evaluate(np.arange(len(curves)), u).points


@pytest.mark.parametrize("basis", ["bezier", "bspline"])
@pytest.mark.parametrize("degree", [2, 3])
@pytest.mark.filterwarnings("ignore:.*its radius is up to:fastlines.FileWarning")
def test_bases_and_degrees(load, basis, degree):
    points = np.random.default_rng(degree).random((7, 3))
    text = f'Shape "curve" "string basis" "{basis}" "integer degree" {degree} "float width0" 0 "float width1" [ 12 ] '
    text += f'"point3 P" [ {" ".join(map(str, points.reshape(-1)))} ]'
    curves = load(text.encode(), "a.pbrt")
    n = {("bezier", 2): 3, ("bezier", 3): 2, ("bspline", 2): 5, ("bspline", 3): 4}[basis, degree]
    step = degree if basis == "bezier" else 1
    assert len(curves) == n
    np.testing.assert_array_equal(curves.strands, [0] * n)
    np.testing.assert_allclose(curves.radius[:, 0], np.arange(n) * 6 / n, rtol=1e-6)
    np.testing.assert_allclose(curves.radius[:, 3], np.arange(1, n + 1) * 6 / n, rtol=1e-6)
    for u in (0, 0.3, 1):
        if basis == "bezier":
            weights = [(1 - u) ** 2, 2 * u * (1 - u), u**2]
            if degree == 3:
                weights = [(1 - u) ** 3, 3 * u * (1 - u) ** 2, 3 * u**2 * (1 - u), u**3]
        else:
            weights = [(1 - u) ** 2 / 2, (1 + 2 * u - 2 * u**2) / 2, u**2 / 2]
            if degree == 3:
                weights = [
                    (1 - u) ** 3 / 6,
                    (3 * u**3 - 6 * u**2 + 4) / 6,
                    (-3 * u**3 + 3 * u**2 + 3 * u + 1) / 6,
                    u**3 / 6,
                ]
        expected = [np.array(weights) @ points[i * step : i * step + degree + 1] for i in range(n)]
        np.testing.assert_allclose(evaluate(curves, u), expected, rtol=1e-5)


@pytest.mark.parametrize(
    ("moves", "matrix"),
    [
        (b"Translate 1 2 3", [[1, 0, 0, 1], [0, 1, 0, 2], [0, 0, 1, 3]]),
        (b"Translate 1 2 3 Identity", np.eye(4)[:3]),
        (b"Rotate 90 0 0 1", [[0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0]]),
        (b"Translate 1 0 0 Rotate 90 0 0 2", [[0, -1, 0, 1], [1, 0, 0, 0], [0, 0, 1, 0]]),
        (b"Scale 9 9 9 Transform [ 0 1 0 0 -1 0 0 0 0 0 1 0 5 6 7 1 ]", [[0, -1, 0, 5], [1, 0, 0, 6], [0, 0, 1, 7]]),
        (
            b"Translate 1 0 0 ConcatTransform [0 2 0 0 -2 0 0 0 0 0 2 0 10 12 14 2]",
            [[0, -1, 0, 6], [1, 0, 0, 6], [0, 0, 1, 7]],
        ),
        (b"LookAt 0 0 5 0 0 0 0 1 0", [[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -1, 5]]),
        (
            b'Translate 1 0 0 CoordinateSystem "a" Scale 9 1 1 CoordSysTransform "a"',
            [[1, 0, 0, 1], [0, 1, 0, 0], [0, 0, 1, 0]],
        ),
        (b'Translate 0 0 2 Camera "x" CoordSysTransform "camera"', [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, -2]]),
        (b"Scale 9 9 9 WorldBegin TransformBegin Scale 7 7 7 TransformEnd", np.eye(4)[:3]),
        (b"AttributeBegin Scale 9 9 9 AttributeEnd ReverseOrientation", np.eye(4)[:3]),
    ],
)
def test_transforms(load, moves, matrix):
    curves = load(moves + CURVE, "a.pbrt")
    matrix = np.array(matrix, np.float64)
    np.testing.assert_allclose(curves.control[0], POINTS @ matrix[:, :3].T + matrix[:, 3], rtol=1e-6, atol=1e-6)
    np.testing.assert_array_equal(curves.radius, [[0.5] * 4])


@pytest.mark.parametrize(("scale", "expected"), [(b"3 3 3", 3), (b"-2 2 2", 2), (b"1 1 1", 1)])
def test_widths_scale_with_the_transform(load, scale, expected):
    curves = load(b"Rotate 33 1 2 3 Scale " + scale + b" Rotate 5 0 1 0" + CURVE, "a.pbrt")
    np.testing.assert_allclose(curves.radius, [[expected / 2] * 4], rtol=1e-6)


@pytest.mark.parametrize(("scale", "expected"), [(b"1 8 1", 2), (b"0 1 1", 0)])
def test_uneven_scale_is_told(load, scale, expected):
    with pytest.warns(fl.FileWarning, match="scale 1 curves unevenly; their widths are scaled by the cube root"):
        curves = load(b"AttributeBegin Scale " + scale + CURVE + b" AttributeEnd" + CURVE, "a.pbrt")
    np.testing.assert_allclose(curves.radius[:, 0], [expected / 2, 0.5], rtol=1e-6)


def test_instances(load):
    text = b'Translate 1 0 0 ObjectBegin "a" Scale 2 2 2' + CURVE * 2 + b' ObjectEnd ObjectInstance "a"' + CURVE
    text += b' Translate 0 1 0 ObjectInstance "a"'
    curves = load(text, "a.pbrt")
    inner, one, two = POINTS * 2 + [1, 0, 0], [1, 0, 0], [1, 1, 0]
    np.testing.assert_array_equal(curves.control, np.stack([inner + one] * 2 + [POINTS + one] + [inner + two] * 2))
    np.testing.assert_array_equal(curves.radius[:, 0], [1, 1, 0.5, 1, 1])
    np.testing.assert_array_equal(curves.strands, range(5))
    assert len(load(b'ObjectBegin "a"' + CURVE + b" ObjectEnd", "a.pbrt")) == 0


def test_instances_that_would_fill_the_memory(load):
    text = b'ObjectBegin "a" ' + CURVE * 3000 + b" ObjectEnd " + b'ObjectInstance "a" ' * 9000
    assert "its instances would make 27000000 curves" in message_of(load, text, "a.pbrt")


def test_included_files(load, tmp_path):
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "b.pbrt").write_bytes(CURVE + b" Translate 9 0 0")
    (tmp_path / "c.pbrt.gz").write_bytes(gzip.compress(b'Include "in/b.pbrt"'))
    curves = load(b'Include "c.pbrt.gz" Import "in/b.pbrt"' + CURVE, "a.pbrt")
    np.testing.assert_array_equal(curves.control[:, 0, 0], [0, 9, 9])


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("gone.pbrt", "line 2: includes 'gone.pbrt', which is not there; put it there"),
        ("in", "which is not there"),
        ("../a.pbrt", "which is not in its own folder"),
        ("/a.pbrt", "which is not in its own folder"),
        ("", "which is not in its own folder"),
        ("a\0b", "which is not in its own folder"),
        ("a.pbrt", "at a depth of 32 files; they include each other"),
        ("bad.pbrt.gz", "which cannot be read"),
        ("wrong.pbrt", "included 'wrong.pbrt': line 1: 'what' is not a directive of pbrt"),
        ("x" * 5000, "which cannot be read"),
    ],
)
def test_files_that_cannot_be_included(load, tmp_path, name, said):
    (tmp_path / "in").mkdir()
    (tmp_path / "bad.pbrt.gz").write_bytes(b"what")
    (tmp_path / "wrong.pbrt").write_bytes(b"what")
    assert said in message_of(load, b'\nInclude "' + name.encode() + b'"', "a.pbrt")


def test_files_that_are_included_too_often(load, tmp_path):
    for name, inner in (("b", "c"), ("c", "d"), ("d", "e")):
        (tmp_path / f"{name}.pbrt").write_text(f'Include "{inner}.pbrt" ' * 100)
    (tmp_path / "e.pbrt").write_bytes(b"#" * 5000)
    assert "too often" in message_of(load, b'Include "b.pbrt"', "a.pbrt")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (b"hello", "line 1: 'hello' is not a directive of pbrt; fix the file"),
        (b'\n\nShape "curve" "float width" 2', "line 3: a curve has no parameter P"),
        (b"Shape curve", "the kind of a shape is 'curve'; expected a string"),
        (
            CURVE + b'Shape "curve" "point P" [1 2 3]',
            "curve 2 has 3 numbers in its P; expected 3 for each point, 4 points",
        ),
        (b'Shape "curve" "point P" [1 2 3 4 five 6]', "curve 1: '1 2 3 4 five 6' is not numbers"),
        (b'Shape "curve" "point P" [1 2 3 4 5 6', "a list does not end"),
        (b'Shape "curve" "point P" [' + b"1 " * 13 + b"]", "curve 1 has 13 numbers"),
        (b'Shape "curve" "point P" [' + b"1 " * 15 + b"]", "curve 1 has 15 numbers"),
        (b'Shape "curve" "P" [1 2 3]', '"P" is not the type and the name of a parameter'),
        (b'Shape "curve" "point P', "'\"point P' does not end"),
        (CURVE + b' "string basis" "catmull"', "a curve has a width, a basis or a degree that it cannot have"),
        (CURVE + b' "integer degree" [4]', "a basis or a degree that it cannot have"),
        (CURVE + b' "float width" [wide]', "a curve has a width, a basis or a degree"),
        (CURVE + b' "float width" -1', "widths of curves must be finite and not negative"),
        (b"Translate 1 2" + CURVE, "Translate has '1 2 Shape'; expected 3 numbers"),
        (b"Transform [1 0 0 1 0 1 0 0 0 0 1 0 0 0 0 1]", "the matrix of Transform is a projection"),
        (b"Transform [1 0 0]", "Transform has '1 0 0'; expected 16 numbers"),
        (b"Rotate 3 0 0 0" + CURVE, "widths of curves must be finite"),
        (b"AttributeEnd", "a block ends that does not begin"),
        (b"ObjectEnd", "an object ends that does not begin"),
        (b'ObjectBegin "a" ObjectBegin "b"', "an object begins inside another one"),
        (b'ObjectInstance "a"', "an instance of 'a' is inside an object, or there is no such object before it"),
        (
            b'ObjectBegin "a" ' + CURVE + b' ObjectEnd ObjectBegin "b" ObjectInstance "a"',
            "an instance of 'a' is inside an object",
        ),
        (b'CoordSysTransform "a"', "there is no coordinate system 'a'"),
        (b"[ 1 2 ]", "is not a directive"),
    ],
)
def test_what_is_wrong_is_refused(load, text, said):
    assert said in message_of(load, text, "a.pbrt")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            CURVE + b'Shape "sphere" Shape "trianglemesh" "integer indices" [0 1 2] Shape "sphere"',
            r"not curves \(2 sphere, 1 tri",
        ),
        (CURVE + b' "string type" "ribbon" "normal N" [0 0 1 0 0 1]', "its 1 ribbons are read as round curves"),
        (b"AttributeBegin" + CURVE, "1 of its blocks, such as AttributeBegin, do not end; it may be cut short"),
        (
            b"ActiveTransform EndTime Translate 9 9 9 ActiveTransform All" + CURVE,
            "transforms change with time; those of the",
        ),
    ],
)
def test_what_is_odd_is_told(load, text, said):
    with pytest.warns(fl.FileWarning, match=said) as told:
        curves = load(text, "a.pbrt")
    assert len(told) == 1
    np.testing.assert_array_equal(curves.control, [POINTS])


def test_nan_is_refused_or_skipped(load):
    text = CURVE + CURVE.replace(b"2 1 0", b"nan 1 0")
    with pytest.raises(fl.InputError, match="NaN"):
        load(text, "a.pbrt")
    assert len(load(text, "a.pbrt", invalid="skip")) == 1


def test_scene_without_curves(load):
    assert len(load(b"WorldBegin # nothing", "a.pbrt")) == 0


@pytest.mark.parametrize(
    "text", [b"[", b"[ 1 ", b'"a" ', b"# x\n", b'#]"[', b"AttributeBegin ", b'Shape "curve" "float x" ["a" "b"] ']
)
def test_long_nonsense_is_refused_quickly(load, text):
    start = time.perf_counter()
    with contextlib.suppress(fl.FileFormatError, fl.FileWarning):
        load(text * 50_000, "a.pbrt")
    assert time.perf_counter() - start < 20


def test_matrices_of_directions_that_are_none():
    assert np.isnan(pbrt_transform.look_at(0, 0, 0, 0, 0, 0, 0, 1, 0)).any()
    assert np.isnan(pbrt_transform.rotation(9, 0, 0, 0)).any()
    assert pbrt_transform.from_numbers([0.0] * 16) is None


@pytest.mark.filterwarnings("ignore::fastlines.FileWarning", "ignore::fastlines.PrecisionWarning")
def test_damage_raises_nothing_else(load):
    text = SCENE + b'ObjectBegin "a"' + CURVE + b' ObjectEnd ObjectInstance "a" Rotate 3 1 1 1 ObjectInstance "a"'
    assert 20 < mutate(load, text, "a.pbrt") < 290
