"""What trees refuse: brute force refuses the same."""

from __future__ import annotations

from contextlib import nullcontext
from functools import partial

import numpy as np
import pytest
from support.builds import ALL_KINDS
from support.nasty import named_scene

import fastlines as fl
from fastlines.geometry.collection import as_geometry


@pytest.mark.parametrize("kind", ALL_KINDS)
def test_radii_and_points_are_refused_by_both(kind: str) -> None:
    """Limits are relative to the box of the tree's root, also where the box of the primitives is another one."""
    geometry = as_geometry(ALL_KINDS[kind](1e-6 * named_scene("random") + 1))
    tree = fl.build(geometry)
    assert np.array_equal(geometry.tree_bounds, tree.box)
    size = float(np.ptp(tree.box, axis=0).max()) + 2 * geometry.radius_beyond
    for distance, is_allowed in ((0.3e12 * size, True), (3e12 * size, False)):
        with nullcontext() if is_allowed else pytest.raises(fl.InputError, match="farther from the scene"):
            tree.count_within([distance, 1, 1], 0)
        with nullcontext() if is_allowed else pytest.raises(fl.InputError, match="farther from the scene"):
            fl.brute_force_points(geometry, [distance, 1, 1], 0, query="count_within")
        for any_hit in (tree.any_hit, partial(fl.brute_force, geometry, query="any_hit")):
            if geometry.takes_radius:
                with nullcontext() if is_allowed else pytest.raises(fl.InputError, match="have a radius"):
                    any_hit([1, 1, 0], [0, 0, 1], distance)
