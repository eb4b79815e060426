"""Files of hair and yarn: strands behind their counts (.data, .bcc), and .hair files that are written."""

from __future__ import annotations

import numpy as np
import pytest
from support.line_files import COUNTS, POINTS, bcc, lost_by, usc
from support.mutations import mutate

import fastlines as fl

# --- .data and .bcc ---


def test_root_without_hair_has_no_segment_but_a_number(load):
    lines = load(usc(), "a.data")
    np.testing.assert_array_equal(lines.segments, POINTS.astype("f4")[[[0, 1], [1, 2], [4, 5]]])
    np.testing.assert_array_equal(lines.strands, [0, 0, 2])
    assert (lines.up, lines.radius) == ("y", None)
    np.testing.assert_array_equal(load(usc(counts=[0, 2, 1]), "a.data").strands, [1])


def test_catmull_rom_splines_open_and_closed(load):
    points = np.random.default_rng(1).random((14, 3)).astype("f4")
    curves = load(bcc(counts=[4, -5, 0, 2, -2, -1], points=points), "a.bcc")
    assert curves.up == "y"
    np.testing.assert_array_equal(np.bincount(curves.strands), [3, 5, 0, 1, 2, 1])
    given = [(points[:4], [4], "pinned"), (points[4:9], [5], "periodic"), (points[9:11], [2], "pinned")]
    expected = [
        fl.Curves.from_strands(control, counts, basis="catmull-rom", wrap=wrap).control
        for control, counts, wrap in given
    ]
    np.testing.assert_allclose(curves.control[[0, 1, 2]], expected[0], rtol=1e-6)
    # A closed curve goes through its points in their order, and back to the first.
    np.testing.assert_array_equal(curves.control[3:8, 0], points[4:9])
    np.testing.assert_array_equal(curves.control[3:8, 3], points[[5, 6, 7, 8, 4]])
    assert {tuple(row) for row in curves.control[3:8].reshape(5, -1)} == {tuple(r) for r in expected[1].reshape(5, -1)}
    np.testing.assert_allclose(curves.control[8:9], expected[2], rtol=1e-6)
    np.testing.assert_array_equal(curves.control[11], [points[13]] * 4)
    lone = load(bcc(counts=[1]), "a.bcc")
    np.testing.assert_array_equal(lone.control, [[POINTS[0]] * 4])
    assert len(load(bcc(counts=[]), "a.bcc")) == 0


@pytest.mark.parametrize("options", [{"kind": b"PL"}, {"kind": b"C0"}, {"kind": b"XX"}])
def test_polylines_are_closed(load, options):
    basis = {} if options["kind"] == b"PL" else {"basis": "linear"}
    lines = load(bcc(counts=[3, -3, -1], **options, up=2), "a.bcc", **basis)
    rows = [[0, 1], [1, 2], [3, 4], [4, 5], [5, 3], [6, 6]]
    np.testing.assert_array_equal(lines.segments, POINTS.astype("f4")[rows])
    np.testing.assert_array_equal(lines.strands, [0, 0, 1, 1, 1, 2])
    assert lines.up == "z"


@pytest.mark.parametrize(
    ("options", "said"),
    [({"n_points": 9}, "counts 9 points, but its curves have 7"), ({"up": 3}, "axis 3 points upwards; expected 0, 1")],
)
def test_odd_header_of_bcc(load, options, said):
    with pytest.warns(fl.FileWarning, match=said):
        assert len(load(bcc(**options), "a.bcc")) == 6


def test_basis_that_there_is_not(load):
    with pytest.raises(fl.InputError, match=r"a\.bcc: basis='cubic' is not a choice"):
        load(bcc(), "a.bcc", basis="cubic")


def test_nan_in_a_spline_leaves_out_what_depends_on_it(load):
    points = POINTS.copy()
    points[0] = np.nan
    with pytest.raises(fl.InputError, match="NaN"):
        load(bcc(points=points), "a.bcc")
    curves = load(bcc(points=points), "a.bcc", invalid="skip")
    assert (len(curves), len(curves.skipped)) == (4, 2)


@pytest.mark.filterwarnings("ignore::fastlines.FileWarning", "ignore::fastlines.PrecisionWarning")
def test_damaged_splines_raise_nothing_else(load):
    mutate(load, bcc(), "a.bcc")


# --- .hair, written ---


def hairs(**more) -> fl.Lines:
    rng = np.random.default_rng(7)
    attributes = {"color": rng.random((7, 3)), "transparency": rng.random(7), "uv": rng.random((7, 2))}
    attributes = {name: values.astype("f4") for name, values in attributes.items()}
    return fl.Lines.from_points(POINTS, COUNTS, radius=rng.random(7), attributes={**attributes, **more})


def test_hair_comes_back_as_it_was_written(tmp_path):
    lines = hairs()
    for name in ("a.hair", "a.hair.gz"):
        fl.write(tmp_path / name, lines)
        back = fl.read(tmp_path / name)
        # A strand of one point is a segment of zero length, which is two points in the file.
        np.testing.assert_array_equal(back.segments, lines.segments)
        np.testing.assert_array_equal(back.strands, lines.strands)
        np.testing.assert_array_equal(back.radius, lines.radius)
        assert list(back.end_attributes) == ["transparency", "color", "uv"]
        for key, values in back.end_attributes.items():
            np.testing.assert_array_equal(values, lines.end_attributes[key])


def test_hair_says_what_it_cannot_hold(tmp_path):
    lines = hairs(age=np.arange(7), color=np.random.default_rng(1).random((7, 3)), uv=np.zeros((7, 3)))
    with pytest.warns(fl.FileWarning) as told:
        fl.write(tmp_path / "a.hair", lines)
    text = str(told[0].message)
    assert "digits of 'color' (float64) beyond float32; 'uv'; 'age'" in text
    assert list(fl.read(tmp_path / "a.hair").attributes) == ["transparency", "color"]


def test_hair_of_too_many_segments_is_cut(tmp_path):
    counts = [3, 65536, 65537, 65536 * 2, 2]
    points = np.arange(3 * sum(counts), dtype="f4").reshape(-1, 3)
    lines = fl.Lines.from_points(points, counts)
    with pytest.warns(fl.FileWarning, match="more than 65,535 segments, each of which is written as several strands"):
        fl.write(tmp_path / "a.hair", lines)
    back = fl.read(tmp_path / "a.hair")
    np.testing.assert_array_equal(back.segments, lines.segments)
    np.testing.assert_array_equal(np.bincount(back.strands), [2, 65535, 65535, 1, 65535, 65535, 1, 1])


def test_hair_says_that_the_largest_whole_numbers_are_rounded(tmp_path):
    for number, is_kept in ((2**63 - 1, False), (2**53 + 1, False), (2**60, True)):
        color = np.full((7, 3), number)
        lines = fl.Lines.from_points(POINTS, COUNTS, attributes={"color": color})
        lost = [] if is_kept else ["digits of 'color' (int64) beyond float32"]
        assert lost_by(tmp_path / "a.hair", lines) == lost


def test_no_hair(tmp_path):
    fl.write(tmp_path / "a.hair", np.empty((0, 2, 3)))
    assert len(fl.read(tmp_path / "a.hair")) == 0
    with pytest.warns(fl.FileWarning, match="no place for it: that segments have no strand$"):
        fl.write(tmp_path / "a.hair", np.array([[[0, 0, 0], [1, 1, 1]], [[1, 1, 1], [2, 2, 2]]]))
    np.testing.assert_array_equal(fl.read(tmp_path / "a.hair").strands, [0, 1])
