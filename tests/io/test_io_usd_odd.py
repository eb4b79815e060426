"""USD: odd and malformed files."""

from __future__ import annotations

import contextlib
import gzip
import sys

import numpy as np
import pytest
from support.line_files import message_of
from support.usd_files import SEVEN, curves, instancer, usda, warned, xform

import fastlines as fl
from fastlines.errors import FastlinesError, InputError, MissingExtraError

pytest.importorskip("pxr")


# --- Malformed files ---


def test_counts_that_do_not_add_up(load):
    lines, text = warned(load, usda(curves(SEVEN, [3, 5])))
    np.testing.assert_array_equal(lines.strands, [0, 0])
    assert "some curves are left out: curveVertexCounts announce more points than there are (/c)" in text
    lines, text = warned(load, usda(curves(SEVEN, [3, -5, 2])))
    assert len(lines) == 2
    lines, text = warned(load, usda(curves(SEVEN, [2147483647, 2147483647])))
    assert len(lines) == 0
    lines, text = warned(load, usda(curves(SEVEN, [3, 2])))
    assert len(lines) == 3
    assert "some points are left out: curveVertexCounts announce fewer than there are (/c)" in text


def test_numbers_of_points_that_fit_no_curve(load):
    widths = ("varying", [0, 6, 1, 1, 6, 0])
    made, text = warned(load, usda(curves(SEVEN[:4] + SEVEN[:5] + SEVEN[1:5], [4, 5, 4], kind="cubic", widths=widths)))
    assert "some curves are left out: their numbers of points fit no nonperiodic bezier curve (/c)" in text
    np.testing.assert_array_equal(made.control, np.float32([SEVEN[:4], SEVEN[1:5]]))
    np.testing.assert_array_equal(made.strands, [0, 2])
    np.testing.assert_array_equal(made.radius, [[0, 1, 2, 3], [3, 2, 1, 0]])


@pytest.mark.parametrize(
    "prim",
    [
        curves(kind="quintic"),
        curves(kind="cubic", basis="power"),
        curves(kind="cubic", basis="hermite"),
        curves(wrap="segmented"),
        curves().replace("int[] curveVertexCounts = [4]", ""),
        curves().replace("point3f[] points", "float[] primvars:p = [1] #"),
    ],
)
def test_prims_that_cannot_be_read(load, prim):
    lines, text = warned(load, usda(prim, curves(name="good")))
    assert len(lines) == 3
    assert "(/c)" in text


@pytest.mark.parametrize(
    "prim",
    [
        curves().replace("point3f[] points", "string points = 'a' #"),
        curves().replace("int[] curveVertexCounts = [4]", "float[] curveVertexCounts = [4.5]"),
        curves().replace("int[] curveVertexCounts = [4]", "string[] curveVertexCounts = ['a']"),
        curves(widths=("vertex", [1])).replace("float[] widths = [1]", "string[] widths = ['a']"),
        curves().replace("uniform token type", "uniform int type = 4 #"),
        curves().replace("uniform token type", "uniform int visibility = 4 #"),
    ],
)
def test_values_of_the_wrong_type(load, prim):
    with contextlib.suppress(FastlinesError):
        warned(load, usda(prim, curves(name="good")))


def test_nan(load):
    data = usda(curves()).replace(b"(1.0, 1.0, 0.0)", b"(1.0, nan, 0.0)")
    assert "rows 1, 2" in message_of(load, data, "a.usda", InputError)
    assert len(load(data, "a.usda", invalid="skip")) == 1
    data = usda(curves(kind="cubic")).replace(b"(1.0, 1.0, 0.0)", b"(1.0, inf, 0.0)")
    assert "row 0" in message_of(load, data, "a.usda", InputError)
    assert len(load(data, "a.usda", invalid="skip")) == 0


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("a.usda", b"#usda 1.0\ndef {"),
        ("a.usda", b"hello"),
        ("a.usdc", b"PXR-USDC" + bytes(200)),
        ("a.usdc", b"hello"),
        ("a.usdz", b"PK\3\4" + bytes(50)),
        ("a.usd", b"?" * 99),
    ],
)
def test_what_is_no_usd_file(load, name, data, capfd):
    text = message_of(load, data, name)
    assert "USD cannot read it (" in text
    assert capfd.readouterr() == ("", "")


def test_references_to_files_that_are_not_there(load, capfd):
    lines, text = warned(load, usda('def "r" (references = @gone.usda@) {}', curves()))
    assert len(lines) == 3
    assert "USD says: " in text
    assert "gone.usda" in text
    assert capfd.readouterr() == ("", "")


