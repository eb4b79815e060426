"""Marks tests as slow: `pytest -m "not slow"` is done within a minute, and touches all that there is."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest


def few_of(values: Iterable[Any], n: int = 2) -> list[Any]:
    """Return parameters of a test, of which all but the first n are slow together."""
    return [value if i < n else pytest.param(value, marks=pytest.mark.slow) for i, value in enumerate(values)]
