"""GeoJSON: values, properties, odd files, bad ones, and what is written."""

from __future__ import annotations

import contextlib
import gzip
import json
import re

import numpy as np
import pytest
from support.line_files import lost_by, message_of
from support.mutations import mutations

import fastlines as fl
from fastlines.errors import FastlinesError, FileWarning
from fastlines.io import read, write


def feature(geometry, properties=None, **more):
    return {"type": "Feature", "geometry": geometry, "properties": properties, **more}


def line(*points):
    return {"type": "LineString", "coordinates": list(points)}


MULTI = {"type": "MultiLineString", "coordinates": [[[5, 5], [6, 6]], [], [[7, 7, 1], [8, 8, 2], [9, 9, 3]]]}
POLYGON = {"type": "Polygon", "coordinates": [[[0, 0], [1, 0], [1, 1], [0, 0]]]}
FEATURES = [
    feature(line([0, 0], [1, 0.5], [1, 2]), {"lanes": 2, "name": "oak", "length": 1.5, "wet": True}, id=7),
    feature(MULTI, {"lanes": 3, "wet": False, "tags": ["a"]}, id=8),
    feature(POLYGON, {"lanes": 9, "area": 3}, id=9),
    feature(None),
    feature({"type": "GeometryCollection", "geometries": [line([3, 3], [4, 4]), POLYGON]}, {"lanes": 4, "wet": True}),
]
COLLECTION = {"type": "FeatureCollection", "features": FEATURES}


def encoded(document):
    return json.dumps(document).encode()


def test_everything(load):
    with pytest.warns(FileWarning) as told:
        lines = load(encoded(COLLECTION), "a.geojson")
    assert lines.strands.tolist() == [0, 0, 1, 2, 2, 3]
    assert lines.segments[:, 1].tolist() == [[1, 0.5, 0], [1, 2, 0], [6, 6, 0], [8, 8, 2], [9, 9, 3], [4, 4, 0]]
    assert {name: values.dtype for name, values in lines.attributes.items()} == {
        "feature": np.int64,
        "lanes": np.int64,
        "name": np.object_,
        "length": np.float64,
        "wet": np.bool_,
        "id": np.float64,
    }
    assert lines.attributes["feature"].tolist() == [0, 0, 1, 1, 1, 4]
    assert lines.attributes["name"].tolist() == ["oak", "oak", "", "", "", ""]
    assert lines.attributes["lanes"].tolist() == [2, 2, 3, 3, 3, 4]
    np.testing.assert_array_equal(lines.attributes["id"], [7, 7, 8, 8, 8, np.nan])
    assert (lines.unit, lines.up) == ("degree", "z")
    texts = [str(warning.message) for warning in told]
    assert "without a line are not read: 2 Polygon, 1 without a geometry" in texts[0]
    assert "properties that hold neither numbers nor texts are not kept: 'tags'" in texts[1]
    assert len(texts) == 2


def test_hits_lead_back_to_features(load):
    names = ["oak", None, 3, True, "ölm"]
    document = {"type": "FeatureCollection", "features": [
        feature(line([i, 0], [i, 1], [i, 2]), {"name": name, "feature": 7}) for i, name in enumerate(names)
    ]}  # fmt: skip
    lines = load(encoded(document), "a.geojson")
    assert lines.attributes["name"][::2].tolist() == ["oak", "", "3", "true", "ölm"]
    assert lines.attributes["feature of strand"].tolist() == [7] * 10
    assert lines.attribute_texts()["name"] == ["text per strand"]
    hits = fl.build(lines).first_hit([[4, 1.5, -1], [9, 9, 9], [0, 0.5, -1]], [0, 0, 1], 0.1)
    assert lines.attributes["name"][hits.prim[hits.hit]].tolist() == ["ölm", "oak"]
    assert document["features"][lines.attributes["feature"][hits.prim[0]]]["properties"]["name"] == "ölm"
    with pytest.raises(fl.InputError, match="'name' holds texts or objects, expected numbers"):
        hits.sample("name")


def test_geometries_count_as_features(load):
    point = {"type": "Point", "coordinates": [0, 0]}
    parts = {"type": "GeometryCollection", "geometries": [point, line([1, 2], [3, 4]), point, line([5, 6], [7, 8])]}
    with pytest.warns(FileWarning, match="2 Point"):
        assert load(encoded(parts), "a.json").attributes["feature"].tolist() == [1, 3]
    with pytest.warns(FileWarning, match="2 Point"):
        assert load(encoded(feature(parts)), "a.json").attributes["feature"].tolist() == [0, 0]


