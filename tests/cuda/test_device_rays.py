"""Rays in the memory of a GPU are read there, and answers stay there; on a host that emulates the GPU."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from support.answers import PLACES
from support.emulated_device import DeviceArray, EmulatedDevice

import fastlines as fl
from fastlines.cuda.device_rays import DeviceHits
from fastlines.query.queries import QUERIES

RANDOM = np.random.default_rng(4)
LINES = fl.Lines.from_segments(RANDOM.uniform(-1, 1, (200, 2, 3)), radius=RANDOM.uniform(0, 0.02, (200, 2)))
TREE = fl.build(LINES)
ORIGINS = RANDOM.uniform(-2, 2, (8, 9, 3)).astype(np.float32)
DIRECTIONS = RANDOM.uniform(-1, 1, (8, 9, 3)).astype(np.float32)


def on_device(array: Any) -> DeviceArray:
    return DeviceArray(np.array(array, np.float32))


def test_lines_with_an_offset_are_refused(device: EmulatedDevice) -> None:
    tree = fl.build(fl.lines(LINES, offset=(1, 0, 0)))
    placed = tree.to("cuda")
    with pytest.raises(
        fl.InputError,
        match=r"have an offset, \(1.0, 0.0, 0.0\).*pass rays as NumPy arrays, or query tree.without_offset",
    ):
        placed.first_hit(on_device(ORIGINS), on_device(DIRECTIONS), 0.01)
    placed.without_offset().first_hit(on_device(ORIGINS), on_device(DIRECTIONS), 0.01)
    assert placed.first_hit(ORIGINS, DIRECTIONS, 0.01).t.tobytes() == (
        tree.first_hit(ORIGINS, DIRECTIONS, 0.01).t.tobytes()
    )


def test_lists_in_parts_are_refused(device: EmulatedDevice) -> None:
    with pytest.raises(fl.InputError, match=r"rays of a GPU or of Dask are not listed in parts; pass NumPy arrays"):
        TREE.to("cuda").iter_all_hits(on_device(ORIGINS), on_device(DIRECTIONS), max_bytes=1000)
    whole, rays = TREE.all_hits(ORIGINS, DIRECTIONS), (ORIGINS, DIRECTIONS)
    parts = list(TREE.to("cuda").iter_all_hits(*rays, max_bytes=500))
    assert len(parts) > 1
    assert np.concatenate([part.t for part in parts]).tobytes() == whole.t.tobytes()


def assert_same(got: Any, expected: Any) -> None:
    if not isinstance(got, DeviceHits):
        got, expected = {"answer": got}, {"answer": expected}
    else:
        names = ("t", "prim", "u", "distance", "t_out", "offsets")
        got, expected = ({name: getattr(hits, name, None) for name in names} for hits in (got, expected))
    for name, array in got.items():
        if array is None:
            assert expected[name] is None
            continue
        assert (array.array.dtype, array.array.shape) == (expected[name].dtype, expected[name].shape), name
        assert array.array.tobytes() == expected[name].tobytes(), name


@pytest.mark.parametrize("query", QUERIES)
def test_answers_are_those_on_the_host(query: str, device: EmulatedDevice) -> None:
    tree = TREE.to("cuda")
    bounds = {"t_min": -0.5, "t_max": RANDOM.uniform(0, 3, (8, 9)).astype(np.float32)}
    for at in PLACES[query]:
        how: dict[str, Any] = {"at": at} | ({"k": 2} if query == "next_hits" else {})
        for directions, radius in ((DIRECTIONS, None), (DIRECTIONS[0, 0], 0.03), (DIRECTIONS, np.full((8, 9), 0.1))):
            expected = getattr(TREE, query)(ORIGINS, directions, radius, **bounds, **how)
            device.uploaded.clear()
            given = None if radius is None else radius if np.ndim(radius) == 0 else on_device(radius)
            got = getattr(tree, query)(
                on_device(ORIGINS), on_device(directions), given, t_min=-0.5, t_max=on_device(bounds["t_max"]), **how
            )
            assert_same(got, expected)
    # Rays are not copied: only records, and numbers that are one for all.
    assert max(device.uploaded) <= max(88, 8 * (ORIGINS.size // 3 + 1))


@pytest.mark.slow
@pytest.mark.parametrize("query", QUERIES)
def test_rays_with_a_spread(query: str, device: EmulatedDevice) -> None:
    how = {"k": 2} if query == "next_hits" else {}
    spreads = RANDOM.choice([0, 1e-4, 0.01, 0.2], (8, 9)).astype(np.float32)
    for lines in (LINES, fl.Lines.from_segments(LINES.segments)):
        tree = fl.build(lines)
        for spread in (0.02, spreads, 0 * spreads):
            given = spread if np.ndim(spread) == 0 else on_device(spread)
            got = getattr(tree.to("cuda"), query)(on_device(ORIGINS), on_device(DIRECTIONS), 0.01, spread=given, **how)
            assert_same(got, getattr(tree, query)(ORIGINS, DIRECTIONS, 0.01, spread=spread, **how))


@pytest.mark.slow
@pytest.mark.parametrize("method", ["bvh-cl", "kd-cl"])
@pytest.mark.parametrize("query", QUERIES)
def test_triangles(query: str, method: str, device: EmulatedDevice) -> None:
    """A triangle may be in several leaves, and is counted and listed once."""
    corners = RANDOM.uniform(-1, 1, (300, 1, 3)) + RANDOM.uniform(-0.3, 0.3, (300, 3, 3))
    tree = fl.build(fl.Triangles(corners), method)
    assert (len(tree.layout.refs) > len(corners)) == (method == "kd-cl")
    for how in [{"k": 2}, {"k": 90, "at": "surface"}] if query == "next_hits" else [{}]:
        got = getattr(tree.to("cuda"), query)(on_device(ORIGINS), on_device(DIRECTIONS), **how)
        assert_same(got, getattr(tree, query)(ORIGINS, DIRECTIONS, **how))


def test_no_rays(device: EmulatedDevice) -> None:
    none = on_device(np.empty((0, 3)))
    assert TREE.to("cuda").first_hit(none, none).t.array.shape == (0,)
    assert TREE.to("cuda").all_hits(none, none).offsets.array.tolist() == [0]


@pytest.mark.parametrize(
    "change",
    [
        {"origins": np.nan},
        {"origins": -np.inf},
        {"directions": np.nan},
        {"directions": np.inf},
        {"directions": 0.0},
        {"directions": 1e-39},
        {"radius": -1.0},
        {"radius": np.nan},
        {"radius": 1e30},
        {"t_min": np.nan},
        {"t_max": np.nan},
        {"t_min": np.inf, "t_max": np.inf},
        {"t_min": 2.0, "t_max": 1.0},
        {"spread": -1e-3},
        {"spread": np.nan},
        {"spread": 2e12},
        {"spread": 0.9e12, "directions": 1.0},
    ],
)
def test_invalid_rays_are_those_of_the_host(change: dict[str, float], device: EmulatedDevice) -> None:
    rays = {
        "origins": ORIGINS[0].copy(),
        "directions": DIRECTIONS[0].copy(),
        "radius": np.full(9, 0.1, np.float32),
        "t_min": np.zeros(9, np.float32),
        "t_max": np.full(9, np.inf, np.float32),
        "spread": np.zeros(9, np.float32),
    }
    for name, value in change.items():
        rays[name][4] = value
    with pytest.raises(fl.InputError, match="1 of 9 rays"):
        TREE.first_hit(**rays)
    with pytest.raises(fl.InputError, match="1 of 9 rays are not valid"):
        TREE.to("cuda").first_hit(**{name: on_device(array) for name, array in rays.items()})


def test_arrays_of_another_kind(device: EmulatedDevice) -> None:
    tree, origins, directions = TREE.to("cuda"), on_device(ORIGINS), on_device(DIRECTIONS)
    with pytest.raises(fl.InputError, match="origins are float64; expected contiguous float32"):
        tree.first_hit(DeviceArray(ORIGINS.astype(np.float64)), directions)
    with pytest.raises(fl.InputError, match="directions are float32, and not contiguous"):
        tree.first_hit(origins, DeviceArray(DIRECTIONS[:, ::-1]))
    with pytest.raises(fl.InputError, match=r"directions have shape \(9, 3\); expected \(8, 9, 3\) or \(3,\)"):
        tree.first_hit(origins, on_device(DIRECTIONS[0]))
    with pytest.raises(fl.InputError, match=r"origins have shape \(8, 9\)"):
        tree.first_hit(DeviceArray(np.ascontiguousarray(ORIGINS[..., 0])), directions)
    with pytest.raises(fl.InputError, match=r"t_min have shape \(2,\)"):
        tree.first_hit(origins, directions, t_min=[0, 1])


def test_what_rays_on_a_device_do_not_take(device: EmulatedDevice) -> None:
    tree, rays = TREE.to("cuda"), (on_device(ORIGINS), on_device(DIRECTIONS))
    for name, value in {"ignore": [0], "ignore_strands": [0], "invalid": "skip"}.items():
        with pytest.raises(fl.InputError, match=f"take no {name}="):
            tree.first_hit(*rays, **{name: value})
    with pytest.raises(fl.InputError, match="at='surface' has no meaning with a spread"):
        tree.all_hits(*rays, at="surface", spread=0.1)
    with pytest.raises(fl.InputError, match="are not merged"):
        tree.all_hits(*rays, at="surface", merge="strand")
    with pytest.raises(fl.InputError, match="this tree answers on the CPU"):
        TREE.to("cpu").first_hit(*rays)
    with pytest.raises(fl.InputError, match="have no radius of their own"):
        fl.build(LINES.segments).to("cuda").first_hit(*rays)
    curves = fl.Curves.from_bezier(RANDOM.uniform(-1, 1, (3, 4, 3)), 0.01)
    with pytest.raises(fl.InputError, match="hits of curves are put together on the CPU"):
        fl.build(curves).to("cuda").first_hit(*rays)
    with pytest.raises(fl.InputError, match="the CPU says which part of a Geometry is hit"):
        fl.build(fl.Geometry([LINES])).to("cuda").first_hit(*rays)
