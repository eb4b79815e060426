"""USD: lines and curves are written, and come back."""

from __future__ import annotations

import os
from dataclasses import replace

import numpy as np
import pytest
from support.usd_files import warned

import fastlines as fl
from fastlines.errors import FileWarning, InputError
from fastlines.io.formats.usd_write import splines_of

pytest.importorskip("pxr")

EXTENSIONS = (".usda", ".usdc", ".usd", ".usdz", ".usda.gz")
RNG = np.random.default_rng(5)
POINTS = (RNG.random((10, 3), np.float32) - np.float32(0.5)) * np.float32([1, 1e-20, 1e20])
COUNTS = [4, 2, 3, 1]


def hair() -> fl.Lines:
    columns = {
        "f2": np.arange(10, dtype="f2"),
        "f4": np.float32([*RNG.random(9), np.nan]),
        "f8": RNG.random(10),
        "i4": np.arange(10, dtype="i4"),
        "i8": np.arange(10) * 2**40,
        "u1": np.arange(10, dtype="u1"),
        "u4": np.arange(10, dtype="u4") * 2**28,
        "u8": np.arange(10, dtype="u8") * 2**60,
        "b": np.arange(10) % 3 == 0,
        "color": RNG.random((10, 3), np.float32),
        "uv": RNG.random((10, 2)),
        "five": RNG.random((10, 5), np.float32),
        "pairs": np.arange(20).reshape(10, 2),
        "my:name": np.arange(10),
    }
    lines = fl.Lines.from_points(POINTS, COUNTS, radius=RNG.random(10, np.float32) * 1e-3, attributes=columns)
    return fl.Lines(
        lines.segments,
        lines.strands,
        lines.radius,
        {"id": np.float64([3, 5, 7, 9])[lines.strands], "tint": RNG.random((4, 4), np.float32)[lines.strands]},
        up="z",
        unit="mm",
        end_attributes=lines.end_attributes,
    )


def splines() -> fl.Curves:
    made = fl.Curves.from_strands(
        POINTS, [10], basis="catmull-rom", radius=RNG.random(10), attributes={"t": RNG.random(10), "n": np.arange(10)}
    )
    more = {"id": np.float32([4, 4, 4, 4, 6, 6, 8])}
    strands = np.array([0, 0, 0, 0, 1, 1, 2])
    return fl.Curves(made.control, made.radius, strands, more, made.end_attributes, up="y", unit="m")


def same(left, right) -> None:
    """Assert that two containers hold the same bits."""
    assert type(left) is type(right)
    for name in ("segments", "control", "strands", "radius"):
        mine, other = getattr(left, name, None), getattr(right, name, None)
        assert (mine is None) == (other is None)
        assert mine is None or (mine.dtype == other.dtype and mine.tobytes() == other.tobytes()), name
    assert (left.up, left.unit) == (right.up, right.unit)
    for kind in ("attributes", "end_attributes"):
        mine, other = getattr(left, kind), getattr(right, kind)
        assert sorted(mine) == sorted(other)
        for name, values in mine.items():
            assert other[name].dtype == values.dtype, name
            assert other[name].tobytes() == values.tobytes(), name


@pytest.mark.parametrize("extension", EXTENSIONS)
@pytest.mark.parametrize("make", [hair, splines])
def test_round_trip(tmp_path, extension, make, capfd):
    given = make()
    fl.write(tmp_path / f"a{extension}", given)
    same(given, fl.read(tmp_path / f"a{extension}"))
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("extension", EXTENSIONS)
def test_geometry(tmp_path, extension):
    with pytest.warns(
        FileWarning,
        match=r"different axes \(z of part 0, y of part 1\), and the file says z for all; "
        r"that parts have different units \(mm of part 0, m of part 1\), and the file says mm for all",
    ):
        fl.write(tmp_path / f"a{extension}", fl.Geometry([hair(), splines()]))
    made = fl.read(tmp_path / f"a{extension}")
    assert [type(part) for part in made.parts] == [fl.Lines, fl.Curves]
    np.testing.assert_array_equal(made.parts[0].segments, hair().segments)
    np.testing.assert_array_equal(made.parts[1].control, splines().control)


