"""Curves of Mitsuba: a point a line, and an empty line between curves."""

from __future__ import annotations

import re

import numpy as np
import pytest
from support.line_files import message_of
from support.mutations import mutate

import fastlines as fl

TEXT = b"""
-1.0 0.1 0.1 0.5
 1.0 1.4 1.2 0.5
\t
-1.0 5.0 2.2 1
-2.3 4.0 2.3 2
 4.0 1.0 2.2 5

 \r

 4.0 0.0 2.3 6
 4e0 0.5 +2.3 .6
"""


@pytest.mark.parametrize("name", ["a.txt", "a.curves", "A.TXT"])
@pytest.mark.parametrize("end", [b"\n", b"\r\n", b"\r"])
def test_linear_curves(load, name, end):
    lines = load(TEXT.replace(b"\r", b"").replace(b"\n", end), name)
    np.testing.assert_array_equal(lines.strands, [0, 1, 1, 2])
    expected = [[[-1, 0.1, 0.1], [1, 1.4, 1.2]], [[-1, 5, 2.2], [-2.3, 4, 2.3]], [[-2.3, 4, 2.3], [4, 1, 2.2]]]
    np.testing.assert_array_equal(lines.segments[:3], np.array(expected, "f4"))
    np.testing.assert_array_equal(lines.radius, np.array([[0.5, 0.5], [1, 2], [2, 5], [6, 0.6]], "f4"))


def test_splines(load):
    rng = np.random.default_rng(1)
    table = rng.random((9, 4)).astype("f4")
    text = "\n".join(
        [" ".join(map(str, row)) for row in table[:5]] + [""] + [" ".join(map(str, row)) for row in table[5:]]
    )
    curves = load(text.encode(), "a.txt", basis="bspline")
    expected = fl.Curves.from_strands(table[:, :3], [5, 4], basis="bspline", radius=table[:, 3])
    for name in ("control", "radius", "strands"):
        np.testing.assert_allclose(getattr(curves, name), getattr(expected, name), rtol=1e-6)


@pytest.mark.parametrize(
    ("text", "said", "options"),
    [
        (b"0 0 0 1\n1 1 1", "line 2 has 3 numbers; expected 4, x y z radius; fix the line", {}),
        (b"0 0 0 1\n\n# what\n", "line 3: '# what' is not numbers; fix it, or check the extension", {}),
        (b"0 0 0 1\n1 1.0.1 1 1", "line 2: '1 1.0.1 1 1' is not numbers", {}),
        (b"0 0 0 1\n1 1-1 1 1", "line 2: '1 1-1 1 1' is not numbers", {}),
        (b"0 0 0 -1\n1 1 1 1", "radii must be finite and not negative .see row 0", {}),
        (b"0 0 0 nan\n1 1 1 1", "radii must be finite and not negative", {}),
        (b"\n0 0 0 1\n1 1 1 1\n", "the curve at line 2 has 2 points; a B-spline has 4 or more", {"basis": "bspline"}),
    ],
)
def test_what_is_wrong_is_refused(load, text, said, options):
    def load_so(data, name):
        return load(data, name, **options)

    assert re.search(said, message_of(load_so, text, "a.txt"))


def test_bad_line_far_behind_is_numbered(load, monkeypatch):
    monkeypatch.setattr("fastlines.io.formats.number_text.PIECE", 64)
    text = b"1 2 3 4\n" * 1000 + b"1 2 3 four\n"
    assert "line 1001:" in message_of(load, text, "a.txt")
    assert len(load(text[:-11], "a.txt")) == 999


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (b"0 0 0 1\n\n1 1 1 1\n2 2 2 2", "1 of its curves have one point, and become segments of zero length"),
        (b"0 0 0 1 7\n1 1 1 1\n\n1 1 1 1\n2 2 2 2", "1 of its lines have more than 4 numbers"),
    ],
)
def test_what_is_odd_is_told(load, text, said):
    with pytest.warns(fl.FileWarning, match=said):
        assert len(load(text, "a.txt")) == 2


@pytest.mark.filterwarnings("ignore:.*its radius is up to:fastlines.FileWarning")
def test_nan_is_refused_or_skipped(load):
    text = b"0 0 nan 1\n1 1 1 1\n2 2 2 1\n3 3 3 3\n4 4 4 4"
    for basis, n in (("linear", 3), ("bspline", 1)):
        with pytest.raises(fl.InputError, match="NaN"):
            load(text, "a.txt", basis=basis)
        assert len(load(text, "a.txt", basis=basis, invalid="skip")) == n
    with pytest.raises(fl.InputError, match="basis='bezier' is not a choice"):
        load(text, "a.txt", basis="bezier")


def test_curves_come_back_as_they_were_written(tmp_path):
    rng = np.random.default_rng(2)
    lines = fl.Lines.from_points(
        rng.random((9, 3)) * 10.0 ** rng.integers(-20, 20, (9, 3)), [4, 3, 2], radius=rng.random(9)
    )
    for name in ("a.txt", "a.curves.gz"):
        fl.write(tmp_path / name, lines)
        back = fl.read(tmp_path / name)
        for part in ("segments", "radius", "strands"):
            np.testing.assert_array_equal(getattr(back, part), getattr(lines, part))
    with pytest.warns(fl.FileWarning, match="radius, which is written as 0; that segments have no strand; the unit"):
        fl.write(tmp_path / "a.txt", fl.Lines(lines.segments, unit="mm"))
    assert not fl.read(tmp_path / "a.txt").radius.any()
    for basis in ("linear", "bspline"):
        fl.write(tmp_path / "a.txt", fl.Lines.from_segments(np.empty((0, 2, 3)), radius=1))
        assert len(fl.read(tmp_path / "a.txt", basis=basis)) == 0


@pytest.mark.filterwarnings("ignore::fastlines.FileWarning", "ignore::fastlines.PrecisionWarning")
def test_damage_raises_nothing_else(load):
    assert 20 < mutate(load, TEXT, "a.txt") < 290
    mutate(load, TEXT.replace(b"\n\n", b"\n"), "a.txt", basis="bspline")
