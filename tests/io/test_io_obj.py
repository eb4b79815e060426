"""Lines of OBJ files."""

from __future__ import annotations

import re

import numpy as np
import pytest
from support.line_files import message_of
from support.mutations import mutate

import fastlines as fl

TEXT = b"""# by hand
mtllib a.mtl
o one
v 0 0 0
  v 1 0 0 # indented
\tv 2.5 0 0
vt 0 1
vn 0 0 1
g hair
usemtl black
l 1/1 2/1 \\
  3
v 3 0 0
l -1 -4
"""


@pytest.mark.parametrize("end", [b"\n", b"\r\n"])
def test_lines(load, end):
    lines = load(TEXT.replace(b"\n", end), "a.obj")
    np.testing.assert_array_equal(lines.segments[:, :, 0], [[0, 1], [1, 2.5], [3, 0]])
    np.testing.assert_array_equal(lines.strands, [0, 0, 1])
    assert not lines.attributes


def test_colours(load):
    lines = load(b"v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nl 1 2", "a.obj")
    np.testing.assert_array_equal(lines.end_attributes["color"], [[[1, 0, 0], [0, 1, 0]]])
    assert lines.attributes["color"].dtype == np.float32


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            b"v 0 0 0\nv 1 0 0\nl 1 2\nf 1 2 1\nf 1 1 1\nfo 1 1 1\n",
            "its 3 faces are not read; only its elements l are lines",
        ),
        (b"v 0 0 0\nv 1 0 0\np 1\nl 1 2", "its 1 points are not read"),
        (b"v 0 0 0 2\nv 1 0 0 1\nl 1 2", "2 of its vertices have more than x y z, but not all have a colour"),
        (b"v 0 0 0 1 1 1\nv 1 0 0\nl 1 2", "1 of its vertices have more than x y z"),
        (b"v 0 0 0\nl 1", "1 of its elements l have less than two vertices; one becomes a segment of zero length"),
        (b"v 0 0 0\nv 1 0 0\nl 1 2\nl", "1 of its elements l have less than two vertices"),
    ],
)
def test_what_is_odd_is_told(load, text, said):
    with pytest.warns(fl.FileWarning, match=said) as told:
        assert len(load(text, "a.obj")) == 1
    assert len(told) == 1


def test_usual_weights_are_not_told(load):
    assert len(load(b"v 0 0 0 1.0\nv 1 0 0 1\nl 1 2", "a.obj")) == 1


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (b"v 0 0 0\nv 1 0\nl 1 2", "line 2 has 2 numbers; expected 3, x y z"),
        (b"v\nl 1", "line 1: a vertex has no coordinates"),
        (b"v 0 0 0\n\nv 1 0 o\nl 1 2", "line 3: '1 0 o' is not numbers"),
        (b"v 0 0 0\n\nl 1 2", "line 3: the vertex 2 is not there; expected 1 to 1"),
        (b"v 0 0 0\nl 1 0", "line 2: the vertex 0 is not there"),
        (b"v 0 0 0\nl 1 \\\n 1\nl 1 -2", "line 4: the vertex -2 is not there"),
        (b"l -1 -1\nv 0 0 0", "line 1: the vertex -1 is not there"),
        (b"v 0 0 0\nl 1 1.5", "line 2: the vertex 1.5 is not there"),
        (b"v 0 0 0\nl 1 nan", "line 2: the vertex nan is not there"),
        (b"v 0 0 0\nl 1 inf", "line 2: the vertex inf is not there"),
        (b"v 0 0 0\nl 1 -inf", "line 2: the vertex -inf is not there"),
        (b"v 0 0 0\nl 1 9999999999999999999999", "line 2: the vertex 1e.22 is not there"),
        (b"v 0 0 0\nl 1 v2", "line 2: '1 v2' is not numbers"),
        (b"\x7fELF\0\0what", "has no line that begins as one of an OBJ file does; check the extension"),
    ],
)
def test_what_is_wrong_is_refused(load, text, said):
    assert re.search(said, message_of(load, text, "a.obj"))


def test_mesh_has_no_lines(load):
    with pytest.warns(fl.FileWarning, match="its 1 faces are not read"):
        assert len(load(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3", "a.obj")) == 0


def test_nan_is_refused_or_skipped(load):
    text = b"v 0 0 nan\nv 1 0 0\nv 0 1 0\nl 1 2 3"
    with pytest.raises(fl.InputError, match="NaN"):
        load(text, "a.obj")
    assert len(load(text, "a.obj", invalid="skip")) == 1


def test_lines_come_back_as_they_were_written(tmp_path):
    rng = np.random.default_rng(2)
    color = rng.random((9, 3)).astype("f4")
    lines = fl.Lines.from_points(rng.random((9, 3)), [4, 3, 2], attributes={"color": color})
    for name in ("a.obj", "a.obj.gz"):
        fl.write(tmp_path / name, lines)
        back = fl.read(tmp_path / name)
        np.testing.assert_array_equal(back.segments, lines.segments)
        np.testing.assert_array_equal(back.strands, lines.strands)
        np.testing.assert_array_equal(back.end_attributes["color"], lines.end_attributes["color"])
    with pytest.warns(fl.FileWarning, match="radius; the numbers of strands, which are counted from 0; 'color'"):
        fl.write(
            tmp_path / "a.obj",
            fl.Lines.from_segments(rng.random((2, 2, 3)), strands=[3, 3], radius=1, attributes={"color": [1, 1]}),
        )
    assert (tmp_path / "a.obj").read_text().splitlines()[-1] == "l 3 4"


def test_no_lines_come_back(tmp_path):
    fl.write(tmp_path / "a.obj", np.empty((0, 2, 3)))
    assert len(fl.read(tmp_path / "a.obj")) == 0


@pytest.mark.filterwarnings("ignore::fastlines.FileWarning", "ignore::fastlines.PrecisionWarning")
def test_damage_raises_nothing_else(load):
    assert 20 < mutate(load, TEXT, "a.obj") < 290