def test_prims_and_strands_of_several_parts_come_back(tmp_path, recwarn):
    """A file of three prims, two of them lines, is written as two prims, whose attribute prim has all three numbers."""
    steps, same_facts = np.arange(12, dtype="f4").reshape(4, 3), {"up": "z", "unit": "mm"}
    lines = fl.Lines.from_points(np.tile(steps, (2, 1)), [4, 4])
    lines = replace(lines, attributes={"prim": np.repeat([0, 2], 3)}, **same_facts)
    curves = fl.Curves(steps.reshape(1, 4, 3), None, np.array([2]), {"prim": np.array([1])}, **same_facts)
    given = fl.Geometry([lines, curves])
    for name in ("a.usda", "b.usdc"):
        fl.write(tmp_path / name, given)
        made = fl.read(tmp_path / name)
        for left, right in zip(given.parts, made.parts, strict=True):
            same(left, right)
        given = made
    assert [str(warning.message) for warning in recwarn] == []


def test_numbers_of_strands_that_change_are_told(tmp_path):
    lines = fl.Lines.from_points(np.arange(12.0).reshape(4, 3), [2, 2])
    with pytest.warns(FileWarning, match="no place for it: the numbers of strands, which are counted from 0$"):
        fl.write(tmp_path / "a.usda", fl.Geometry([lines, lines, lines]))
    np.testing.assert_array_equal(fl.read(tmp_path / "a.usda").strands, range(6))


def test_parts_without_a_unit_or_an_axis_beside_others_are_told(tmp_path):
    lines = fl.Lines.from_points(np.arange(12.0).reshape(4, 3), [2, 2])
    metres = replace(lines, strands=lines.strands + 2, unit="m", up="x")
    with pytest.warns(FileWarning) as told:
        fl.write(tmp_path / "a.usda", fl.Geometry([lines, metres]))
    assert str(told[0].message).endswith(
        "that parts have different axes (none of part 0, x of part 1), and the file says y for all; "
        "that parts have different units (none of part 0, m of part 1), and the file says m for all"
    )
    assert (fl.read(tmp_path / "a.usda").unit, fl.read(tmp_path / "a.usda").up) == ("m", "y")


def test_other_parts_of_a_geometry(tmp_path):
    balls = fl.Spheres.from_centres([[0, 0, 0]], radius=1)
    with pytest.warns(FileWarning, match="part 0, Triangles; part 2, Spheres"):
        fl.write(tmp_path / "a.usda", fl.Geometry([fl.Triangles([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]]), hair(), balls]))
    assert len(fl.read(tmp_path / "a.usda")) == len(hair())
    with pytest.raises(InputError, match="USD curves hold lines and curves, and there are none"):
        fl.write(tmp_path / "b.usda", fl.Geometry([balls]))
    assert not (tmp_path / "b.usda").exists()


@pytest.mark.parametrize("name", ["a.npz", "a.usda"])
def test_only_lines_and_curves_are_written(tmp_path, name):
    triangles = fl.Triangles([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]])
    for given in (fl.Spheres.from_centres([[0, 0, 0]], radius=1), triangles, fl.Boxes([[[0, 0, 0], [1, 1, 1]]])):
        with pytest.raises(InputError, match=f"this is {type(given).__name__}; files hold Lines or Curves"):
            fl.write(tmp_path / name, given)
    with pytest.raises(
        InputError,
        match=r"a\.npz: this is a Geometry of part 0 \(1 triangle\), part 1 \(7 .*"
        r"all parts to one of \.usd, \.usda, .*, or one by itself, as in fl\.write\(path, geometry\.parts\[1\]\)",
    ):
        fl.write(tmp_path / "a.npz", fl.Geometry([triangles, hair()]))
    assert not list(tmp_path.iterdir())


def test_names_that_are_not_unicode(tmp_path):
    lines = fl.Lines(np.zeros((1, 2, 3), "f4"), attributes={"sur\udc80": np.ones(1), "good": np.ones(1)})
    with pytest.warns(FileWarning, match=r"no place for it.*; 'sur\\udc80' \(float64, 1-d\)$"):
        fl.write(tmp_path / "a.usda", lines)
    assert list(fl.read(tmp_path / "a.usda").attributes) == ["good"]


@pytest.mark.parametrize("extension", EXTENSIONS)
def test_nothing(tmp_path, extension):
    fl.write(tmp_path / f"a{extension}", np.empty((0, 2, 3)))
    assert len(fl.read(tmp_path / f"a{extension}")) == 0


