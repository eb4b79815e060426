"""What a build makes of a bound on memory."""

from __future__ import annotations

import pytest

import fastlines as fl
from fastlines.forest.building.budget import CHUNK, LEAST, TILE, TUNING, Budget
from fastlines.settings.methods import best_settings, method_settings

BEST = best_settings()


def test_without_a_bound() -> None:
    budget = Budget(None, None, BEST)
    assert (budget.n_rows, budget.at_once, budget.most_of(40), budget.most_of(4000)) == (CHUNK, 2, TILE, TILE)
    assert Budget(None, 7, BEST).most_of(40) == 7


def test_tiles_fit_into_memory() -> None:
    for memory in (150_000_000, 300_000_000, 10**9, 10**10):
        budget = Budget(memory, None, BEST)
        most = budget.most_of(36)
        assert most == TILE or 150 < (memory - TUNING.process) / most < 250
        assert LEAST <= budget.n_rows <= CHUNK
        assert budget.most_of(100) <= most
        assert Budget(memory, most, BEST).most_of(36) == most


def test_memory_below_what_works() -> None:
    with pytest.raises(
        fl.InputError, match=r"memory=1000 is less than the build of a tile takes; give (\d+) bytes or more"
    ) as raised:
        Budget(1000, None, BEST)
    least = int(str(raised.value).split("give ")[1].split()[0])
    assert Budget(least, None, BEST).most_of(0) == LEAST
    with pytest.raises(
        fl.InputError, match=r"tile of max_segments=9000000 takes; give \d+ bytes or more, or max_segments=\d+"
    ):
        Budget(10**9, 9_000_000, BEST)
    with pytest.raises(fl.InputError, match="a tile takes"):
        Budget(least, None, BEST).most_of(80)


def test_trees_that_take_more_memory_are_smaller() -> None:
    kd, best = (Budget(300_000_000, None, settings).most_of(36) for settings in (method_settings("kd-d2"), BEST))
    assert 0.1 < kd / best < 0.5