@pytest.mark.parametrize("name", ["a.json", "a.geojsonl", "a.ndjson", "a.geojson"])
@pytest.mark.parametrize("mark", ["", "\x1e"])
def test_one_feature_a_line(load, name, mark):
    text = "\r\n".join(mark + json.dumps(item) for item in [feature(line([i, 0], [i, 1]), {"i": i}) for i in range(3)])
    lines = load(text.encode() + b"\n\n", name)
    assert lines.attributes["i"].tolist() == lines.segments[:, 0, 0].tolist() == [0, 1, 2]


def test_geometries_alone_and_short_lines(load):
    assert load(encoded(line([1, 2], [3, 4])), "a.json").segments.tolist() == [[[1, 2, 0], [3, 4, 0]]]
    assert load(encoded(line([1, 2])), "a.json").segments.tolist() == [[[1, 2, 0]] * 2]
    assert len(load(encoded(line()), "a.json")) == 0
    assert len(load(encoded({"type": "FeatureCollection", "features": []}), "a.json")) == 0
    assert load(b"\xef\xbb\xbf" + encoded(line([1, 2], [3, 4, 5])), "a.json").segments[0].tolist() == [
        [1, 2, 0],
        [3, 4, 5],
    ]
    with pytest.warns(FileWarning, match="1 lines have more than 3 numbers"):
        assert load(encoded(line([1, 2, 3, 4], [1, 2, 3, 4])), "a.json").segments[0, 0].tolist() == [1, 2, 3]


@pytest.mark.parametrize(
    ("crs", "unit", "warns"),
    [
        ("urn:ogc:def:crs:OGC:1.3:CRS84", "degree", False),
        ("EPSG:4326", "degree", False),
        ("urn:ogc:def:crs:EPSG::25832", None, True),
        (None, None, False),
    ],
)
def test_reference_system(load, crs, unit, warns):
    document = {**line([1, 2], [3, 4]), "crs": crs and {"type": "name", "properties": {"name": crs}}}
    with pytest.warns(FileWarning, match="25832") if warns else contextlib.nullcontext():
        assert load(encoded(document), "a.json").unit == unit


def test_precision_radius_and_nan(load):
    with pytest.warns(fl.PrecisionWarning):
        load(encoded(line([16.123456789, 48.2], [16.1234568, 48.2])), "a.geojson")
    document = feature(line([0, 0], [1, 1]), {"width": 0.5, "type": "LineString"})
    lines = load(encoded(document), "a.geojson", radius="width")
    assert (lines.radius.tolist(), lines.attributes["type"].tolist()) == ([0.5], ["LineString"])
    with pytest.raises(fl.FileFormatError, match=r"no property 'type' of numbers for the radius; .*: 'width'"):
        load(encoded(document), "a.geojson", radius="type")
    text = b'{"type": "LineString", "coordinates": [[0, 0], [NaN, 1], [2, 2], [3, 3]]}'
    assert "rows 0, 1" in message_of(load, text, "a.json", fl.InputError)
    assert load(text, "a.json", invalid="skip").skipped.tolist() == [0, 1]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("{", "is not JSON: .* .line 1, column 2.; fix it"),
        ("oak", "is not JSON"),
        (" \r\n", "is not JSON"),
        ("\x1e\n", "is not JSON"),
        ("[1, 2]", "holds no object; expected GeoJSON"),
        ('{"a": 1}', "holds an object of type None; expected GeoJSON, such as a FeatureCollection"),
        ('{"type": "Topology"}', "of type 'Topology'"),
        ('{"type": "FeatureCollection"}', "a FeatureCollection in it has no list of features"),
        ('{"type": "GeometryCollection", "geometries": 3}', "no list of geometries"),
        ('{"type": "LineString"}', "line 0 of it .LineString. has coordinates that are not a list of points"),
        ('{"type": "LineString", "coordinates": [[1, "2"], [3, 4]]}', "not a list of points"),
        ('{"type": "LineString", "coordinates": [[1], [2]]}', "not a list of points"),
        ('{"type": "LineString", "coordinates": [[1, 2], [3]]}', "not a list of points"),
        ('{"type": "LineString", "coordinates": [1, 2]}', "not a list of points"),
        ('{"type": "LineString", "coordinates": [[1, null], [3, 4]]}', "not a list of points"),
        ('{"type": "LineString", "coordinates": [[[1, 2], [3, 4]]]}', "not a list of points"),
        ('{"type": "MultiLineString", "coordinates": [[1, 2], [3, 4]]}', "not a list of points"),
        ('{"type": "MultiLineString", "coordinates": 1}', "not a list of points"),
        ("[" * 100_000, "cannot be read as JSON"),
        ("1" * 5000, "cannot be read as JSON|holds no object"),
        ('{"type": "LineString", "coordinates": [[1' + "0" * 400 + ", 2], [3, 4]]}", "not a list of points"),
    ],
)
def test_bad_files(load, text, said):
    message = message_of(load, text.encode(), "a.json")
    assert re.search(said, message), message


