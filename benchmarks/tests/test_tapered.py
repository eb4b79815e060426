"""Lines that taper for the benchmark of thick lines."""

from __future__ import annotations

import numpy as np

from fastlines import Lines
from fastlines_bench.harness.subjects import tapered


def test_each_strand_tapers_from_the_radius_to_a_fifth_of_it() -> None:
    strands = Lines.from_strands([[[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 5, 0], [1, 5, 0]]])
    assert np.allclose(tapered(strands, 1.0).radius, [[1, 0.6], [0.6, 0.2], [1, 0.2]])
    alone = Lines.from_segments(strands.segments)
    assert np.allclose(tapered(alone, 0.5).radius, [[0.5, 0.1]] * 3)
    assert tapered(Lines.from_segments(np.empty((0, 2, 3))), 0.5).radius.shape == (0, 2)
