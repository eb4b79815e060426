"""The recipes of docs/extending.md: their C++ is what the C++ tests run, and their Python works."""

from __future__ import annotations

import re
import sys
import textwrap
import tomllib
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import fastlines as fl
from fastlines.geometry import kinds
from fastlines.geometry.hit_places import HitPlaces, HitRays
from fastlines.io.source import Source
from fastlines.structure.geometry_file import from_sections, to_sections

ROOT = Path(__file__).parents[1]
RECIPES = (ROOT / "docs" / "extending.md").read_text(encoding="utf-8")
ENDS = np.array([[[0, 0, 0], [1, 1, 1]], [[2, 0, 0], [3, 1, 1]]], np.float32)


def block(language: str, contains: str) -> str:
    """Return the block of code that contains a text."""
    blocks = re.findall(rf"^( *)```{language}\n(.*?)^\1```", RECIPES, re.DOTALL | re.MULTILINE)
    (found,) = [textwrap.dedent(code) for _, code in blocks if contains in code]
    return found


@pytest.fixture
def module(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Run code as a module of the package."""

    def run(name: str, code: str) -> Any:
        made = ModuleType(f"fastlines.{name}")
        made.__package__ = made.__name__.rpartition(".")[0]
        monkeypatch.setitem(sys.modules, made.__name__, made)
        exec(compile(code, name, "exec"), made.__dict__)
        return made

    return run


@pytest.mark.parametrize("name", ["thirds", "tubes"])
def test_headers_are_those_of_the_cpp_tests(name: str) -> None:
    tested = (ROOT / "cpp" / "tests" / f"{name}.hpp").read_text(encoding="utf-8")
    here = re.sub(r'#include "fastlines/\w+/', '#include "', tested)
    assert block("cpp", f"struct {name.capitalize()[:-1]}") == here


def test_queries_are_those_of_the_example() -> None:
    example = (ROOT / "examples" / "own_queries.cpp").read_text(encoding="utf-8")
    for query in ("float least_distance(", "std::size_t count_visible("):
        assert block("cpp", query) in example


@pytest.mark.parametrize("end", [b"\n", b"\r\n"])
def test_xyzl(module: Any, end: bytes) -> None:
    code = block("py", "xyzl")
    outside = "from fastlines import Lines\nfrom fastlines.io import Format, Source\n"
    assert outside in code
    inside = re.sub(r"FORMAT = .*\n", "", code.replace(outside, block("py", "from ..source import Source")))
    assert "Format" not in inside
    parse = module("io.formats.xyzl", inside).read
    lines = parse(Source(end.join([b"", b"0 0 0", b" 1\t0 0 ", b" ", b"", b"5 5 5", b"6 6 6"]), "a.xyzl"), "error")
    np.testing.assert_array_equal(lines.segments, [[[0, 0, 0], [1, 0, 0]], [[5, 5, 5], [6, 6, 6]]])
    assert lines.strands.tolist() == [0, 1]
    assert len(parse(Source(end, "a.xyzl"), "error")) == 0
    for bad in (b"1 2", b"1 2 3 4", b"1 2 x", b"1,2,3", b"\xff"):
        with pytest.raises(fl.FileFormatError, match=r"^a.xyzl: line 3: .* is not three numbers"):
            parse(Source(end.join([b"0 0 0", b"1 0 0", bad]), "a.xyzl"), "error")
    nan = Source(end.join([b"0 0 0", b"nan 0 0", b"1 1 1", b"2 2 2"]), "a.xyzl")
    assert parse(nan, "skip").skipped.tolist() == [0, 1]
    with pytest.raises(fl.InputError, match="NaN"):
        parse(nan, "error")


def test_xyzl_in_a_package_of_its_own(install_format: Any, load: Any) -> None:
    project = tomllib.loads(block("toml", "xyzl"))["project"]
    install_format(project["name"], block("py", "xyzl"), project["entry-points"]["fastlines.formats"])
    (printf,) = re.findall(r"printf '(.*)' > a\.xyzl", RECIPES)
    lines = load(printf.encode().decode("unicode_escape").encode(), "a.xyzl")
    np.testing.assert_array_equal(
        lines.segments, np.reshape([0, 0, 0, 1, 0, 0, 1, 0, 0, 1, 1, 0, *[5] * 3, *[6] * 3], (3, 2, 3))
    )
    assert lines.strands.tolist() == [0, 0, 1]


def test_the_docs_of_formats_have_the_paragraph_to_change() -> None:
    page = (ROOT / "docs" / "formats.md").read_text(encoding="utf-8")
    (paragraph,) = [text for text in page.split("\n\n") if text.startswith("`format=` takes an extension")]
    assert re.search(r"\. The others are [^.]*\.$", paragraph)


def test_tubes(module: Any) -> None:
    tubes_of = module("geometry.tubes", block("py", "class Tubes")).Tubes.from_segments
    tubes = tubes_of(ENDS, radius=[0.5, 0.25])
    assert tubes.kind == "tubes"
    np.testing.assert_array_equal(tubes.core_rows, np.column_stack([ENDS.reshape(-1, 6), [0.5, 0.25]]))
    assert tubes.core_rows.dtype == np.float32
    assert tubes_of(np.empty((0, 2, 3)), radius=np.empty(0)).core_rows.shape == (0, 7)
    for radius in (None, [[0.5, 0.5], [0.25, 0.25]]):
        with pytest.raises(fl.InputError, match="tubes need a radius of shape"):
            tubes_of(ENDS, radius=radius)


def test_tori(module: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    tori_of = module("geometry.tori", block("py", "class Tori")).Tori
    rows = np.float32([[0, 0, 0, 0, 0, 1, 2, 0.5], [9, 0, 0, 0, 1, 0, 1, 0.25]])
    tori = tori_of(rows)
    assert tori.core_data() == tori.build_data() == ("tori", tori.core_rows)
    np.testing.assert_array_equal(tori.bounds, [[-2.5, -2.5, -2.5], [10.25, 2.5, 2.5]])
    assert tori_of(np.empty((0, 8))).bounds.tolist() == [[np.inf] * 3, [-np.inf] * 3]
    with pytest.raises(fl.InputError, match=r"tori have shape \(2, 7\); expected \(n, 8\)"):
        tori_of(rows[:, :7])

    # A ray from above hits the top of the tube.
    rays = HitRays(np.array([[2.0, 0, 9]]), np.array([[0.0, 0, -1]]), np.zeros(1), np.zeros(1), np.full(1, np.inf))
    hits = HitPlaces(np.zeros(1, int), np.zeros(1), np.array([8.5]), rays)
    np.testing.assert_allclose(tori.normals_at(hits), [[0, 0, 1]])
    assert np.isnan(tori.tangents_at(hits)).all()

    # What has a default: words, facts, a camera, files.
    assert (tori.count_text(), tori.summary()["n_tori"], tori.needs_radius) == ("2 tori", 2, False)
    assert repr(tori) == "<Tori: 2 tori>"
    assert fl.Camera.framing(tori, (0, 0, -1)).target[2] == 0
    monkeypatch.setitem(kinds.KINDS, "Tori", tori_of)
    arrays, facts, lost = to_sections(tori)
    np.testing.assert_array_equal(from_sections(arrays, facts, ValueError).rows, rows)
    assert lost == []
    with pytest.raises(fl.InputError, match="part 0 is a Tori; expected one of Lines"):
        fl.Geometry([tori])


def test_thirds() -> None:
    from fastlines.settings import splits

    made: dict[str, Any] = dict(vars(splits))
    exec(compile(block("py", "class Thirds"), "thirds", "exec"), made)
    assert made["Thirds"](max_refs=3) == splits.split_set_from("thirds", {"max_refs": 3})
    assert not made["Thirds"]().tight_only


def test_embers(module: Any) -> None:
    picture = module("embers", block("py", "class Embers")).picture
    assert picture.light[..., 0].max() > 2 * picture.light[..., 1].max() > 0
