"""The scenes of points and of contacts, and the peers that search them, beside brute force."""

from __future__ import annotations

import importlib.util
import os
import shutil
from dataclasses import replace

import numpy as np
import pytest

import fastlines as fl
from fastlines_bench.harness import machine
from fastlines_bench.harness.clock import take_turns
from fastlines_bench.peers import closest_points, pairs
from fastlines_bench.proximity import contacts, scenes

needs_scipy = pytest.mark.skipif(importlib.util.find_spec("scipy") is None, reason="scipy is not installed")
needs_compiler = pytest.mark.skipif(not (shutil.which("g++") or shutil.which("c++")), reason="needs a compiler")


# --- Scenes ---


@pytest.mark.parametrize("name", scenes.SIZES)
def test_scenes_have_any_number_of_segments(name):
    for n in (1, 7, 123):
        assert len(scenes.make(f"{name}:{n}").lines) == n
    assert len(scenes.make(name, quick=True).lines) == scenes.QUICK_SIZES[name]
    assert np.array_equal(scenes.make(f"{name}:50").lines.segments, scenes.make(f"{name}:50").lines.segments)


def test_a_neuron_is_connected():
    lines = scenes.make("neuron").lines
    starts, ends = ({point.tobytes() for point in lines.segments[:, end]} for end in (0, 1))
    assert starts - ends == {np.zeros(3, np.float32).tobytes()}


def test_files_replace_scenes(tmp_path):
    lines = fl.scenes.make("bun-hair", 100).lines
    path = tmp_path / scenes.FILES["tracts"]
    fl.write(path, replace(lines, unit="mm", up="z"), reference={"voxel_to_rasmm": np.eye(4), "dimensions": (2, 2, 2)})
    scene = scenes.make("tracts", str(tmp_path))
    assert (scene.source, len(scene.lines)) == ("stroke.trk.gz", 100)
    assert scenes.make("tracts:60", str(tmp_path)).source == "generated"
    assert scenes.make("neuron:60", str(tmp_path)).source == "generated"


def test_half_of_the_points_are_near():
    scene = scenes.make("spaghetti:40")
    points = scenes.points_of_users(scene, 2001)
    assert points.shape == (2001, 3)
    assert points.dtype == np.float64
    distances = least_distances(scene.lines, points) / scene.size
    assert 0.5 < (distances < 3 * scenes.OFFSET).mean() < 0.75
    # They are not sorted.
    first = distances[:1000]
    assert 0.5 < (first < 3 * scenes.OFFSET).mean() < 0.75


@pytest.mark.parametrize("name", contacts.GENERATORS)
def test_contacts_have_any_number_of_segments(name):
    for n in (1, 7, 1000):
        assert len(contacts.GENERATORS[name](n).lines) == n


def test_neighbouring_rows_of_yarn_touch():
    scene = contacts.yarn(1000)
    strands = scene.lines.strands
    found = brute_force_pairs(scene)
    of_rows = np.abs(strands[found[:, 0]] - strands[found[:, 1]])
    assert set(of_rows.tolist()) == {0, 1}
    touched = np.unique(found[of_rows == 1])
    assert len(touched) > 100
    assert len(np.unique(strands[touched])) == strands.max() + 1


def test_the_density_of_rods_is_constant():
    per_rod = [len(brute_force_pairs(contacts.rods(n))) / n for n in (500, 1000)]
    assert 2 < per_rod[0] < per_rod[1] < 4  # those at the faces of the cube touch fewer


# --- Peers ---


@pytest.mark.parametrize("name", closest_points.PEERS)
def test_peers_find_the_nearest_point(name):
    if not closest_points.is_installed(name):
        pytest.skip(f"{name} is not installed")
    segments = scenes.make("neuron:200").lines.segments.copy()
    segments[7, 1] = segments[7, 0]  # without a length
    scene = scenes.PointScene("neuron", "generated", fl.Lines.from_segments(segments))
    points = scenes.points_of_users(scene, 500)
    peer = closest_points.PEERS[name](scene.lines, 1)
    search = peer.search(points, 1)
    of, distances = search.distances(search.run())
    off = (distances - least_distances(scene.lines, points)[of]) / scene.size
    assert len(of) == 500
    assert off.min() > -1e-6
    assert off.max() < (1e-6 if peer.exact else closest_points.SAMPLING)
    eight = peer.search(points, 8)
    assert (eight is None) == peer.exact
    if eight is not None:
        assert np.array_equal(eight.distances(eight.run())[1], distances)


