"""Streamlines in TRX files, from hand-written archives."""

from __future__ import annotations

import errno
import io
import re
import warnings
import zipfile
from dataclasses import replace

import numpy as np
import pytest
from support.line_files import AROUND, FIRST, LAST, POINTS, STRANDS, TRX_EXTRA, message_of, trx

import fastlines as fl
from fastlines.errors import FastlinesError

SEGMENTS = POINTS[np.stack([FIRST, LAST], axis=1)]


@pytest.mark.parametrize("method", [zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED])
def test_all_parts(load, method):
    lines = load(trx(extra=TRX_EXTRA, method=method), "a.trx")
    np.testing.assert_array_equal(lines.segments, SEGMENTS)
    np.testing.assert_array_equal(lines.strands, STRANDS)
    np.testing.assert_array_equal(lines.end_attributes["fa"], np.stack([FIRST, LAST], axis=1))
    np.testing.assert_array_equal(lines.attributes["colour"], np.arange(12).reshape(4, 3)[STRANDS])
    np.testing.assert_array_equal(lines.attributes["group left"], [True, True, False, False, True])
    assert (lines.unit, lines.up) == ("mm", "z")


@pytest.mark.parametrize("dtype", ["float16", "float32", "float64"])
def test_types_of_positions(load, dtype):
    points = POINTS.astype(dtype)
    expected = points.astype(np.float32)[np.stack([FIRST, LAST], axis=1)]
    np.testing.assert_array_equal(load(trx(points=points), "a.trx").segments, expected)


def test_places_outside_of_the_file(load):
    """The central directory of an archive may point anywhere; before the file there is nothing to read."""
    data = trx(extra=TRX_EXTRA)
    end = data.rindex(b"PK\5\6")
    directory = int.from_bytes(data[end + 16 : end + 20], "little")
    for place in (0, 7, directory - 1, directory + 9, len(data), 2**31, 2**32 - 1):
        for at, offset in ((end + 16, place), (directory + 42, place)):
            damaged = data[:at] + offset.to_bytes(4, "little") + data[at + 4 :]
            if offset or at == end + 16:
                assert "not a whole .trx file" in message_of(load, damaged, "a.trx")


def repacked(data: bytes, name: str, others: dict[str, bytes] | None = None) -> bytes:
    """Pack the members of an archive again, by other names."""
    stream = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(data)) as given, zipfile.ZipFile(stream, "w") as archive:
        for member in given.namelist():
            archive.writestr(name.format(member), given.read(member))
        for member, more in (others or {}).items():
            archive.writestr(member, more)
    return stream.getvalue()


LEFT_BY_SYSTEMS = {"__MACOSX/tracts/._header.json": b"x", "tracts/.DS_Store": b"x", "tracts/dpv/Thumbs.db": b"x"}


@pytest.mark.parametrize("name", ["tracts/{}", "a.trx/{}", "./{}", "deep/in/{}", "/{}", "tracts\\{}"])
def test_archives_of_a_folder(load, name):
    lines = load(repacked(trx(extra=TRX_EXTRA), name, LEFT_BY_SYSTEMS), "a.trx")
    np.testing.assert_array_equal(lines.segments, SEGMENTS)
    np.testing.assert_array_equal(lines.end_attributes["fa"], np.stack([FIRST, LAST], axis=1))
    assert sorted(lines.attributes) == ["colour", "fa", "group left"]


def test_archives_of_several_folders(load):
    both = repacked(trx(), "left/{}", {"right/header.json": b"{}"})
    assert "holds several files of streamlines, in the folders 'left/' and 'right/'" in message_of(load, both, "a.trx")


@pytest.mark.parametrize("name", ["a.trx", "a.TRX", "tracts"])
@pytest.mark.parametrize("inside", ["", "tracts"])
def test_unpacked_archives(tmp_path, name, inside):
    folder = tmp_path / name
    with zipfile.ZipFile(io.BytesIO(trx(extra=TRX_EXTRA))) as archive:
        archive.extractall(folder / inside)
    (folder / ".DS_Store").write_bytes(b"x")
    if (name, inside) == ("tracts", "tracts"):
        with pytest.raises(IsADirectoryError):
            fl.read(folder)
        return
    done: list[float] = []
    lines = fl.read(folder, progress=done.append)
    np.testing.assert_array_equal(lines.segments, SEGMENTS)
    np.testing.assert_array_equal(lines.attributes["group left"], [True, True, False, False, True])
    assert (lines.unit, done[-1]) == ("mm", 1)
    assert fl.read(folder, bundle="left").n_strands == 2
    assert fl.read(folder, format="trx").n_strands == 4
    with pytest.raises(OSError, match=r"directory|denied|Directory"):
        fl.read(folder, format="swc")


def test_folders_that_are_not_whole(tmp_path):
    (tmp_path / "a.trx").mkdir()
    with pytest.raises(fl.FileFormatError, match=r"holds no 'header.json', so it is not a whole"):
        fl.read(tmp_path / "a.trx")


