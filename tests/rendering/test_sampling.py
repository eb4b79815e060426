"""Samples of pixels: each power of two of them is evenly distributed, and they follow the filter."""

from __future__ import annotations

import numpy as np
import pytest

from fastlines.rendering.sampling.sobol import FILTER_RADIUS, WINDOW, filter_offset, hashed, uniforms

SEEDS = hashed(np.arange(200, dtype=np.uint32))


@pytest.mark.parametrize("pair", [0, 1, 5])
@pytest.mark.parametrize("log_count", [0, 2, 4, 6])
def test_the_first_samples_of_each_pixel_lie_in_one_elementary_box_each(pair, log_count):
    count = 1 << log_count
    points = np.array([[uniforms(i, SEEDS, 2 * pair + axis) for axis in (0, 1)] for i in range(count)])
    assert points.min() >= 0
    assert points.max() < 1
    for log_x in range(log_count + 1):
        columns, rows = 1 << log_x, count >> log_x
        cell = (points[:, 0] * columns).astype(int) * rows + (points[:, 1] * rows).astype(int)
        assert (np.sort(cell, axis=0) == np.arange(count)[:, None]).all()


def test_pixels_and_pairs_are_independent():
    many = hashed(np.arange(20_000, dtype=np.uint32))
    numbers = np.stack([uniforms(3, many, dimension) for dimension in range(6)])
    assert np.abs(numbers.mean(axis=1) - 0.5).max() < 0.01
    assert np.abs(np.corrcoef(numbers) - np.eye(6)).max() < 0.03
    assert abs(np.corrcoef(numbers[0, 1:], numbers[0, :-1])[0, 1]) < 0.03


def test_offsets_are_distributed_as_the_filter():
    offsets = filter_offset((np.arange(100_000) + np.float32(0.5)) / 100_000)
    counts, edges = np.histogram(offsets, 30, (-FILTER_RADIUS, FILTER_RADIUS))
    place = ((edges[1:] + edges[:-1]) / 2 + FILTER_RADIUS) / (2 * FILTER_RADIUS)
    window = sum(weight * np.cos(2 * np.pi * k * place) for k, weight in enumerate(WINDOW))
    assert counts / counts.sum() == pytest.approx(window / window.sum(), abs=2e-3)
