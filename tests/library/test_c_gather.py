"""Sums over hits in the C interface, by ctypes: those of Python, bit for bit."""

from __future__ import annotations

import ctypes as c
from typing import Any

import numpy as np
import pytest
from support.c_library import GatherOptions, Library, Rays, pointer

import fastlines as fl

RNG = np.random.default_rng(1)
ORIGINS = RNG.uniform(-1, 2, (300, 3)).astype(np.float32)
DIRECTIONS = (RNG.random((300, 3)) - ORIGINS).astype(np.float32)
T_MAX = np.full(300, 2, np.float32)
DEPTHS = np.sort(RNG.random((300, 5)).astype(np.float32), axis=1)
BLURS = ("box", "epanechnikov", "none")


def c_rays(**rest: Any) -> Rays:
    arrays = {"origins": ORIGINS, "directions": DIRECTIONS, "t_max": T_MAX}
    return Rays(n=300, **{name: pointer(array) for name, array in arrays.items()}, **rest)


@pytest.mark.parametrize("spread", [0.0, 0.01])
@pytest.mark.parametrize("blur", BLURS)
def test_sums_are_those_of_python(library: Library, lines: fl.Lines, blur: str, spread: float) -> None:
    tree, mine = library.build(lines), fl.build(lines, method="bvh-cl")
    values = RNG.random((len(lines), 2)).astype(np.float32)
    rays = c_rays(radius=0.03, spread=spread)
    given: dict[str, Any] = {"origins": ORIGINS, "directions": DIRECTIONS, "radius": 0.03, "t_max": 2, "spread": spread}
    options = GatherOptions(blur=BLURS.index(blur), n_channels=2, values=pointer(values), has_phase=1, phase=0.5)
    options.sigma[:2], options.line_sigma[:2] = (0.1, 0.2), (0.3, 0.4)
    how = {"values": values, "blur": blur, "sigma": [0.1, 0.2], "line_sigma": [0.3, 0.4], "phase": 0.5}
    for options.with_ends in (0, 1):
        expected = mine.gather(**given, **how, inner=not options.with_ends, squares=True)
        assert expected.count.sum() > 300
        for found, of_python in zip(
            tree.gather(rays, options), (expected.sum, expected.squares, expected.count), strict=True
        ):
            np.testing.assert_array_equal(found, of_python)
    depths = GatherOptions(optical_depth=pointer(DEPTHS), n_depths=5)
    np.testing.assert_array_equal(tree.gather(rays, depths)[0][:, 0], mine.gather(**given, optical_depth=DEPTHS).sum)
    np.testing.assert_array_equal(tree.gather(rays)[0][:, 0], mine.gather(**given).sum)


def test_bad_input_is_refused(library: Library, lines: fl.Lines) -> None:
    tree = library.build(lines)
    with pytest.raises(RuntimeError, match="unknown fl_blur"):
        tree.gather(c_rays(radius=0.1), GatherOptions(blur=7))
    with pytest.raises(RuntimeError, match="n_channels is 9; expected 1 to 8"):
        tree.gather(c_rays(radius=0.1), GatherOptions(n_channels=9))
    with pytest.raises(RuntimeError, match="optical_depth is an array, and n_depths is 0; set both, or neither"):
        tree.gather(c_rays(radius=0.1), GatherOptions(optical_depth=pointer(DEPTHS)))
    with pytest.raises(RuntimeError, match="optical_depth is NULL, and n_depths is 5"):
        tree.gather(c_rays(radius=0.1), GatherOptions(n_depths=5))
    with pytest.raises(RuntimeError, match="rays is NULL"):
        library.call("fl_gather", tree.tree, None, None, None, None, None)
    with pytest.raises(RuntimeError, match="sum is NULL"):
        library.call("fl_gather", tree.tree, c.byref(c_rays(radius=0.1)), None, None, None, None)
