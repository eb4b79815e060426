"""Files of text: in UTF-16 and UTF-32, damaged, and with numbers that no reader expects."""

from __future__ import annotations

import codecs
import contextlib
import gzip
import warnings
from pathlib import PurePath

import numpy as np
import pytest
from support.line_files import message_of
from support.mutations import mutations
from support.text_files import NEEDS, NUMBERS, TEXTS, with_odd_numbers

import fastlines as fl
from fastlines.errors import FastlinesError
from fastlines.io import known_formats


@pytest.fixture(params=TEXTS)
def name(request) -> str:
    text: str = request.param
    if (library := NEEDS.get(PurePath(text).suffix)) is not None:
        pytest.importorskip(library)
    return text


def parts_of(geometry):
    """Return the arrays of lines or curves."""
    return [getattr(part, next(iter(part.sections))) for part in geometry.each_part()]


def test_each_format_of_text_has_a_file():
    rows = {row.name for row in known_formats().values() if row.text}
    assert {known_formats()[PurePath(name).suffix].name for name in TEXTS} == rows - {"vtp"}


# --- Encodings ---


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-32", "latin-1"])
def test_encodings(load, name, encoding):
    options = {"elevation": False} if name == "a.gpx" else {}
    expected = parts_of(load(TEXTS[name], name, **options))
    data = TEXTS[name].decode().encode(encoding)
    for given, called in ((data, name), (gzip.compress(data), f"{name}.gz")):
        for one, other in zip(parts_of(load(given, called, **options)), expected, strict=True):
            np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("mark", [codecs.BOM_UTF16_BE, codecs.BOM_UTF16_LE])
def test_marks_of_utf_16(load, mark):
    text = "1 1 0 0 0 1 -1\n2 1 1 0 0 1 1 # ř\n"
    data = mark + text.encode("utf-16-be" if mark == codecs.BOM_UTF16_BE else "utf-16-le")
    assert load(data, "a.swc").segments.tolist() == [[[0, 0, 0], [1, 0, 0]]]
    assert "is UTF-16 text, but not whole" in message_of(load, data[:-1], "a.swc")


def test_binary_files_are_no_text(load):
    """A .data file of 65,279 strands begins as text of UTF-16 does."""
    n = 0xFEFF
    strand = np.zeros(7, "<i4")
    strand[0] = 2
    data = np.concatenate([np.array([n], "<i4"), np.tile(strand, n)]).tobytes()
    assert data[:2] == codecs.BOM_UTF16_LE
    assert len(load(data, "a.data")) == n


# --- Damage ---


def read_all(load, copies, name: str) -> int:
    """Read files; return how many could be read. What is no error or warning of the package falls through."""
    n_read, errors = 0, []
    for i, data in enumerate(copies):
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", fl.FileWarning)
                warnings.simplefilter("ignore", fl.PrecisionWarning)
                load(data or b" ", name, invalid=("error", "skip")[i % 2])
            n_read += 1
        except FastlinesError as error:
            errors.append(error)
    assert not any("\n" in str(error) for error in errors)
    assert not [error for error in errors if error.__cause__ is not None]  # each was foreseen
    return n_read


def test_numbers_that_no_reader_expects(load, name):
    assert read_all(load, with_odd_numbers(TEXTS[name], 4 * len(NUMBERS), seed=1), name) > 0


def test_damaged_texts(load, name):
    read_all(load, mutations(TEXTS[name], 30, seed=5), name)
    read_all(load, [TEXTS[name][:n] for n in range(1, len(TEXTS[name]), 29)], name)


#: Runs that a pattern could match in many ways.
N = 100_000
LONG_RUNS = {
    "digits.txt": b"1" * N + b"x 0 0 1\n",
    "fraction.txt": b"1." + b"1" * N + b"x 0 0 1\n",
    "comment.csv": b"#" + b" " * N,
    "blanks.csv": b"POINT(0 0)" + b" " * N + b"x",
    "returns.ply": b"ply\n" + b"\r" * N + b"x\nend_header\n",
    "properties.ply": b"ply\nelement a 0\n" + b"".join(b"property char a%d\n" % i for i in range(N // 5)),
    "unit.swc": b"# units " + b" :" * N,
    "appended.vtp": b"<a>" + b"<AppendedData " * N,
}


@pytest.mark.filterwarnings("ignore::fastlines.FileWarning")
@pytest.mark.parametrize("file", LONG_RUNS)
def test_long_runs_take_no_time(load, file):
    with contextlib.suppress(FastlinesError):
        load(LONG_RUNS[file], file)


def test_numbers_of_400_digits_are_infinite(load):
    big = "1" + "0" * 400
    feature = '{"type": "Feature", "properties": {"a": %s}, "geometry": {"type": "LineString", "coordinates": %s}}'
    lines = load((feature % (big, "[[0, 0], [1, 1]]")).encode(), "a.json")
    assert lines.attributes["a"].tolist() == [np.inf]
    assert load(f'id,wkt\n-{big},"LINESTRING (0 0, 1 1)"\n'.encode(), "a.csv").attributes["id"].tolist() == [-np.inf]
    for row in ((feature % ("1", f"[[0, 0], [{big}, 1]]")), feature % ("1" + "0" * 5000, "[[0, 0], [1, 1]]")):
        message_of(load, row.encode(), "a.json")
    message_of(load, f"LINESTRING (0 0, {big} 1)".encode(), "a.wkt", fl.InputError)


def test_what_a_reader_does_not_foresee_is_an_error_of_the_file(load, monkeypatch):
    import fastlines.io.formats.swc as swc

    for kind in (OverflowError, IndexError, KeyError, UnicodeError, EOFError, RecursionError):

        def stumble(source, invalid, kind=kind):
            raise kind("it stumbles")

        monkeypatch.setattr(swc, "read", stumble)
        said = message_of(load, b"1 1 0 0 0 1 -1", "a.swc")
        assert f"cannot be read as swc ({kind.__name__}: " in said
    for bug in (TypeError, AttributeError, OSError, MemoryError):

        def break_down(source, invalid, bug=bug):
            raise bug("a bug, or the disk")

        monkeypatch.setattr(swc, "read", break_down)
        with pytest.raises(bug, match="a bug, or the disk"):
            load(b"1 1 0 0 0 1 -1", "a.swc")


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "utf-16-be", "utf-32"])
def test_first_bytes_tell_the_format_in_other_encodings(load, encoding):
    assert len(load("# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\n".encode(encoding), "a.zzz")) == 0


@pytest.mark.filterwarnings("ignore::fastlines.FileWarning")
@pytest.mark.parametrize("name", [name for name in TEXTS if PurePath(name).suffix not in (".vtk", ".usda")])
def test_carriage_returns_end_lines(load, name):
    if library := NEEDS.get(PurePath(name).suffix):
        pytest.importorskip(library)
    assert len(load(TEXTS[name].replace(b"\n", b"\r"), name)) == len(load(TEXTS[name], name))


def test_carriage_returns_between_features(load):
    lines = b'{"type": "LineString", "coordinates": [[0, 0], [1, 0]]}\r' * 3
    assert len(load(lines, "a.geojsonl")) == 3
