"""Trees in files: they come back as they were, mapped into memory; files that lie are refused, or harmless."""

from __future__ import annotations

import json
import os
import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support import nasty
from support.patience import HANGS
from support.slow import few_of
from support.tree_files import RAYS, SEGMENTS, joined, refused, rewritten, same_answers, saved, split, with_metadata

import fastlines as fl
from fastlines.support import container


@pytest.mark.parametrize("method", fl.METHODS)
@pytest.mark.parametrize("name", ["crossing", "points", "single", "empty", "hair", "scale 1e8", "moved 1e4"])
def test_round_trip(tmp_path: Path, method: str, name: str) -> None:
    case = nasty.cases(0)[name]
    tree = fl.build(case.segments, method)
    tree.save(tmp_path / "a.flt")
    back = fl.load(tmp_path / "a.flt")
    assert (back.method, back.settings, back.limits_hit) == (tree.method, tree.settings, tree.limits_hit)
    assert back.nodes.tobytes() == tree.nodes.tobytes()
    assert back.refs.tobytes() == tree.refs.tobytes()
    assert (back.nodes.dtype, back.refs.dtype) == (tree.nodes.dtype, tree.refs.dtype)
    back.validate()
    assert back.cost() == tree.cost()
    for radius in (0.0, case.radii["medium"], case.radii["per ray"]):
        one, other = (t.all_hits(case.origins, case.directions, radius) for t in (tree, back))
        assert one.prim.tobytes() == other.prim.tobytes()
        assert one.t.tobytes() == other.t.tobytes()
    # Saving what was loaded gives the same file, also over itself.
    back.save(tmp_path / "b.flt")
    before = (tmp_path / "a.flt").read_bytes()
    assert (tmp_path / "b.flt").read_bytes() == before
    back.save(tmp_path / "a.flt")
    assert (tmp_path / "a.flt").read_bytes() == before
    assert back.cost() == tree.cost()


def test_everything_that_lines_say_is_kept(tmp_path: Path) -> None:
    more = {"lookahead": [1, 2], "cost": fl.Cost(0.25), "limits": fl.Limits(max_refs=23, leaf_size=0.125)}
    tree, _ = saved(tmp_path / "a.flt", splits=(fl.PlaneGrid(5), fl.Median(max_refs=4)), **more)
    back = fl.load(tmp_path / "a.flt")
    assert back.settings == tree.settings
    assert back.limits_hit == tree.limits_hit
    assert "max_refs" in back.limits_hit
    for name in ("segments", "strands", "radius"):
        got, given = getattr(back.geometry, name), getattr(tree.geometry, name)
        assert got.dtype == given.dtype
        assert (got == given).all()
    assert back.geometry.attributes["id"].tolist() == list(range(20))


def test_is_mapped_aligned_and_read_only(tmp_path: Path) -> None:
    _, data = saved(tmp_path / "a.flt")
    back = fl.load(tmp_path / "a.flt")
    for array in (back.nodes, back.refs, back.geometry.segments, back.geometry.radius):
        base = array
        while not isinstance(base, np.memmap):
            assert base.base is not None, "the array is a copy"
            base = base.base
        assert not array.flags.writeable
        assert array.flags.aligned
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0
    header, _ = split(data)
    start = len(data) - max(entry["data_offsets"][1] for name, entry in header.items() if name != "__metadata__")
    assert start % 64 == 0
    for name, entry in header.items():
        if name != "__metadata__":
            assert (start + entry["data_offsets"][0]) % container.DTYPES[entry["dtype"]].itemsize == 0, name


@pytest.mark.parametrize("shift", [1, 2, 3, 4])
def test_sections_out_of_step_are_refused(tmp_path: Path, shift: int) -> None:
    """The core reads words: it must not be given any that start between two."""
    path = tmp_path / "a.flt"
    _, data = saved(path)
    header, body = split(data)
    text = json.dumps(header).encode()
    text += b" " * (-(8 + len(text)) % 64 + shift)
    path.write_bytes(len(text).to_bytes(8, "little") + text + body)
    with pytest.raises(fl.FileFormatError, match="multiple of 64"):
        fl.load(path)


