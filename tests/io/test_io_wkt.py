"""Well-known text, alone and in tables: values, columns, odd rows and bad ones."""

from __future__ import annotations

import contextlib
import csv
import re

import numpy as np
import pytest
from support.line_files import message_of
from support.mutations import mutations

import fastlines as fl
from fastlines.errors import FastlinesError, FileWarning

TABLE = """\
id;name;length;wet;the_geom
1;oak street;1.5;true;LINESTRING(0 0,1 0,1 2)
2;"elm; lane";;FALSE;"MULTILINESTRING ((5 5, 6 6), (7 7, 8 8, 9 9))"
3;;3e2;false;POINT (1 1)
4;;4;true;
"""


def points_of(lines):
    """Return the points of each strand, and check that its segments follow each other."""
    points = []
    for strand in np.unique(lines.strands):
        ends = lines.segments[lines.strands == strand]
        assert (ends[1:, 0] == ends[:-1, 1]).all()
        points.append(np.concatenate([ends[:1, 0], ends[:, 1]]).tolist())
    return points


def test_table_with_everything(load):
    with pytest.warns(FileWarning) as told:
        lines = load(TABLE.encode(), "a.csv")
    assert points_of(lines) == [
        [[0, 0, 0], [1, 0, 0], [1, 2, 0]],
        [[5, 5, 0], [6, 6, 0]],
        [[7, 7, 0], [8, 8, 0], [9, 9, 0]],
    ]
    assert {name: values.dtype for name, values in lines.attributes.items()} == {
        "feature": np.int64,
        "id": np.int64,
        "name": np.object_,
        "length": np.float64,
        "wet": np.bool_,
    }
    assert lines.attributes["feature"].tolist() == [0, 0, 1, 1, 1]
    assert lines.attributes["name"].tolist() == ["oak street"] * 2 + ["elm; lane"] * 3
    assert lines.attributes["id"].tolist() == [1, 1, 2, 2, 2]
    assert lines.attributes["wet"].tolist() == [True, True, False, False, False]
    np.testing.assert_array_equal(lines.attributes["length"], [1.5, 1.5, np.nan, np.nan, np.nan])
    texts = [str(warning.message) for warning in told]
    assert len(texts) == 1
    assert "without a line are not read: 1 without a geometry, 1 POINT" in texts[0]
    assert (lines.up, lines.unit) == ("z", None)


@pytest.mark.parametrize("delimiter", [",", ";", "\t", "|"])
@pytest.mark.parametrize("quote", ["'", '"'])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_delimiters_quotes_and_line_ends(load, delimiter, quote, end):
    rows = ["id,WKT".replace(",", delimiter)]
    rows += [f"{i}{delimiter}{quote}LINESTRING (0 0, {i} 1){quote}" for i in range(3)]
    lines = load(end.join(rows).encode(), "a.tsv")
    assert lines.segments[:, 1, 0].tolist() == [0, 1, 2]
    assert lines.attributes["id"].tolist() == [0, 1, 2]


@pytest.mark.parametrize(
    ("text", "z", "m"),
    [
        ("LINESTRING (0 0 5, 1 1 6)", [5, 6], None),
        ("LINESTRING Z (0 0 5, 1 1 6)", [5, 6], None),
        ("linestringz(0 0 5,1 1 6)", [5, 6], None),
        ("LINESTRING M (0 0 5, 1 1 6)", [0, 0], [5, 6]),
        ("LINESTRING ZM (0 0 5 7, 1 1 6 8)", [5, 6], [7, 8]),
        ("LineString(0 0 5 7,1 1 6 8)", [5, 6], [7, 8]),
        ("SRID=4326; LINESTRING Z(0 0 5, 1 1 6);", [5, 6], None),
        ("MULTILINESTRING Z((0 0 5, 1 1 6))", [5, 6], None),
        ("GEOMETRYCOLLECTION Z (LINESTRING Z (0 0 5, 1 1 6))", [5, 6], None),
        ("GEOMETRYCOLLECTION M (LINESTRING (0 0 5, 1 1 6))", [0, 0], [5, 6]),
        ("LINESTRING (0 0 5,\n 1\t1   6.0e0\n)\n", [5, 6], None),
    ],
)
def test_dimensions(load, text, z, m):
    for name, data in (("a.wkt", text), ("a.csv", f'geom\n"{text}"\n')):
        lines = load(data.encode(), name)
        assert lines.segments[0].tolist() == [[0, 0, z[0]], [1, 1, z[1]]]
        assert (None if m is None else lines.end_attributes["m"][0].tolist()) == m
        assert lines.unit == ("degree" if "SRID" in text else None)


