"""GeoParquet: geometries as WKB of every dialect, lists of coordinates, columns, reference systems, and damage."""

from __future__ import annotations

import io
import json
import struct
import warnings

import numpy as np
import pytest
from support.line_files import message_of
from support.mutations import mutations

import fastlines as fl
from fastlines.io.formats.wkb import Wkb

pa = pytest.importorskip("pyarrow")
parquet = pytest.importorskip("pyarrow.parquet")

Z, M, SRID = 0x80000000, 0x40000000, 0x20000000


def wkb(kind: int, *body: bytes, order: str = "<", flags: int = 0, srid: int | None = None) -> bytes:
    code = kind | flags | (SRID if srid is not None else 0)
    head = struct.pack(f"{order}BI", order == "<", code)
    return head + (b"" if srid is None else struct.pack(f"{order}I", srid)) + b"".join(body)


def numbers(points, order: str = "<", count: bool = True) -> bytes:
    flat = np.asarray(points, f"{order}f8").tobytes()
    return struct.pack(f"{order}I", len(points)) + flat if count else flat


def line(points, **how) -> bytes:
    return wkb(how.pop("kind", 2), numbers(points, how.get("order", "<")), **how)


def several(kind: int, *parts: bytes, **how) -> bytes:
    return wkb(kind, struct.pack(f"{how.get('order', '<')}I", len(parts)), *parts, **how)


POINT = wkb(1, numbers([1.0, 1.0], count=False))
POLYGON = wkb(3, struct.pack("<I", 1), numbers([[0, 0], [1, 0], [1, 1], [0, 0]]))
GEO = {"version": "1.1.0", "primary_column": "geometry", "columns": {"geometry": {"encoding": "WKB"}}}


def file_of(geometry, geo=GEO, extension=".parquet", **columns) -> bytes:
    table = pa.table(columns | {"geometry": geometry})
    if geo is not None:
        table = table.replace_schema_metadata({"geo": geo if isinstance(geo, str) else json.dumps(geo)})
    stream = io.BytesIO()
    if extension == ".parquet":
        parquet.write_table(table, stream)
    else:
        with pa.ipc.new_file(stream, table.schema) as writer:
            writer.write_table(table)
    return stream.getvalue()


@pytest.mark.parametrize("extension", [".parquet", ".feather"])
def test_rows_are_features(load, extension):
    rows = [
        line([[0, 0], [1, 0]]),
        several(
            5, line([[1, 1, 5], [2, 2, 6]], kind=1002), line([[3, 3, 1], [4, 4, 2], [5, 5, 3]], kind=1002), flags=1000
        ),
        POINT,
        several(7, line([[7, 7], [8, 8]]), POLYGON, several(4, POINT)),
        line(np.empty((0, 2))),
        None,
    ]
    data = file_of(rows, extension=extension, id=[5, 6, 7, 8, 9, 10], name=["a", "b", "c", "d", None, "f"],
                   width=[1.0, None, 3, 4, 5, 6])  # fmt: skip
    said = "without a line are not read: 1 without a geometry, 2 POINT, 1 POLYGON, 1 MULTIPOINT"
    with pytest.warns(fl.FileWarning, match=said):
        lines = load(data, f"a{extension}")
    expected = [[[0, 0, 0], [1, 0, 0]], [[1, 1, 5], [2, 2, 6]], [[3, 3, 1], [4, 4, 2]], [[4, 4, 2], [5, 5, 3]]]
    assert lines.segments.tolist() == [*expected, [[7, 7, 0], [8, 8, 0]]]
    assert lines.strands.tolist() == [0, 1, 2, 2, 3]
    assert lines.attributes["feature"].tolist() == [0, 1, 1, 1, 3]
    assert lines.attributes["id"].tolist() == [5, 6, 6, 6, 8]
    assert lines.attributes["name"].tolist() == ["a", "b", "b", "b", "d"]
    np.testing.assert_array_equal(lines.attributes["width"], [1, np.nan, np.nan, np.nan, 4])
    assert (lines.unit, lines.up) == ("degree", "z")


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("srid", [None, 4326])
@pytest.mark.parametrize(
    ("kind", "flags", "z", "m"),
    [(2, 0, 0, 0), (1002, 0, 1, 0), (2002, 0, 0, 1), (3002, 0, 1, 1), (2, Z, 1, 0), (2, M, 0, 1), (2, Z | M, 1, 1)],
)
def test_dialects_of_wkb(load, order, srid, kind, flags, z, m):
    points = np.array([[0.0, 1, *([5] * z), *([7] * m)], [2, 3, *([6] * z), *([8] * m)]])
    geometry = line(points, kind=kind, flags=flags, order=order, srid=srid)
    lines = load(file_of([geometry]), "a.parquet")
    assert lines.segments.tolist() == [[[0, 1, 5 * z], [2, 3, 6 * z]]]
    if m:
        assert lines.end_attributes["m"].tolist() == [[7, 8]]
    assert set(lines.attributes) == {"feature"} | ({"m"} if m else set())