def test_saving_is_all_or_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.flt"
    tree, before = saved(path)

    def fail(*_: object) -> None:
        raise OSError("disk full")

    monkeypatch.setattr(container.np, "ascontiguousarray", fail)
    with pytest.raises(OSError, match="disk full"):
        tree.save(path)
    monkeypatch.undo()
    assert path.read_bytes() == before
    assert [entry.name for entry in tmp_path.iterdir()] == ["a.flt"]
    with pytest.raises(OSError, match="missing"):
        tree.save(tmp_path / "missing" / "a.flt")
    with pytest.raises(OSError, match=r"a\.flt"):
        tree.save(path / "b.flt")
    (tmp_path / "folder").mkdir()
    with pytest.raises(OSError, match="folder"):
        tree.save(tmp_path / "folder")
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["a.flt", "folder"]
    assert path.read_bytes() == before


def test_odd_paths(tmp_path: Path) -> None:
    tree, _ = saved(tmp_path / "žluťoučký kůň.flt")
    assert same_answers(tree, fl.load(str(tmp_path / "žluťoučký kůň.flt")))
    for path in (tmp_path, tmp_path / "none.flt"):
        with pytest.raises(OSError, match=path.name):
            fl.load(path)
    for data in (b"", b"x", b"\0" * 8, b"\0" * 500, b"\xff" * 500, b"PK\3\4" + bytes(600)):
        (tmp_path / "bad.flt").write_bytes(data)
        with pytest.raises(fl.FileFormatError, match=r"bad\.flt is not a whole tree file"):
            fl.load(tmp_path / "bad.flt")


def test_checksums_that_are_not_the_last_section(tmp_path: Path) -> None:
    saved(path := tmp_path / "a.flt")
    header, body = split(path.read_bytes())
    entry = header["crc32"]
    n, end = entry["shape"][0], entry["data_offsets"][1]
    header["more"] = {"dtype": "U8", "shape": [n + 1, 4], "data_offsets": [end, end + 4 * n + 4]}
    head = joined(header, b"")
    sums = head, *(body[slice(*each["data_offsets"])] for name, each in header.items() if name != "__metadata__")
    right = b"".join(container.checksum(np.frombuffer(part, np.uint8)).to_bytes(4, "little") for part in sums[:-1])
    path.write_bytes(head + body + right)
    with pytest.raises(fl.FileFormatError, match="its checksums are not one for the header and each section before"):
        fl.load(path, verify=True)