@pytest.mark.filterwarnings("ignore::fastlines.FileWarning", "ignore::fastlines.PrecisionWarning")
def test_damaged_text(load):
    for data in mutations(encoded(COLLECTION), 500):
        with contextlib.suppress(FastlinesError):
            lines = load(data, "a.geojson", invalid="skip")
            assert len(lines.strands) == len(lines.segments)


# --- Writing ---


def test_what_is_written_is_read_again(tmp_path):
    rng = np.random.default_rng(0)
    points = (rng.normal(size=(50, 3)) * 10.0 ** rng.integers(-6, 3, size=(50, 1))).astype(np.float32)
    lines = fl.Lines.from_points(points, [10, 25, 1, 14])
    values = {"i": np.arange(4), "f": np.float64([0.1, np.nan, 1e300, -0.0]), "b": np.array([True, False, True, True])}
    lines = fl.Lines(
        lines.segments, lines.strands, attributes={name: v[lines.strands] for name, v in values.items()}, unit="degree"
    )
    write(tmp_path / "a.geojson.gz", lines)
    again = read(tmp_path / "a.geojson.gz")
    assert again.segments.tobytes() == lines.segments.tobytes()
    assert (again.strands == lines.strands).all()
    for name, expected in lines.attributes.items():
        assert again.attributes[name].dtype == expected.dtype
        np.testing.assert_array_equal(again.attributes[name], expected)
    assert again.unit == "degree"


def test_flat_lines_have_no_z(tmp_path):
    write(tmp_path / "a.json", fl.Lines.from_strands([[[0.1, 0, 0], [1, 0, 0]]]))
    assert '"crs": null' in (tmp_path / "a.json").read_text()
    assert '"coordinates": [[0.1, 0.0], [1.0, 0.0]]' in (tmp_path / "a.json").read_text()
    assert read(tmp_path / "a.json").unit is None
    write(tmp_path / "a.json", fl.Lines.from_segments(np.empty((0, 2, 3))))
    assert len(read(tmp_path / "a.json")) == 0


def test_what_has_no_place_is_told(tmp_path):
    lines = fl.Lines.from_points(
        [[0, 0, 0], [1, 0, 0], [2, 0, 1]], [3], radius=0.5, attributes={"heat": [1.0, 2.0, 3.0], "rgb": np.ones((3, 3))}
    )
    lines = fl.Lines(
        lines.segments,
        lines.strands,
        lines.radius,
        attributes={
            "far": np.array([np.inf, np.inf]),
            "each": np.array([1, 2]),
            "name": np.array(["a", "a"]),
            "none": np.array([np.nan, np.nan]),
        },
        end_attributes=lines.end_attributes,
        unit="mm",
    )
    with pytest.warns(FileWarning) as told:
        write(tmp_path / "a.geojson", lines)
    text = str(told[0].message)
    for part in ("'heat' of each point", "'rgb' of each point", "'each', which differs", "the unit 'mm'",
                 "infinite values of 'far'", "'none', which is NaN everywhere", "radius='radius'"):  # fmt: skip
        assert part in text, text
    with pytest.warns(FileWarning, match="neither numbers nor texts are not kept: 'far', 'none'"):
        again = read(tmp_path / "a.geojson", radius="radius")
    assert (again.radius.tolist(), again.attributes["name"].tolist()) == ([0.5, 0.5], ["a", "a"])
    with pytest.warns(FileWarning, match="the radius, which differs along the lines"):
        write(tmp_path / "a.geojson", fl.Lines.from_points([[0, 0, 0], [1, 0, 0]], [2], radius=[1, 2]))


