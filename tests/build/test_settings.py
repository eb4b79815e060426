"""Settings of a build: what is just refused."""

from __future__ import annotations

from collections.abc import Callable

import pytest

import fastlines as fl


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: fl.Presplit(refs=2**32 - 15), "refs=4294967281; .* 1 to 4294967280"),
        (lambda: fl.Settings(presplit=0.5), r"presplit=0\.5; expected fl\.Presplit\(\)"),
        (lambda: fl.build([[[0, 0, 0], [1, 1, 1]]], presplit="area"), r"presplit='area'; expected fl\.Presplit\(\)"),
        (lambda: fl.Settings(reinsertion=-1), "reinsertion=-1; .* 0 to 1000"),
        (lambda: fl.Settings(reinsertion=1001), "reinsertion=1001; .* 0 to 1000"),
        (lambda: fl.BinnedPlanes(max_refs=0), "max_refs=0; .* 1 or more"),
    ],
)
def test_settings_out_of_their_bounds_are_refused(make: Callable[[], object], said: str) -> None:
    with pytest.raises(fl.InputError, match=said):
        make()


def test_settings_at_their_bounds_are_taken() -> None:
    assert fl.Presplit(refs=2**32 - 16).refs == 2**32 - 16
    assert [fl.Settings(reinsertion=n).reinsertion for n in (0, 1000)] == [0, 1000]
    assert fl.BinnedPlanes(max_refs=1).max_refs == 1