def test_plain_text_of_several_geometries(load):
    text = "# roads\nLINESTRING (0 0, 1 1)\n\nLINESTRING EMPTY\nMULTILINESTRING EMPTY\n"
    text += "MULTILINESTRING ((0 0, 2 2), EMPTY)\n"
    text += "GEOMETRYCOLLECTION (LINESTRING (3 3, 4 4),GEOMETRYCOLLECTION(MULTILINESTRING ((5 5, 6 6)), POINT (1 1)))\n"
    text += "POLYGON ((0 0, 1 0, 1 1, 0 0))\n"
    with pytest.warns(FileWarning, match="not read: 1 POINT, 1 POLYGON"):
        lines = load(text.encode(), "a.wkt")
    assert lines.segments[:, 1, 0].tolist() == [1, 2, 4, 6]
    assert lines.strands.tolist() == [0, 1, 2, 3]
    assert lines.attributes["feature"].tolist() == [0, 3, 4, 4]
    over_lines = "LINESTRING (0 0,\n1 1);\nLINESTRING (2 2,\n3 3)"
    assert load(over_lines.encode(), "a.wkt").segments[:, 1, 0].tolist() == [1, 3]
    assert load(over_lines.encode(), "a.wkt").attributes["feature"].tolist() == [0, 1]
    nested = "GEOMETRYCOLLECTION (POINT (0 0),\nLINESTRING (0 0, 1 1)), POINT (1 1), LINESTRING (2 2,\n3 3)"
    with pytest.warns(FileWarning, match="2 POINT"):
        assert load(nested.encode(), "a.wkt").attributes["feature"].tolist() == [0, 2]


def test_hits_lead_back_to_rows(load):
    text = 'name,wkt\noak,\n\n7,LINESTRING (0 0)\nelm,"MULTILINESTRING ((5 5, 6 6), (7 7, 8 8))"\n'
    with pytest.warns(FileWarning, match="1 without a geometry"):
        lines = load(text.encode(), "a.csv")
    assert lines.attributes["name"].tolist() == ["7", "elm", "elm"]
    assert lines.attributes["feature"].tolist() == [1, 2, 2]


OTHERS = [
    "POINT (1 1)",
    "point z(1 1 1)",
    "POINT EMPTY",
    "LINESTRING EMPTY",
    "LINESTRING Z EMPTY",
    "MULTILINESTRING EMPTY;",
    "MULTIPOINT ((1 1), EMPTY)",
    "SRID=4326;POLYGON ((0 0, 1 0, 1 1, 0 0))",
    "MULTIPOLYGON ZM (((0 0 1 1, 1 0 1 1, 1 1 1 1, 0 0 1 1)))",
    "GEOMETRYCOLLECTION EMPTY",
    "GEOMETRYCOLLECTION (POINT (1 1))",
    "GEOMETRYCOLLECTION (POINT EMPTY)",
    "POLYGON ((0 0,\n1 0, 1 1, 0 0))",
    "TRIANGLE ((0 0, 1 0, 1 1, 0 0))",
    "LINESTRING\nEMPTY",
    "POLYGON\n((0 0, 1 0, 1 1, 0 0))",
]