def test_what_usd_has_no_place_for(tmp_path):
    segments = np.float32([[[0, 0, 0], [1, 0, 0]], [[1, 0, 0], [2, 0, 0]], [[5, 0, 0], [6, 0, 0]]])
    lines = fl.Lines(
        segments,
        np.array([4, 4, 4]),
        np.float32([[1, 1], [2, 2], [3, 3]]),
        {
            "id": np.arange(3),
            "text": np.array(["a"] * 3),
            "matrix": np.ones((3, 2, 2)),
            "my name": np.ones(3),
            "widths": np.ones(3),
            "my_name": np.ones(3),
        },
        up="x",
        unit="degree",
    )
    with pytest.warns(FileWarning) as caught:
        fl.write(tmp_path / "a.usda", lines)
    text = str(caught[0].message)
    for part in (
        "the axis that points upwards, which is neither y nor z",
        "the unit 'degree', which is not a known length",
        "radius on both sides of a point",
        "'id', which differs from segment to segment",
        "'text' (<U1, 1-d)",
        "'matrix' (float64, 3-d)",
        "the name 'my name', which is written as 'my_name'",
        "the name 'my_name', which is written as 'my_name_'",
        "the name 'widths', which is written as 'widths_'",
        "the numbers of strands, which are counted from 0",
    ):
        assert part in text
    made = fl.read(tmp_path / "a.usda")
    np.testing.assert_array_equal(made.segments, segments)
    np.testing.assert_array_equal(made.strands, [0, 0, 1])
    assert sorted(made.attributes) == ["my_name", "my_name_", "widths_"]


@pytest.mark.parametrize("unit", ["m", "cm", "µm", "in", "0.5 m", "2e-07 m", "Å"])
def test_units(tmp_path, unit):
    fl.write(tmp_path / "a.usdc", fl.Lines(np.zeros((1, 2, 3), "f4"), np.zeros(1, int), unit=unit))
    assert fl.read(tmp_path / "a.usdc").unit == unit


def test_curves_whose_radius_jumps_are_two_splines():
    control = np.float32([[[3 * i + j, 0, 0] for j in range(4)] for i in range(3)])
    curves = fl.Curves(control, np.float32([[1] * 4, [1, 1, 1, 2], [3] * 4]), np.zeros(3, int))
    assert list(splines_of(curves).counts) == [7, 4]


def test_extent_holds_the_thickness(tmp_path):
    from pxr import Usd, UsdGeom

    fl.write(tmp_path / "a.usdc", fl.Lines(np.float32([[[0, 0, 0], [1, 2, 3]]]), np.zeros(1, int), np.float32([0.5])))
    stage = Usd.Stage.Open(str(tmp_path / "a.usdc"))
    prim = UsdGeom.BasisCurves(stage.GetDefaultPrim())
    np.testing.assert_array_equal(prim.GetExtentAttr().Get(), [[-0.5] * 3, [1.5, 2.5, 3.5]])
    np.testing.assert_array_equal(prim.GetWidthsAttr().Get(), [1, 1])


@pytest.mark.filterwarnings("ignore:.*numbers of strands:fastlines.FileWarning")
def test_prims_are_named_by_what_they_hold(tmp_path):
    from pxr import Usd

    lines = fl.Lines(np.float32([[[0, 0, 0], [1, 2, 3]]]), np.zeros(1, int))
    curves = fl.Curves(np.zeros((1, 4, 3), np.float32), None, np.zeros(1, int))
    parts = {"lines": lines, "curves": curves, "geometry": fl.Geometry([lines, curves])}
    for name, geometry in parts.items():
        fl.write(tmp_path / f"{name}.usdc", geometry)
        stage = Usd.Stage.Open(str(tmp_path / f"{name}.usdc"))
        root = stage.GetDefaultPrim()
        assert root.GetName() == name
        assert [str(child.GetName()) for child in root.GetChildren()] == (
            ["lines0", "curves1"] if name == "geometry" else []
        )


def test_cannot_write(tmp_path):
    with pytest.raises(OSError, match="there is no folder"):
        fl.write(tmp_path / "gone" / "a.usda", hair())


def test_written_file_has_no_oddities(tmp_path, load):
    fl.write(tmp_path / "b.usda", hair())
    assert warned(load, (tmp_path / "b.usda").read_bytes())[1] == ""


def test_a_package_that_is_not_whole_is_an_error(tmp_path, monkeypatch):
    from pxr import UsdUtils

    package = UsdUtils.CreateNewUsdzPackage

    def cut_short(asset, path):
        package(asset, path)
        os.truncate(path, os.path.getsize(path) - 100)
        return True

    monkeypatch.setattr(UsdUtils, "CreateNewUsdzPackage", cut_short)
    with pytest.raises(OSError, match=r"a\.usdz: USD could not write the package; is there enough space on the disk"):
        fl.write(tmp_path / "a.usdz", [[[0, 0, 0], [1, 1, 1]]])
    assert not list(tmp_path.iterdir())
