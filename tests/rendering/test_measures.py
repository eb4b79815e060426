"""Numbers of each ray: hits against `count_hits`, and visited nodes against a recursion."""

from __future__ import annotations

import numpy as np
import pytest

import fastlines as fl
from fastlines.rendering import MEASURES, node_visits, progressive, visited_nodes
from fastlines.rendering.looks.table import NUMBERS

SCENE = fl.scenes.make("spaghetti", 300)


def recursive(tree, origin, direction, grow, node=0):
    """Count the visited nodes of one ray, one box at a time."""
    low, high = tree.nodes["box"][node].astype(np.float64)
    enter, leave = 0.0, np.inf
    for axis in range(3):
        a, b = low[axis] - grow, high[axis] + grow
        if direction[axis] == 0:
            if not a <= origin[axis] <= b:
                return 0
            continue
        sides = (a - origin[axis]) / direction[axis], (b - origin[axis]) / direction[axis]
        enter, leave = max(enter, min(sides)), min(leave, max(sides))
    if enter > leave:
        return 0
    right = int(tree.nodes["right"][node])
    below = [node + 1, right] if right else []
    return 1 + sum(recursive(tree, origin, direction, grow, child) for child in below)


@pytest.mark.parametrize("method", ["best", "bvh-cl", "kd-d2"])
@pytest.mark.parametrize("own_radius", [None, 0.01])
@pytest.mark.parametrize("max_pairs", [1 << 18, 16])
def test_visited_nodes_are_those_of_a_recursion(method, own_radius, max_pairs, monkeypatch):
    monkeypatch.setattr(node_visits, "MAX_PAIRS", max_pairs)
    lines = SCENE.lines if own_radius is None else SCENE.lines.with_radius(own_radius)
    tree = fl.build(lines, method)
    origins, directions = (a.astype(np.float64) for a in SCENE.camera.rays(9, 9))
    # Rays along axes, and one that starts within.
    origins = np.concatenate([origins, [[0.5, 0.5, -3], [-3, 0.5, 0.5], [0.5, 0.5, 0.5], [99, 99, 99]]])
    directions = np.concatenate([directions, np.eye(3)[[2, 0, 1, 1]]])
    found = visited_nodes(tree, origins, directions, 0.003)
    grow = 0.003 + (tree.geometry.max_radius if own_radius else 0.0)
    assert found.tolist() == [recursive(tree, o, d, grow) for o, d in zip(origins, directions, strict=True)]
    assert found.max() > 10


def test_nothing_is_visited_in_an_empty_tree():
    assert visited_nodes(fl.build(np.zeros((0, 2, 3))), [[0, 0, 0]], [[0, 0, 1]]).tolist() == [0]


def test_hits_are_counted_for_the_ray_of_each_pixel():
    tree = fl.build(SCENE.lines)
    picture = fl.render(tree, SCENE.camera, width=24, height=20, look="hits", radius=0.003)
    counts = tree.count_hits(*SCENE.camera.rays(24, 20), 0.003).reshape(20, 24)
    assert (picture.aovs["hits"] == counts).all()
    assert ((picture.alpha > 0) == (counts > 0)).all()
    assert list(picture.aovs) == ["hits"]
    shown = picture.to_bytes().reshape(-1, 3)
    few, many = np.flatnonzero(counts.ravel() == 1)[0], counts.argmax()
    assert shown[many, 1] > shown[few, 1]  # viridis ends in yellow


def test_density_is_the_length_of_lines_per_area():
    tree = fl.build(SCENE.lines)
    picture = fl.render(tree, SCENE.camera, width=24, height=20, look="density", radius=0.01)
    gathered = tree.gather(*SCENE.camera.rays(24, 20), 0.01).sum.reshape(20, 24)
    assert np.array_equal(picture.aovs["density"], gathered.astype(np.float32))
    # Over parallel rays, it adds up to the length of the lines within the picture.
    x, y = np.meshgrid(np.arange(-0.5, 1.5, 0.005), np.arange(-0.5, 1.5, 0.005))
    column = tree.gather(np.stack([x, y, np.full_like(x, -9)], axis=-1), [0, 0, 1], 0.01)
    assert column.sum.sum() * 0.005**2 == pytest.approx(SCENE.lines.lengths().sum(), rel=0.01)
    # Whatever the unit of length, the brightest pixels have the last colour.
    small = fl.lines(SCENE.lines.segments * 1e3)
    assert fl.render(small, width=32, height=32, look="density").to_bytes().max() > 200
    with pytest.raises(fl.InputError, match="there are only 2 triangles; use look='hits'"):
        fl.render(fl.Triangles(np.random.default_rng(0).random((2, 3, 3))), width=8, height=8, look="density")
    with pytest.raises(fl.InputError, match="radius=0 is none; pass a radius above 0"):
        fl.render(tree, SCENE.camera, width=8, height=8, look="density", radius=0)


def test_a_larger_radius_is_more_hits_and_more_work():
    tree = fl.build(SCENE.lines)
    options = {"width": 16, "height": 16}
    for name in ("hits", "work"):
        little, much = (fl.render(tree, SCENE.camera, look=name, radius=r, **options).aovs[name] for r in (0.001, 0.01))
        assert (little <= much).all()
        assert little.sum() < much.sum()


def test_samples_are_averaged_and_bands_do_not_matter(monkeypatch):
    options = {"width": 16, "height": 12, "look": "hits", "radius": 0.01, "samples": 4}
    picture = fl.render(SCENE.lines, SCENE.camera, **options)
    values = picture.aovs["hits"]
    assert (4 * values == np.round(4 * values)).all()
    assert (values != np.round(values)).any()
    monkeypatch.setattr(progressive, "MAX_RAYS", 50)
    assert (fl.render(SCENE.lines, SCENE.camera, **options).light == picture.light).all()


def test_a_measure_has_its_own_colours_and_may_have_aovs():
    with pytest.raises(fl.InputError, match="color='plain' does not apply: the look 'work'"):
        fl.render(SCENE.lines, look="work", color="plain")
    with pytest.raises(fl.InputError, match="did you mean 'hits'"):
        fl.render(SCENE.lines, look="hitss")
    picture = fl.render(SCENE.lines, width=8, height=8, look="work", radius=0.01, aovs=True)
    assert {"depth", "work"} < set(picture.aovs)
    nothing = fl.Lines.from_segments(np.zeros((0, 2, 3)))
    assert not fl.render(nothing, width=8, height=8, look="hits", radius=0.1).alpha.any()
    assert list(NUMBERS) == list(MEASURES)