@pytest.mark.filterwarnings("ignore::fastlines.FileWarning")
@pytest.mark.parametrize("text", OTHERS)
def test_files_that_begin_with_no_line(load, text):
    for data in (f"{text}\nLINESTRING (0 0, 1 0)\n", f"# roads\n\n{text}\n# more\nLINESTRING (0 0, 1 0)"):
        assert load(data.encode(), "a.wkt").segments.tolist() == [[[0, 0, 0], [1, 0, 0]]]
    for data in (f'"{text}",7\n"LINESTRING (0 0, 1 0)",8\n', f"id,way\n7,'{text}'\n8,'LINESTRING (0 0, 1 0)'\n"):
        lines = load(data.encode(), "a.csv")
        assert lines.segments.tolist() == [[[0, 0, 0], [1, 0, 0]]]
        assert [values.tolist() for values in lines.attributes.values()] == [[1], [8]]
    assert len(load(text.encode(), "a.wkt")) == 0


@pytest.mark.filterwarnings("ignore::fastlines.FileWarning")
@pytest.mark.parametrize("name", ["a.csv", "a.wkt"])
def test_quotes_where_they_are_needed(load, name):
    lines = load(b'POINT (1 1)\n"LINESTRING (0 0, 1 0)"\nPOINT EMPTY\n', name)
    assert lines.segments.tolist() == [[[0, 0, 0], [1, 0, 0]]]


def test_other_geometries_alone_are_told(load):
    for name, text in (("a.wkt", "POINT (1 1)\nPOINT (2 2)\n"), ("a.csv", "id,way\n1,POINT (1 1)\n2,POINT (2 2)\n")):
        with pytest.warns(FileWarning, match="without a line are not read: 2 POINT"):
            assert len(load(text.encode(), name)) == 0
    with pytest.warns(FileWarning) as told:
        assert len(load(b'id,place,way\n1,POINT (1 1),POINT (3 3)\n2,,"LINESTRING (0 0, 1 1)"\n', "a.csv")) == 1
    assert ["not kept: 'place'" in str(told[1].message), len(told)] == [True, 2]


def test_titles_of_columns_are_no_geometries(load):
    lines = load(b'Point (m),wkt\noak,"LINESTRING (0 0, 1 1)"\n', "a.csv")
    assert lines.attributes["Point (m)"].tolist() == ["oak"]


def test_lines_of_one_point_and_tables_without_lines(load):
    assert load(b"wkt\nLINESTRING (1 2)\n", "a.csv").segments.tolist() == [[[1, 2, 0]] * 2]
    for text in ("wkt,id\nLINESTRING EMPTY,1\n", "wkt,id\n"):
        lines = load(text.encode(), "a.csv")
        assert (len(lines), list(lines.attributes)) == (0, ["feature"])


def test_columns_are_chosen(load):
    text = 'road,ways,geometry,width\n"LINESTRING (0 0, 1 1)","LINESTRING (2 2, 3 3)","LINESTRING (4 4, 5 5)",0.5\n'
    with pytest.warns(FileWarning, match="'geometry', 'ways'"):
        assert load(text.encode(), "a.csv", column="ROAD").segments[0, 0, 0] == 0
    with pytest.warns(FileWarning, match="'road', 'ways'"):
        lines = load(text.encode(), "a.csv", radius="width")
    assert lines.segments[0, 0, 0] == 4
    assert (lines.radius.tolist(), list(lines.attributes)) == ([0.5], ["feature"])
    with pytest.warns(FileWarning, match="'ways'"):
        assert load(text.replace("geometry", "other").encode(), "a.csv").segments[0, 0, 0] == 0
    assert load(b'"LINESTRING (0 0, 1 1)",7\n', "a.csv").attributes["column 2"].tolist() == [7]
    assert list(load(b"geom,a,a,\nLINESTRING (0 0),1,2,3\n", "a.csv").attributes) == ["feature", "a", "a 3", "column 4"]