def test_a_peer_that_is_missing_is_named(monkeypatch):
    monkeypatch.setattr(closest_points, "is_installed", lambda name: False)
    with pytest.raises(fl.InputError, match=r"fcpw is not installed: run  pip install './benchmarks\[nearest\]'"):
        closest_points.check_installed("fcpw")


def test_samples_are_close():
    lines = fl.Lines.from_segments([[[0, 0, 0], [1, 0, 0]], [[0, 0, 0], [0, 0, 0]]])
    points, of = closest_points.sample(lines, 0.3)
    np.testing.assert_allclose(points[:, 0], [0.125, 0.375, 0.625, 0.875, 0])
    assert of.tolist() == [0, 0, 0, 0, 1]


def test_morton_order_visits_octants():
    corners = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], np.float64)
    shuffled = np.random.default_rng(0).permutation(8)
    assert np.array_equal(shuffled[closest_points.morton_order(corners[shuffled])], np.arange(8))


@needs_scipy
@pytest.mark.parametrize("name", contacts.GENERATORS)
@pytest.mark.parametrize("share", [2.0, 0.3])
def test_pairs_of_samples_are_those_of_brute_force(name, share):
    scene = contacts.GENERATORS[name](301)
    sampled = pairs.SampledPairs(scene.lines, scene.radius, scene.skip_neighbours, share)
    assert np.array_equal(sampled.find(), brute_force_pairs(scene))


@needs_compiler
@pytest.mark.parametrize("name", contacts.GENERATORS)
@pytest.mark.parametrize("n", [1, 2, 16, 301])
def test_textbook_pairs_are_those_of_brute_force(name, n):
    scene = contacts.GENERATORS[name](n)
    found = pairs.TextbookPairs(scene.lines)
    found._room = 3  # the memory grows
    assert np.array_equal(found.find(scene.radius, scene.skip_neighbours), brute_force_pairs(scene))


def test_distances_of_segments():
    first = np.array([[[0, 0, 0], [1, 0, 0]]] * 4, np.float64)
    second = np.array(
        [
            [[0.5, -1, 2], [0.5, 1, 2]],  # across
            [[3, 1, 0], [4, 1, 0]],  # parallel, beyond the end
            [[0.2, 1, 0], [0.7, 1, 0]],  # parallel, beside
            [[0.5, 3, 0], [0.5, 3, 0]],  # a point
        ],
        np.float64,
    )
    np.testing.assert_allclose(pairs.segment_distances(first, second), [2, 5**0.5, 1, 3])
    np.testing.assert_allclose(pairs.segment_distances(second, first), [2, 5**0.5, 1, 3])


# --- The harness ---


def test_sides_take_turns():
    order = []
    ticks = iter(range(100))
    sides = {name: lambda name=name: order.append(name) or name for name in "ab"}
    seconds, answers = take_turns(3, sides, lambda: float(next(ticks)))
    assert order == ["a", "b"] * 3
    assert seconds == {"a": [1, 1, 1], "b": [1, 1, 1]}
    assert answers == {"a": "a", "b": "b"}


def test_few_processors():
    if not hasattr(os, "sched_getaffinity"):
        pytest.skip("needs Linux")
    before = os.sched_getaffinity(0)
    with machine.few_processors(1):
        assert len(os.sched_getaffinity(0)) == 1
    assert os.sched_getaffinity(0) == before


def least_distances(lines, points):
    """Return the distance of each point from the nearest segment, in float64."""
    ends = lines.segments.astype(np.float64)
    n, m = len(points), len(ends)
    squares = pairs._square_from_points(
        np.repeat(points, m, axis=0), np.tile(ends[:, 0], (n, 1)), np.tile(ends[:, 1] - ends[:, 0], (n, 1))
    )
    return np.sqrt(squares.reshape(n, m).min(axis=1))


def brute_force_pairs(scene):
    """Return all pairs of a scene, tested one by one in float64."""
    ends, strands = scene.lines.segments.astype(np.float64), scene.lines.strands
    i, j = np.triu_indices(len(ends), 1)
    is_near = pairs.segment_distances(ends[i], ends[j]) <= scene.radius
    is_neighbour = (strands[i] >= 0) & (strands[i] == strands[j]) & (j - i <= scene.skip_neighbours)
    return np.stack([i, j], axis=1)[is_near & ~is_neighbour]
