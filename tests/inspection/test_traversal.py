"""The way of a ray through a tree: what it enters, and that every hit is found in a leaf that it enters."""

from __future__ import annotations

import numpy as np
import pytest

import fastlines as fl
from fastlines.inspection import outline_of, trace_ray
from fastlines.rendering.node_visits import visited_nodes

METHODS = ("best", "bvh-cl", "bvh-d2", "kd-d2")


def rays(n: int) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(5)
    origins = random.uniform(-0.5, 1.5, (n, 3))
    return origins, random.uniform(0, 1, (n, 3)) - origins


@pytest.mark.parametrize("method", METHODS)
def test_every_hit_is_in_a_leaf_that_the_ray_enters(method: str) -> None:
    tree = fl.build(fl.scenes.make("spaghetti", 300).lines, method)
    outline = outline_of(tree)
    n_hits = 0
    for origin, direction in zip(*rays(20), strict=True):
        way = trace_ray(tree, origin, direction, 0.02, outline=outline)
        expected = tree.all_hits(origin[None], direction[None], 0.02)
        assert way.hits.prim.tolist() == expected.prim.tolist()
        assert way.n_found.sum() == len(expected)  # a piece owns each hit
        assert len(way.nodes) == visited_nodes(tree, origin, direction, 0.02)[0]
        assert way.n_tests == outline.n_refs[way.nodes[way.is_leaf]].sum()
        n_hits += len(expected)
    assert n_hits > 50


@pytest.mark.parametrize("method", METHODS)
def test_the_first_hit_ends_the_way(method: str) -> None:
    tree = fl.build(fl.scenes.make("spaghetti", 300).lines, method)
    n_shorter = 0
    for origin, direction in zip(*rays(20), strict=True):
        first = trace_ray(tree, origin, direction, 0.02, query="first")
        whole = trace_ray(tree, origin, direction, 0.02)
        expected = tree.first_hit(origin, direction, 0.02)
        assert first.hits.prim.tolist() == ([int(expected.prim)] if expected.hit else [])
        assert set(first.nodes.tolist()) <= set(whole.nodes.tolist())
        # Whatever is skipped begins behind the hit.
        skipped = ~np.isin(whole.nodes, first.nodes)
        assert (whole.enter[skipped] >= np.float64(expected.t)).all()
        assert first.cost <= whole.cost
        n_shorter += skipped.any()
    assert n_shorter > 0


def test_children_follow_their_parents_and_the_nearer_one_is_first() -> None:
    tree = fl.build(fl.scenes.make("spaghetti", 300).lines, "bvh-d2")
    outline = outline_of(tree)
    way = trace_ray(tree, [0.5, 0.5, -1], [0, 0, 1], 0.01, outline=outline)
    place = {node: i for i, node in enumerate(way.nodes.tolist())}
    at = dict(zip(way.nodes.tolist(), way.enter.tolist(), strict=True))
    for node in way.nodes[1:].tolist():
        assert place[int(outline.parent[node])] < place[node]
    for node in way.nodes[~way.is_leaf].tolist():
        left, right = node + 1, int(outline.right[node])
        if left in place and right in place:
            assert (place[left] < place[right]) == (at[left] <= at[right])


def test_pieces_of_curves_and_parts_are_assigned_too() -> None:
    points = np.cumsum(np.random.default_rng(1).normal(size=(20, 3)), axis=0)
    curves = fl.Curves.from_strands(points, [len(points)], basis="catmull-rom")
    both = fl.Geometry([fl.Lines.from_strands([points + 3]), curves])
    n_hits = 0
    for geometry in (curves, both):
        tree = fl.build(geometry, "bvh-d2")
        for target in points:
            way = trace_ray(tree, [50, 40, 30], target - [50, 40, 30], 0.3)
            n_hits += len(way.hits)
            assert way.n_found.sum() == len(way.hits)  # also where two pieces meet
    assert n_hits > 20


