"""The examples in docstrings run and print the documented output."""

from __future__ import annotations

import doctest
import importlib
import pkgutil

import pytest

import fastlines_bench

COMPILED = ("_counting", "_embree", "_step_timings", "__main__")
#: Modules that need a library of a peer.
NEEDS = {"fastlines_bench.peers.warp_kernels": "warp"}
#: Modules of a process that has the switches of mutants, which these need to be imported.
IN_A_PROCESS_OF_MUTANTS = ("python_pytest", "python_switch")
MODULES = [
    name
    for _, name, _ in pkgutil.walk_packages(fastlines_bench.__path__, "fastlines_bench.")
    if not name.rpartition(".")[2].startswith(COMPILED + IN_A_PROCESS_OF_MUTANTS)
]


@pytest.mark.parametrize("name", MODULES)
def test_docstrings(name: str) -> None:
    if name in NEEDS:
        pytest.importorskip(NEEDS[name])
    failed, _ = doctest.testmod(importlib.import_module(name))
    assert failed == 0
