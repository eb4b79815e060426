"""Writing: what is refused, with what to do instead; units; and rows that were skipped."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.line_files import lost_by

import fastlines as fl
from fastlines.errors import InputError
from fastlines.support.units import METERS, meters_of, unit_of

LINES = fl.Lines.from_strands(np.arange(12.0).reshape(2, 2, 3))


def test_arguments_in_the_wrong_order(tmp_path):
    for path in ("a.npz", tmp_path / "a.npz"):
        with pytest.raises(InputError, match=r"a\.npz', the name of a file; the name comes first: fl\.write\(path, l"):
            fl.write(LINES, path)


def test_a_tree_is_not_written(tmp_path):
    with pytest.raises(InputError, match=r"a\.npz: lines are a Tree; expected lines: pass tree\.geometry"):
        fl.write(tmp_path / "a.npz", fl.build(LINES))
    for name in ("a.flt", "a.flt.gz"):
        with pytest.raises(
            InputError, match=r"is the name of a tree.*; fl\.build\(lines\)\.save\(path\) builds a tree"
        ):
            fl.write(tmp_path / name, LINES)
    assert not list(tmp_path.iterdir())


def test_a_folder_is_not_written(tmp_path):
    (tmp_path / "a.npz").mkdir()
    for folder in (tmp_path, str(tmp_path / "a.npz")):
        with pytest.raises(IsADirectoryError, match="is a directory; expected the name of a file to write"):
            fl.write(folder, LINES)


def test_a_geometry_names_its_parts_and_what_holds_them(tmp_path):
    curves = fl.Curves.from_bezier(np.eye(4, 3)[None])
    with pytest.raises(InputError) as caught:
        fl.write(tmp_path / "a.swc", fl.Geometry([LINES, curves]))
    assert str(caught.value) == (
        f"{tmp_path / 'a.swc'}: this is a Geometry of part 0 (2 segments), part 1 (1 curve), and such files hold one "
        "part; write all parts to one of .usd, .usda, .usdc, .usdz, or one by itself, as in fl.write(path, "
        "geometry.parts[0])"
    )
    with pytest.raises(InputError, match="this is a Geometry of no parts"):
        fl.write(tmp_path / "a.swc", fl.Geometry([]))


def test_an_extension_that_is_not_written_names_the_nearest_that_is(tmp_path):
    with pytest.raises(InputError, match=r"'\.npzz' are not written; did you mean '\.npz'\? known: \.parquet"):
        fl.write(tmp_path / "a.npzz", LINES)
    with pytest.raises(InputError, match=r"'\.tfx' are not written; known: \.parquet"):  # it is read
        fl.write(tmp_path / "a.tfx", LINES)


def test_a_missing_tree_is_told_as_other_missing_files_are(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"no such file; check the path \(the working directory is") as caught:
        fl.load(tmp_path / "gone.flt")
    assert Path(caught.value.filename) == tmp_path / "gone.flt"


# --- Units ---


@pytest.mark.parametrize("name", ["a.swc", "a.trk", "a.tck", "a.trx"])
def test_units_that_a_format_does_not_have_are_told(tmp_path, name):
    own, per_metre = ("µm", "1e+06") if name == "a.swc" else ("mm", "1000")
    as_they_are = f"(coordinates are written as they are, and will be read as {own}"
    for unit, said in (
        (None, f"that the unit is not known (coordinates will be read as {own})"),
        ("m", f"the unit 'm' {as_they_are}: to keep lengths, multiply them and the radius by {per_metre} first)"),
        ("degree", f"the unit 'degree' {as_they_are})"),
        (own, None),
    ):
        lines = replace(LINES.with_radius(1), unit=unit, up="z")
        told = [text for text in lost_by(tmp_path / name, lines) if "unit" in text]
        assert told == ([said] if said else [])
        back = fl.read(tmp_path / name)
        assert back.unit == own
        np.testing.assert_array_equal(back.segments, LINES.segments)  # never scaled


def test_both_micro_signs_are_one_unit(tmp_path):
    for sign in ("\N{MICRO SIGN}", "\N{GREEK SMALL LETTER MU}"):
        assert lost_by(tmp_path / "a.swc", replace(LINES.with_radius(1), unit=f"{sign}m")) == []


def test_names_of_units():
    for name, meters in METERS.items():
        assert unit_of(meters) == name
        assert meters_of(name) == meters
    assert meters_of(unit_of(0.3)) == 0.3
    for other in ("degree", "", " m", "0 m", "-1 m", "1e m", "1.2.3 m", "."):
        assert meters_of(other) is None


# --- Rows that were skipped ---


@pytest.mark.parametrize("name", ["a.npz", "a.npy", "a.obj", "a.ply"])
def test_rows_that_were_skipped_are_told(tmp_path, name):
    rows = np.arange(24.0).reshape(4, 2, 3)
    rows[1:3, 0] = np.nan
    lines = fl.Lines.from_segments(rows, strands=[0, 1, 2, 3], invalid="skip")
    said = "2 rows of the input, skipped for NaN or Inf"
    assert said in lost_by(tmp_path / name, lines)
    assert said not in lost_by(tmp_path / name, replace(lines, skipped=np.empty(0, np.int64)))
    curves = fl.Curves.from_bezier(np.where(np.arange(24).reshape(2, 4, 3) < 1, np.nan, 1), invalid="skip")
    assert "1 row of the input, skipped for NaN or Inf" in lost_by(tmp_path / name, curves)


# --- Curves in formats without curves ---


def test_pieces_keep_the_attributes_of_curves(tmp_path):
    at_points = {"heat": np.linspace(0, 1, 9), "id": np.arange(9), "colour": np.eye(9, 3, dtype="f4")}
    points = np.random.default_rng(0).random((9, 3))
    curves = fl.Curves.from_strands(points, [5, 4], basis="catmull-rom", attributes=at_points)
    curves = replace(curves, attributes={"age": np.array([3, 3, 8])})
    pieces = curves.pieces
    assert lost_by(tmp_path / "a.vtp", curves) == ["curves, which are written as their pieces"]
    back = fl.read(tmp_path / "a.vtp")
    np.testing.assert_array_equal(back.segments, pieces.lines.segments)
    np.testing.assert_array_equal(back.attributes["age"], np.array([3, 3, 8])[pieces.curve])
    u = np.stack([pieces.begin, pieces.end], axis=1)
    heat = curves.end_attributes["heat"][pieces.curve]
    np.testing.assert_allclose(back.end_attributes["heat"], heat[:, :1] * (1 - u) + heat[:, 1:] * u, atol=1e-7)
    first = pieces.first[:-1]
    for name, values in curves.end_attributes.items():
        np.testing.assert_array_equal(back.end_attributes[name][first, 0], values[:, 0])
    assert set(np.unique(back.end_attributes["id"])) <= set(range(9))
    assert pieces.lines.attributes == {}


def test_values_of_pieces_that_are_not_finite():
    ends = {"a": np.array([[np.inf, 1.0]]), "b": np.array([[np.nan, 2.0]]), "c": np.array([[True, False]])}
    curves = fl.Curves.from_bezier(np.random.default_rng(0).random((1, 4, 3)), end_attributes=ends)
    straight = curves.as_lines()
    assert straight.end_attributes["a"][0, 0] == np.inf
    assert straight.end_attributes["a"][-1, 1] == 1
    assert np.isnan(straight.end_attributes["b"][0, 0])
    assert straight.end_attributes["b"][-1, 1] == 2
    assert straight.end_attributes["c"].dtype == np.bool_
