"""The same answers on a real GPU, with arrays of NumPy, torch, CuPy and JAX; skipped on machines without one."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from support import nasty
from support.answers import PLACES, assert_same, cases, options, question
from support.builds import ALL_KINDS
from support.emulated_device import TUNINGS

import fastlines as fl
from fastlines.cuda import program
from fastlines.cuda.cuda_device import gpu
from fastlines.query.queries import QUERIES

RANDOM = np.random.default_rng(8)
TREE = fl.build(RANDOM.uniform(-1, 1, (2000, 2, 3)))
ORIGINS = RANDOM.uniform(-2, 2, (50, 100, 3)).astype(np.float32)
DIRECTIONS = RANDOM.uniform(-1, 1, (50, 100, 3)).astype(np.float32)


@pytest.fixture(autouse=True)
def on_a_gpu() -> None:
    try:
        gpu()
    except fl.FastlinesError as error:
        pytest.skip(str(error))


@pytest.mark.parametrize("name", nasty.NAMES)
@pytest.mark.parametrize("kind", ["segments", "round cones", "triangles", "a mixture"])
def test_answers_are_those_of_brute_force(kind: str, name: str) -> None:
    case = cases(0, n_rays=60)[name]
    asked, _ = question(case)
    geometry = ALL_KINDS[kind](case.segments)
    tree = fl.build(geometry).to("cuda")
    for query in QUERIES:
        for at in PLACES[query]:
            how = options(query) | {"at": at}
            expected = fl.brute_force(geometry, **asked, query=query, **how)  # type: ignore[arg-type]
            assert_same(getattr(tree, query)(**asked, **how), expected, f"{query}, {how}")


@pytest.mark.parametrize("tuning", TUNINGS, ids=str)
def test_tuning_changes_no_answer(tuning: dict[str, int], monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in tuning.items():
        monkeypatch.setitem(program.TUNING, name, value)
    tree = fl.build(TREE.geometry)
    for radius in (0.001, 0.1):
        for query in QUERIES:
            for at in PLACES[query]:
                how = options(query) | {"at": at}
                answers = (
                    getattr(tree.to(where), query)(ORIGINS, DIRECTIONS, radius, **how) for where in ("cuda", "cpu")
                )
                assert_same(*answers, f"{query}, {how}, {radius=}")


def _torch() -> tuple[Callable[[Any], Any], Callable[[Any], Any]]:
    torch = pytest.importorskip("torch")
    return lambda array: torch.from_numpy(array).cuda(), lambda array: torch.from_dlpack(array).cpu().numpy()


def _cupy() -> tuple[Callable[[Any], Any], Callable[[Any], Any]]:
    cupy = pytest.importorskip("cupy")
    return cupy.asarray, lambda array: cupy.asnumpy(cupy.from_dlpack(array))


def _jax() -> tuple[Callable[[Any], Any], Callable[[Any], Any]]:
    jax = pytest.importorskip("jax")
    jax.config.update("jax_enable_x64", True)  # else it makes 32 bits of the 64 of ids
    return lambda array: jax.device_put(array, jax.devices("gpu")[0]), lambda array: np.asarray(
        jax.dlpack.from_dlpack(array)
    )


@pytest.mark.parametrize("library", [_torch, _cupy, _jax])
def test_arrays_stay_on_the_gpu(library: Any) -> None:
    to_gpu, to_host = library()
    tree, rays = TREE.to("cuda"), (to_gpu(ORIGINS), to_gpu(DIRECTIONS), 0.01)
    hits, expected = tree.first_hit(*rays, at="surface"), TREE.first_hit(ORIGINS, DIRECTIONS, 0.01, at="surface")
    for name in ("t", "prim", "u", "distance", "t_out"):
        assert to_host(getattr(hits, name)).tobytes() == getattr(expected, name).tobytes(), name
    lists, listed = tree.all_hits(*rays), TREE.all_hits(ORIGINS, DIRECTIONS, 0.01)
    for name in ("offsets", "t", "prim"):
        assert to_host(getattr(lists, name)).tobytes() == getattr(listed, name).tobytes(), name
    assert to_host(tree.count_hits(*rays)).tolist() == listed.counts.reshape(50, 100).tolist()
    assert to_host(tree.any_hit(*rays)).astype(bool).tolist() == (listed.counts > 0).reshape(50, 100).tolist()
    # What is allocated is freed again, and what is freed may be reused: answers stay the same.
    for _ in range(20):
        assert to_host(tree.first_hit(*rays, at="surface").t).tobytes() == expected.t.tobytes()
