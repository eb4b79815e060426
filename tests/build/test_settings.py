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
        (lambda: fl.Settings(bad_levels=17), "bad_levels=17; .* 0 to 16"),
        (lambda: fl.Settings(bad_refines=-1), "bad_refines=-1; .* 0 to 16"),
        (lambda: fl.Settings(lookahead=1, beam=2), r"a lookahead of 2 or more, this is \(1,\)"),
        (lambda: fl.BinnedPlanes(max_refs=0), "max_refs=0; .* 1 or more"),
        (lambda: fl.BinnedPlanes(n_planes=0), "n_planes=0; .* 1 to 4096"),
        (lambda: fl.BinnedPlanes(n_planes=4097), "n_planes=4097; .* 1 to 4096"),
        (lambda: fl.BinnedPlanes(sample=-1), "sample=-1; .* 0 or more"),
        (lambda: fl.BinnedPlanes(uncut_only_side=-1), "uncut_only_side=-1; .* 0 to 1e6"),
        (lambda: fl.BinnedPlanes(uncut_only_side=2e6), "uncut_only_side=2000000.0; .* 0 to 1e6"),
    ],
)
def test_settings_out_of_their_bounds_are_refused(make: Callable[[], object], said: str) -> None:
    with pytest.raises(fl.InputError, match=said):
        make()


def test_settings_at_their_bounds_are_taken() -> None:
    assert fl.Presplit(refs=2**32 - 16).refs == 2**32 - 16
    assert [fl.Settings(reinsertion=n).reinsertion for n in (0, 1000)] == [0, 1000]
    assert fl.BinnedPlanes(max_refs=1).max_refs == 1
    assert [fl.Settings(bad_levels=n).bad_levels for n in (0, 16)] == [0, 16]
    assert fl.Settings(lookahead=2, beam=2).beam == 2
    assert [fl.BinnedPlanes(n_planes=n).n_planes for n in (1, 4096)] == [1, 4096]
    assert [fl.BinnedPlanes(uncut_only_side=side).uncut_only_side for side in (0.0, 1e6)] == [0.0, 1e6]
