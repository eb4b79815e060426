"""`Tree.refit`: after any motion, answers are those of brute force and the tree is one of the theory."""

from __future__ import annotations

import dataclasses
import zlib

import numpy as np
import pytest
from support.nasty import cases, named_scene, triangles_on
from support.slow import few_of

import fastlines as fl
from fastlines.engines import set_simd
from fastlines.query.queries import QUERIES

METHODS = tuple(fl.METHODS)
ROUND = 4  # in ulps of the scene: what the rounding of cuts may do to a box


def moved(name: str, segments: np.ndarray) -> np.ndarray:
    """Move segments in a way that has a name."""
    rng = np.random.default_rng(zlib.crc32(name.encode()))
    p, q = segments[:, :1], segments[:, 1:]
    ways = {
        "not at all": lambda: segments,
        "a little": lambda: segments + rng.normal(0, 0.01, segments.shape),
        "anywhere": lambda: rng.uniform(-1, 1, segments.shape),
        "around": lambda: segments[:, ::-1],
        "apart": lambda: segments + 100 * rng.normal(0, 1, (len(segments), 1, 3)),
        "to scale 1e6": lambda: segments * 1e6,
        "to scale 1e-6": lambda: segments * 1e-6,
        "far away": lambda: segments + 1e3,
        "to points": lambda: np.repeat(p, 2, axis=1),
        "to one point": lambda: np.ones_like(segments),
        "some to points": lambda: np.where(rng.random((len(segments), 1, 1)) < 0.3, p, segments),
        "onto one another": lambda: np.repeat(segments[:1], len(segments), axis=0),
        "to a plane": lambda: segments * [1, 0, 1],
        "to huge and tiny": lambda: p + (q - p) * 10 ** rng.uniform(-12, 3, (len(segments), 1, 1)) * [[[0], [1]]],
    }
    assert name in WAYS
    assert set(ways) == set(WAYS)
    return ways[name]().astype(np.float32)


WAYS = (
    "not at all",
    "a little",
    "anywhere",
    "around",
    "apart",
    "to scale 1e6",
    "to scale 1e-6",
    "far away",
    "to points",
    "to one point",
    "some to points",
    "onto one another",
    "to a plane",
    "to huge and tiny",
)


def spaghetti() -> np.ndarray:
    """Few lines that every good tree cuts to many pieces."""
    return fl.scenes.make("spaghetti", 150).lines.segments


def assert_same_answers(tree: fl.Tree, segments: np.ndarray, seed: int, kernels=("auto",)) -> None:
    """Compare every query with brute force, bit for bit, on rays near the segments and a few radii."""
    rng = np.random.default_rng(seed)
    low, high = segments.reshape(-1, 3).min(axis=0), segments.reshape(-1, 3).max(axis=0)
    size = float((high.astype(np.float64) - low).max()) or 1.0
    at = segments[rng.integers(len(segments), size=40), rng.integers(2, size=40)]
    direction = rng.normal(0, 1, (40, 3))
    origins = np.float32(at - 2 * size * direction + rng.normal(0, 0.02 * size, (40, 3)))
    for radius in (0.0, 0.003 * size, 0.1 * size):
        for query in QUERIES:
            more = {"k": 3} if query == "next_hits" else {}
            expected = fl.brute_force(segments, origins, direction, radius, query=query, **more)
            for kernel in kernels:
                answer = getattr(tree, query)(origins, direction, radius, kernel=kernel, **more)
                assert_equal(answer, expected)


def assert_equal(answer, expected) -> None:
    if isinstance(answer, np.ndarray):
        np.testing.assert_array_equal(answer, expected)
        return
    for name in {field.name for field in dataclasses.fields(answer)} - {"geometry", "rays"} | {"row", "strand"}:
        ours, theirs = getattr(answer, name), getattr(expected, name)
        if ours is not None:
            np.testing.assert_array_equal(ours, theirs, err_msg=name)


def assert_well_formed(tree: fl.Tree, lines: np.ndarray) -> None:
    tree.validate()
    assert tree.cost(by="f") == pytest.approx(tree.cost(by="g"), rel=1e-9)
    np.testing.assert_array_equal(tree.nodes["box"][0], tree.geometry.bounds)
    np.testing.assert_array_equal(tree.geometry.segments, lines)


