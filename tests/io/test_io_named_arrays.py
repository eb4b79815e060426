"""Named arrays: .npz and .safetensors, read and written."""

from __future__ import annotations

import json
import re
import struct

import numpy as np
import pytest
from support.line_files import COUNTS, POINTS, message_of, npz, safetensors

import fastlines as fl
from fastlines.errors import FastlinesError, FileWarning

N_CURVES = 3
CONTROL = np.arange(36, dtype="f4").reshape(N_CURVES, 4, 3) ** 1.25
COEFFICIENTS = np.array([[1, -0.5, 0.25, 2]] * N_CURVES, "f4")
WRITERS = {".npz": npz, ".safetensors": safetensors}


def same(left, right) -> None:
    """Assert that two containers hold the same bits."""
    assert type(left) is type(right)
    for name in ("segments", "control", "strands", "radius", "up", "unit", "tolerance"):
        mine, other = getattr(left, name, None), getattr(right, name, None)
        if isinstance(mine, np.ndarray):
            assert mine.dtype == other.dtype
            assert mine.tobytes() == other.tobytes(), name
        else:
            assert mine == other, name
    for kind in ("attributes", "end_attributes"):
        mine, other = getattr(left, kind), getattr(right, kind)
        assert sorted(mine) == sorted(other)
        for name, values in mine.items():
            assert other[name].dtype == values.dtype
            assert other[name].shape == values.shape
            assert other[name].tobytes() == values.tobytes(), name


def all_kinds() -> dict[str, fl.Lines | fl.Curves]:
    n = 5
    rng = np.random.default_rng(1)
    columns = {
        "id": np.arange(n, dtype="u2"),
        "color": rng.random((n, 3), np.float32),
        "file": np.arange(n, dtype="i1"),  # an argument of numpy.savez
        "up": np.arange(n) % 2 == 0,
        "radius": np.arange(n) / 3,
        "attributes/odd": np.arange(n, dtype="f2"),
        "matrix": rng.random((n, 2, 2)),
    }
    ends = {
        "fa": rng.random((n, 2), np.float32),
        "uv": rng.random((n, 2, 2)),
        "strands": np.arange(2 * n).reshape(n, 2),
    }
    segments = rng.random((n, 2, 3), np.float32)
    full = fl.Lines(
        segments,
        np.array([3, 3, 4, 9, 9]),
        rng.random((n, 2), np.float32),
        columns,
        up="y",
        unit="µm",
        end_attributes=ends,
    )
    return {
        "full": full,
        "plain": fl.Lines(segments),
        "radius": fl.Lines(segments, radius=rng.random(n, np.float32)),
        "none": fl.Lines(segments[:0]),
        "curves": fl.Curves(
            CONTROL,
            COEFFICIENTS,
            np.array([0, 0, 1]),
            {"id": np.arange(N_CURVES)},
            {"t": np.ones((N_CURVES, 2))},
            up="z",
            unit="m",
            tolerance=0.1,
        ),
        "plain curves": fl.Curves(CONTROL),
    }


@pytest.mark.parametrize("extension", [".npz", ".safetensors", ".npz.gz", ".safetensors.GZ"])
@pytest.mark.parametrize("kind", all_kinds())
@pytest.mark.filterwarnings("ignore:.*its radius is up to:fastlines.FileWarning")
def test_round_trip(tmp_path, extension, kind):
    given = all_kinds()[kind]
    fl.write(tmp_path / f"a{extension}", given)
    same(given, fl.read(tmp_path / f"a{extension}"))


@pytest.mark.parametrize("extension", WRITERS)
def test_what_is_no_number_is_reported(tmp_path, extension):
    lines = fl.Lines(
        np.zeros((1, 2, 3), "f4"), attributes={"name": np.array([None]), "z": np.array([1j]), "a\0b": np.ones(1)}
    )
    with pytest.warns(FileWarning, match=r"not kept.*'name' \(object\); 'z' \(complex128\); 'a\?x00b'|a.x00b"):
        fl.write(tmp_path / f"a{extension}", lines)
    assert not fl.read(tmp_path / f"a{extension}").attributes


def test_safetensors_are_little_endian_and_aligned(tmp_path):
    lines = fl.Lines(
        np.zeros((3, 2, 3), "f4"), attributes={"a": np.arange(3, dtype=">i2"), "b": np.arange(3, dtype="u1")}
    )
    fl.write(tmp_path / "a.safetensors", lines)
    data = (tmp_path / "a.safetensors").read_bytes()
    length = struct.unpack("<Q", data[:8])[0]
    assert (8 + length) % 64 == 0
    offsets = [entry["data_offsets"][0] for name, entry in json.loads(data[8 : 8 + length]).items() if name[0] != "_"]
    assert len(offsets) == 4
    back = fl.read(tmp_path / "a.safetensors")
    np.testing.assert_array_equal(back.attributes["a"], [0, 1, 2])
    assert back.segments.flags.aligned