def test_bundle(load):
    data = trx(extra={**TRX_EXTRA, "groups/none.uint32": b"", "groups/back.int64": np.array([2, 0]).tobytes()})
    lines = load(data, "a.trx", bundle="back")
    np.testing.assert_array_equal(lines.segments, SEGMENTS[[3, 0, 1]])
    np.testing.assert_array_equal(lines.strands, [0, 1, 1])
    np.testing.assert_array_equal(lines.attributes["fa"], [4, 0, 1])
    np.testing.assert_array_equal(lines.attributes["colour"][:, 0], [6, 0, 0])
    assert len(load(data, "a.trx", bundle="none")) == 0
    for wrong in ("front", 3, ["left"]):
        with pytest.raises(fl.InputError, match=r"there is no bundle .*; its groups are left, none, back"):
            load(data, "a.trx", bundle=wrong)


def test_many_groups_are_named_in_a_warning(load):
    groups = {f"groups/g{i}.uint8": b"\1" for i in range(65)}
    with pytest.warns(fl.FileWarning, match=r"its 65 groups \(g0, g1, g2, g3, g4, …\) are left out.*bundle="):
        assert not load(trx(extra=groups), "a.trx").attributes
    assert load(trx(extra=groups), "a.trx", bundle="g7").n_strands == 1
    del groups["groups/g7.uint8"]
    assert len(load(trx(extra=groups), "a.trx").attributes) == 64


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"last_offset": False}, "its offsets lack the end of the last streamline"),
        ({"extra": {"dps/id.int16": bytes(10)}}, r"'dps/id' in it has 5 values for 4 streamlines, and is left out"),
        ({"extra": {"dpv/id.2.int16": bytes(4)}}, r"'dpv/id' in it has 1 values for 7 points, and is left out"),
        ({"extra": {"dpv/id.complex64": bytes(56)}}, r"'dpv/id.complex64' in it \(56 bytes\) is left out"),
        ({"extra": {"dpv/id.float32": bytes(27)}}, r"'dpv/id.float32' in it \(27 bytes\) is left out"),
        ({"extra": {"dpg/left/mean.float32": bytes(4)}}, "'dpg/left/mean' in it is left out, as it is not a value"),
        ({"extra": {"groups/a.uint8": b"\4"}}, "'groups/a' in it does not hold numbers of its 4 streamlines"),
        ({"extra": {"groups/a.float32": bytes(4)}}, "'groups/a' in it does not hold numbers"),
        (
            {"extra": {"dpv/a.uint8": bytes(7), "dpv/a .uint8": bytes(7)}},
            "'dpv/a .uint8' in it is left out",
        ),
    ],
)
def test_oddities_are_told(load, options, said):
    with pytest.warns(fl.FileWarning, match=said) as told:
        lines = load(trx(**options), "a.trx")
    assert len(told) == 1
    np.testing.assert_array_equal(lines.segments, SEGMENTS)
    np.testing.assert_array_equal(lines.strands, STRANDS)


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"PK" + bytes(99), "not a whole .trx file"),
        (trx(header="[]"), "'header.json' does not count streamlines and vertices"),
        (trx(header="{"), "'header.json' does not count"),
        (trx(header="[" * 9999), "'header.json' does not count"),
        (trx(without="header"), "holds no 'header.json', so it is not a whole .trx file"),
        (trx(header='{"NB_STREAMLINES": 4.0, "NB_VERTICES": 7}'), "are not whole numbers"),
        (trx(header='{"NB_STREAMLINES": 4, "NB_VERTICES": -1}'), "are not whole numbers"),
        (trx(header='{"NB_STREAMLINES": 4, "NB_VERTICES": 8}'), r"positions are float32 of shape \(7, 3\); .*\(8, 3\)"),
        (trx(header='{"NB_STREAMLINES": 9, "NB_VERTICES": 7}'), r"offsets are .* shape \(5,\); .*\(10,\)"),
        (trx(without="pos"), r"positions are float32 of shape \(0, 3\)"),
        (trx(without="off"), r"offsets are int64 of shape \(1,\)"),
        (trx(points=POINTS.astype("<i4")), "positions are int32"),
        (trx(counts=[3, 1, 2]), "its 4 offsets, from 0 to 6, do not rise from 0 to the 7 points of its 3 streamlines"),
        (trx(counts=[3, -1, 5]), "do not rise"),
        (trx(method=zipfile.ZIP_BZIP2), "packed by an unknown method"),
        (trx(extra={"a": bytes(60_000_000)}, method=zipfile.ZIP_DEFLATED), "unpacks to more than"),
        (trx().replace(POINTS.tobytes()[:20], bytes(20)), "Bad CRC-32"),
    ],
)
def test_lies_are_told_in_one_sentence(load, data, said):
    assert re.search(said, message_of(load, data, "a.trx"))


