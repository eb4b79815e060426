"""Tables of Parquet and Arrow."""

from __future__ import annotations

import io
import itertools
import re
import sys
import warnings

import numpy as np
import pytest
from support.line_files import POINTS, message_of

import fastlines as fl
from fastlines.errors import FastlinesError, FileWarning, InputError, MissingExtraError
from fastlines.io import source as sources
from fastlines.io.source import Source

pa = pytest.importorskip("pyarrow")
parquet = pytest.importorskip("pyarrow.parquet")

EXTENSIONS = (".parquet", ".feather", ".arrow")
STRAND = [7, 7, 7, 2, 2, 9, 9]
SEGMENTS = POINTS[:6].reshape(3, 6)


def file_of(table, extension: str = ".parquet") -> bytes:
    stream = io.BytesIO()
    if extension == ".parquet":
        parquet.write_table(table, stream)
    else:
        kind = pa.ipc.new_file if extension == ".arrow" else pa.ipc.new_stream
        with kind(stream, table.schema) as writer:
            writer.write_table(table)
    return stream.getvalue()


def points(**more):
    return pa.table({"x": POINTS[:, 0], "y": POINTS[:, 1], "z": POINTS[:, 2], "strand": STRAND} | more)


def segments(**more):
    return pa.table(dict(zip(("x0", "y0", "z0", "x1", "y1", "z1"), SEGMENTS.T, strict=True)) | more)


def lists(values):
    """Make a column of nested lists of fixed size."""
    array = pa.array(np.asarray(values).reshape(-1))
    for size in np.shape(values)[:0:-1]:
        array = pa.FixedSizeListArray.from_arrays(array, size)
    return array


def warned(load, data: bytes, name: str = "a.parquet"):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        made = load(data, name)
    return made, "\n".join(str(one.message) for one in caught)


# --- Reading ---


@pytest.mark.parametrize("extension", EXTENSIONS)
def test_a_row_a_segment(load, extension):
    table = segments(
        radius=[1.0, 2, 3], strand=pa.array([4, 4, -1], pa.int16()), id=[1, 2, 3], tint=lists(np.ones((3, 4)))
    )
    lines = load(file_of(table, extension), f"a{extension}")
    np.testing.assert_array_equal(lines.segments.reshape(-1, 3), POINTS[:6])
    np.testing.assert_array_equal(lines.strands, [4, 4, -1])
    np.testing.assert_array_equal(lines.radius, [1, 2, 3])
    np.testing.assert_array_equal(lines.attributes["id"], [1, 2, 3])
    np.testing.assert_array_equal(lines.attributes["tint"], np.ones((3, 4)))
    lines = load(file_of(segments(radius0=[1.0, 2, 3], radius1=[2.0, 3, 4]), extension), f"a{extension}")
    np.testing.assert_array_equal(lines.radius, [[1, 2], [2, 3], [3, 4]])
    assert lines.n_strands == 0


@pytest.mark.parametrize("shape", [(3, 6), (3, 2, 3)])
def test_segments_as_lists(load, shape):
    lines = load(file_of(pa.table({"segment": lists(SEGMENTS.reshape(shape))})), "a.parquet")
    np.testing.assert_array_equal(lines.segments.reshape(-1, 3), POINTS[:6])


@pytest.mark.parametrize("extension", EXTENSIONS)
def test_a_row_a_point(load, extension):
    lines = load(file_of(points(radius=np.arange(7), id=np.arange(7)), extension), f"a{extension}")
    # Strands are in the order of their numbers, and points in that of rows.
    ends = [[3, 4], [0, 1], [1, 2], [5, 6]]
    np.testing.assert_array_equal(lines.segments, POINTS[ends])
    np.testing.assert_array_equal(lines.strands, [2, 7, 7, 9])
    np.testing.assert_array_equal(lines.radius, ends)
    np.testing.assert_array_equal(lines.end_attributes["id"], ends)
    table = pa.table({"point": lists(POINTS), "strand": [0, 1, 0, 1, 1, 0, 2]})
    lines = load(file_of(table, extension), f"a{extension}")
    np.testing.assert_array_equal(lines.segments, POINTS[[[0, 2], [2, 5], [1, 3], [3, 4], [6, 6]]])


@pytest.mark.parametrize("kind", [pa.string(), pa.large_string(), pa.dictionary(pa.int8(), pa.string())])
def test_strands_of_texts(load, kind):
    names = pa.array(["b", "b", "a", "a", "b", "c", "c"], pa.string()).cast(kind)
    lines = load(file_of(points(strand=names), ".arrow"), "a.arrow")
    np.testing.assert_array_equal(lines.segments, POINTS[[[0, 1], [1, 4], [2, 3], [5, 6]]])
    np.testing.assert_array_equal(lines.strands, [0, 0, 1, 2])


