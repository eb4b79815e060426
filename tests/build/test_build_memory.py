"""The model of a build's memory: its sizes are those of trees and layouts, and it never shrinks."""

import numpy as np
import pytest

import fastlines as fl
from fastlines.cli.dry_run import SMALL, forecast, walk
from fastlines.settings.build_memory import build_bytes, expected_refs, layout_bytes, most_prims, tree_bytes
from fastlines.settings.methods import best_settings


def test_sizes_of_a_tree_and_its_layout():
    lines = fl.scenes.make("bun-hair", 20_000).lines
    tree = fl.build(lines, effort=0.0)
    made = tree.nodes.nbytes + tree.refs.nbytes
    assert tree_bytes(tree.n_refs, tree.settings) == pytest.approx(made, rel=0.15)
    layout = tree.layout
    n_bytes = layout.nodes.nbytes + layout.leaves.nbytes + layout.refs.nbytes
    assert layout_bytes(tree.n_refs)[0] == pytest.approx(n_bytes, rel=0.2)


@pytest.mark.parametrize("method", fl.METHODS)
def test_more_primitives_references_or_threads_take_more(method):
    settings = fl.METHODS[method]
    sizes = [build_bytes(n, settings) for n in (0, 1, 1000, 10**6, 10**8)]
    assert sizes == sorted(sizes)
    assert build_bytes(10**6, settings, 2 * 10**6) > build_bytes(10**6, settings, 10**6)
    assert build_bytes(10**6, settings, n_threads=8) > build_bytes(10**6, settings, n_threads=1)
    assert expected_refs(1000, settings) >= 1000


def test_a_build_within_a_memory():
    settings = best_settings(n_prims=10**6)
    n_prims = most_prims(10**9, settings, 1.2)
    assert 32 * n_prims + build_bytes(n_prims, settings, int(1.2 * n_prims)) <= 10**9
    assert most_prims(0, settings) == 0
    assert most_prims(4 * 10**9, settings, 50.0) < most_prims(4 * 10**9, settings, 1.0) / 10


@pytest.mark.parametrize(("scene", "n_segments"), [("spaghetti", 40_000), ("straight-hair", 100_000)])
def test_walks_estimate_the_number_of_references(scene, n_segments):
    lines = fl.scenes.make(scene, n_segments).lines
    tree = fl.build(lines, effort=0.0)
    facts = forecast(lines, tree.settings, lambda pieces: fl.build(pieces, effort=0.0))
    assert facts["n_refs"] == pytest.approx(tree.n_refs, rel=0.2)
    assert facts["seconds"] > 0


def test_a_walk_cuts_lines_and_ends_where_all_coincide():
    random = np.random.default_rng(0)
    segments = fl.scenes.make("spaghetti", 50_000).lines.segments
    pieces, factor = walk(segments, random)
    assert len(pieces) <= SMALL
    assert factor > 1.0
    inside = (pieces >= segments.min(axis=(0, 1))) & (pieces <= segments.max(axis=(0, 1)))
    assert inside.all()
    assert len(segments) == 50_000
    alike = np.repeat(segments[:1], 50_000, axis=0)
    pieces, factor = walk(alike, random)
    assert len(pieces) <= SMALL
    assert factor == 1.0


@pytest.mark.parametrize("boxes", ["tight", "cut"])
@pytest.mark.parametrize("n", [1, 1000, 10**6])
def test_the_bytes_of_the_smallest_tree_hold_a_reference_for_each_primitive(n: int, boxes: str) -> None:
    least = fl.Limits().bytes_for(n, boxes)
    assert fl.Limits(max_bytes=least).refs_for(n, boxes) == n
    assert fl.Limits(max_bytes=least - 1).refs_for(n, boxes) == n - 1
    assert fl.Limits(max_bytes=0).refs_for(n, boxes) == 0