def test_safetensors_of_others(tmp_path):
    library = pytest.importorskip("safetensors.numpy")
    library.save_file(
        {"points": POINTS, "counts": np.array(COUNTS), "age": np.arange(7, dtype="f2")},
        tmp_path / "a.safetensors",
        {"format": "np", "unit": "mm"},
    )
    lines = fl.read(tmp_path / "a.safetensors")
    assert lines.n_strands == 4
    assert lines.unit == "mm"
    np.testing.assert_array_equal(lines.end_attributes["age"][0], [0, 1])
    fl.write(tmp_path / "b.safetensors", lines)
    loaded = library.load_file(tmp_path / "b.safetensors")
    np.testing.assert_array_equal(loaded["segments"], lines.segments)
    np.testing.assert_array_equal(loaded["end_attributes/age"], lines.end_attributes["age"])


def test_unaligned_tensors_are_read(load):
    lines = load(safetensors(age=np.ones(3, "u1"), segments=POINTS[:6].reshape(3, 2, 3)), "a.safetensors")
    np.testing.assert_array_equal(lines.segments.reshape(-1, 3), POINTS[:6])


@pytest.mark.parametrize("extension", WRITERS)
def test_curves(load, extension):
    file = WRITERS[extension]
    assert load(file(control=CONTROL, radius=np.ones(3, "f4")), f"a{extension}").radius.shape == (3, 4)
    curves = load(file(control=CONTROL, radius=np.float32([[1, 4]] * 3)), f"a{extension}")
    np.testing.assert_array_equal(curves.radius[0], [1, 2, 3, 4])
    bad = CONTROL.copy()
    bad[1, 2, 0] = np.nan
    curves = load(file(control=bad, radius=COEFFICIENTS * np.float32([[1], [2], [3]])), f"a{extension}", invalid="skip")
    assert list(curves.rows) == [0, 2]
    np.testing.assert_array_equal(curves.radius, COEFFICIENTS[[0, 2]] * np.float32([[1], [3]]))


@pytest.mark.parametrize("extension", WRITERS)
@pytest.mark.parametrize(
    ("arrays", "said"),
    [
        ({"control": CONTROL[:, :3]}, r"'control' has shape \(3, 3, 3\); expected \(3, 4, 3\)"),
        ({"control": CONTROL, "radius": -COEFFICIENTS}, "not negative at both ends of a curve .see rows 0, 1, 2"),
        ({"control": CONTROL, "radius": COEFFICIENTS * [[1], [-1], [1]]}, "not negative at both .* .see row 1"),
        ({"control": CONTROL, "radius": COEFFICIENTS[:, :3]}, r"'radius' has shape \(3, 3\); expected \(3,\)"),
        ({"control": CONTROL, "counts": np.ones(3, "i8")}, "holds the arrays .*; expected 'segments' or 'control'"),
        (
            {"control": CONTROL, "end_attributes/t": np.ones(3)},
            r"'end_attributes/t' has shape \(3,\); expected \(3, 2\)",
        ),
        ({"control": CONTROL, "t": np.ones(3), "attributes/t": np.ones(3)}, "attribute 't' is in it twice"),
        ({"control": CONTROL, "t": np.ones(3), "end_attributes/t": np.ones((3, 2))}, "'t' is in attributes and in"),
    ],
)
def test_arrays_that_do_not_fit(load, extension, arrays, said):
    text = message_of(load, WRITERS[extension](**arrays), f"a{extension}", FastlinesError)
    assert re.search(said, text), text


@pytest.mark.parametrize(
    ("facts", "said"),
    [
        ({"up": "w"}, "'up' is 'w'; expected 'x', 'y' or 'z'"),
        ({"unit": ""}, "'unit' is ''; expected the name of a unit"),
        ({"tolerance": "1"}, "'tolerance' is '1'; expected a length above 0, and of curves only"),
    ],
)
def test_facts_that_are_none(load, facts, said):
    segments = POINTS[:6].reshape(3, 2, 3)
    assert said in message_of(load, safetensors(facts, segments=segments), "a.safetensors")
    assert said in message_of(load, npz(segments=segments, **facts), "a.npz")


@pytest.mark.parametrize("unit", [b"mm", 1j, np.datetime64("2000"), np.array(["mm"])])
def test_a_fact_is_one_text(load, unit):
    text = message_of(load, npz(segments=POINTS[:6].reshape(3, 2, 3), unit=unit), "a.npz")
    assert f"'unit': holds {np.asarray(unit).dtype}; expected real numbers" in text