@pytest.mark.parametrize("way", few_of(WAYS, n=3))
@pytest.mark.parametrize("method", METHODS)
def test_answers(method: str, way: str) -> None:
    tree = fl.build(spaghetti(), method)
    assert tree.n_nodes > 1 or method in ("bvh-ss", "kd-cl")  # these make one leaf
    segments = moved(way, spaghetti())
    bare = tree.refit(segments)
    assert_well_formed(bare, segments)
    assert "layout" not in vars(bare)
    assert_same_answers(bare, segments, 1, ("binary", "auto"))

    assert len(tree.layout.refs) > 0
    laid = tree.refit(segments)
    assert_well_formed(laid, segments)
    assert "layout" in vars(laid)
    assert_same_answers(laid, segments, 2, ("auto", "single", "wave", "bundle"))


@pytest.mark.parametrize("name", cases(0, 8, 9))
def test_nasty_scenes(name: str) -> None:
    """Any scene of the catalogue may move to any other way of itself, one after the other."""
    case = cases(3, 40, 9)[name]
    tree = fl.build(case.segments)
    assert tree.layout.mean_extent >= 0 or len(case.segments) == 0
    for way in ("a little", "around", "to points", "not at all"):
        segments = moved(way, case.segments) if len(case.segments) else case.segments
        tree = tree.refit(segments)
        tree.validate()
        for radius in case.radii.values():
            for query in ("first_hit", "all_hits"):
                expected = fl.brute_force(segments, case.origins, case.directions, radius, query=query)
                assert_equal(getattr(tree, query)(case.origins, case.directions, radius), expected)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("scene", few_of(["crossing", "hair", "star", "duplicates", "flat", "moved 1e4", "scale 1e-8"]))
def test_unmoved(scene: str, method: str) -> None:
    """Same references and topology; boxes too, but for the rounding of cuts, and none at all from then on."""
    tree = fl.build(named_scene(scene, 200), method)
    same = tree.refit(tree.geometry)
    assert same.refs is tree.refs
    for name in ("right", "first_ref", "n_refs"):
        np.testing.assert_array_equal(same.nodes[name], tree.nodes[name])
    if tree.settings.boxes == "tight":
        ulp = np.spacing(np.abs(tree.geometry.segments).max())
        assert np.abs(same.nodes["box"].astype(np.float64) - tree.nodes["box"]).max() <= ROUND * ulp
        whole = np.isinf(tree.refs["s1"]) & (tree.refs["s0"] == 0)
        if whole.all():
            np.testing.assert_array_equal(same.nodes["box"], tree.nodes["box"])
        assert same.growth == pytest.approx(1, rel=1e-4)
    else:
        assert same.growth == 1
    there = same.refit(moved("anywhere", tree.geometry.segments))
    assert there.refit(tree.geometry).nodes.tobytes() == same.nodes.tobytes()
    assert there.refit(tree.geometry).growth == same.growth


@pytest.mark.parametrize("method", METHODS)
def test_layout_of_unmoved(method: str) -> None:
    """What a collapse lays out and what a refit makes of it are the same blocks."""
    tree = fl.build(spaghetti(), method)
    layout, again = tree.layout, tree.refit(tree.geometry).layout
    for name in ("nodes", "leaves", "refs"):
        assert getattr(layout, name).tobytes() == getattr(again, name).tobytes(), name
    assert layout.mean_extent == again.mean_extent


def test_does_not_depend_on_threads_or_instructions() -> None:
    tree = fl.build(fl.scenes.make("spaghetti", 2000).lines)
    assert tree.n_refs > 20_000
    assert len(tree.layout.nodes) > 100
    segments = moved("a little", tree.geometry.segments)
    made = set()
    try:
        for simd in fl.available_simd():
            set_simd(simd)
            for n_threads in (1, 2, 3):
                fl.set_num_threads(n_threads)
                after = tree.refit(segments)
                layout = after.layout
                made.add((after.nodes.tobytes(), layout.nodes.tobytes(), layout.leaves.tobytes(), layout.mean_extent))
    finally:
        set_simd(None)
        fl.set_num_threads(None)
    assert len(made) == 1


def test_boxes_are_those_of_points() -> None:
    """Leaves, against the definition in double."""
    tree = fl.build(named_scene("crossing", 100)).refit(moved("anywhere", named_scene("crossing", 100)))
    p, q = tree.geometry.segments[tree.refs["prim"]].astype(np.float64).swapaxes(0, 1)
    ends = []
    for s in (tree.refs["s0"], tree.refs["s1"]):
        with np.errstate(invalid="ignore"):
            at = (p + s[:, None].astype(np.float64) * (q - p)).astype(np.float32)
        ends.append(np.where(s[:, None] < 1, at, q.astype(np.float32)))
    for node in tree.nodes[tree.is_leaf]:
        own = slice(node["first_ref"], node["first_ref"] + node["n_refs"])
        np.testing.assert_array_equal(node["box"][0], np.min([end[own].min(axis=0) for end in ends], axis=0))
        np.testing.assert_array_equal(node["box"][1], np.max([end[own].max(axis=0) for end in ends], axis=0))


