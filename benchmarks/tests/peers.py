"""Marks for tests that need a peer."""

from __future__ import annotations

import pytest

from fastlines.errors import FastlinesError
from fastlines_bench.peers import embree


def has_embree() -> bool:
    try:
        embree.load(1)
    except FastlinesError:
        return False
    return True


needs_embree = pytest.mark.skipif(not has_embree(), reason="Embree is not installed")