def test_truncated_or_longer(tmp_path: Path) -> None:
    _, data = saved(tmp_path / "a.flt")
    (tmp_path / "a.flt").write_bytes(data[: len(data) // 2])
    with pytest.raises(fl.FileFormatError, match=f"promises {len(data)} bytes, but it has {len(data) // 2};"):
        fl.load(tmp_path / "a.flt")
    for n_bytes in [*range(0, len(data), 7), len(data) - 1, len(data) - 64]:
        refused(tmp_path / "a.flt", data[:n_bytes])
    for more in (b"\0", b"\0" * 64, data):
        refused(tmp_path / "a.flt", data + more)


#: Changes to the header, as text; and to the entry of a section.
METADATA: list[Any] = [
    None, [], "x", 3, {}, {"format": "fastlines tree 1"}, {"format": "fastlines tree 2"}, {"format": None},
    {"format": 1},
]  # fmt: skip
ENTRIES: list[Any] = [
    None, [], 3, "nodes", {}, {"dtype": "U32"},
    {"dtype": "F64"}, {"dtype": "u32"}, {"dtype": None}, {"dtype": ["U32"]}, {"dtype": {}}, {"dtype": "I64"},
    {"dtype": "F32"},
    {"shape": None}, {"shape": []}, {"shape": 9}, {"shape": "9"}, {"shape": [0, 9]}, {"shape": [-1, 9]},
    {"shape": [9, 0]}, {"shape": [1e300, 9]}, {"shape": [float("inf"), 9]}, {"shape": [float("nan"), 9]},
    {"shape": [10**30, 9]}, {"shape": [0, 10**30]}, {"shape": [2**64, 0]}, {"shape": [-(2**63), -1]},
    {"shape": [None, 9]}, {"shape": [[1], 9]}, {"shape": ["a", 9]}, {"shape": [True, 9]}, {"shape": [1] * 100},
    {"shape": {"a": 1}},
    {"data_offsets": None}, {"data_offsets": []}, {"data_offsets": [0]}, {"data_offsets": [0, 1, 2]},
    {"data_offsets": [0, 0]}, {"data_offsets": [-4, 0]}, {"data_offsets": [0, 2**63]}, {"data_offsets": [0, 10**4000]},
    {"data_offsets": [0, float("inf")]}, {"data_offsets": "00"}, {"data_offsets": [36, 0]}, {"data_offsets": {}},
    {"shape": [10**4000, 9], "data_offsets": [0, 36 * 10**4000]},
    {"shape": [0, 9], "data_offsets": [0, 0]}, {"shape": [0, 10**30], "data_offsets": [0, 0]},
    {"shape": [0, 2**62, 2**62], "data_offsets": [0, 0]}, {"shape": [0] * 65, "data_offsets": [0, 0]},
]  # fmt: skip
SETTINGS = [
    "", "null", "3", "[]", "{}", "[" * 100_000, "NaN", '{"splits": 3}',
    '{"splits": [], "boxes": "tight", "lookahead": [1], "cost": {}, "limits": {}}',
    '{"splits": [{"name": "grid"}], "boxes": "tight", "lookahead": [1], "cost": {}, "limits": {}}',
    '{"splits": [{"name": ["plane_grid"]}], "boxes": "tight", "lookahead": [1], "cost": {}, "limits": {}}',
    '{"splits": [{"name": "plane_grid", "n": 3}], "boxes": "tight", "lookahead": [1], "cost": {}, "limits": {}}',
    '{"splits": [{"name": "plane_grid"}], "boxes": "loose", "lookahead": [1], "cost": {}, "limits": {}}',
    '{"splits": [{"name": "plane_grid"}], "boxes": "tight", "lookahead": [1e999], "cost": {}, "limits": {}}',
    '{"splits": [{"name": "plane_grid"}], "boxes": "tight", "lookahead": [1], "cost": {"c_trav": NaN}, "limits": {}}',
    '{"splits": [{"name": "plane_grid"}], "boxes": "tight", "lookahead": [1], "cost": [], "limits": {"a": 1}}',
]  # fmt: skip


def test_lying_length_of_the_header(tmp_path: Path) -> None:
    _, data = saved(tmp_path / "a.flt")
    for length in (0, 1, 2, 7, 9, 2**20 + 1, 2**31, 2**32, 2**63, 2**64 - 1, 2**64 - 8, len(data)):
        refused(tmp_path / "a.flt", length.to_bytes(8, "little") + data[8:])


@pytest.mark.parametrize("text", [b"", b"null", b"[]", b"3", b'"x"', b"{", b"\xff", b"{}", b"NaN", b"[", b'{"a":'])
def test_header_that_is_none(tmp_path: Path, text: bytes) -> None:
    _, data = saved(tmp_path / "a.flt")
    for repeated in (1, 100_000):
        refused(tmp_path / "a.flt", joined(text * repeated, split(data)[1]))


@pytest.mark.parametrize("metadata", METADATA, ids=str)
def test_lying_metadata(tmp_path: Path, metadata: Any) -> None:
    header, body = split(saved(tmp_path / "a.flt")[1])
    refused(tmp_path / "a.flt", joined({**header, "__metadata__": metadata}, body))


@pytest.mark.parametrize("key", ["format", "method", "settings", "limits_hit"])
def test_lying_metadata_entry(tmp_path: Path, key: str) -> None:
    header, body = split(saved(tmp_path / "a.flt")[1])
    for value in (None, 3, [], {}):
        refused(tmp_path / "a.flt", joined(with_metadata(header, **{key: value}), body))


@pytest.mark.parametrize("number", [1, 3, 20])
def test_another_format_is_named(tmp_path: Path, number: int) -> None:
    header, body = split(saved(tmp_path / "a.flt")[1])
    (tmp_path / "a.flt").write_bytes(joined(with_metadata(header, format=f"fastlines tree {number}"), body))
    with pytest.raises(fl.FileFormatError, match=rf"its format is 'fastlines tree {number}', expected '.* tree 2'"):
        fl.load(tmp_path / "a.flt", verify=False)


@pytest.mark.parametrize("text", SETTINGS, ids=lambda text: text[:150])
def test_lying_settings(tmp_path: Path, text: str) -> None:
    header, body = split(saved(tmp_path / "a.flt")[1])
    refused(tmp_path / "a.flt", joined(with_metadata(header, settings=text), body))


def test_what_is_quoted_is_short_and_printable(tmp_path: Path) -> None:
    header, body = split(saved(tmp_path / "a.flt")[1])
    settings = json.loads(header["__metadata__"]["settings"])
    text = json.dumps(settings | {"\x82 \n" + "x" * 5000: 1})
    refused(tmp_path / "a.flt", joined(with_metadata(header, settings=text), body))
    with pytest.raises(fl.FileFormatError) as caught:
        fl.load(tmp_path / "a.flt", verify=False)
    assert str(caught.value).isprintable()


@pytest.mark.parametrize("text", ["3", "[3]", '{"a": null}', '{"a": 1e999}', '{"a": []}', "[" * 100_000, ""], ids=len)
def test_lying_limits(tmp_path: Path, text: str) -> None:
    header, body = split(saved(tmp_path / "a.flt")[1])
    refused(tmp_path / "a.flt", joined(with_metadata(header, limits_hit=text), body))


@pytest.mark.parametrize("change", ENTRIES, ids=lambda change: str(change)[:60])
@pytest.mark.parametrize("name", few_of(["nodes", "refs", "segments", "strands"], n=1))
def test_lying_entry(tmp_path: Path, name: str, change: Any) -> None:
    header, body = split(saved(tmp_path / "a.flt")[1])
    entry = {**header[name], **change} if isinstance(change, dict) and change else change
    if entry != header[name]:
        refused(tmp_path / "a.flt", joined({**header, name: entry}, body))
    refused(tmp_path / "a.flt", joined({key: value for key, value in header.items() if key != name}, body))


def test_arrays_that_lie(tmp_path: Path) -> None:
    path = tmp_path / "a.flt"
    tree, _ = saved(path)
    n_nodes, n_refs = tree.n_nodes, tree.n_refs
    leaf, inner = (int(np.flatnonzero(tree.is_leaf == is_leaf)[-1]) for is_leaf in (True, False))
    lies: list[tuple[str, int, str, Any]] = [
        ("nodes", 0, "right", 0), ("nodes", 0, "right", 1), ("nodes", 0, "right", n_nodes),
        ("nodes", 0, "right", 2**32 - 1), ("nodes", inner, "right", inner), ("nodes", inner, "right", 1),
        ("nodes", leaf, "right", leaf + 1), ("nodes", leaf, "right", 1),
        ("nodes", leaf, "first_ref", n_refs), ("nodes", leaf, "first_ref", 2**32 - 1),
        ("nodes", leaf, "n_refs", n_refs + 1), ("nodes", leaf, "n_refs", 2**32 - 1), ("nodes", leaf, "n_refs", 0),
        ("nodes", 0, "box", np.nan), ("nodes", leaf, "box", np.inf), ("nodes", leaf, "box", 99.0),
        ("nodes", inner, "box", 0.0), ("nodes", 0, "box", [[-9] * 3, [9] * 3]),
        ("refs", 0, "prim", 20), ("refs", 0, "prim", 2**32 - 1), ("refs", 0, "s0", np.nan), ("refs", 0, "s0", -0.5),
        ("refs", 0, "s0", np.inf), ("refs", 0, "s1", np.nan), ("refs", 0, "s1", -1.0),
    ]  # fmt: skip
    for section, row, field, value in lies:
        array = getattr(tree, section).copy()
        array[row][field] = value
        words = array.view(np.uint32).reshape(len(array), -1)
        refused(path, rewritten(tree, path, **{section: words}).read_bytes())
    # Pieces that are none of a tiling: hits would be told twice, or not at all.
    whole = tree.refs.copy()
    whole["s0"], whole["s1"] = 0, np.inf
    cut = np.flatnonzero(np.isfinite(tree.refs["s1"]))
    one_longer, one_shorter = tree.refs.copy(), tree.refs.copy()
    one_longer["s1"][cut[0]], one_shorter["s1"][cut[0]] = np.inf, tree.refs["s0"][cut[0]]
    elsewhere = tree.refs.copy()
    elsewhere["prim"] = np.roll(tree.refs["prim"], 1)
    for refs in (whole, one_longer, one_shorter, elsewhere):
        refused(path, rewritten(tree, path, refs=refs.view(np.uint32).reshape(-1, 3)).read_bytes())
    # Leaves that do not hold their pieces: a box that is a corner, and one that is a little too small.
    for shrink in (1.0, 0.01):
        nodes = tree.nodes.copy()
        low, high = nodes["box"][leaf]
        nodes["box"][leaf, 1] = high - np.float32(shrink) * (high - low)
        refused(path, rewritten(tree, path, nodes=nodes.view(np.uint32).reshape(-1, 9)).read_bytes())
    for changed in (
        {"skipped": np.array([-1])},
        {"skipped": np.array([3, 3])},
        {"skipped": np.array([21])},
        {"segments": np.full_like(SEGMENTS, np.nan)},
        {"segments": SEGMENTS[:-1]},
        {"segments": 2 * SEGMENTS},
        {"segments": np.empty((0, 2, 3), np.float32), "strands": np.empty(0, np.int64)},
        {"strands": np.zeros(19, np.int64)},
        {"radius": np.zeros(19, np.float32)},
        {"nodes": np.empty((0, 9), np.uint32)},
        {"refs": np.empty((0, 3), np.uint32)},
    ):
        refused(path, rewritten(tree, path, **changed).read_bytes())


#: Loads a file with bytes changed, again and again, and asks what it accepts everything. Prints how many it accepted.
FLIPS = """
import os, pickle, sys
import numpy as np, fastlines as fl

def same(one, other):
    names = ("offsets", "t", "prim", "u", "distance")
    return all(getattr(one, name).tobytes() == getattr(other, name).tobytes() for name in names)

path, seed, n_rounds = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
data, origins, directions = pickle.load(sys.stdin.buffer)
rng = np.random.default_rng(seed)
header = 8 + int.from_bytes(data[:8], "little")
accepted = 0
for _ in range(n_rounds):
    changed = bytearray(data)
    for _ in range(rng.integers(1, 4)):
        place = rng.integers(0, header) if rng.random() < 0.3 else rng.integers(header, len(data))
        how = rng.integers(0, 4)
        if how == 0:
            changed[place] ^= 1 << rng.integers(0, 8)
        elif how == 1:
            changed[place] = rng.integers(0, 256)
        elif how == 2:
            place = place // 4 * 4
            changed[place : place + 4] = changed[(other := rng.integers(header, len(data) - 4) // 4 * 4) : other + 4]
        else:
            place = place // 4 * 4
            word = int(rng.choice([0, 1, 2**31, 2**32 - 1, 0x7F800000, 0x7F7FFFFF]))
            changed[place : place + 4] = word.to_bytes(4, "little")
    with open(path, "wb") as file:
        file.write(changed)
    try:
        fl.load(path, verify=True)
    except fl.FastlinesError as error:
        assert "\\n" not in str(error)
    else:
        assert changed == data
    try:
        tree = fl.load(path, verify=False)
    except fl.FastlinesError as error:
        assert "\\n" not in str(error)
        continue
    accepted += 1
    for radius in (0.0, 0.1, 9.0):
        right = fl.brute_force(tree.geometry, origins, directions, radius)
        counts = np.diff(right.offsets)
        for kernel in ("auto", "binary"):
            first = tree.first_hit(origins, directions, radius, kernel=kernel)
            assert (first.prim[counts > 0] == right.prim[right.offsets[:-1][counts > 0]]).all()
            assert (first.prim[counts == 0] == -1).all()
            assert (tree.any_hit(origins, directions, radius, kernel=kernel) == (counts > 0)).all()
            assert (tree.count_hits(origins, directions, radius, kernel=kernel) == counts).all()
            assert same(tree.all_hits(origins, directions, radius, kernel=kernel), right)
    repr(tree), tree.stats(), tree.levels(), tree.cost(by="g")
    try:
        tree.validate()
    except fl.InvalidTreeError as error:
        assert 0 <= error.node < tree.n_nodes
print(accepted)
"""


@pytest.mark.parametrize("seed", few_of(range(4), n=0))
@pytest.mark.parametrize("method", ["bvh-d2", "kd-d2"])
def test_changed_bytes_are_refused_or_answer_right(tmp_path: Path, seed: int, method: str) -> None:
    _, data = saved(tmp_path / "a.flt", method=method)
    n_rounds = 300
    ended = subprocess.run(
        [sys.executable, "-W", "error", "-c", FLIPS, str(tmp_path / "b.flt"), str(seed), str(n_rounds)],
        input=pickle.dumps((data, *RAYS)),
        capture_output=True,
        timeout=HANGS,
        check=False,
        env={**os.environ, "FASTLINES_NUM_THREADS": "1"},
    )
    assert ended.returncode == 0, f"exit code {ended.returncode}: {ended.stderr.decode()[-3000:]}"
    assert 0 < int(ended.stdout) < n_rounds, "both should happen"


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs pipes")
def test_a_pipe_is_no_tree(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.flt")
    with pytest.raises(fl.FileFormatError, match="not a regular file"):
        fl.load(tmp_path / "pipe.flt")
