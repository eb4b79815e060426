"""Queries on a GPU give the answers of brute force, bit for bit: here on a host that emulates the GPU's threads."""

from __future__ import annotations

import pickle
from concurrent.futures import ThreadPoolExecutor
from itertools import product
from typing import Any

import numpy as np
import pytest
from support import nasty
from support.answers import PLACES, assert_same, cases, options, question
from support.builds import ALL_KINDS
from support.emulated_device import TUNINGS, EmulatedDevice
from support.nasty import spreads
from support.slow import few_of

import fastlines as fl
from fastlines.cuda import program
from fastlines.cuda.columns import SCAN_RUN, scan
from fastlines.cuda.scene import stack_room
from fastlines.query.queries import QUERIES, QueryName

#: The kinds of geometry that kernels know: all but one's own.
KINDS = [kind for kind in ALL_KINDS if kind != "one's own"]
#: Those that rays with a spread are for.
LINES = ("segments", "round cones", "spheres", "curves")
#: Queries, and their arguments.
QUESTIONS: list[tuple[QueryName, dict[str, Any]]] = [
    (query, {"at": at} | how)
    for query in QUERIES
    for at in PLACES[query]
    for how in ([{}, *({"k": k, "rank": rank} for k, rank in product((0, 1, 3, 40), ("t", "distance")))])
    if (query == "next_hits") == ("k" in how)
]
RAYS = [[0, 0, -5], [0.2, 0, -5]], [0, 0, 1], 0.5
TREE = fl.build([[[-1, 0, 0], [1, 0, 0]], [[0, -1, 1], [0, 1, 1]]])


@pytest.fixture(autouse=True)
def on_cpu_afterwards():
    yield
    fl.set_backend("cpu")


@pytest.mark.parametrize("name", few_of(nasty.NAMES, 3))
@pytest.mark.parametrize("kind", KINDS)
def test_answers_are_those_of_brute_force(kind: str, name: str, device: EmulatedDevice) -> None:
    case = cases(0, n_rays=60)[name]
    asked, _ = question(case)
    geometry = ALL_KINDS[kind](case.segments)
    methods = list(fl.METHODS)
    tree = fl.build(geometry, methods[nasty.NAMES.index(name) % len(methods)]).to("cuda")
    for query, how in QUESTIONS:
        expected = fl.brute_force(geometry, **asked, query=query, **how)
        assert_same(getattr(tree, query)(**asked, **how), expected, f"{query}, {how}")


@pytest.mark.parametrize("kind", ["triangles", "boxes", "a mixture"])
def test_shapes_in_several_leaves(kind: str, device: EmulatedDevice) -> None:
    """A ray may find a shape in several leaves; it is counted and listed once."""
    case = cases(2, n_rays=60)["crossing"]
    asked, _ = question(case)
    geometry = ALL_KINDS[kind](case.segments)
    tree = fl.build(geometry, splits=fl.PlaneGrid(4), limits=fl.Limits(max_leaf_refs=2, max_refs=400)).to("cuda")
    assert len(tree.layout.refs) > 1.2 * len(geometry.core_rows)
    for query, how in QUESTIONS:
        expected = fl.brute_force(geometry, **asked, query=query, **how)
        assert_same(getattr(tree, query)(**asked, **how), expected, f"{query}, {how}")
    assert "move_lists" in device.launched
    assert ("count_prims" in device.launched) == (kind != "a mixture")  # crossings of curves are counted on the CPU


def test_rays_that_see_some_parts(device: EmulatedDevice) -> None:
    """The layout is uploaded once, and the primitives again for other parts."""
    case = cases(0, n_rays=60)["hair"]
    asked, _ = question(case)
    geometry = fl.Geometry([ALL_KINDS[kind](case.segments) for kind in ("round cones", "triangles", "curves")])
    tree = fl.build(geometry).to("cuda")
    for parts in (None, [0, 2], 1, [0, 2]):
        for query, how in QUESTIONS[::3]:
            expected = fl.brute_force(geometry, **asked, parts=parts, query=query, **how)
            assert_same(getattr(tree, query)(**asked, parts=parts, **how), expected, f"{query}, {how}, {parts}")


@pytest.mark.parametrize("name", few_of(nasty.NAMES, 2))
@pytest.mark.parametrize("kind", LINES)
def test_rays_with_a_spread(kind: str, name: str, device: EmulatedDevice) -> None:
    case = cases(0, n_rays=60)[name]
    asked, _ = question(case)
    asked["spread"] = spreads(case, len(asked["origins"]), 1)
    geometry = ALL_KINDS[kind](case.segments)
    tree = fl.build(geometry).to("cuda")
    for query, how in QUESTIONS:
        if how["at"] == "closest":
            expected = fl.brute_force(geometry, **asked, query=query, **how)
            assert_same(getattr(tree, query)(**asked, **how), expected, f"{query}, {how}")