@pytest.mark.parametrize("extension", [".parquet", ".arrow"])
@pytest.mark.parametrize("interleaved", [False, True])
def test_lists_of_coordinates(load, extension, interleaved):
    def points(*rows):
        if not interleaved:
            return [dict(zip("xyzm", row, strict=False)) for row in rows]
        return [list(row) for row in rows]

    point = pa.list_(pa.field("xyzm", pa.float64()), 4) if interleaved else pa.struct(
        [pa.field(axis, pa.float64()) for axis in "xyzm"])  # fmt: skip
    nan = float("nan")
    flat = [points((0, 1, nan, 7), (2, 3, nan, 8)), None, points((5, 5, 5, 1), (6, 6, 6, 2), (7, 7, 7, 3))]
    for column, encoding in (
        (pa.array(flat, pa.list_(point)), "linestring"),
        (pa.array(flat, pa.large_list(point)), "linestring"),
        (pa.array([[flat[0]], [], [flat[2]]], pa.list_(pa.list_(point))), "multilinestring"),
    ):
        about = {"primary_column": "geometry", "columns": {"geometry": {"encoding": encoding, "crs": None}}}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", fl.FileWarning)
            lines = load(file_of(column, about, extension, a=[1, 2, 3]), f"a{extension}")
        assert lines.segments.tolist() == [
            [[0, 1, 0], [2, 3, 0]], [[5, 5, 5], [6, 6, 6]], [[6, 6, 6], [7, 7, 7]]]  # fmt: skip
        assert lines.attributes["feature"].tolist() == [0, 2, 2]
        assert lines.attributes["a"].tolist() == [1, 3, 3]
        assert lines.end_attributes["m"].tolist() == [[7, 8], [1, 2], [2, 3]]
        assert lines.unit is None


def test_columns_of_geoarrow_need_no_metadata_of_the_file(load):
    field = pa.field("way", pa.binary(), metadata={"ARROW:extension:name": "geoarrow.wkb"})
    table = pa.Table.from_arrays([pa.array([line([[0, 0], [1, 2]])])], schema=pa.schema([field]))
    stream = io.BytesIO()
    with pa.ipc.new_file(stream, table.schema) as writer:
        writer.write_table(table)
    lines = load(stream.getvalue(), "a.arrow")
    assert lines.segments.tolist() == [[[0, 0, 0], [1, 2, 0]]]
    assert lines.unit is None


@pytest.mark.parametrize(
    ("about", "unit"),
    [
        ({"crs": {"coordinate_system": {"axis": [{"unit": "metre"}]}}}, "m"),
        ({"crs": "OGC:CRS84"}, "degree"),
        ({"crs": None}, None),
        ({}, None),
        ([], None),
    ],
)
def test_columns_of_geoarrow_say_their_reference_system(load, about, unit):
    known = {"ARROW:extension:name": "geoarrow.wkb", "ARROW:extension:metadata": json.dumps(about)}
    schema = pa.schema([pa.field("way", pa.binary(), metadata=known)])
    table = pa.Table.from_arrays([pa.array([line([[0, 0], [1, 2]])])], schema=schema)
    stream = io.BytesIO()
    with pa.ipc.new_file(stream, table.schema) as writer:
        writer.write_table(table)
    assert load(stream.getvalue(), "a.arrow").unit == unit


@pytest.mark.parametrize(
    ("crs", "unit", "said"),
    [
        ({"id": {"authority": "OGC", "code": "CRS84"}}, "degree", ""),
        ({"coordinate_system": {"axis": [{"unit": "degree"}, {"unit": "degree"}]}}, "degree", ""),
        ({"name": "a", "coordinate_system": {"axis": [{"unit": "metre"}]}}, "m", ""),
        ({"coordinate_system": {"axis": [{"unit": {"type": "LinearUnit", "name": "metre"}}]}}, "m", ""),
        ({"name": "Oak grid", "coordinate_system": {"axis": []}}, None, "system Oak grid, whose unit is not known"),
        ("EPSG:9", None, "system EPSG:9, whose unit is not known"),
        (None, None, ""),
        ([], None, r"system \[\]"),
    ],
)
def test_reference_systems(load, crs, unit, said):
    geo = GEO | {"columns": {"geometry": {"encoding": "WKB", "crs": crs}}}
    data = file_of([line([[0, 0], [1, 1]])], geo)
    if said:
        with pytest.warns(fl.FileWarning, match=said):
            assert load(data, "a.parquet").unit is unit
    else:
        assert load(data, "a.parquet").unit == unit


