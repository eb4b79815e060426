"""The best builder: octets of planes, its aims and its effort, side by side."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from support.nasty import SCENES, boxes_of, named_scene, same, triangles_on

import fastlines as fl
from fastlines.settings.methods import LARGE, best_settings

COST = fl.Cost(2.0)


@pytest.fixture(autouse=True)
def as_before() -> Iterator[None]:
    yield
    fl.set_simd(None)
    fl.set_num_threads(None)


@pytest.mark.parametrize("boxes", ["tight", "cut"])
@pytest.mark.parametrize("name", SCENES)
def test_nasty_scenes_make_valid_trees(name: str, boxes: fl.splits.BoxRule) -> None:
    ends = named_scene(name, 60)
    for tree in (fl.build(ends, boxes=boxes), fl.build(ends, boxes=boxes, cost=fl.Cost(0.3), effort=1)):
        tree.validate()
        assert tree.method == "best"
    whole = fl.build(ends, boxes=boxes, cost=fl.Cost(0.3), effort=1, limits=fl.Limits(max_depth=0))
    assert tree.cost() <= whole.cost() * (1 + 1e-12)


@pytest.mark.parametrize("boxes", ["tight", "cut"])
@pytest.mark.parametrize("n_planes", [1, 7, 8, 20])
def test_octets_find_what_the_grid_finds(n_planes: int, boxes: fl.splits.BoxRule) -> None:
    for name in ("random", "crossing", "hair", "axis parallel", "moved 1e4"):
        ends = named_scene(name, 120)
        more = {"boxes": boxes, "bad_levels": 3, "limits": fl.Limits(max_depth=12)}
        exact = fl.build(ends, splits=fl.PlaneGrid(n_planes), **more)
        octets = fl.build(ends, splits=fl.BinnedPlanes(n_planes), **more)
        octets.validate()
        assert octets.cost() == pytest.approx(exact.cost(), rel=0.01)


def test_whole_splits_save_references() -> None:
    lines = fl.scenes.make("bun-hair", 3000).lines
    cut, whole = (fl.build(lines, splits=fl.BinnedPlanes(8, n), limits=fl.Limits(leaf_refs=16)) for n in (0, 100))
    whole.validate()
    assert whole.n_refs < 0.9 * cut.n_refs
    assert (np.bincount(whole.refs["prim"], minlength=3000) > 0).all()


def test_effort_makes_trees_cheaper() -> None:
    lines = fl.scenes.make("spaghetti", 300).lines
    for boxes in ("tight", "cut"):
        costs = [fl.build(lines, boxes=boxes, cost=fl.Cost(1.0), effort=effort).cost() for effort in (0, 0.5, 1)]
        assert costs[0] > costs[1] > costs[2]
    assert fl.build(lines).settings == fl.METHODS["best"] == fl.build(lines, "best", effort=0.5).settings


@pytest.mark.slow
def test_large_inputs_are_built_with_the_least_effort() -> None:
    lines = fl.scenes.make("straight-hair", LARGE).lines
    assert fl.build(lines).settings == best_settings(0) != fl.METHODS["best"]
    assert fl.build(lines, effort=0.5).settings == fl.METHODS["best"]
    assert fl.build(lines.segments[1:]).settings == fl.METHODS["best"]
    for aim in ({"cost": COST}, {"boxes": "cut"}):
        assert best_settings(**aim, n_prims=LARGE) == best_settings(0.5, **aim)


def test_a_cost_is_what_the_tree_aims_at() -> None:
    lines = fl.scenes.make("spaghetti", 500).lines
    aimed = fl.build(lines, cost=COST)
    assert aimed.settings.cost == COST
    for method in ("bvh-cl", "bvh-ss", "bvh-d2"):
        assert aimed.cost() < fl.build(lines, method).cost()
    for method in ("kd-cl", "kd-d2"):
        assert fl.build(lines, boxes="cut").cost() < fl.build(lines, method).cost()


def test_limits_leave_the_rest_of_the_method_alone() -> None:
    limits = fl.build(fl.scenes.make("spaghetti", 100).lines, limits=fl.Limits(max_refs=5000)).settings.limits
    assert limits == fl.Limits(max_refs=5000, max_leaf_refs=16, leaf_refs=16)


def test_a_budget_of_references_holds() -> None:
    lines = fl.scenes.make("spaghetti", 400).lines
    free = fl.build(lines, cost=COST)
    assert free.n_refs > 3000
    for budget in (400, 1000, 3000):
        bound = fl.build(lines, cost=COST, limits=fl.Limits(max_refs=budget))
        bound.validate()
        assert bound.n_refs <= budget
        assert bound.limits_hit["max_refs"] > 0
        assert bound.cost() >= free.cost()


@pytest.mark.parametrize("scene", ["spaghetti", "straight-hair"])
def test_under_a_tight_budget_it_is_no_worse_than_whole_splits(scene: str) -> None:
    lines = fl.scenes.make(scene, 1000).lines
    whole = fl.build(lines, "bvh-cl")
    for share in (1, 1.1, 2):
        bound = fl.build(lines, cost=COST, limits=fl.Limits(max_refs=int(share * 1000)))
        bound.validate()
        # Planes by centres are coarser than a sweep.
        assert bound.cost() <= 1.1 * whole.cost()


@pytest.mark.parametrize("given", [{"limits": fl.Limits(max_depth=1)}, {"limits": fl.Limits(max_refs=600)}], ids=str)
def test_no_tree_is_dearer_than_its_leaf(given: dict[str, object]) -> None:
    """A forecast need not come true where limits are in its way; pruning takes it back."""
    lines = fl.scenes.make("spaghetti", 300).lines
    for more in ({"boxes": "tight"}, {"boxes": "cut"}):
        for lookahead in (2, (1, 2)):
            tree = fl.build(
                lines,
                splits=fl.PlaneGrid(4),
                lookahead=lookahead,
                cost=fl.Cost(0.6),
                **more,
                **given,  # type: ignore[arg-type]
            )
            assert tree.cost() <= 300 * (1 + 1e-12)


@pytest.mark.parametrize("scale", [1e-25, 1e-22, 1e-8, 1e8, 1e19, 1e25])
def test_octets_do_not_mind_the_scale(scale: float) -> None:
    ends = fl.scenes.make("spaghetti", 300).lines.segments
    tree = fl.build(ends * np.float32(scale), cost=COST)
    assert tree.cost() == pytest.approx(fl.build(ends, cost=COST).cost(), rel=0.01)


def test_pieces_thinner_than_a_division_can_bear() -> None:
    ends = fl.scenes.make("spaghetti", 300).lines.segments - np.float32(0.5)
    ends[::3, 0, 0], ends[::3, 1, 0] = 0.0, 1e-40
    octets = fl.build(ends, splits=fl.BinnedPlanes(16), bad_levels=3)
    exact = fl.build(ends, splits=fl.PlaneGrid(16), bad_levels=3)
    octets.validate()
    assert octets.cost() == pytest.approx(exact.cost(), rel=0.01)


@pytest.mark.slow
@pytest.mark.parametrize(
    "settings",
    [{}, {"cost": COST}, {"limits": fl.Limits(max_refs=30_000)}, {"boxes": "cut"}, {"method": "bvh-cl"}],
    ids=str,
)
def test_the_same_tree_for_all_threads_and_instruction_sets(settings: dict[str, object]) -> None:
    # Enough references that subtrees are built side by side.
    lines = fl.scenes.make("straight-hair", 20_000).lines
    fl.set_num_threads(1)
    alone = fl.build(lines, **settings)  # type: ignore[arg-type]
    for n_threads in (2, 3, 7):
        fl.set_num_threads(n_threads)
        assert same(alone, fl.build(lines, **settings))  # type: ignore[arg-type]
    for simd in fl.available_simd():
        fl.set_simd(simd)
        assert same(alone, fl.build(lines, **settings))  # type: ignore[arg-type]


@pytest.mark.parametrize("boxes", ["tight", "cut"])
@pytest.mark.parametrize("name", ["random", "crossing", "axis parallel", "duplicates", "points", "flat", "outlier"])
def test_a_plane_that_is_chosen_by_a_sample_divides_all(name: str, boxes: str) -> None:
    ends = named_scene(name, 300)
    given = {"boxes": boxes, "bad_levels": 2, "limits": fl.Limits(max_depth=12)}
    for sample in (1, 5, 40):
        tree = fl.build(ends, splits=fl.BinnedPlanes(8, sample=sample), **given)  # type: ignore[arg-type]
        tree.validate()
    by_all = [fl.build(ends, splits=fl.BinnedPlanes(8, sample=sample), **given) for sample in (0, 300)]  # type: ignore[arg-type]
    assert same(*by_all), "nothing was left out"


@pytest.mark.parametrize("sample", [0, 100])
def test_lines_that_all_cross_a_plane(sample: int) -> None:
    lines = np.tile(np.array([[[0, 0, 0], [1, 0.9, 0.8]]], np.float32), (3000, 1, 1))
    tree = fl.build(lines, splits=fl.BinnedPlanes(3, sample=sample), prune=False, limits=fl.Limits(max_refs=50_000))
    tree.validate()
    assert tree.n_refs > 6000, "children have as many references as their parent"
    rays = {"origins": [[0.5, 0.45, -1], [0.5, 0.5, -1]], "directions": [[0, 0, 1]] * 2, "radius": 1e-2}
    assert tree.count_hits(**rays).tolist() == fl.brute_force(lines, **rays, query="count_hits").tolist() == [3000, 0]


def test_sampling_costs_next_to_nothing() -> None:
    lines = fl.scenes.make("spaghetti-2", 4_000).lines
    for effort in (0.0, 0.5):
        sampled = fl.build(lines, effort=effort)
        (octets,) = sampled.settings.splits
        exact = fl.build(lines, "best", effort=effort, splits=replace(octets, sample=0))
        assert not same(sampled, exact)
        assert sampled.cost() < 1.04 * exact.cost()


def test_whole_splits_are_judged_by_all() -> None:
    """By the boxes of a sample alone, lines that cross would be split whole: they are smaller."""
    lines = fl.scenes.make("spaghetti", 5000).lines
    octets = fl.BinnedPlanes(8, 64, 16, gap_refs=5000)
    refs = [fl.build(lines, "best", splits=replace(octets, sample=sample)).n_refs for sample in (0, 40)]
    assert refs[1] > 0.97 * refs[0]


def test_small_nodes_are_no_bad_levels() -> None:
    lines = fl.scenes.make("spaghetti", 500).lines
    for boxes in ("tight", "cut"):
        given = {"boxes": boxes, "splits": fl.BinnedPlanes(16), "bad_levels": 3, "prune": False, "cost": fl.Cost(0.5)}
        few, many, none = (fl.build(lines, bad_refs=n, **given) for n in (3, 0, 500))  # type: ignore[arg-type]
        assert none.n_nodes < few.n_nodes < many.n_nodes
        assert none.n_nodes == fl.build(lines, **{**given, "bad_levels": 0}).n_nodes
    with pytest.raises(fl.InputError, match="bad_refs=-1"):
        fl.build(lines, bad_refs=-1)


@pytest.mark.parametrize("sample", [0, 100])
def test_whole_splits_of_what_lies_apart(sample: int) -> None:
    """Hair is then cut less; lines that cross are nearly as they were, for they hardly ever lie apart."""
    for scene_name, low, high in (("straight-hair", 0.3, 0.8), ("spaghetti", 0.9, 1.0)):
        lines = fl.scenes.make(scene_name, 5000).lines
        plain = fl.BinnedPlanes(8, 64, 16, sample=sample)
        given = {"bad_levels": 3, "prune": False, "limits": fl.Limits(leaf_refs=16)}
        cut, whole = (
            fl.build(lines, splits=octets, **given)  # type: ignore[arg-type]
            for octets in (plain, replace(plain, gap_refs=5000))
        )
        whole.validate()
        assert low * cut.n_refs < whole.n_refs < high * cut.n_refs


def test_where_no_plane_is_allowed_references_are_split_whole() -> None:
    lines = fl.scenes.make("spaghetti", 3000).lines
    limits = fl.Limits(max_refs=3000, leaf_refs=16)
    for octets in (fl.BinnedPlanes(8, 16), fl.BinnedPlanes(8, gap_refs=5000)):
        tree = fl.build(lines, splits=octets, bad_levels=3, limits=limits)
        tree.validate()
        assert tree.nodes["n_refs"][tree.is_leaf].max() < 300


def test_a_build_side_by_side_can_be_stopped() -> None:
    def stop(share: float) -> None:
        raise KeyboardInterrupt

    fl.set_num_threads(3)
    lines = fl.scenes.make("spaghetti-2", 20_000).lines
    with pytest.raises(KeyboardInterrupt):
        fl.build(lines, cost=COST, effort=1, progress=stop)


def test_other_primitives_take_object_splits() -> None:
    ends = named_scene("random", 80)
    for geometry in (triangles_on(ends), boxes_of(ends)):
        tree = fl.build(geometry, cost=fl.Cost(0.5))
        tree.validate()
        by_hand = fl.build(geometry, splits=fl.ObjectSweep(), bad_levels=3, cost=fl.Cost(0.5))
        assert same(tree, by_hand)


def test_bad_wishes_are_refused() -> None:
    ends = named_scene("random", 10)
    for effort in (-0.1, 1.1, float("nan"), "high"):
        with pytest.raises(fl.InputError, match=r"effort=.*from 0"):
            fl.build(ends, effort=effort)  # type: ignore[arg-type]
    with pytest.raises(fl.InputError, match="knob of method='best'"):
        fl.build(ends, "bvh-cl", effort=0.5)
    with pytest.raises(fl.InputError, match="offers object splits"):
        fl.build(ends, splits=fl.BinnedPlanes(8, 4), boxes="cut")
    with pytest.raises(fl.InputError, match="uncut_refs"):
        fl.BinnedPlanes(8, -1)
    with pytest.raises(fl.InputError, match="uncut_only_refs=9 is more than uncut_refs=8"):
        fl.BinnedPlanes(8, 8, 9)
    with pytest.raises(fl.InputError, match=r"max_overlap=1\.5"):
        fl.BinnedPlanes(8, 8, 4, 1.5)
    with pytest.raises(fl.InputError, match="sample"):
        fl.BinnedPlanes(8, sample=-1)
    with pytest.raises(fl.InputError, match="offers object splits"):
        fl.build(ends, splits=fl.BinnedPlanes(8, gap_refs=100), boxes="cut")
    with pytest.raises(fl.InputError, match=r"gap=0\.0; expected a fraction"):
        fl.BinnedPlanes(8, gap_refs=100, gap=0.0)
    with pytest.raises(fl.InputError, match=r"uncut_only_side=-1; expected a multiple of the radius"):
        fl.BinnedPlanes(8, uncut_only_side=-1)
    with pytest.raises(fl.InputError, match="offers object splits"):
        fl.build(ends, splits=fl.BinnedPlanes(8, uncut_only_side=4), boxes="cut")
    with pytest.raises(fl.InputError, match="gap_refs=8 is for nodes of more than uncut_refs=8"):
        fl.BinnedPlanes(8, 8, gap_refs=8)
    for given in ({"beam": 3}, {"exhaustive": True}):
        with pytest.raises(fl.InputError, match="lookahead of 2 or more"):
            fl.build(ends, **given)


def test_a_bound_on_memory_is_one_on_references() -> None:
    lines = fl.scenes.make("spaghetti", 300).lines
    free = fl.build(lines, cost=COST)
    bound = fl.build(lines, cost=COST, limits=fl.Limits(max_bytes=160 * 300 + 160 * 2000))
    assert bound.n_refs <= 2000 < free.n_refs
    assert bound.limits_hit["max_refs"] > 0
    with pytest.raises(fl.InputError, match=r"max_bytes=1000 is less .* allow 72000 or more"):
        fl.build(lines, limits=fl.Limits(max_bytes=1000))
    with pytest.raises(fl.InputError, match="allow 138000 or more"):
        fl.build(lines, boxes="cut", limits=fl.Limits(max_bytes=1000))


def test_bad_refines_cut_in_the_middle_where_the_search_says_leaf() -> None:
    lines = fl.scenes.make("spaghetti", 200).lines
    assert fl.build(lines, "kd-cl").n_nodes == 1
    cut = [fl.build(lines, "kd-cl", bad_refines=n, prune=False) for n in (1, 3)]
    for tree in cut:
        tree.validate()
        box, left = tree.nodes["box"][:2]
        axis = int((box[1] - box[0]).argmax())
        assert left[1, axis] == np.float32((float(box[0, axis]) + float(box[1, axis])) / 2)
    assert cut[1].n_nodes > cut[0].n_nodes > 1
    # With pruning, what did not pay is taken back.
    assert fl.build(lines, "kd-cl", bad_refines=3).cost() <= 200
    # Bad levels are none of them.
    both = {"boxes": "cut", "splits": fl.PlaneGrid(2), "bad_levels": 1, "prune": False}
    assert fl.build(lines, **both, bad_refines=2).n_nodes > fl.build(lines, **both).n_nodes


def test_lines_that_lie_on_each_other_are_cut_no_finer_than_others() -> None:
    once = np.random.default_rng(0).random((300, 2, 3))
    refs = [fl.build(np.repeat(once, n, axis=0)).n_refs / (300 * n) for n in (16, 17, 40)]
    assert max(refs[1:]) < 2 * refs[0]


WATCHED_BUILD = """
import sys, threading
import numpy as np
import fastlines as fl