def test_equal_t_in_different_nodes(device: EmulatedDevice) -> None:
    """From afar, many layers of lines have the same t; the first hit is the lowest id, which may be in the last one."""
    z = np.add.outer(0.02 * np.arange(30), 1e-4 * np.arange(20)).ravel()[::-1]  # gaps are wider than a quantum
    lines = fl.Lines.from_segments(np.stack([np.stack([0 * z + x, 0 * z + 0.5, z], axis=1) for x in (0, 1)], axis=1))
    rays = {"origins": [[x, 0.5, side * 1e7] for x in (0.3, 0.6) for side in (-1, 1)], "radius": 0.001}
    rays["directions"] = [[0, 0, 1], [0, 0, -1]] * 2
    tree = fl.build(lines)
    for at, k in product(("closest", "surface"), (1, 5)):
        first = tree.to("cuda").first_hit(**rays, at=at)
        assert_same(first, fl.brute_force(lines, **rays, query="first_hit", at=at))
        expected = fl.brute_force(lines, **rays, query="next_hits", k=k, at=at)
        assert_same(tree.to("cuda").next_hits(**rays, k=k, at=at), expected)
        listed = fl.brute_force(lines, **rays, query="all_hits", at=at)
        same_t = np.add.reduceat(listed.t == np.repeat(first.t, listed.counts), listed.offsets[:-1], dtype=int)
        assert same_t.max() > 300, "many layers"


@pytest.mark.parametrize("name", fl.scenes.NAMES)
def test_scenes_of_the_thesis(name: str, device: EmulatedDevice) -> None:
    lines = fl.scenes.make(name, 400).lines
    tree = fl.build(lines).to("cuda")
    low, high = np.asarray(lines.bounds, np.float64)
    random = np.random.default_rng(1)
    origins = low + (high - low) * random.uniform(-0.5, 1.5, (300, 3))
    rays = origins, low + (high - low) * random.uniform(0, 1, (300, 3)) - origins
    for radius in (0.0, 1e-3 * (high - low).max(), 0.02 * (high - low).max()):
        for query in QUERIES:
            expected = fl.brute_force(lines, *rays, radius, query=query, **options(query))
            assert_same(getattr(tree, query)(*rays, radius, **options(query)), expected, f"{query}, {radius=}")


def test_threads_that_ask_one_tree_upload_it_once(device: EmulatedDevice) -> None:
    lines = fl.scenes.make("spaghetti", 400).lines
    tree = fl.build(lines).to("cuda")
    rays = np.random.default_rng(1).uniform(-1, 1, (2, 100, 3))
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(lambda _: tree.first_hit(*rays, 0.01), range(8)))
    for hits in found:
        assert_same(hits, fl.brute_force(lines, *rays, 0.01, query="first_hit"))
    assert device.uploaded.count(lines.segments.nbytes) == 1


