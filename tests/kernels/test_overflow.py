"""Coordinates whose squares overflow: all kernels agree."""

from __future__ import annotations

import numpy as np
import pytest

import fastlines as fl


@pytest.mark.parametrize("at", ["closest", "surface", "entry"])
def test_one_point_is_counted_once_however_far_it_is(at: str) -> None:
    """Squares of such coordinates overflow; lanes that have no ray of their own count nothing."""
    far = np.float32(2.8460483e26)
    tree = fl.build(np.full((1, 2, 3), far))
    rays = [[1.3 * far, far, far], [far, far, -far]], [[-0.1 * far, 0.02 * far, 0.1 * far], [0, 0, far]]
    for kernel in ("auto", "single", "wave", "bundle", "binary"):
        assert tree.count_hits(*rays, 0.0, at=at, kernel=kernel).tolist() == [0, 1], kernel
        assert tree.all_hits(*rays, 0.0, at=at, kernel=kernel).prim.tolist() == [0], kernel