@pytest.mark.filterwarnings("ignore::fastlines.FileWarning", "ignore::fastlines.PrecisionWarning")
def test_damaged_members(load):
    """Members are damaged before they are packed, as a checksum finds all damage after it."""
    with zipfile.ZipFile(io.BytesIO(trx(extra=TRX_EXTRA))) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    rng = np.random.default_rng(7)
    n_refused = 0
    for trial in range(300):
        name = list(members)[trial % len(members)]
        stream = io.BytesIO()
        with zipfile.ZipFile(stream, "w") as archive:
            for other, data in members.items():
                damaged = bytearray(data)
                if other == name and trial % 3:
                    damaged[rng.integers(len(damaged))] = rng.integers(256)
                elif other == name:
                    damaged = damaged[: rng.integers(len(damaged))]
                archive.writestr(other, bytes(damaged))
        try:
            lines = load(stream.getvalue(), "a.trx", invalid=("error", "skip")[trial % 2])
            assert len(lines.segments) == len(lines.strands)
        except FastlinesError:
            n_refused += 1
    assert 30 < n_refused < 270


# --- Written files ---


def test_round_trip(tmp_path, load):
    lines = replace(load(trx(extra=TRX_EXTRA), "a.trx"), metadata=AROUND)
    fl.write(tmp_path / "b.trx", lines)
    again = fl.read(tmp_path / "b.trx")
    np.testing.assert_array_equal(again.segments, lines.segments)
    np.testing.assert_array_equal(again.strands, lines.strands)
    assert {name: values.dtype for name, values in again.attributes.items()} == {
        name: values.dtype for name, values in lines.attributes.items()
    }
    for name, values in lines.attributes.items():
        np.testing.assert_array_equal(again.attributes[name], values)


def test_what_is_lost_is_told(tmp_path):
    lines = fl.Lines.from_segments(
        SEGMENTS,
        strands=[0, 0, 1, 2, 7],
        radius=1,
        attributes={"a/b": np.arange(5) // 2 * 0, "yes": np.ones(5, np.bool_), "word": np.array(["a"] * 5)},
    )
    said = r"'radius' is the radius.*'a/b' \('a_b' is written\).*'yes' is boolean.*'word', <U1.*numbers of strands"
    with pytest.warns(fl.FileWarning, match=said):
        fl.write(tmp_path / "a.trx", lines)
    again = fl.read(tmp_path / "a.trx")
    np.testing.assert_array_equal(again.segments, lines.segments)
    assert set(again.attributes) == {"radius", "a_b", "yes"}


def test_names_that_become_the_same_are_kept_apart(tmp_path):
    values = {"a/b": 1, "a_b": 2, "a.b": 3.5, "group a/b": True, "group a_b": False}
    per_segment = {name: np.full(5, value) for name, value in values.items()}
    lines = fl.Lines.from_segments(SEGMENTS, strands=[0, 0, 1, 2, 3], attributes=per_segment)
    with pytest.warns(fl.FileWarning) as told:
        fl.write(tmp_path / "a.trx", lines)
    for said in ("'a/b' ('a_b_' is", "'a.b' ('a_b__' is", "'group a/b' ('group a_b_' is"):
        assert said in str(told[0].message)
    expected = {"a_b_": 1, "a_b": 2, "a_b__": 3.5, "group a_b_": True, "group a_b": False}
    assert {name: v[0] for name, v in fl.read(tmp_path / "a.trx").attributes.items()} == expected


def test_trx_python_reads_it(tmp_path, load):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        library = pytest.importorskip("trx.trx_file_memmap")
    fl.write(tmp_path / "b.trx", load(trx(extra=TRX_EXTRA), "a.trx"), reference=AROUND["grid"])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        file = library.load(str(tmp_path / "b.trx"))
    np.testing.assert_array_equal(file.streamlines[2], POINTS[4:6])
    np.testing.assert_array_equal(file.groups["left"], [0, 3])
    np.testing.assert_array_equal(file.data_per_streamline["colour"], np.arange(12).reshape(4, 3))
    file.close()


def test_an_error_of_the_disk_is_no_damage(tmp_path, monkeypatch):
    (tmp_path / "a.trx").write_bytes(trx())

    def broken(*args, **kwargs):
        raise OSError(errno.EIO, "Input/output error")

    monkeypatch.setattr(zipfile.ZipExtFile, "read", broken)
    with pytest.raises(OSError, match="Input/output"):
        fl.read(tmp_path / "a.trx")


@pytest.mark.filterwarnings("ignore:Duplicate name")
@pytest.mark.parametrize("name", ["header.json", "positions.3.float32", "dpv/fa.float32"])
def test_a_name_that_is_there_twice_is_refused(load, name):
    data = io.BytesIO(trx(extra=TRX_EXTRA))
    with zipfile.ZipFile(data, "a") as archive:
        archive.writestr(name, b"")
    said = re.escape(f"holds several members named {name!r}; write it again with each name once")
    with pytest.raises(fl.FileFormatError, match=said):
        load(data.getvalue(), "a.trx")