def test_tolerance_of_curves_is_a_length(load):
    for text in ("0", "-1", "nan", "inf", "wide"):
        assert "'tolerance' is" in message_of(load, npz(control=CONTROL, tolerance=text), "a.npz")
    assert load(npz(control=CONTROL, tolerance="0.5"), "a.npz").tolerance == 0.5


def test_arrays_called_like_facts_are_attributes_as_before(load):
    lines = load(npz(segments=POINTS[:6].reshape(3, 2, 3), up=[1, 2, 3], unit=np.ones(3)), "a.npz")
    assert sorted(lines.attributes) == ["unit", "up"]
    assert lines.up is None


ENTRY = '{"segments": {"dtype": "F32", "shape": [1, 6], "data_offsets": [0, 24]}%s}'


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"1234567", "lengths of the header .* do not fit"),
        (struct.pack("<Q", 2**63), "its header has 9223372036854775808 bytes, expected at most"),
        (struct.pack("<Q", 100) + b"{}", "bytes of the header .* do not fit"),
        (safetensors(header=b"[]"), "its header is not that of a safetensors file; check the extension"),
        (safetensors(header=b"[" * 100_000), "its header is not that"),
        (safetensors(header=b'{"a": 1}'), "its header is not that"),
        (safetensors(header=b'{"__metadata__": {"up": 1}}'), "its header is not that"),
        (safetensors(header=b'{"a": {"dtype": "F32", "shape": 1e999, "data_offsets": [0, 1]}}'), "its header is not"),
        (safetensors(header=(ENTRY % ', "segments": 1').encode()), "its header is not that"),
        (safetensors(header=b"{}"), "holds the arrays .none."),
        (
            safetensors(header=(ENTRY % "").encode()),
            "'segments' ends at byte .*, and the file has fewer; the file is cut",
        ),
        (safetensors(header=(ENTRY % "").encode(), tail=bytes(25)), "1 bytes are left over behind its last array"),
        (safetensors(header=ENTRY.replace("[0,", "[4,").encode() % b"", tail=bytes(24)), "'segments' is not where the"),
        (safetensors(header=ENTRY.replace("24", "20").encode() % b"", tail=bytes(24)), "does not have 20 bytes; fix"),
        (
            safetensors(header=ENTRY.replace("F32", "BF16").encode() % b"", tail=bytes(24)),
            "is of type BF16; expected one of",
        ),
        (safetensors(header=ENTRY.replace("1, 6", "-1, -6").encode() % b"", tail=bytes(24)), "has a wrong shape"),
        (
            safetensors(header=ENTRY.replace("1, 6", "1," * 99 + "6").encode() % b"", tail=bytes(24)),
            "has a wrong shape",
        ),
        (safetensors(header=ENTRY.replace("1, 6", f"{2**62}, 0").encode() % b"", tail=bytes(24)), "has a wrong shape"),
    ],
)
def test_headers_that_lie(load, data, said):
    text = message_of(load, data, "a.safetensors")
    assert re.search(said, text), text


@pytest.mark.filterwarnings("ignore::fastlines.PrecisionWarning")
@pytest.mark.parametrize("extension", WRITERS)
def test_texts(tmp_path, load, extension):
    names, ends = ["oak", "", "oak"], [["a", "b"], ["ö", "a"], ["", "b"]]
    lines = fl.Lines(np.zeros((3, 2, 3), "f4"), attributes={"name": np.array(names), "radius": np.array(names, object)},
                     end_attributes={"atom": np.array(ends, object)})  # fmt: skip
    fl.write(tmp_path / f"a{extension}", lines)
    again = fl.read(tmp_path / f"a{extension}")
    assert again.attributes["name"].tolist() == again.attributes["radius"].tolist() == names
    assert again.end_attributes["atom"].tolist() == ends
    arrays = {"segments": np.zeros((1, 2, 3)), "name": np.array([1], "i4"), "texts/name": np.frombuffer(b'["a"]', "u1")}
    data = npz(**arrays) if extension == ".npz" else safetensors(**arrays)
    assert "the texts of 'name' do not fit its numbers" in message_of(load, data, f"b{extension}")


@pytest.mark.filterwarnings("ignore:.*its radius is up to:fastlines.FileWarning")
def test_damaged_curves(load):
    data = safetensors(
        {"unit": "m", "tolerance": "0.5"}, control=CONTROL, radius=COEFFICIENTS, **{"end_attributes/t": np.ones((3, 2))}
    )
    rng = np.random.default_rng(11)
    n_read = 0
    messages = []
    for trial in range(500):
        damaged = bytearray(data)
        for at in rng.integers(len(data), size=1 + trial % 3):
            damaged[at] = rng.integers(256)
        try:
            n_read += len(load(bytes(damaged), "a.safetensors", invalid=("error", "skip")[trial % 2])) <= N_CURVES
        except FastlinesError as error:
            messages.append(str(error))
    assert n_read > 50
    assert not any("\n" in message for message in messages)
