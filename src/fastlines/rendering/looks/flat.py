"""Looks without light: the depth, and colours of ids, normals and tangents."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from ...arrays import FloatArray
from ..fragments import Fragments
from ..lighting import SOFT, Rig
from ..palette import of_numbers
from ..sampler import Sampler
from ..stage import Stage
from ..unit_vectors import across
from .look import Backdrop

BLACK = Backdrop("#000", "#000")


def depth(fragments: Fragments, stage: Stage) -> FloatArray:
    """Return greys: lighter is nearer."""
    return np.repeat(stage.depth_tone.light(fragments.hits.t)[:, None], 3, axis=1).astype(np.float32)


def ids(fragments: Fragments, stage: Stage) -> FloatArray:
    """Return a colour for each strand, and for what has none, for each primitive."""
    return of_numbers(fragments.strand)


def normals(fragments: Fragments, stage: Stage) -> FloatArray:
    """Return normals as the camera sees them, from [−1, 1] to [0, 1]; of thin lines, the way to the eye across them."""
    towards = fragments.normals
    if towards is None:
        towards = across(fragments.tangents, fragments.to_eye)[2]
    return _as_color(towards, stage)


def tangents(fragments: Fragments, stage: Stage) -> FloatArray:
    """Return the directions of lines as the camera sees them, from [−1, 1] to [0, 1]."""
    return _as_color(fragments.tangents, stage)


def _as_color(vectors: FloatArray, stage: Stage) -> FloatArray:
    right, up, forward = stage.camera.axes().astype(np.float32)
    seen = np.stack([vectors @ right, vectors @ up, -(vectors @ forward)], axis=1)
    return np.asarray(((seen + 1) / 2) ** 2.2, np.float32)


@dataclass(frozen=True)
class Flat:
    """Colours that depend on nothing but the fragment."""

    color: Callable[[Fragments, Stage], FloatArray]
    backdrop: Backdrop = BLACK
    rig: Rig = SOFT
    is_light: bool = field(default=False, init=False)
    has_ground: bool = field(default=False, init=False)

    def shade(self, fragments: Fragments, stage: Stage, sampler: Sampler) -> FloatArray:
        """Return the colour of each fragment, (n, 3) float32 linear."""
        return self.color(fragments, stage)