def test_kd_tree_becomes_a_bvh() -> None:
    """Empty leaves and all."""
    tree = fl.build(named_scene("hair", 200), "kd-cl")
    assert tree.stats()["n_empty_leaves"] > 0
    after = tree.refit(moved("a little", tree.geometry.segments))
    assert (after.settings.boxes, after.method) == ("tight", "custom")
    assert after.settings.splits == tree.settings.splits
    assert_well_formed(after, after.geometry.segments)
    assert np.isfinite(after.nodes["box"]).all()
    assert fl.build(named_scene("hair", 200), "bvh-d2").refit(tree.geometry).method == "bvh-d2"


@pytest.mark.parametrize("n", [1, 3, 5000, 20_000])
def test_one_leaf(n: int) -> None:
    """A leaf may hold any number of references."""
    lines = fl.scenes.make("spaghetti", n).lines
    tree = fl.build(lines, "bvh-ss", limits=fl.Limits(max_depth=0))
    assert tree.n_nodes == 1
    segments = lines.segments[::-1] * 2
    after = tree.refit(segments)
    assert_well_formed(after, segments)


def test_empty() -> None:
    tree = fl.build(np.empty((0, 2, 3)))
    assert tree.layout.refs.shape == (0, 2)
    after = tree.refit(np.empty((0, 2, 3)))
    after.validate()
    assert after.growth == 1
    assert not after.first_hit([0, 0, 0], [0, 0, 1], 1).hit


def test_keeps_what_lines_know() -> None:
    lines = fl.Lines.from_points(
        np.random.default_rng(0).random((20, 3)), [12, 8], radius=np.full(20, 0.1), attributes={"k": np.arange(20)}
    )
    tree = fl.build(lines)
    after = tree.refit(lines.segments + np.float32(1)).geometry
    assert after.strands is lines.strands
    assert after.radius is lines.radius
    assert after.end_attributes["k"] is lines.end_attributes["k"]
    other = fl.Lines.from_segments(lines.segments)
    assert tree.refit(other).geometry is other


def test_is_its_own() -> None:
    segments = named_scene("crossing", 50)
    tree = fl.build(segments)
    array = segments.copy()
    after = tree.refit(array)
    array[:] = np.nan
    assert_same_answers(after, segments, 3)
    for own in (after.nodes, after.refs, after.layout.nodes, after.layout.leaves):
        assert not own.flags.writeable
    assert after.nodes is not tree.nodes


def test_save_and_load(tmp_path) -> None:
    tree = fl.build(named_scene("crossing", 200), "best")
    after = tree.refit(moved("anywhere", tree.geometry.segments))
    after.save(tmp_path / "t.flt")
    loaded = fl.load(tmp_path / "t.flt")
    assert loaded.nodes.tobytes() == after.nodes.tobytes()
    assert (loaded.built_cost, loaded.growth, loaded.method) == (after.built_cost, after.growth, "best")
    loaded.validate()
    again = loaded.refit(tree.geometry)
    assert again.growth == pytest.approx(1, rel=1e-4)
    assert_same_answers(again, tree.geometry.segments, 4)

    tree.save(tmp_path / "t.flt")
    assert fl.load(tmp_path / "t.flt").built_cost is None


def test_growth() -> None:
    tree = fl.build(fl.scenes.make("spaghetti", 500).lines)
    assert tree.growth == tree.stats()["growth"] == 1
    after = tree.refit(moved("anywhere", tree.geometry.segments))
    assert after.growth == pytest.approx(after.cost() / tree.cost(), rel=1e-9)
    assert after.growth == after.stats()["growth"] > 1.5
    assert after.refit(moved("anywhere", tree.geometry.segments)).growth == after.growth


def test_pieces_leave_their_primitives_nodes() -> None:
    """Why a refitted tree is checked by piece: another piece of a segment may come to lie in a node's box."""
    tree = fl.build(fl.scenes.make("spaghetti", 300).lines)
    after = tree.refit(moved("anywhere", tree.geometry.segments))
    after.validate()
    with pytest.raises(fl.InvalidTreeError, match="axiom 5"):
        dataclasses.replace(after, built_cost=None).validate()