@pytest.mark.parametrize("tuning", few_of(TUNINGS, 1), ids=str)
def test_tuning_changes_no_answer(
    tuning: dict[str, int], device: EmulatedDevice, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, value in tuning.items():
        monkeypatch.setitem(program.TUNING, name, value)
    case = cases(1, n_rays=60)["hair"]
    asked, _ = question(case)
    tree = fl.build(case.segments)
    for query, how in QUESTIONS:
        assert_same(getattr(tree.to("cuda"), query)(**asked, **how), getattr(tree, query)(**asked, **how), query)


def test_the_layout_is_uploaded_once(device: EmulatedDevice) -> None:
    tree = fl.build(TREE.geometry).to("cuda")
    tree.any_hit(*RAYS)
    first = len(device.uploaded)
    tree.to("cuda").any_hit(*RAYS)
    n_a_query = len(device.uploaded) - first
    assert n_a_query == 6  # the arrays of the rays, and their record
    assert first == n_a_query + 5  # nodes, leaves, references, primitives, and their record
    assert device.launched == ["any_hit", "any_hit"]


def test_the_backend_of_all_trees(device: EmulatedDevice) -> None:
    assert (fl.get_backend(), TREE.backend) == ("cpu", "cpu")
    fl.set_backend("cuda")
    assert (fl.get_backend(), TREE.backend, TREE.to("cpu").backend) == ("cuda", "cuda", "cpu")
    assert_same(TREE.first_hit(*RAYS), TREE.to("cpu").first_hit(*RAYS))
    assert device.launched == ["first_closest"]


def test_a_placed_tree_is_like_any_other(device: EmulatedDevice) -> None:
    tree = TREE.to("cuda")
    assert (tree.backend, tree.to("cpu").backend, TREE.backend) == ("cuda", "cpu", "cpu")
    assert tree.nodes is TREE.nodes
    assert pickle.loads(pickle.dumps(tree)).backend == "cpu"
    hits = tree.all_hits(*RAYS, at="surface")
    assert_same(hits, TREE.all_hits(*RAYS, at="surface"))
    assert np.allclose(np.linalg.norm(hits.normals(), axis=1), 1)
    # What is wrapped around a backend works with this one.
    assert_same(tree.first_hit(*RAYS, ignore=[0]), TREE.first_hit(*RAYS, ignore=[0]))
    shares: list[float] = []
    tree.count_hits(*RAYS, progress=shares.append)
    assert shares[-1] == 1.0


def test_no_rays_and_no_lines(device: EmulatedDevice) -> None:
    empty = fl.build(np.empty((0, 2, 3)))
    for tree, rays in (
        (TREE, (np.empty((0, 3)), np.empty((0, 3)), 0.5)),
        (empty, RAYS),
        (empty, (np.empty((0, 3)), np.empty((0, 3)), 0.5)),
    ):
        for query in QUERIES:
            expected = getattr(tree.to("cpu"), query)(*rays, **options(query))
            assert_same(getattr(tree.to("cuda"), query)(*rays, **options(query)), expected)


@pytest.mark.parametrize("n", [1, SCAN_RUN, SCAN_RUN + 1, SCAN_RUN**2 + 1])
def test_scan(n: int, device: EmulatedDevice) -> None:
    numbers = np.random.default_rng(n).integers(0, 100, n)
    memory = device.upload(numbers)
    scan(device, device.compile("DeviceSegments", 64), memory.pointer, n)
    assert np.array_equal(device.download(memory, np.int64, n), np.cumsum(numbers))


def test_stack_room() -> None:
    """A root with three inner children, of which the second has four: when it is taken last, two wait below."""
    nodes = np.zeros((8, 128), np.uint8)
    nodes[0, 16], nodes[0, 24] = 1, 3
    nodes[2, 16], nodes[2, 24] = 4, 4
    assert stack_room(nodes) == 6
    assert stack_room(nodes[:0]) == 1


@pytest.mark.parametrize("kind", ["segments", "round cones", "curves"])
def test_the_cpu_sums_what_the_gpu_finds(kind: str, device: EmulatedDevice) -> None:
    tree = fl.build(ALL_KINDS[kind](TREE.geometry.segments))
    how: dict[str, Any] = {"values": np.arange(len(tree.geometry)) + 1, "sigma": 0.1}
    for spread in (0.0, 0.02):
        found, expected = (on.gather(*RAYS, **how, spread=spread) for on in (tree.to("cuda"), tree))
        assert found.count.any()
        assert found.sum.tobytes() == expected.sum.tobytes()


def test_what_the_gpu_does_not_do(device: EmulatedDevice) -> None:
    tree = TREE.to("cuda")
    with pytest.raises(fl.InputError, match="at='surface' has no meaning with a spread"):
        tree.first_hit([0, 0, -5], [0, 0, 1], spread=0.1, at="surface")
    with pytest.raises(fl.InputError, match="kernel='wave' is one of the CPU's"):
        tree.first_hit(*RAYS, kernel="wave")
    triangles = fl.build(fl.Triangles([[[0, 0, 0], [1, 0, 0], [0, 1, 0]]]))
    with pytest.raises(fl.InputError, match="a spread is for lines, and this tree is over Triangles"):
        triangles.to("cuda").first_hit(*RAYS, spread=0.1)
    balls = fl.build(ALL_KINDS["one's own"]([[[-1, 0, 0], [1, 0, 0]]]))
    with pytest.raises(fl.InputError, match="a class of your own, and this tree is over Balls; query it on the CPU"):
        balls.to("cuda")
    fl.set_backend("cuda")
    with pytest.raises(fl.InputError, match="a class of your own"):
        balls.first_hit(*RAYS[:2])
    with pytest.raises(fl.InputError, match="backend='gpu'"):
        TREE.to("gpu")


def test_a_tree_that_is_too_deep(device: EmulatedDevice, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("fastlines.cuda.scene.MAX_STACK", 0)
    with pytest.raises(fl.FastlinesError, match="on the stack of each ray, and a GPU has room for 0"):
        fl.build(TREE.geometry).to("cuda").first_hit(*RAYS)
