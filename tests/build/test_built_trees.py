"""What is built is a tree: every method, and other settings, on nasty input."""

import numpy as np
import pytest
from support.nasty import SCENES, boxes_of, named_scene, triangles_on
from support.slow import few_of

import fastlines as fl


@pytest.mark.parametrize("name", few_of(SCENES, n=6))
@pytest.mark.parametrize("method", fl.METHODS)
def test_every_method_on_nasty_input(method, name):
    ends = named_scene(name)
    for geometry in (ends, triangles_on(ends), boxes_of(ends)):
        fl.build(geometry, method).validate()


@pytest.mark.parametrize("name", few_of(SCENES, n=6))
@pytest.mark.parametrize(
    "options",
    [
        {"splits": (fl.ObjectSweep(), fl.PlaneGrid(7)), "cost": fl.Cost(c_trav=0.2)},
        {"splits": fl.PlaneEvents(), "cost": fl.Cost(c_trav=0.2)},
        {"splits": fl.Midpoint(), "limits": fl.Limits(max_leaf_refs=2)},
        {"splits": fl.Median(), "boxes": "cut", "cost": fl.Cost(c_trav=0.2)},
        {"splits": (fl.Midpoint(), fl.Median()), "limits": fl.Limits(max_refs=60)},
        {"splits": fl.PlaneGrid(3), "boxes": "cut", "limits": fl.Limits(leaf_refs=0, max_depth=9), "lookahead": 2},
    ],
    ids=lambda options: " ".join(options) + " " + options.get("boxes", ""),
)
def test_other_settings_on_nasty_input(options, name):
    fl.build(named_scene(name), **options).validate()


def test_a_finely_cut_triangle():
    corners = np.array([[[2, -4, 8], [8, -7, -5], [-5, -5, 1]]]) / 8
    limits = fl.Limits(leaf_refs=0, max_depth=12, max_refs=10**6)
    fl.build(
        fl.Triangles(corners), splits=fl.PlaneGrid(3), lookahead=1, cost=fl.Cost(c_trav=0.1), limits=limits
    ).validate()
