"""The blocks of a layout: none is smaller than what is in it."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import fastlines as fl

Array = npt.NDArray[Any]

#: The blocks of nodes and leaves (docs/engine.md).
NODE = np.dtype("3f4, f4, u4, u4, u1, u1, 6u1, (3, 16)u1, (3, 16)u1")
NODE.names = ("org", "scale", "first_inner", "first_leaf", "n_inner", "n_children", "unused", "low", "high")
LEAF = np.dtype("3f4, f4, f4, u4, u4, 100u1")
LEAF.names = ("org", "scale", "per_scale", "first_ref", "n_refs", "rest")


def boxes_of(layout: Any, segments: Array) -> tuple[Array, Array]:
    """Return the boxes (n, 2, 3) of what lies below nodes and in leaves, of a layout whose segments are not cut."""
    nodes, leaves = layout.nodes.view(NODE)[:, 0], layout.leaves.view(LEAF)[:, 0]
    each = np.stack([segments.min(axis=1), segments.max(axis=1)], axis=1)[layout.refs[:, 0]]
    places = leaves[["first_ref", "n_refs"]].tolist()
    of_leaves = np.stack([hull(each[first : first + n]) for first, n in places])
    of_nodes = np.zeros((len(nodes), 2, 3), np.float32)
    for i in range(len(nodes) - 1, -1, -1):
        of_nodes[i] = hull(children_of(nodes[i], of_nodes, of_leaves))
    return of_nodes, of_leaves


def hull(boxes: Array) -> Array:
    return np.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])


def children_of(node: Any, of_nodes: Array, of_leaves: Array) -> Array:
    n_inner, n_leaves = int(node["n_inner"]), int(node["n_children"]) - int(node["n_inner"])
    inner = of_nodes[node["first_inner"] : node["first_inner"] + n_inner]
    return np.concatenate([inner, of_leaves[node["first_leaf"] : node["first_leaf"] + n_leaves]])


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("simd", fl.available_simd())
def test_boxes_are_rounded_outwards(simd: str, seed: int) -> None:
    """Also where they end a little beyond a whole number of quanta of their node, or a little before."""
    rng = np.random.default_rng(seed)
    corner = 0.5 + 0.5 * rng.random()  # of the scene's box, so that its frame is the coordinates' own
    starts = rng.uniform(-0.9, 0.9, (3000, 1, 3))
    segments = (np.concatenate([starts, starts + rng.normal(0, 0.02, starts.shape)], axis=1) * corner).astype("f4")
    segments[:2] = [[[-corner] * 3] * 2, [[corner] * 3] * 2]
    fl.set_simd(simd)
    try:
        root = fl.build(segments, "bvh-cl").layout.nodes.view(NODE)[0, 0]
        org, scale = root["org"].astype(float), float(root["scale"])
        whole = (org + np.rint((segments[2:] - org) / scale) * scale).astype(np.float32)
        segments[2:] = np.nextafter(whole, rng.choice([-2, 2], whole.shape).astype(np.float32))
        layout = fl.build(segments, "bvh-cl").layout
    finally:
        fl.set_simd(None)
    nodes = layout.nodes.view(NODE)[:, 0]
    assert (nodes["org"][0] == root["org"]).all()
    of_nodes, of_leaves = boxes_of(layout, segments)
    for node in nodes:
        boxes = children_of(node, of_nodes, of_leaves).astype(float)
        low, high = (
            node["org"][:, None] + node[name][:, : len(boxes)] * float(node["scale"]) for name in ("low", "high")
        )
        assert (boxes[:, 0] >= low.T).all()
        assert (boxes[:, 1] <= high.T).all()