@pytest.mark.parametrize(("up", "said"), [(None, []), ("z", []), ("y", ["the upward axis 'y' (z will be up)"])])
def test_other_axes_are_told(tmp_path, up, said):
    lines = fl.Lines(np.ones((1, 2, 3), np.float32), np.zeros(1, int), up=up, unit="degree")
    assert lost_by(tmp_path / "a.geojson", lines) == said
    assert read(tmp_path / "a.geojson").up == "z"


def test_strands_that_fork_are_told(tmp_path):
    segments = np.float32([[[0, 0, 0], [1, 0, 0]], [[1, 0, 0], [2, 0, 0]], [[1, 0, 0], [1, 1, 0]]])
    lost = lost_by(tmp_path / "a.geojson", fl.Lines(segments, np.zeros(3, int)))
    assert lost == ["the numbers of strands, which are counted from 0"]
    assert read(tmp_path / "a.geojson").strands.tolist() == [0, 0, 1]


def test_names_that_change_are_told_and_kept_apart(tmp_path):
    names = {"a\nb": np.array([1]), "a?b": np.array([2])}
    lines = fl.Lines(np.ones((1, 2, 3), np.float32), np.zeros(1, int), attributes=names)
    assert lost_by(tmp_path / "a.geojson", lines) == [r"the name 'a\nb' ('a?b_' is written)"]
    assert read(tmp_path / "a.geojson").attributes == {"feature": 0, "a?b_": 1, "a?b": 2}


def test_features_are_written_as_they_were(tmp_path, load):
    parts = {"type": "MultiLineString", "coordinates": [[[0.0, 1.0], [2.0, 3.0]], [[4.0, 5.0], [6.0, 7.0], [8.0, 9.0]]]}
    features = [feature(line([0.5, 0.0], [1.0, 0.0]), {"name": "a"}), feature(parts, {"name": "b"}),
                feature(line([0.0, 1.5], [1.0, 1.0]), {"name": "b"})]  # fmt: skip
    lines = load(encoded({"type": "FeatureCollection", "features": features}), "a.geojson")
    assert lost_by(tmp_path / "b.geojson", lines) == []
    assert json.loads((tmp_path / "b.geojson").read_text())["features"] == features
    again = read(tmp_path / "b.geojson")
    assert again.attributes["feature"].tolist() == lines.attributes["feature"].tolist() == [0, 1, 1, 1, 2]
    some = fl.Lines(lines.segments[1:], lines.strands[1:], unit="degree",
                    attributes={name: values[1:] for name, values in lines.attributes.items()})  # fmt: skip
    assert "the numbers of features, which are counted from 0" in lost_by(tmp_path / "c.geojson", some)
    assert json.loads((tmp_path / "c.geojson").read_text())["features"] == features[1:]


@pytest.mark.parametrize("name", ["a.geojsonl", "a.ndjson", "A.NDJSON.gz"])
def test_a_feature_a_line(tmp_path, name):
    points = np.arange(12.0).reshape(4, 3)
    lines = fl.Lines.from_points(points, [2, 2])
    lines = fl.Lines(lines.segments, lines.strands, attributes={"id": np.array([7, 8])}, unit="degree")
    assert lost_by(tmp_path / name, lines) == []
    data = (tmp_path / name).read_bytes()
    rows = (gzip.decompress(data) if name.endswith(".gz") else data).decode().splitlines()
    assert [json.loads(row)["properties"] for row in rows] == [{"id": 7}, {"id": 8}]
    again = read(tmp_path / name)
    np.testing.assert_array_equal(again.segments, lines.segments)
    assert (again.strands.tolist(), again.attributes["id"].tolist(), again.unit) == ([0, 1], [7, 8], "degree")
    for unit, said in (("mm", "the unit 'mm'"), (None, "that the unit is not known (coordinates will be read as deg")):
        lost = lost_by(tmp_path / name, fl.Lines(lines.segments, lines.strands, unit=unit))
        assert len(lost) == 1
        assert lost[0].startswith(said)
        assert read(tmp_path / name).unit == "degree"
    fl.write(tmp_path / name, np.empty((0, 2, 3)))
    assert len(read(tmp_path / name)) == 0
