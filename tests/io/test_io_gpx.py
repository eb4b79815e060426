"""GPX: values, odd files and bad ones."""

from __future__ import annotations

import contextlib
import re

import numpy as np
import pytest
from support.line_files import message_of
from support.mutations import mutations

import fastlines as fl
from fastlines.errors import FastlinesError, FileWarning
from fastlines.io.formats import gpx

HEAD = '<?xml version="1.0" encoding="UTF-8"?>\n'
ROOT = '<gpx version="1.1" creator="a" xmlns="http://www.topografix.com/GPX/1/1" xmlns:x="http://x.org/">'
TRACKS = f"""{HEAD}{ROOT}
 <metadata><time>2000-01-01T00:00:00Z</time></metadata>
 <wpt lat="1" lon="2"><ele>3</ele></wpt>
 <rte><name>r</name><rtept lat="10" lon="20"/><rtept lat="11" lon="21"><ele>5</ele></rtept></rte>
 <trk><name>t</name>
  <trkseg>
   <trkpt lat="48.5" lon="16.25"><ele>200.5</ele><time>1970-01-01T00:00:10Z</time>
     <extensions><x:more><x:hr>90</x:hr><x:time>7</x:time></x:more></extensions></trkpt>
   <trkpt lat="48.75" lon="16.5"><time>1970-01-01T01:00:11.25+01:00</time><fix>3d</fix><speed>2</speed></trkpt>
   <trkpt lon="16.75" lat="49"><ele>201</ele><time>yesterday</time></trkpt>
  </trkseg>
  <trkseg></trkseg>
 </trk>
 <trk><trkseg><trkpt lat="0" lon="1"/></trkseg></trk>
</gpx>
"""