def test_long_fields_and_the_limit_of_the_csv_module(load):
    limit = csv.field_size_limit()
    n = 50_000
    text = 'geom\n"LINESTRING (' + ", ".join(f"{i} {i}.5" for i in range(n)) + ')"\n'
    lines = load(text.encode(), "a.csv")
    assert len(lines) == n - 1
    assert lines.segments[-1, 1].tolist() == [n - 1, n - 0.5, 0]
    assert csv.field_size_limit() == limit


def test_nan_and_far_coordinates(load):
    text = b'id,wkt\n7,"LINESTRING (0 0, 1 nan, 2 2, 3 3)"\n8,"LINESTRING (0 0, 1 1)"\n'
    assert "rows 0, 1" in message_of(load, text, "a.csv", fl.InputError)
    lines = load(text, "a.csv", invalid="skip")
    assert lines.skipped.tolist() == [0, 1]
    assert lines.attributes["id"].tolist() == [7, 8]
    with pytest.warns(fl.PrecisionWarning):
        load(b"LINESTRING (16.123456789 48.2, 16.1234568 48.2)", "a.wkt")


def test_rows_with_too_many_fields(load):
    with pytest.warns(FileWarning, match=": 1 rows have more fields than the 2 of the header"):
        assert len(load(b"wkt,id\nLINESTRING (0 0),1,2\n", "a.csv")) == 1


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("a.csv", "x,y,z\n1,2,3\n", "no column of lines .*; its columns are 'x', 'y', 'z'; name it with column="),
        (
            "a.csv",
            "wkt\nLINESTRING (0 0, 1 1\n",
            "line 2: 'LINESTRING .0 0, 1 1' does not end as it should; expected a LINESTRING",
        ),
        (
            "a.csv",
            "wkt,a\nLINESTRING (0 0, 1 1),1\n",
            "line 2: 'LINESTRING .0 0' does not end as it should; .* in quotes",
        ),
        ("a.csv", "wkt\nLINESTRING (0 0; 1 1)\n", "line 2: '0 0; 1 1' is not a list of points"),
        ("a.csv", 'wkt\nLINESTRING (0 0)\n\n"LINESTRING (0 0, 1)"\n', "line 4: '0 0, 1' is not a list"),
        ("a.csv", "wkt\nLINESTRING (0)\n", "line 2: '0' is not a list of points; expected 2, 3 or 4 numbers"),
        ("a.csv", "wkt\nLINESTRING (0 0 0 0 0)\n", "line 2: '0 0 0 0 0' is not a list"),
        ("a.csv", 'wkt\n"LINESTRING (0 0,)"\n', "line 2: '0 0,' is not a list"),
        ("a.csv", 'wkt\n"LINESTRING (0 0, 1 one)"\n', "line 2: '0 0, 1 one' is not a list"),
        ("a.csv", 'wkt\n"MULTILINESTRING (0 0, 1 1)"\n', "does not end as"),
        ("a.csv", 'wkt\n"MULTILINESTRING ((0 0, 1 1)"\n', "does not end as"),
        ("a.csv", 'wkt\n"LINESTRING ((0 0, 1 1))"\n', "does not end as"),
        ("a.csv", "wkt\noak\n", "line 2: 'oak' is not a geometry"),
        ("a.csv", 'wkt\n"MULTILINESTRING ((0 0, (1 1))"\n', "'MULTILINESTRING ..0 0, .1 1..' does not end as"),
        ("a.csv", "wkt\n" + "01" + "02000000" * 4 + "\n", "line 2: the column 'wkt' holds binary geometries"),
        ("a.csv", "\n\n \n", "holds only blank lines"),
        ("a.wkt", "LINESTRING (0 0, 1 1)\nLINESTRING (0 0, 1 1) oak", "line 2: 'oak' is not a geometry"),
        ("a.wkt", "oak", "no column of lines"),
    ],
)
def test_bad_rows_are_named(load, name, text, said):
    message = message_of(load, text.encode(), name)
    assert re.search(said, message), message


