"""Layouts in tree files: they come back as they were, mapped into memory; layouts that lie are refused, or harmless."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support import nasty
from support.builds import ALL_KINDS
from support.tree_files import RAYS, SEGMENTS, split

import fastlines as fl
import fastlines.cuda.placed_tree
from fastlines.structure import layout_file, tree_file
from fastlines.structure.layout import BLOCK
from fastlines.support import container
from fastlines.tree import Tree

GRID = [("org", "<f4", 3), ("scale", "<f4")]
CHILDREN = [("first_inner", "<u4"), ("first_leaf", "<u4"), ("n_inner", "u1"), ("n_children", "u1")]
NODE = np.dtype([*GRID, *CHILDREN, ("unused", "u1", 6), ("planes", "u1", 96)])
PIECES = [("first_ref", "<u4"), ("n_refs", "<u2"), ("shape", "<u2"), ("radius", "<f4")]
LEAF = np.dtype([*GRID, ("inv_scale", "<f4"), *PIECES, ("ends", "u1", 96)])
SAVED = [kind for kind in ALL_KINDS if kind != "one's own"]


def refuse(*_: Any, **__: Any) -> None:
    raise AssertionError("the layout was built")


def hits_of(tree: fl.Tree) -> list[bytes]:
    found = [tree.all_hits(*RAYS, 0.1, kernel=kernel) for kernel in ("auto", "single", "wave", "bundle")]
    near = tree.nearest(RAYS[0], k=3)
    columns = [getattr(hits, name) for hits in found for name in ("offsets", "prim", "t", "u", "distance")]
    boxed = tree.in_box([-0.5] * 3, [0.5] * 3)
    return [array.tobytes() for array in (*columns, near.prim, near.distance, boxed.prim)]


@pytest.mark.parametrize("method", ["best", "kd-cl"])
@pytest.mark.parametrize("kind", SAVED)
def test_round_trip(tmp_path: Path, kind: str, method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    tree = fl.build(ALL_KINDS[kind](SEGMENTS), method)
    expected = hits_of(tree)
    tree.save(tmp_path / "a.flt", layout=True)
    monkeypatch.setattr(fastlines.cuda.placed_tree, "build_layout", refuse)
    for verify, trusted in ((None, False), (False, False), (False, True)):
        back = tree_file.read(Tree, tmp_path / "a.flt", verify, trusted=trusted)
        assert hits_of(back) == expected
        for name in ("nodes", "leaves", "refs"):
            array, given = getattr(back.layout, name), getattr(tree.layout, name)
            assert array.tobytes() == given.tobytes()
            base = array
            while not isinstance(base, np.memmap):
                assert base.base is not None, f"{name} are a copy"
                base = base.base
            if name != "refs":
                assert array.ctypes.data % BLOCK == 0
    # Saving what was loaded gives the same file.
    back.save(tmp_path / "b.flt", layout=True)
    assert (tmp_path / "b.flt").read_bytes() == (tmp_path / "a.flt").read_bytes()


def test_of_many_nodes(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    starts = rng.random((5000, 1, 3))
    ends = starts + rng.normal(0, 0.02, (5000, 1, 3))
    tree = fl.build(fl.Lines.from_segments(np.concatenate([starts, ends], axis=1)))
    tree.save(tmp_path / "a.flt", layout=True)
    back = fl.load(tmp_path / "a.flt")
    assert back.layout.nodes.view(NODE)["n_inner"].max() > 2
    assert hits_of(back) == hits_of(tree)


def test_files_without_a_layout_have_no_trace_of_it(tmp_path: Path) -> None:
    tree = fl.build(SEGMENTS)
    tree.save(tmp_path / "a.flt", layout=True)
    fl.load(tmp_path / "a.flt").save(tmp_path / "b.flt")
    tree.save(tmp_path / "c.flt")
    assert (tmp_path / "b.flt").read_bytes() == (tmp_path / "c.flt").read_bytes()
    assert b"layout" not in (tmp_path / "c.flt").read_bytes()


def test_of_an_empty_tree_and_of_moved_lines_in_a_frame(tmp_path: Path) -> None:
    fl.build(np.zeros((0, 2, 3))).save(tmp_path / "empty.flt", layout=True)
    assert not fl.load(tmp_path / "empty.flt").any_hit([0, 0, -5], [0, 0, 1], 1)
    tree = fl.build(SEGMENTS, frame=[[-9] * 3, [9] * 3])
    hits_of(tree)
    moved = tree.refit(SEGMENTS * 0.5)
    moved.save(tmp_path / "moved.flt", layout=True)
    back = fl.load(tmp_path / "moved.flt")
    assert back.layout.view.frame == moved.layout.view.frame
    assert hits_of(back) == hits_of(moved) == hits_of(fl.build(SEGMENTS * 0.5, frame=[[-9] * 3, [9] * 3]))


def test_another_form_is_laid_out_anew(tmp_path: Path) -> None:
    tree = fl.build(SEGMENTS)
    tree.save(tmp_path / "a.flt", layout=True)
    arrays, metadata = container.read(tmp_path / "a.flt")
    facts = {"form": layout_file.FORM + 1}
    container.write(tmp_path / "b.flt", arrays, {**metadata, layout_file.KEY: json.dumps(facts)}, BLOCK)
    back = fl.load(tmp_path / "b.flt")
    assert "layout" not in back.__dict__
    assert hits_of(back) == hits_of(tree)


def test_more_sections(tmp_path: Path) -> None:
    tree = fl.build(SEGMENTS)
    more = {"ids": np.arange(20) * 7, "flags": np.arange(20) % 2 == 0}
    for layout in (False, True):
        tree_file.write(tree, tmp_path / "a.flt", layout=layout, more=more)
        back = tree_file.read_more(tmp_path / "a.flt")
        assert back.keys() == more.keys()
        for name, values in more.items():
            np.testing.assert_array_equal(back[name], values)
            assert not back[name].flags.writeable
        assert hits_of(fl.load(tmp_path / "a.flt")) == hits_of(tree)
    tree.save(tmp_path / "a.flt")
    assert tree_file.read_more(tmp_path / "a.flt") == {}


def thick_lines() -> fl.Lines:
    more: dict[str, Any] = {"strands": np.arange(20) // 3, "attributes": {"id": np.arange(20)}}
    more["end_attributes"] = {"at": np.arange(40.0).reshape(20, 2)}
    return fl.Lines.from_segments(SEGMENTS, radius=np.linspace(0.1, 1, 40).reshape(20, 2), **more)


@pytest.mark.parametrize("trusted", [False, True])
def test_rows_of_thick_lines_are_mapped(tmp_path: Path, trusted: bool) -> None:
    tree = fl.build(thick_lines())
    tree.save(tmp_path / "a.flt", layout=True)
    back = tree_file.read(Tree, tmp_path / "a.flt", trusted=trusted)
    assert isinstance(back.geometry, fl.Lines)
    for rows in (back.geometry.core_rows, back.geometry.cone_rows):
        assert isinstance(rows, np.memmap)
        assert not rows.flags.writeable
        np.testing.assert_array_equal(rows, tree.geometry.core_rows)
    assert hits_of(back) == hits_of(tree)
    spread = [each.all_hits(*RAYS, 0.0, spread=0.01) for each in (tree, back)]
    np.testing.assert_array_equal(spread[0].t, spread[1].t)


def test_trusted_lines_are_those_that_were_saved(tmp_path: Path) -> None:
    lines = thick_lines()
    for each in (lines, lines.without_radius(), fl.Spheres.from_centres(SEGMENTS[:, 0], 1)):
        fl.build(each).save(tmp_path / "a.flt", layout=True)
        back = tree_file.read(Tree, tmp_path / "a.flt", trusted=True).geometry
        checked = fl.load(tmp_path / "a.flt").geometry
        assert type(back) is type(checked) is type(each)
        for field in fields(fl.Lines):
            for got, expected in zip(*(leaves_of(getattr(of, field.name)) for of in (back, checked)), strict=True):
                np.testing.assert_array_equal(got, expected)
                assert not isinstance(got, np.ndarray) or not got.flags.writeable
        with pytest.raises(AttributeError):
            back.radius = None  # type: ignore[misc]


def leaves_of(value: Any) -> list[Any]:
    return [*value.keys(), *value.values()] if isinstance(value, Mapping) else [value]


# --- Layouts that lie ---


def test_rows_that_are_not_those_of_the_lines_are_refused(tmp_path: Path) -> None:
    tree = fl.build(thick_lines())
    tree.save(tmp_path / "a.flt", layout=True)
    arrays, metadata = container.read(tmp_path / "a.flt")
    rows, facts = arrays["layout/cone_rows"].copy(), json.loads(metadata[layout_file.KEY])
    rows[3, 7] += 1
    lies: list[tuple[dict[str, Any], dict[str, Any]]] = [
        ({**arrays, "layout/cone_rows": rows}, facts),
        ({**arrays, "layout/cone_rows": rows[:-1]}, facts),
        ({**arrays, "layout/cone_rows": rows.reshape(-1)}, facts),
        ({name: array for name, array in arrays.items() if name != "layout/cone_rows"}, facts),
        (arrays, {**facts, "max_radius": 0.5}),
        (arrays, {**facts, "max_radius": "1"}),
        (arrays, {name: value for name, value in facts.items() if name != "max_radius"}),
    ]
    for changed, said in lies:
        container.write(tmp_path / "b.flt", changed, {**metadata, layout_file.KEY: json.dumps(said)}, BLOCK)
        with pytest.raises(fl.FileFormatError, match=r"b\.flt is not a usable tree file"):
            fl.load(tmp_path / "b.flt", verify=False)


def broken(path: Path, tree: fl.Tree, section: str, rows: Any) -> Path:
    """Save a tree with other rows of its layout, and right checksums."""
    tree.save(path, layout=True)
    arrays, metadata = container.read(path)
    like = arrays[f"layout/{section}"]
    arrays[f"layout/{section}"] = np.ascontiguousarray(rows).view(like.dtype).reshape(-1, like.shape[1])
    container.write(path, arrays, metadata, BLOCK)
    return path


def scene(kind: str) -> fl.Tree:
    segments = nasty.crossing(np.random.default_rng(1), 400).astype(np.float32)
    return fl.build(ALL_KINDS[kind](segments), "bvh-cl")


FAULTS: list[tuple[str, str, Any]] = [
    ("nodes", "first_inner", [0, 1, 2**32 - 1, 2**31, 400]),
    ("nodes", "first_leaf", [2**32 - 1, 2**32 - 16, 2**31, 10_000]),
    ("nodes", "n_inner", [17, 255]),
    ("nodes", "n_children", [0, 17, 255]),
    ("nodes", "org", [np.nan, np.inf]),
    ("nodes", "scale", [0, -1, np.nan, np.inf]),
    ("leaves", "first_ref", [1, 2**32 - 1, 2**32 - 16, 10_000]),
    ("leaves", "n_refs", [17, 2**16 - 1, 0]),
    ("leaves", "shape", [2, 2**16 - 1]),
    ("leaves", "scale", [0, np.nan, -np.inf]),
    ("leaves", "inv_scale", [0, np.nan, np.inf]),
    ("leaves", "radius", [-1, np.nan, np.inf]),
    ("leaves", "org", [np.nan]),
    ("refs", "prim", [400, 2**31, 2**32 - 1, 7]),
    ("refs", "s", [1, 2**31]),
]


@pytest.mark.parametrize("kind", ["segments", "round cones", "triangles"])
@pytest.mark.parametrize(("section", "field", "values"), FAULTS, ids=lambda of: of if isinstance(of, str) else "")
def test_a_wrong_field_is_refused(tmp_path: Path, section: str, field: str, values: Any, kind: str) -> None:
    tree = scene(kind)
    like = {"nodes": NODE, "leaves": LEAF, "refs": np.dtype([("prim", "<u4"), ("s", "<u4")])}[section]
    good = getattr(tree.layout, section).copy().view(like)[:, 0]
    for value in values:
        # Of a node that has inner children, so that their index counts.
        rows = [0] if section == "nodes" else [0, len(good) // 2, len(good) - 1]
        for row in rows:
            bad = good.copy()
            bad[field][row] = value
            if (bad == good).all():
                continue
            path = broken(tmp_path / "a.flt", tree, section, bad)
            for verify in (None, False):
                with pytest.raises(fl.FileFormatError, match=r"a\.flt is not a usable tree file: .*(layout|section)"):
                    fl.load(path, verify=verify)


def test_wrong_graphs_are_refused(tmp_path: Path) -> None:
    tree = scene("segments")
    nodes, leaves = tree.layout.nodes.copy().view(NODE)[:, 0], tree.layout.leaves.copy().view(LEAF)[:, 0]
    inner = np.flatnonzero(nodes["n_inner"])
    assert len(inner) > 1
    cycle, shared, lost = nodes.copy(), nodes.copy(), nodes.copy()
    cycle["first_inner"][inner[-1]] = 0
    shared["first_inner"][0] += 1
    lost["n_inner"][0] -= 1
    for bad in (cycle, shared, lost, nodes[:-1], nodes[:0], np.concatenate([nodes, nodes[-1:]])):
        with pytest.raises(fl.FileFormatError, match="of the layout"):
            fl.load(broken(tmp_path / "a.flt", tree, "nodes", bad), verify=False)
    for rows in (leaves[:-1], leaves[:0], np.concatenate([leaves, leaves[-1:]]), leaves[::-1]):
        with pytest.raises(fl.FileFormatError, match="of the layout"):
            fl.load(broken(tmp_path / "a.flt", tree, "leaves", rows), verify=False)
    for refs in (tree.layout.refs[:-1], tree.layout.refs[:0], np.concatenate([tree.layout.refs] * 2)):
        with pytest.raises(fl.FileFormatError, match="of the layout"):
            fl.load(broken(tmp_path / "a.flt", tree, "refs", refs), verify=False)


def test_a_chain_that_is_too_deep_is_refused(tmp_path: Path) -> None:
    tree = fl.build(SEGMENTS[:1])
    n = 5000
    nodes = np.repeat(tree.layout.nodes.view(NODE)[:, 0], n)
    nodes["first_inner"], nodes["n_inner"] = np.arange(1, n + 1), 1
    nodes["n_inner"][-1] = 0
    with pytest.raises(fl.FileFormatError, match="too deep"):
        fl.load(broken(tmp_path / "a.flt", tree, "nodes", nodes))


@pytest.mark.parametrize("section", ["nodes", "leaves", "refs"])
def test_sections_of_another_shape_are_refused(tmp_path: Path, section: str) -> None:
    tree = scene("segments")
    tree.save(tmp_path / "a.flt", layout=True)
    arrays, metadata = container.read(tmp_path / "a.flt")
    name = f"layout/{section}"
    others = [
        None,
        arrays[name][:, :1],
        arrays[name].reshape(-1),
        arrays[name].view("<i4" if section == "refs" else "i1"),
    ]
    for other in others:
        changed = {**arrays, name: other} if other is not None else {k: v for k, v in arrays.items() if k != name}
        order = sorted(changed.items(), key=lambda item: -item[1].dtype.itemsize)
        container.write(tmp_path / "b.flt", dict(order), metadata)
        with pytest.raises(fl.FileFormatError, match=name):
            fl.load(tmp_path / "b.flt")
    for facts in ('{"form": 1}', '{"form": 1, "mean_extent": NaN}', "[]", "{", '{"form": 1, "mean_extent": -1}'):
        container.write(tmp_path / "b.flt", arrays, {**metadata, layout_file.KEY: facts}, BLOCK)
        with pytest.raises(fl.FileFormatError, match="is not a usable tree file"):
            fl.load(tmp_path / "b.flt")


@pytest.mark.parametrize("kind", ["segments", "round cones", "a mixture"])
def test_no_flipped_byte_crashes_a_query(tmp_path: Path, kind: str) -> None:
    tree = scene(kind)
    tree.save(tmp_path / "a.flt", layout=True)
    data = (tmp_path / "a.flt").read_bytes()
    header, body = split(data)
    start = len(data) - len(body)
    spans = [header[f"layout/{name}"]["data_offsets"] for name in ("nodes", "leaves", "refs")]
    rng = np.random.default_rng(3)
    n_refused = 0
    for i in range(120):
        begin, end = spans[i % 3]
        at = start + begin + int(rng.integers(0, end - begin))
        if i % 3 < 2:  # mostly in the heads of blocks
            at = start + begin + int(rng.integers(0, (end - begin) // BLOCK)) * BLOCK + int(rng.integers(0, 36))
        changed = bytearray(data)
        changed[at] ^= int(rng.integers(1, 256))
        (tmp_path / "b.flt").write_bytes(changed)
        with pytest.raises(fl.FileFormatError, match="has changed since it was written"):
            fl.load(tmp_path / "b.flt")
        try:
            hits_of(fl.load(tmp_path / "b.flt", verify=False))
        except fl.FileFormatError:
            n_refused += 1
    assert n_refused > 30