@pytest.mark.parametrize(
    ("change", "axiom"), [("leaf grown", "BVH axiom"), ("leaf shrunk", "axiom 5"), ("parent shrunk", "axiom 4")]
)
def test_broken_boxes_are_found(change: str, axiom: str) -> None:
    tree = fl.build(spaghetti(), "bvh-d2")
    after = tree.refit(moved("a little", tree.geometry.segments))
    nodes = after.nodes.copy()
    leaf, parent = int(np.flatnonzero(after.is_leaf[1:] & ~after.is_leaf[:-1])[0]) + 1, 1
    if change == "leaf grown":
        nodes["box"][leaf] = nodes["box"][leaf - 1]  # its parent's
    else:
        node = leaf if change == "leaf shrunk" else parent
        nodes["box"][node, 1] = nodes["box"][node, 0]
    with pytest.raises(fl.InvalidTreeError, match=axiom):
        dataclasses.replace(after, nodes=nodes).validate()


def test_refused() -> None:
    tree = fl.build(named_scene("crossing", 30))
    with pytest.raises(fl.InputError, match="29 segments were given for a tree over 30"):
        tree.refit(named_scene("crossing", 30)[1:])
    for bad in (np.nan, np.inf, 1e31):
        segments = named_scene("crossing", 30)
        segments[7, 1, 2] = bad
        with pytest.raises(fl.InputError, match="row 7"):
            tree.refit(segments)
    with pytest.raises(fl.InputError, match="shape"):
        tree.refit(np.zeros((30, 3)))
    with pytest.raises(fl.InputError, match="refits are for lines; this tree is over Triangles"):
        fl.build(triangles_on(named_scene("crossing", 30))).refit(named_scene("crossing", 30))
    with pytest.raises(fl.InputError, match="built_cost"):
        dataclasses.replace(tree, built_cost=-1.0)


def test_skipped_rows() -> None:
    segments = named_scene("crossing", 30)
    segments[4] = np.nan
    tree = fl.build(segments, invalid="skip")
    with pytest.raises(fl.InputError, match=r"array\[tree.geometry.rows\]"):
        tree.refit(named_scene("crossing", 30))
    assert tree.refit(named_scene("crossing", 30)[tree.geometry.rows]).n_prims == 29


@pytest.mark.parametrize("what", ["right", "range"])
def test_what_is_no_tree_is_not_made(what: str) -> None:
    tree = fl.build(fl.scenes.make("spaghetti", 300).lines, "bvh-d2")
    nodes = tree.nodes.copy()
    inner, leaves = np.flatnonzero(~tree.is_leaf), np.flatnonzero(tree.is_leaf)
    if what == "right":
        nodes["right"][inner[-5]] = tree.n_nodes - 1
    else:
        nodes["first_ref"][leaves[5]] = tree.n_refs - nodes["n_refs"][leaves[5]]
    with pytest.raises(fl.InvalidTreeError):
        dataclasses.replace(tree, nodes=nodes)


def test_progress_and_many_segments() -> None:
    lines = fl.scenes.make("straight-hair", 3000).lines
    tree = fl.build(lines, "bvh-ss", splits=fl.PlaneGrid(4), limits=fl.Limits(max_depth=4))
    seen: list[float] = []
    assert tree.refit(lines, progress=seen.append).n_refs == tree.n_refs
    assert all(0 <= share <= 1 for share in seen)


def test_rebuild_rule() -> None:
    tree = fl.build(fl.scenes.make("spaghetti", 300).lines)
    rule = fl.RebuildPolicy(build_seconds=1.0)
    assert not any(rule.due(tree, 1000.0) for _ in range(3))  # as built: nothing is lost
    worse = tree.refit(moved("anywhere", tree.geometry.segments))
    lost = 1 - 1 / worse.growth
    assert not rule.due(worse, 0.4 / lost)
    assert not rule.due(worse, 0.5 / lost)
    assert rule.lost_seconds == pytest.approx(0.9)
    assert rule.due(worse, 0.11 / lost)
    assert rule.lost_seconds == 0
    assert not rule.due(dataclasses.replace(worse, built_cost=1e9), 10.0)  # a cost that has fallen loses nothing
    for seconds in (0, -1, np.nan, "1"):
        with pytest.raises(fl.InputError, match="build_seconds"):
            fl.RebuildPolicy(seconds)
    for seconds in (-1, np.nan, np.inf):
        with pytest.raises(fl.InputError, match="query_seconds"):
            rule.due(tree, seconds)
