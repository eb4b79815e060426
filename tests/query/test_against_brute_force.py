"""Every tree answers as brute force does, bit for bit: with each kernel, instruction set and number of threads."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import Any

import pytest
from support import nasty
from support.answers import PLACES, assert_same, cases, options, question
from support.builds import ALL_KINDS, BUILDS, KINDS, METHODS, build

import fastlines as fl
from fastlines.query.backend import KERNELS
from fastlines.query.queries import QUERIES, QueryName

#: How many seeds there are for each kind of primitive; all but the first are slow.
N_SEEDS = {"segments": 4, "round cones": 2, "a mixture": 2}
N_THREADS = (1, 3)
#: Queries, and their arguments.
QUESTIONS: list[tuple[QueryName, dict[str, Any]]] = [
    (query, {"at": at} | how)
    for query in QUERIES
    for at in PLACES[query]
    for how in ([options(query), {"k": 2, "rank": "distance"}] if query == "next_hits" else [{}])
]
#: Kernels and instruction sets; the binary tree has one text for all.
WAYS = [*product([kernel for kernel in KERNELS if kernel != "binary"], fl.available_simd()), ("binary", None)]
#: The builds that are not methods.
OTHERS = [name for name in BUILDS if name not in METHODS]


def has_room(name: str) -> bool:
    """Return whether a build may have more references than a case has segments."""
    max_refs = BUILDS[name].get("limits", fl.Limits()).max_refs
    return max_refs is None or max_refs >= 1000


#: Those that take any primitive, not only lines.
FOR_ANY = [name for name in OTHERS if not BUILDS[name].keys() & {"presplit", "reinsertion"} and has_room(name)]


@pytest.fixture(autouse=True)
def any_engine() -> Iterator[None]:
    yield
    fl.set_simd(None)
    fl.set_num_threads(None)


def chosen(seed: int, name: str, kind: str) -> list[str]:
    """Return names of builds: each method, the one to ask in all ways first, and three others, in turn."""
    i = seed + nasty.NAMES.index(name)
    methods = [list(METHODS)[(i + j) % len(METHODS)] for j in range(len(METHODS))]
    others = OTHERS if kind in KINDS else FOR_ANY
    return [*methods, *(others[(3 * i + j) % len(others)] for j in range(3))]


def is_slow(kind: str, seed: int, name: str) -> bool:
    """Return whether a case may wait: other seeds, and of most kinds two of three scenes, in turn."""
    turn = (list(ALL_KINDS).index(kind) + nasty.NAMES.index(name)) % 3
    return seed > 0 or (turn != 0 and kind not in ("segments", "round cones"))


@pytest.mark.parametrize(
    ("kind", "seed", "name"),
    [
        pytest.param(kind, seed, name, marks=pytest.mark.slow if is_slow(kind, seed, name) else ())
        for kind in ALL_KINDS
        for seed in range(N_SEEDS.get(kind, 1))
        for name in nasty.NAMES
    ],
)
def test_answers_are_those_of_brute_force(seed: int, name: str, kind: str) -> None:
    case = cases(seed, n_rays=60)[name]
    asked, _ = question(case)
    geometry = ALL_KINDS[kind](case.segments)
    trees = {build_name: build(geometry, **BUILDS[build_name]) for build_name in chosen(seed, name, kind)}
    for tree in trees.values():
        tree.validate()
        assert tree.cost(by="f") == pytest.approx(tree.cost(by="g"), rel=1e-9)  # Theorem 1
        limits, stats = tree.settings.limits, tree.stats()
        assert limits.max_refs is None or stats["n_refs"] <= limits.max_refs
        assert stats["depth"] <= limits.max_depth
        assert limits.max_leaf_refs is None or stats["largest_leaf_refs"] <= limits.max_leaf_refs
    turn = seed
    for query, how in QUESTIONS:
        expected = fl.brute_force(geometry, **asked, query=query, **how)
        for i, (build_name, tree) in enumerate(trees.items()):
            turn += 1
            for kernel, simd in WAYS if i == 0 else (WAYS[(7 * turn + i) % len(WAYS)],):
                turn += 1
                n_threads = N_THREADS[turn % len(N_THREADS)]
                fl.set_simd(simd)
                fl.set_num_threads(n_threads)
                got = getattr(tree, query)(**asked, **how, kernel=kernel)
                assert_same(got, expected, f"{build_name}: {query}, {how}, {kernel=}, {simd=}, {n_threads=}, {seed=}")