def test_references_to_other_files(load, tmp_path):
    (tmp_path / "other.usda").write_bytes(usda(curves(), head='defaultPrim = "c"'))
    assert len(load(usda('def "r" (references = @./other.usda@) {}'), "a.usda")) == 3


@pytest.mark.parametrize("name", ["A.USDA", "a.usda.gz", "a.usd", "a[1].usda", "a b@c.usda", "noextension"])
def test_names_of_files(load, name):
    data = usda(curves())
    assert len(load(gzip.compress(data) if name.endswith(".gz") else data, name)) == 3


def test_unsaved_changes_are_told(load, tmp_path):
    from pxr import Usd

    load(usda(curves()), "a.usda")
    stage = Usd.Stage.Open(str(tmp_path / "a.usda"))
    assert len(load(usda(curves(SEVEN)), "a.usda")) == 6
    stage.DefinePrim("/more")
    assert "without saving it; it is read as changed" in warned(load, usda(curves()))[1]


def test_changed_file_is_read_again(load):
    for n in (2, 3, 7):
        assert len(load(usda(curves(SEVEN[:n])), "a.usda")) == n - 1


def test_without_the_library(load, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pxr", None)
    with pytest.raises(MissingExtraError, match=r"reading USD files .*the extra 'usd'"):
        load(usda(curves()), "a.usda")
    with pytest.raises(MissingExtraError, match=r"writing USD files .*the extra 'usd'"):
        fl.write(tmp_path / "b.usda", [[[0, 0, 0], [1, 1, 1]]])


@pytest.mark.filterwarnings("ignore::fastlines.FileWarning", "ignore::fastlines.PrecisionWarning")
def test_damaged_text(load):
    more = 'int[] primvars:id = [7] (interpolation = "uniform")'
    data = usda(
        xform(curves(SEVEN, kind="cubic", widths=("vertex", list(range(7))), more=more)),
        instancer(curves(name="a") + curves(name="b")),
        head="metersPerUnit = 1",
    )
    rng = np.random.default_rng(3)
    messages = []
    for trial in range(300):
        damaged = bytearray(data)
        for at in rng.integers(len(data), size=1 + trial % 3):
            damaged[at] = rng.choice(list(b'0123456789-.,()[]{}<>"\n xe')) if trial % 2 else rng.integers(256)
        try:
            load(bytes(damaged), "a.usda", invalid=("error", "skip")[trial // 2 % 2])
        except FastlinesError as error:
            messages.append(str(error))
    assert len(messages) > 50
    assert not any("\n" in message for message in messages)


def test_alembic_is_told_how_to_get_there(load):
    assert "is Alembic, which is not read; import it in Blender or Houdini, and" in message_of(load, b"Ogawa", "a.abc")


@pytest.mark.parametrize("change", [lambda t: t.encode("utf-8-sig"), lambda t: t.encode("utf-16"), None])
def test_files_beside_a_packed_or_marked_one_are_found(tmp_path, change):
    prims = 'def BasisCurves "c" { uniform token type = "linear" int[] curveVertexCounts = [2]'
    layer = f'#usda 1.0\n(defaultPrim = "c")\n{prims}\npoint3f[] points = [(0, 0, 0), (1, 0, 0)]\n}}\n'
    (tmp_path / "part.usda").write_text(layer.replace(" int[]", "\nint[]").replace("{ uniform", "{\nuniform"))
    text = '#usda 1.0\ndef "a" (references = @./part.usda@) {}\n'
    path = tmp_path / ("whole.usda" if change else "whole.usda.gz")
    path.write_bytes(change(text) if change else gzip.compress(text.encode()))
    assert len(fl.read(path)) == 1


def test_what_is_odd_about_an_instancer_names_it(load):
    head = 'def PointInstancer "trees" {\nint[] protoIndices = [0]\npoint3f[] positions = [(0, 0, 0)]\n'
    with pytest.warns(fl.FileWarning, match="left out, as there is no prototype /oak .*/trees"):
        assert len(load(f"#usda 1.0\n{head}rel prototypes = </oak>\n}}\n".encode(), "a.usda")) == 0
    turns = "quath[] orientations = [(1, 0, 0, 0), (1, 0, 0, 0)]\n"
    with pytest.warns(fl.FileWarning) as told:
        load(f"#usda 1.0\n{head}{turns}rel prototypes = </oak>\n}}\n".encode(), "a.usda")
    assert any("/trees -- found [2] orientations" in str(warning.message) for warning in told)
