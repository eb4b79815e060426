"""The calls of an operation that fail in turn, and what a worker tells of them: a line of JSON each."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from typing import Any


def tell(**what: Any) -> None:
    """Print a line of JSON."""
    print(json.dumps(what), flush=True)


def fail_in_turn(
    run: Callable[[int], tuple[bool, str, Sequence[str]]],
    first: int,
    leaked: Callable[[int], float] = lambda n_calls: 0.0,
) -> None:
    """Fail call first and each after it, until a run has no such call.

    `run(n)` returns whether call n was reached, its name, and what was wrong after it; `leaked(n_calls)` returns the
    bytes that stay in use for each fault.
    """
    n = first
    while True:
        tell(trying=n)
        was_reached, call, wrong = run(n)
        for each in wrong:
            tell(n=n, wrong=each)
        if not was_reached:
            break
        tell(n=n, call=call)
        n += 1
    tell(n_calls=n - 1, leaked=leaked(n - 1) if n > 1 else 0.0)