def test_several_chunks_and_types(load):
    table = pa.concat_tables([points(id=pa.array(range(7), pa.uint8())), points(id=pa.array(range(7), pa.uint8()))])
    table = table.set_column(0, "x", table.column("x").cast(pa.float64()))
    lines = load(file_of(table, ".feather"), "a.feather")
    assert len(lines) == 11
    assert lines.attributes["id"].dtype == np.uint8


def test_empty_cells(load):
    table = points(age=[1, None, 3, 4, 5, 6, 7], flag=[True, None, True, False, True, True, True])
    lines, text = warned(load, file_of(table))
    assert np.isnan(lines.end_attributes["age"]).sum() == 2
    assert "the column 'age' has 1 empty rows, which are NaN; so it is of type float64" in text
    assert lines.attributes["flag"].dtype == np.float64
    table = points().set_column(0, "x", pa.array([1.0, None, 3, 4, 5, 6, 7]))
    assert "rows 1, 2" in message_of(load, file_of(table), "a.parquet", InputError)


def test_columns_that_are_no_numbers(load):
    lines, text = warned(load, file_of(segments(name=["a", "b", "c"], when=pa.array([1, 2, 3], pa.timestamp("s")))))
    assert not lines.attributes
    assert re.search(r"columns that are not numbers are not read: name \(string\), when \(timestamp\[.*\]\)", text)


def test_no_rows(load):
    for table in (segments().slice(0, 0), points().slice(0, 0), pa.table({"segment": lists(SEGMENTS).slice(0, 0)})):
        for extension in EXTENSIONS:
            assert len(load(file_of(table, extension), f"a{extension}")) == 0


def test_first_bytes_say_what_it_is(load):
    assert len(load(file_of(segments()), "a.arrow")) == 3
    assert len(load(file_of(segments(), ".arrow"), "a.parquet")) == 3
    assert len(load(file_of(segments()), "a.table")) == 3


@pytest.mark.parametrize(
    ("table", "said"),
    [
        (
            pa.table({"a": [1]}),
            r"has the columns \['a'\]; expected x0 y0 z0 x1 y1 z1 for a row a segment, or x y z and",
        ),
        (
            pa.table({"geometry": [b"1"]}).replace_schema_metadata({"geo": "{}"}),
            "row 0: the column 'geometry' holds no WKB",
        ),
        (points().drop(["strand"]), "has points without a column 'strand'"),
        (points(x0=POINTS[:, 0], segment=lists(np.ones((7, 6)))), "has columns of segments and of points; expected"),
        (points(strand=[0, 1, 2, 3, 4, 5, -1]), "the column 'strand' has negative numbers"),
        (points(strand=[0, 1, 2, 3, 4, 5, None]), "the column 'strand' has 1 empty rows"),
        (points(strand=np.arange(7.0)), "the column 'strand' is of type double; expected whole numbers, or texts"),
        (points(strand=np.full(7, 2**63, "u8")), "has numbers from 9223372036854775808"),
        (points(radius=-np.ones(7)), "radius must be finite and not negative"),
        (
            pa.table({"segment": pa.array([[1.0] * 6, None], pa.list_(pa.float32(), 6))}),
            "'segment' has 1 empty rows|all lists to be of size=6",
        ),
        (pa.table([pa.array([1]), pa.array([2])], names=["x", "x"]), "several columns of one name"),
        (
            pa.Table.from_arrays(
                segments(t=[1, 2, 3]).columns,
                schema=pa.schema(
                    [*segments().schema, pa.field("t", pa.int64(), metadata={"fastlines": "end_attributes"})]
                ),
            ),
            "a column of values at both ends of segments is not a list of 2",
        ),
    ],
)
def test_tables_that_are_no_lines(load, table, said):
    for extension in (".parquet", ".arrow"):
        text = message_of(load, file_of(table, extension), f"a{extension}")
        assert re.search(said, text), text


@pytest.mark.parametrize(
    "data", [b"hello", b"PAR1" + bytes(50), b"ARROW1" + bytes(50), b"\xff\xff\xff\xff" + bytes(50)]
)
@pytest.mark.parametrize("extension", EXTENSIONS)
def test_what_is_no_table(load, data, extension):
    assert "not a whole table (" in message_of(load, data, f"a{extension}")


