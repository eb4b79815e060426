"""Counts and nouns go together, for 0, 1 and more of each thing."""

from __future__ import annotations

import re

import numpy as np
import pytest

import fastlines as fl
from fastlines.support.texts import counted, singular, with_article

RAY = [0, 0, -9], [0, 0, 1], 0.1


class Balls:
    """A class of one's own."""

    def __init__(self, n):
        self.n = n

    def bounds(self):
        return np.tile(np.float64([[[0, 0, 0], [1, 1, 1]]]), (self.n, 1, 1))

    def hit(self, ids, rays, radius):
        return np.full(len(ids), np.nan)


def lines(n):
    points = np.float32([[i, 0, 0] for i in range(n + 1)])
    return fl.Lines.from_strands([points]) if n else fl.Lines.from_segments([])


def curves(n):
    return fl.Curves.from_bezier(np.zeros((n, 4, 3)), strands=np.zeros(n, np.int64))


#: What makes n of something, and what it says of 1 and of 2.
MADE = {
    "lines": (lines, "<Lines: 1 segment, 1 strand>", "<Lines: 2 segments, 1 strand>"),
    "spheres": (
        lambda n: fl.Spheres.from_centres(np.zeros((n, 3)), 1),
        "<Spheres: 1 sphere, radius>",
        "<Spheres: 2 spheres, radius>",
    ),
    "curves": (curves, "<Curves: 1 curve, 1 strand>", "<Curves: 2 curves, 1 strand>"),
    "triangles": (
        lambda n: fl.Triangles(np.zeros((n, 3, 3))),
        "<Triangles: 1 triangle>",
        "<Triangles: 2 triangles>",
    ),
    "boxes": (lambda n: fl.Boxes(np.zeros((n, 2, 3))), "<Boxes: 1 box>", "<Boxes: 2 boxes>"),
    "own": (
        lambda n: fl.build(Balls(n)).geometry,
        "<UserPrimitives: 1 primitive of Balls>",
        "<UserPrimitives: 2 primitives of Balls>",
    ),
    "parts": (
        lambda n: fl.Geometry([fl.Boxes(np.zeros((n, 2, 3)))]),
        "<Geometry: <Boxes: 1 box>>",
        "<Geometry: <Boxes: 2 boxes>>",
    ),
    "first hits": (
        lambda n: fl.build(lines(1)).first_hit(np.full((n, 3), 9.0), *RAY[1:]),
        "<FirstHits: 1 ray, 0 hit>",
        "<FirstHits: 2 rays, 0 hit>",
    ),
    "all hits": (
        lambda n: fl.build(lines(1)).all_hits(np.tile(RAY[0], (n, 1)), *RAY[1:]),
        "<AllHits: 1 ray, 1 hit>",
        "<AllHits: 2 rays, 2 hits>",
    ),
}


@pytest.mark.parametrize("name", MADE)
def test_what_objects_say(name):
    make, one, two = MADE[name]
    assert (repr(make(1)), repr(make(2))) == (one, two)
    assert re.search(r"\b0 [a-z]+(s|xes)\b", repr(make(0)))


@pytest.mark.parametrize("n", [0, 1, 2])
def test_what_trees_say(n):
    tree = fl.build(lines(n))
    for shown in (repr(tree), repr(tree.layout), tree.to_dot()):
        for number, noun in re.findall(r"(?<![\w.])([\d,]+) ([a-z]+)", shown):
            if noun in ("primitives", "primitive", "references", "reference", "nodes", "node", "leaves", "leaf"):
                assert (singular(noun) == noun) == (number == "1"), shown


def test_nouns():
    assert [counted(n, "boxes") for n in (0, 1, 2, 3000)] == ["0 boxes", "1 box", "2 boxes", "3,000 boxes"]
    for one, many in (
        ("ray", "rays"),
        ("leaf", "leaves"),
        ("vertex", "vertices"),
        ("mesh", "meshes"),
        ("body", "bodies"),
    ):
        assert singular(many) == one
    assert [with_article(name) for name in ("Ellipsoids", "Lines", "int", "str", "ndarray", "Ellipse", "Glass")] == [
        "Ellipsoids",
        "Lines",
        "an int",
        "a str",
        "a ndarray",
        "an Ellipse",
        "a Glass",
    ]
