"""The C library and lines, for the tests of the C interface."""

from __future__ import annotations

import numpy as np
import pytest
from support.c_library import Library

import fastlines as fl


@pytest.fixture(scope="module")
def library() -> Library:
    try:
        fl.get_lib()
    except fl.FastlinesError as error:
        pytest.skip(f"this is not an installation: {error}")
    return Library()


@pytest.fixture(scope="module", params=["segments", "round cones"])
def lines(request: pytest.FixtureRequest) -> fl.Lines:
    made = fl.scenes.make("spaghetti", 300).lines
    if request.param == "segments":
        return made
    rng = np.random.default_rng(5)
    return made.with_radius(rng.uniform(0, 0.01, (len(made), 2)).astype(np.float32))