def test_old_feather_and_odd_metadata(load):
    assert "is Feather of version 1" in message_of(load, b"FEA1" + bytes(50), "a.feather")
    table = segments().replace_schema_metadata({"up": "w", "unit": "\n"})
    lines, text = warned(load, file_of(table))
    assert (lines.up, lines.unit) == (None, None)
    assert "its 'up' is 'w', no axis, and is not used" in text
    assert "its 'unit' is not text, and is not used" in text


def test_tables_that_grow_beyond_measure(load):
    n = 10_000_000
    zeros = pa.DictionaryArray.from_arrays(pa.array(np.zeros(n, "i1")), pa.array([0.0]))
    table = pa.table(dict.fromkeys(("x0", "y0", "z0", "x1", "y1", "z1"), zeros))
    assert "announces 10000000 rows of 6 columns" in message_of(load, file_of(table), "a.parquet")


@pytest.mark.parametrize("n_batches", [1, 2, 3])
def test_batches_are_joined(load, n_batches):
    stream, table = io.BytesIO(), points(id=np.arange(7))
    ends = [0, *range(2, 2 * n_batches, 2), 7]
    with pa.ipc.new_file(stream, table.schema) as writer:
        for begin, end in itertools.pairwise(ends):
            writer.write_table(table.slice(begin, end - begin))
    lines, whole = load(stream.getvalue(), "a.arrow"), load(file_of(table, ".arrow"), "b.arrow")
    np.testing.assert_array_equal(lines.segments, whole.segments)
    np.testing.assert_array_equal(lines.end_attributes["id"], whole.end_attributes["id"])


def test_one_radius_counts_before_those_of_the_ends(load):
    lines = load(file_of(segments(radius=[1.0, 2, 3], radius0=[4.0, 5, 6], radius1=[7.0, 8, 9])), "a.parquet")
    np.testing.assert_array_equal(lines.radius, [1, 2, 3])
    np.testing.assert_array_equal(lines.attributes["radius0"], [4, 5, 6])
    np.testing.assert_array_equal(lines.attributes["radius1"], [7, 8, 9])


@pytest.mark.parametrize("least", [0, 1])
def test_a_parquet_file_may_announce_up_to_the_limit(load, monkeypatch, least):
    n = 10_000
    data = file_of(pa.table({name: np.zeros(n) for name in ("x0", "y0", "z0", "x1", "y1", "z1")}))
    monkeypatch.setattr(sources, "UNPACK_FACTOR", 0)
    monkeypatch.setattr(sources, "UNPACK_BYTES", 48 * n - least)
    if least:
        assert f"announces {n} rows of 6 columns" in message_of(load, data, "a.parquet")
    else:
        assert len(load(data, "a.parquet")) == n


def test_batches_that_grow_beyond_measure(load):
    batch = pa.record_batch({name: np.zeros(10**5) for name in ("x0", "y0", "z0", "x1", "y1", "z1")})
    for kind in (pa.ipc.new_file, pa.ipc.new_stream):
        stream = io.BytesIO()
        with kind(stream, batch.schema, options=pa.ipc.IpcWriteOptions(compression="zstd")) as writer:
            for _ in range(20):
                writer.write_batch(batch)
        assert "unpacks to more than" in message_of(load, stream.getvalue(), "a.arrow")


@pytest.mark.parametrize("extension", EXTENSIONS)
def test_columns_that_are_not_used_are_not_unpacked(load, extension):
    n = 10**6
    table = points(**{"a.b": np.arange(7.0), "x.y": [[{"z": 1}]] * 7, "text": ["a" * n] * 7, "z.t": [b"a"] * 7})
    stream = io.BytesIO()
    if extension == ".parquet":
        parquet.write_table(table, stream, compression="zstd")
    else:
        kind = pa.ipc.new_file if extension == ".arrow" else pa.ipc.new_stream
        with kind(stream, table.schema, options=pa.ipc.IpcWriteOptions(compression="zstd")) as writer:
            for _ in range(5):  # 35 MB of text
                writer.write_table(table)
    assert len(stream.getvalue()) < 40_000
    lines, text = warned(load, stream.getvalue(), f"a{extension}")
    assert list(lines.attributes) == ["a.b"]
    assert re.search(r"not read: x.y \(list.*, text \(string\), z.t \(binary\)", text)