@pytest.mark.parametrize("text", ["1,'{}'\n", "'{}',1\n", "id,geometry\n1,'{}'\n", 'id,geometry\n1,"{}"\n'])
@pytest.mark.parametrize("kind", ["LINESTRING (0 0, 1 1)", "GEOMETRYCOLLECTION (LINESTRING (0 0, 1 1))"])
def test_quotes_of_either_kind(load, text, kind):
    np.testing.assert_array_equal(load(text.format(kind).encode(), "a.csv").segments, [[[0, 0, 0], [1, 1, 0]]])


def test_columns_of_one_name(load):
    lines = load(b'wkt,a,a 4,a,a\n"LINESTRING(0 0,1 1)",1,2,3,4\n', "a.csv")
    assert {name: values.tolist() for name, values in lines.attributes.items() if name != "feature"} == {
        "a": [1], "a 4": [2], "a 4 4": [3], "a 5": [4]
    }  # fmt: skip


def test_a_column_called_as_the_values_of_points(load):
    lines = load(b'm,wkt\n7,"LINESTRING M (0 0 1, 1 1 2)"\n', "a.csv")
    assert lines.end_attributes["m"].tolist() == [[1, 2]]
    assert lines.attributes["m of strand"].tolist() == [7]


def test_options_that_do_not_fit(load):
    for options, said in (
        ({"column": "road"}, "no column 'road'; its columns are 'wkt', 'a'"),
        ({"radius": "b"}, "no column 'b' of numbers for the radius; those of numbers are: 'a'"),
        ({"radius": "a"}, "must be finite and not negative"),
    ):
        with pytest.raises(FastlinesError, match=said):
            load(b"wkt,a\nLINESTRING (0 0),-1\n", "a.csv", **options)


@pytest.mark.filterwarnings("ignore::fastlines.FileWarning", "ignore::fastlines.PrecisionWarning")
@pytest.mark.parametrize("name", ["a.csv", "a.wkt"])
def test_damaged_text(load, name):
    good = "LINESTRING (0 0, 1 1)\nSRID=4326;MULTILINESTRING ZM ((1 2 3 4), (5 6 7 8, 1 1 1 1))\n"
    good = TABLE if name == "a.csv" else good
    for data in mutations(good.encode(), 400):
        with contextlib.suppress(FastlinesError):
            lines = load(data, name, invalid="skip")
            assert len(lines.strands) == len(lines.segments)


def test_long_runs_take_no_time(load):
    n = 200_000
    for text in (f"LINESTRING{' ' * n}x", "SRID=" + "1" * n, "A" * n, "(" * n, " " * n + "("):
        message_of(load, b"wkt\n" + text.encode(), "a.csv")
    load(b"wkt" + b",a" * 20_000 + b"\n", "a.csv")


def test_a_single_column_needs_no_quotes(load):
    lines = load(b"geom\r\nLINESTRING (0 0, 1 0)\r\nMULTILINESTRING ((0 0, 1 1), (2 2, 3 3))\r\n", "a.csv")
    assert lines.attributes["feature"].tolist() == [0, 1, 1]


@pytest.mark.parametrize("word", ["NULL", "None", "nan", "EMPTY"])
def test_words_for_no_geometry_are_counted(load, word):
    with pytest.warns(FileWarning, match="1 without a geometry"):
        lines = load(f"{word}\n# comment\nLINESTRING (0 0, 1 0)\n".encode(), "a.wkt")
    assert lines.attributes["feature"].tolist() == [1]
    with pytest.warns(FileWarning, match="1 without a geometry"):
        lines = load(f'id,geom\n7,{word}\n8,"LINESTRING (0 0, 1 0)"\n'.encode(), "a.csv")
    assert lines.attributes["id"].tolist() == [8]