def n_tested(tree: fl.Tree, entered: set[int], node: int, tested: set[int]) -> int:
    """Count tests as the core's traversal does: it skips primitives that it has tested, but for pieces of lines."""
    if node not in entered:
        return 0
    row = tree.nodes[node]
    if row["right"]:
        return sum(n_tested(tree, entered, child, tested) for child in (node + 1, int(row["right"])))
    refs = tree.refs[int(row["first_ref"]) :][: int(row["n_refs"])]["prim"].tolist()
    before = len(tested)
    tested.update(refs)
    return len(refs) if tree.geometry.has_directions else len(tested) - before


@pytest.mark.parametrize("kind", ["triangles", "spheres", "several kinds"])
@pytest.mark.parametrize("method", ["bvh-d2", "kd-d2"])
def test_shapes_in_several_leaves_are_tested_and_found_once(kind: str, method: str) -> None:
    random = np.random.default_rng(3)
    corners = random.uniform(0, 1, (50, 1, 3)) + random.normal(0, 0.1, (50, 3, 3))
    spheres = fl.Spheres.from_centres(random.uniform(0, 1, (50, 3)), radius=0.05)
    parts = [fl.lines(random.uniform(0, 1, (40, 2, 3))).with_radius(0.01), spheres, fl.Triangles(corners)]
    geometry = {"triangles": parts[2], "spheres": spheres, "several kinds": fl.Geometry(parts)}[kind]
    tree = fl.build(geometry, method)
    n_hits, n_refs = 0, 0
    for ray in zip(*rays(20), strict=True):
        way, first = trace_ray(tree, *ray), trace_ray(tree, *ray, query="first")
        assert way.n_found.sum() == len(way.hits) == int(tree.count_hits(*ray))
        assert way.n_tests == n_tested(tree, set(way.nodes.tolist()), 0, set())
        assert first.n_tests == n_tested(tree, set(first.nodes.tolist()), 0, set())
        assert (first.n_found.sum() > 0) == (len(way.hits) > 0)
        n_hits += len(way.hits)
        n_refs += int(tree.nodes["n_refs"][way.nodes[way.is_leaf]].sum()) - way.n_tests
    assert n_hits > 5
    assert (n_refs > 0) == (kind != "spheres")  # spheres are not cut


def test_lines_far_from_the_origin_are_entered_where_they_are() -> None:
    lines = fl.lines(np.array([[[0, 0, 0], [1, 1, 1]]]) + 1e7, offset="auto")
    way = trace_ray(fl.build(lines), np.array([0.5, 0.5, -5]) + 1e7, [0, 0, 1], 0.01)
    assert way.hits.prim.tolist() == [0]
    assert way.enter[0] == pytest.approx(4.99, abs=0.011)


def test_a_tree_without_lines_and_a_ray_that_misses() -> None:
    empty = trace_ray(fl.build(np.zeros((0, 2, 3))), [0, 0, 0], [0, 0, 1], 0.1)
    assert (len(empty.nodes), empty.n_tests, empty.cost, len(empty.hits)) == (0, 0, 0, 0)
    missed = trace_ray(fl.build([[[0, 0, 0], [1, 1, 1]]]), [9, 9, 9], [0, 0, 1], 0.1)
    assert (len(missed.nodes), len(missed.hits)) == (0, 0)


def test_bad_rays_are_refused() -> None:
    tree = fl.build([[[0, 0, 0], [1, 1, 1]]])
    with pytest.raises(fl.InputError, match="radius"):
        trace_ray(tree, [0, 0, 0], [0, 0, 1])
    with pytest.raises(fl.InputError, match="direction"):
        trace_ray(tree, [0, 0, 0], [0, 0, 0], 0.1)
    with pytest.raises(fl.InputError, match="query"):
        trace_ray(tree, [0, 0, 0], [0, 0, 1], 0.1, query="last")  # type: ignore[arg-type]
    with pytest.raises(fl.InputError, match="origin: a str cannot be read"):
        trace_ray(tree, "foo", [0, 0, 1], 0.1)
    with pytest.raises(fl.InputError, match=r"origin has shape \(2, 3\); expected three numbers"):
        trace_ray(tree, [[0, 0, 0]] * 2, [[0, 0, 1]] * 2, 0.1)
    with pytest.raises(fl.InputError, match="tree is int; expected a Tree"):
        trace_ray(5, [0, 0, 0], [0, 0, 1], 0.1)  # type: ignore[arg-type]