@pytest.mark.parametrize("more", [-1, 0, 1])
@pytest.mark.parametrize("n_blocks", [1, 2])
def test_a_file_that_is_cut_short_is_refused_wherever_its_blocks_end(load, monkeypatch, n_blocks, more):
    cut = TRACKS.partition("</gpx>")[0].strip().encode()
    cut += b" " * (len(cut) % n_blocks)
    monkeypatch.setattr(gpx, "_BLOCK", len(cut) // n_blocks + more)
    assert "is not complete XML: no element found" in message_of(load, cut, "a.gpx")


def test_everything(load):
    with pytest.warns(FileWarning) as told:
        lines = load(TRACKS.encode(), "a.gpx")
    assert lines.strands.tolist() == [0, 1, 1, 3]
    assert lines.segments[:, 1].tolist() == [[21, 11, 5], [16.5, 48.75, 0], [16.75, 49, 201], [1, 0, 0]]
    assert lines.attributes["track"].tolist() == [-1, 0, 0, 1]
    assert lines.attributes["feature"].tolist() == [0, 1, 1, 2]
    assert lines.attributes["name"].tolist() == ["r", "t", "t", ""]
    nan = np.nan
    np.testing.assert_array_equal(lines.end_attributes["hr"], [[nan, nan], [90, nan], [nan, nan], [nan, nan]])
    np.testing.assert_array_equal(lines.end_attributes["speed"], [[nan, nan], [nan, 2], [2, nan], [nan, nan]])
    np.testing.assert_array_equal(lines.end_attributes["time"][1:3], [[10, 11.25], [11.25, nan]])
    assert lines.attributes["time of extension"][1] == 7
    assert (lines.unit, lines.up) == ("degree", "z")
    texts = "\n".join(str(warning.message) for warning in told)
    for part in ("1 waypoints are not read", "texts of points are not kept: 'fix'", "1 times of points are not dates",
                 "z is in metres and x and y are in degrees; elevation=False"):  # fmt: skip
        assert part in texts
    assert len(told) == 4


def test_an_element_called_track_does_not_replace_the_counter(load):
    text = f'{ROOT}<trk><trkseg><trkpt lat="1" lon="2"><track>7</track></trkpt></trkseg></trk></gpx>'
    lines = load(text.encode(), "a.gpx")
    assert lines.attributes["track"].tolist() == [0]
    assert lines.attributes["track of points"].tolist() == [7]


def test_elements_of_tracks_and_of_points_are_kept_apart(load):
    text = (
        f"{ROOT}<trk><name>walk</name><number>3</number><track>x</track><link><text>no</text></link>"
        '<trkseg><trkpt lat="1" lon="2"><name>1</name></trkpt></trkseg></trk>'
        '<rte><desc>a &amp;\n b</desc><name>sail</name><rtept lat="3" lon="4"><feature>9</feature></rtept></rte></gpx>'
    )
    columns = load(text.encode(), "a.gpx").attributes
    assert columns["name"].tolist() == ["walk", "sail"]
    np.testing.assert_array_equal(columns["name of points"], [1, np.nan])
    np.testing.assert_array_equal(columns["number"], [3, np.nan])
    assert columns["desc"].tolist() == ["", "a &\n b"]
    assert (columns["feature"].tolist(), columns["feature of points"].tolist()[1]) == ([0, 1], 9)
    assert (columns["track"].tolist(), columns["track of strand"].tolist()) == ([0, -1], ["x", ""])
    assert "text" not in columns


def test_without_elevation(load):
    text = f'{ROOT}<rte><rtept lat="1" lon="2"><ele>3</ele></rtept><rtept lat="2" lon="2"></rtept></rte></gpx>'
    lines = load(text.encode(), "a.gpx", elevation=False)
    assert lines.segments[0, :, 2].tolist() == [0, 0]
    np.testing.assert_array_equal(lines.end_attributes["ele"], [[3, np.nan]])


def test_prefixes_encodings_and_files_without_lines(load):
    text = '<g:gpx xmlns:g="a"><g:trk><g:trkseg><g:trkpt lat="1" lon="2"/></g:trkseg></g:trk></g:gpx>'
    for encoding in ("utf-8", "utf-16", "latin-1"):
        data = f'<?xml version="1.0" encoding="{encoding}"?>{text}'.encode(encoding)
        assert load(data, "a.gpx").segments[0, 0].tolist() == [2, 1, 0]
    assert len(load(f"{ROOT}</gpx>".encode(), "a.gpx")) == 0


def test_many_points(load):
    points = "".join(f'<trkpt lat="{i / 1000}" lon="{-i / 500}"><ele>1</ele></trkpt>\n' for i in range(30_000))
    text = f"{ROOT}<trk><trkseg>{points}</trkseg></trk></gpx>"
    with pytest.warns(FileWarning, match="metres"):
        lines = load(text.encode(), "a.gpx")
    assert (lines.segments[:, 1, 1] == (np.arange(1, 30_000) / 1000).astype(np.float32)).all()
    assert (lines.segments[:, :, 2] == 1).all()


def test_nan(load):
    text = f'{ROOT}<rte><rtept lat="nan" lon="2"/><rtept lat="2" lon="2"/><rtept lat="3" lon="2"/></rte></gpx>'
    assert "row 0" in message_of(load, text.encode(), "a.gpx", fl.InputError)
    assert load(text.encode(), "a.gpx", invalid="skip").attributes["track"].tolist() == [-1]


BOMB = '<!DOCTYPE a [<!ENTITY a "aaaaaaaaaa">' + "".join(
    f'<!ENTITY {chr(98 + i)} "{f"&{chr(97 + i)};" * 10}">' for i in range(9)
)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (TRACKS[:-20], "is not complete XML: unclosed token"),
        ("oak", "is not complete XML: syntax error"),
        (f"{HEAD}<kml></kml>", "its root is <kml>; expected <gpx>"),
        (f"{ROOT}\n<rte>\n<rtept lat='1'/></rte></gpx>", "line 3: a point has no lon and lat that are numbers"),
        (f"{ROOT}<rte><rtept lat='1' lon='1,5'/></rte></gpx>", "line 1: a point has no lon and lat"),
        (f"{BOMB}]><gpx>&j;</gpx>", "has a document type .DOCTYPE., which GPX does not need; remove it"),
        (f"{ROOT}&lol;</gpx>", "is not complete XML: undefined entity"),
        ('<?xml version="1.0" encoding="oak"?><gpx/>', "not complete XML: unknown encoding|cannot be read as XML"),
    ],
)
def test_bad_files(load, text, said):
    message = message_of(load, text.encode(), "a.gpx")
    assert re.search(said, message), message


@pytest.mark.filterwarnings("ignore::fastlines.FileWarning", "ignore::fastlines.PrecisionWarning")
def test_damaged_text(load):
    for data in mutations(TRACKS.encode(), 500):
        with contextlib.suppress(FastlinesError):
            lines = load(data, "a.gpx", invalid="skip")
            assert len(lines.strands) == len(lines.segments)


@pytest.mark.filterwarnings("ignore::fastlines.FileWarning")
def test_many_names_take_little_memory(load):
    points = "".join(f'<trkpt lat="{i}" lon="0"><x{i}>1</x{i}></trkpt>' for i in range(10_000))
    text = f"{ROOT}<trk><trkseg>{points}</trkseg></trk></gpx>"
    with pytest.warns(FileWarning, match="elements of points with few values are not kept"):
        lines = load(text.encode(), "a.gpx")
    assert 10 < len(lines.attributes) < 100
    tracks = "".join(f'<trk><x{i}>1</x{i}><trkseg><trkpt lat="{i}" lon="0"/></trkseg></trk>' for i in range(10_000))
    with pytest.warns(FileWarning, match="elements of tracks with few values are not kept"):
        lines = load(f"{ROOT}{tracks}</gpx>".encode(), "a.gpx")
    assert 10 < len(lines.attributes) < 100