def resident():
    return int(open("/proc/self/statm").read().split()[1]) * 4096

def strands():  # short and all one way: a KD tree has more leaves without references than with
    rng = np.random.default_rng(0)
    steps = rng.normal(0, 0.003, (2000, 31, 3)) + [0, 0, 0.01]
    return fl.Lines.from_strands(list(np.cumsum(steps, axis=1) + rng.random((2000, 1, 3)) * [1, 1, 0]))

def shells():  # nearly all in the corner of a corner: right children hold nearly all
    rng = np.random.default_rng(1)
    corner = lambda size, n: -size * (0.3 + 0.7 * rng.random((n, 3)))
    starts = np.concatenate([*(corner(8.0**-level, 100) for level in range(16)), corner(8.0**-16, 60_000)])
    return fl.Lines.from_segments(np.stack([starts, starts * 0.999], axis=1))

bound, scene, settings = int(sys.argv[1]), sys.argv[2], eval(sys.argv[3])
lines = fl.scenes.make(scene).lines if scene == "spaghetti-2" else eval(scene)()
fl.build(lines.segments[:100])  # what the first call brings in counts for none
before = most = resident()
done = threading.Event()

def watch():
    global most
    while not done.wait(0.001):
        most = max(most, resident())

watcher = threading.Thread(target=watch, daemon=True)
watcher.start()
tree = fl.build(lines, limits=fl.Limits(max_bytes=bound), **settings)
done.set()
watcher.join()
assert "max_refs" in tree.limits_hit or scene == "shells"
print(most - before)
"""


@pytest.mark.slow
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc/self/statm")
@pytest.mark.parametrize(
    ("scene", "settings", "bound"),
    [
        ("spaghetti-2", "{}", 30_000_000),
        ("spaghetti-2", "{'cost': fl.Cost(2.0)}", 30_000_000),
        ("spaghetti-2", "{'boxes': 'cut'}", 30_000_000),
        ("strands", "{'boxes': 'cut'}", 60_000_000),
        ("shells", "{}", 15_000_000),
    ],
)
def test_a_build_stays_within_its_memory(scene: str, settings: str, bound: int) -> None:
    said = subprocess.run(
        [sys.executable, "-c", WATCHED_BUILD, str(bound), scene, settings], capture_output=True, text=True, check=True
    )
    assert 1_000_000 < int(said.stdout) < bound
