"""Pictures that are made sample by sample, in several threads: they can be interrupted, saved, and resumed."""

from __future__ import annotations

import os
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any, TypeVar

import numpy as np

from ..arrays import AnyArray
from ..support.computed_once import computed_once
from ..threads import get_num_threads, map_in_threads
from .draft import Draft, Grid
from .pictures.picture import Picture
from .shading.depth import MAX_BANDS, MAX_RAYS, MIN_RAYS, bands, check_size
from .shading.shading_context import ShadingContext
from .state import describe, digest, read_state, write_state

_Item = TypeVar("_Item")


class Progressive(ABC):
    """Sums of samples of all pixels, one sample after another, each in bands of rows.

    It can be interrupted at any point, saved, and resumed by another one with the same settings. The picture is then
    the same, bit for bit, as without the interruption.

    Parameters
    ----------
    context : ShadingContext
    width, height : int
    samples : int
        How many samples of a pixel are averaged.
    sums : mapping of str to tuple of int
        What is summed for each pixel, and the shape of one value.
    """

    def __init__(
        self, context: ShadingContext, width: int, height: int, samples: int, sums: Mapping[str, tuple[int, ...]]
    ) -> None:
        check_size(width, height)
        self.context, self.width, self.height, self.samples = context, width, height, samples
        self._shapes = sums
        self._sums: dict[str, AnyArray] = {
            name: np.zeros((height * width, *shape), np.float64) for name, shape in sums.items()
        }
        self._counts: AnyArray = np.zeros(height, np.int64)
        #: The pixels and rows of a band, and their new sums, while they are being stored.
        self._stored: tuple[slice, slice, dict[str, AnyArray], int] | None = None
        self._draft: Draft | None = None
        self._seconds_a_pass: float | None = None

    def draw_draft(self) -> None:
        """Sample some pixels, which stand for rows without a sample. The samples of `passes` do not depend on it."""
        grid = Grid(self.width, self.height)
        groups = grid.groups(get_num_threads(), MAX_RAYS)
        pixels = [grid.pixels(rows) for rows in groups]
        found: list[Mapping[str, AnyArray]] = []
        start, n_timed = time.perf_counter(), sum(map(len, pixels))
        for more in self._mapped(partial(self._sample, 0), pixels, is_first=True):
            found.append(more)
            if len(found) == 1 < len(groups):  # it has made what all others share
                start, n_timed = time.perf_counter(), n_timed - len(pixels[0])
        self._seconds_a_pass = (time.perf_counter() - start) * self.width * self.height / n_timed
        self._draft = Draft.of(grid, self._shapes, groups, found)

    def passes(self, progress: Callable[[float], object] | None = None) -> Iterator[int]:
        """Add one sample to each pixel at a time, and yield how many there are."""
        self._store()
        is_first = self._draft is None
        max_rays = min(MAX_RAYS, max(MIN_RAYS, self.width * self.height // MAX_BANDS))
        for index in range(int(self._counts.min()), self.samples):
            start, is_whole = time.perf_counter(), bool((self._counts == index).all())
            left = [rows for rows in bands(self.width, self.height, max_rays) if self._counts[rows.start] <= index]
            for rows, more in zip(left, self._mapped(partial(self._sample_rows, index), left, is_first), strict=True):
                own = slice(rows.start * self.width, rows.stop * self.width)
                self._stored = own, rows, {name: self._sums[name][own] + more[name] for name in more}, index + 1
                self._store()
                if progress is not None:
                    progress((index + rows.stop / self.height) / self.samples)
            is_first = False
            if is_whole:
                self._seconds_a_pass = time.perf_counter() - start
            yield index + 1

    def _mapped(
        self, sample: Callable[[_Item], Mapping[str, AnyArray]], parts: list[_Item], is_first: bool
    ) -> Iterator[Mapping[str, AnyArray]]:
        """Sample some parts of the picture, several at a time.

        At first, each part is alone until one is not empty: it has made all that others share.
        """
        n_alone = 0
        while n_alone < len(parts) and (is_first or not self._may_use_threads):
            found = sample(parts[n_alone])
            is_first, n_alone = is_first and not any(map(np.any, found.values())), n_alone + 1
            yield found
        yield from map_in_threads(sample, parts[n_alone:], MAX_BANDS)

    @property
    def _may_use_threads(self) -> bool:
        """Whether several bands may be sampled at a time: not if code of the user's own runs, nor on a GPU."""
        tree = self.context.tree
        is_ours = str(getattr(self._shader, "__module__", "")).partition(".")[0] == "fastlines"
        return is_ours and not tree.geometry.has_user_code and tree.backend == "cpu"

    def _sample_rows(self, index: int, rows: slice) -> Mapping[str, AnyArray]:
        return self._sample(index, np.arange(rows.start * self.width, rows.stop * self.width))

    @abstractmethod
    def _sample(self, index: int, pixels: AnyArray) -> Mapping[str, AnyArray]:
        """Return what one sample adds to the sums of some pixels."""

    @property
    @abstractmethod
    def _shader(self) -> object:
        """The object or the function that makes the picture of what rays hit."""

    @abstractmethod
    def picture(self) -> Picture:
        """Return the picture of all samples so far; rows without one are those of the draft, if it is drawn."""

    @abstractmethod
    def _own_settings(self) -> dict[str, Any]:
        """Return all that the samples depend on besides the size, the lines and the camera."""

    @property
    def n_rows(self) -> int:
        """How many rows have a sample at least."""
        self._store()
        return int((self._counts > 0).sum())

    @property
    def has_picture(self) -> bool:
        """Whether there is a draft, or a row with a sample."""
        return self._draft is not None or self.n_rows > 0

    @property
    def seconds_left(self) -> float | None:
        """About how long the samples that are left take; None before a draft or a sample of all pixels."""
        return None if self._seconds_a_pass is None else self._seconds_a_pass * (self.samples - self.done)

    @property
    def done(self) -> int:
        """How many samples each pixel has."""
        self._store()
        return int(self._counts.min())

    def _means(self, name: str) -> AnyArray:
        """Return the mean of the samples of each pixel so far, (height, width, …)."""
        self._store()
        sums = self._sums[name].reshape(self.height, self.width, *self._sums[name].shape[1:])
        means = sums / np.maximum(self._counts, 1).reshape(-1, *[1] * (sums.ndim - 1))
        if self._draft is not None:
            empty = np.flatnonzero(self._counts == 0)
            means[empty] = self._draft.rows(name, empty)
        return means

    def _store(self) -> None:
        """Store the sums of a band; where that was interrupted, it is done anew."""
        if self._stored is not None:
            own, rows, sums, n_samples = self._stored
            for name, values in sums.items():
                self._sums[name][own] = values
            self._counts[rows] = n_samples
            self._stored = None

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the samples so far to a .npz file, from which `resume` goes on; it appears whole or not at all."""
        self._store()
        write_state(path, self._settings, self._state)

    def resume(self, path: str | os.PathLike[str]) -> int:
        """Take over the samples that `save` has written; return how many of them each pixel has.

        The total number of samples may be another one, unless other rays are traced for it.

        Raises
        ------
        InputError
            If the file is not the state of a picture, or is that of one with other settings or lines.
        OSError
            If it cannot be read.
        """
        found = read_state(path, self._settings, self._state)
        self._sums = {name: found[name] for name in self._sums}
        self._counts = found["counts"]
        return int(self._counts.min())

    @property
    def _state(self) -> dict[str, AnyArray]:
        return {**self._sums, "counts": self._counts}

    @computed_once
    def _settings(self) -> dict[str, str]:
        """All that the samples depend on, but for the version of fastlines."""
        context = self.context
        settings = {
            "size": f"{self.width} × {self.height}",
            "radius": context.radius,
            "camera": context.camera,
            **self._own_settings(),
            "lines": context.tree.geometry.count_text(),
            "checksum": digest(context.tree.geometry),
            "rays at a time": MAX_RAYS,
        }
        return {name: value if isinstance(value, str) else describe(value) for name, value in settings.items()}
