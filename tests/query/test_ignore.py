"""What queries leave out, for each ray."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from support.answers import assert_same

import fastlines as fl
from fastlines.query.queries import QUERIES


@pytest.mark.parametrize("name", ["ignore", "ignore_strands"])
@pytest.mark.parametrize("query", QUERIES)
def test_what_is_ignored_broadcasts_as_rays_do(query: str, name: str) -> None:
    rng = np.random.default_rng(8)
    tree = fl.build(fl.Lines.from_segments(rng.random((40, 2, 3)), radius=np.full(40, 0.1), strands=np.arange(40) // 2))
    origins, directions = rng.random((6, 1, 3)) - [0, 0, 3], rng.normal(np.array([0, 0, 1]), 0.1, (6, 4, 3))
    more: dict[str, Any] = {"k": 2} if query == "next_hits" else {}

    def ask(ignore: Any, **bounds: Any) -> Any:
        return getattr(tree, query)(origins, directions, **{name: ignore}, **bounds, **more)

    def same(a: Any, b: Any) -> None:
        if isinstance(a, np.ndarray):
            assert np.array_equal(a, b)
        else:
            assert_same(a, b)

    for shape in ((6, 1, 3), (1, 4, 3), (4, 3), (1, 1, 3), (6, 4, 3), (1, 3), (6, 1, 0)):
        numbers = rng.integers(-1, 20, shape)
        same(ask(numbers), ask(np.ascontiguousarray(np.broadcast_to(numbers, (6, 4, shape[-1])))))
    first = tree.first_hit(origins, [0, 0, 1])
    assert first.prim.shape == (6, 1)
    of_hits = first.strand if name == "ignore_strands" else first.prim
    same(ask(first), ask(np.repeat(of_hits, 4, axis=1)[..., None]))
    # Radius and bounds broadcast equally.
    for bound in ("radius", "spread", "t_min", "t_max"):
        values = rng.random((6, 1)) + (3 if bound == "t_max" else 0)
        same(ask(None, **{bound: values}), ask(None, **{bound: np.repeat(values, 4, axis=1)}))
    for wrong in (np.zeros((5, 1, 1), int), np.zeros((2, 6, 4, 1), int), np.zeros((6, 2, 1), int)):
        with pytest.raises(fl.InputError, match=r"expected \(k,\) for all rays, or .* that broadcasts to it"):
            ask(wrong)
    with pytest.raises(fl.InputError, match=r"hits of shape \(6, 4\); expected that of the rays \(6,\)"):
        tree.any_hit(origins[:, 0], [0, 0, 1], **{name: tree.first_hit(origins, directions)})