def test_boxes_are_no_loss_and_other_columns_are(load):
    box = pa.array([{"xmin": 0.0}])
    geo = {"primary_column": "geometry",
           "columns": {"geometry": {"encoding": "WKB", "covering": {"bbox": {"xmin": ["bbox", "xmin"]}}}}}  # fmt: skip
    assert len(load(file_of([line([[0, 0], [1, 1]])], geo, bbox=box), "a.parquet")) == 1
    with pytest.warns(fl.FileWarning, match="neither numbers nor texts are not read: bbox "):
        load(file_of([line([[0, 0], [1, 1]])], bbox=box), "a.parquet")


def test_radius_and_own_columns(load):
    data = file_of([line([[0, 0], [1, 1], [2, 2]])], radius=[0.5])
    assert load(data, "a.parquet").radius.tolist() == [0.5, 0.5]
    own = {name: [float(i)] for i, name in enumerate(("x0", "y0", "z0", "x1", "y1", "z1"))}
    with pytest.warns(fl.FileWarning, match="columns that are not numbers are not read: geometry"):
        assert load(file_of([line([[0, 0], [1, 1]])], **own), "a.parquet").segments.tolist() == [[[0, 1, 2], [3, 4, 5]]]


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (file_of([b"1"]), "row 0: the column 'geometry' holds no WKB: it does not begin with a byte order"),
        (file_of([line([[0, 0]]), line([[0, 0]])[:-1]]), "row 1: .* holds no WKB: it is cut short"),
        (file_of([line([[0, 0]]) + b"\0"]), "1 bytes are left over"),
        (file_of([wkb(77, b"\0" * 8)]), "its type is 0x4d, of no geometry"),
        (file_of([several(7, POINT)[:-1]]), "cut short"),
        (file_of([wkb(7, b"\xff\xff\xff\x7f")]), "cut short"),
        (file_of([wkb(2, b"\xff\xff\xff\x7f")]), "cut short"),
        (file_of([1]), "is of type int64; expected WKB"),
        (file_of([1.5], GEO | {"columns": {"geometry": {"encoding": "linestring"}}}), "expected lists of points"),
        (file_of([1], {}, q=[1]), "is of type int64; expected WKB"),
        (file_of([b"1"], None), "or geometries as in GeoParquet"),
        (file_of([b"1"], "{"), "holds no WKB"),
    ],
)
def test_bad_geometries(load, data, said):
    import re

    message = message_of(load, data, "a.parquet")
    assert re.search(said, message), message


def test_points_and_polygons_alone(load):
    with pytest.warns(fl.FileWarning, match="not read: 1 POINT, 1 POLYGON"):
        assert len(load(file_of([POINT, POLYGON]), "a.parquet")) == 0
    geo = {"primary_column": "geometry", "columns": {"geometry": {"encoding": "point"}}}
    with pytest.warns(fl.FileWarning, match="not read: 1 POINT"):
        assert len(load(file_of(pa.array([{"x": 1.0, "y": 2.0}]), geo), "a.parquet")) == 0


def test_nan_in_a_geometry(load):
    data = file_of([line([[0, 0], [np.nan, 1], [2, 2], [3, 3]])])
    assert "rows 0, 1" in message_of(load, data, "a.parquet", fl.InputError)
    assert load(data, "a.parquet", invalid="skip").segments.tolist() == [[[2, 2, 0], [3, 3, 0]]]


@pytest.mark.parametrize("extension", [".parquet", ".arrow"])
def test_small_files_of_many_geometries_are_refused(load, extension):
    big = line(np.random.default_rng(0).random((20_000, 2)))
    column = pa.DictionaryArray.from_arrays(pa.array(np.zeros(9000, "i4")), pa.array([big]))
    assert "unpacks to more than" in message_of(load, file_of(column, extension=extension), f"a{extension}")


def test_damaged_wkb():
    data = several(7, several(5, line([[0, 0], [1, 1]])), POLYGON, line([[1, 2, 3], [4, 5, 6]], kind=1002, order=">"))
    for i, damaged in enumerate([*mutations(data, 400), *(data[:n] for n in range(len(data)))]):
        found = Wkb()
        try:
            found.add(damaged, i)
        except ValueError:
            continue
        points, counts, _ = found.arrays()
        assert counts.sum() == len(points) <= len(damaged) // 16