@pytest.mark.parametrize("extension", EXTENSIONS)
def test_long_names_of_strands_are_not_repeated(load, extension):
    n = 2000
    name = pa.DictionaryArray.from_arrays(pa.array([1] * n + [0] * n + [2] * n, pa.int16()), ["b" * 10**5, "a", "a"])
    table = pa.table(dict.fromkeys("xyz", np.arange(3 * n) % 99) | {"strand": name})
    if extension == ".parquet":
        table = table.set_column(3, "strand", table["strand"].cast(pa.string()))
    data = file_of(table, extension)
    from fastlines.io.formats.arrow_table import read_table

    read = read_table(Source(data, "a"), lambda names: True)[0]["strand"]
    assert pa.types.is_dictionary(read.type)
    assert read.nbytes < 2e7  # 200 MB, if each row had its own letters
    lines = load(data, f"a{extension}")
    assert np.unique(lines.strands, return_counts=True)[1].tolist() == [2 * n - 1, n - 1]
    assert lines.strands[0] == 0


def test_without_the_library(load, tmp_path, monkeypatch):
    data = file_of(segments())
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(MissingExtraError, match=r"reading .parquet, .*the extra 'arrow'"):
        load(data, "a.parquet")
    with pytest.raises(MissingExtraError, match=r"writing .parquet, .*the extra 'arrow'"):
        fl.write(tmp_path / "b.arrow", [[[0, 0, 0], [1, 1, 1]]])


# --- Writing ---


@pytest.mark.parametrize("extension", [*EXTENSIONS, ".parquet.gz"])
@pytest.mark.filterwarnings("ignore:.*its radius is up to:fastlines.FileWarning")
def test_round_trip(tmp_path, extension):
    rng = np.random.default_rng(0)
    n = 5
    columns = {
        name: (rng.random((n, *shape)) * 100).astype(dtype)
        for name, dtype, shape in [
            ("b", "?", ()),
            ("i1", "i1", ()),
            ("u8", "u8", (2,)),
            ("f2", "f2", ()),
            ("m", "f4", (2, 2)),
        ]
    }
    ends = {"t": rng.random((n, 2)), "color": rng.random((n, 2, 3), np.float32)}
    for radius in (None, rng.random(n, np.float32), rng.random((n, 2), np.float32)):
        lines = fl.Lines(
            rng.random((n, 2, 3), np.float32),
            np.array([3, 3, 5, 5, -1]),
            radius,
            columns,
            up="x",
            unit="Å",
            end_attributes=ends,
        )
        fl.write(tmp_path / f"a{extension}", lines)
        back = fl.read(tmp_path / f"a{extension}")
        assert back.segments.tobytes() == lines.segments.tobytes()
        np.testing.assert_array_equal(back.strands, lines.strands)
        assert (back.up, back.unit) == ("x", "Å")
        assert (radius is None) == (back.radius is None)
        assert radius is None or back.radius.tobytes() == radius.tobytes()
        assert sorted(back.attributes) == sorted(lines.attributes)
        assert sorted(back.end_attributes) == sorted(lines.end_attributes)
        for name, values in {**lines.attributes, **lines.end_attributes}.items():
            other = back.end_attributes.get(name, back.attributes[name]) if name in ends else back.attributes[name]
            expected = lines.end_attributes.get(name, values)
            assert other.dtype == expected.dtype
            np.testing.assert_array_equal(other, expected)


def test_what_tables_have_no_place_for(tmp_path):
    lines = fl.Lines(
        np.zeros((1, 2, 3), "f4"), attributes={"x": np.ones(1), "name": np.array(["a"]), "radius": np.ones(1)}
    )
    with pytest.warns(FileWarning, match=r"'x' \(its name is taken\); 'name' \(<U1\); 'radius' \(its name is taken\)"):
        fl.write(tmp_path / "a.parquet", lines)
    assert not fl.read(tmp_path / "a.parquet").attributes


@pytest.mark.parametrize("extension", EXTENSIONS)
def test_names_that_are_not_unicode(tmp_path, extension):
    lines = fl.Lines(np.zeros((1, 2, 3), "f4"), attributes={"sur\udc80": np.ones(1), "line\nbreak": np.ones(1)})
    with pytest.warns(FileWarning, match=r"no place for it: 'sur\\udc80' \(float64\)$"):
        fl.write(tmp_path / f"a{extension}", lines)
    assert list(fl.read(tmp_path / f"a{extension}").attributes) == ["line\nbreak"]


@pytest.mark.filterwarnings("ignore::fastlines.FileWarning", "ignore::fastlines.PrecisionWarning")
@pytest.mark.parametrize("extension", EXTENSIONS)
def test_tables_cut_short(load, extension):
    data = file_of(points(radius=np.arange(7), tint=lists(np.ones((7, 4)))), extension)
    messages = []
    for n in range(0, len(data), max(len(data) // 60, 1)):
        try:
            load(data[:n] or b"\0", f"a{extension}")
        except FastlinesError as error:
            messages.append(str(error))
    assert len(messages) > 50
    assert not any("\n" in message for message in messages)
