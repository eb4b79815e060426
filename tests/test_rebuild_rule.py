"""`RebuildPolicy`: the bound of docs/refit.md on builds and what queries lose."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

import fastlines as fl


def test_rebuild_rule_takes_at_most_twice_the_best_schedule() -> None:
    """The theorem of docs/refit.md, where its premise holds: no tree loses more than one that was built earlier."""
    rng, n = np.random.default_rng(0), 12
    ratios = []
    for _ in range(150):
        # What the tree that is built before frame b loses in frame f; a build takes 1.
        lost = rng.random((n, n)) ** rng.choice([0.5, 3, 20]) * rng.choice([0.3, 1, 3])
        lost = np.sort(lost, axis=0)[::-1]
        # The best choice from a build on: the next one comes before frame e, or there is none.
        best = np.zeros(n + 1)
        for b in range(n - 1, -1, -1):
            best[b] = min([lost[b, b:].sum(), *(lost[b, b:e].sum() + 1 + best[e] for e in range(b + 1, n))])
        rule, built, total = fl.RebuildPolicy(build_seconds=1.0), 0, 0.0
        for frame in range(n):
            # A tree of growth 2 loses half of the time of its queries.
            if rule.due(SimpleNamespace(growth=2.0), 2 * lost[built, frame]):  # type: ignore[arg-type]
                total += 1  # and the loss of this frame is left out
                built = frame + 1
            else:
                total += lost[built, frame]
        ratios.append(total / best[0])
    assert max(ratios) <= 2
    assert max(ratios) > 1.2, "the bound is not far from what happens"
