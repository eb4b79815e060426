"""Looks without light: the depth, and colours of ids, normals and tangents."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from ...arrays import FloatArray
from ...support.vectors import across
from ..color.palette import of_numbers
from ..sampling.sampler import Sampler
from ..shading.fragments import Fragments
from ..shading.lighting import SOFT, Rig
from ..shading.shading_context import ShadingContext
from .look import Backdrop

BLACK = Backdrop("#000", "#000")


def depth(fragments: Fragments, context: ShadingContext) -> FloatArray:
    """Return greys: lighter is nearer."""
    return np.repeat(context.depth_tone.light(fragments.hits.t)[:, None], 3, axis=1).astype(np.float32)


def ids(fragments: Fragments, context: ShadingContext) -> FloatArray:
    """Return a colour for each strand, and for what has none, for each primitive."""
    return of_numbers(fragments.strand)


def normals(fragments: Fragments, context: ShadingContext) -> FloatArray:
    """Return normals as the camera sees them, from [−1, 1] to [0, 1]; of thin lines, the way to the eye across them."""
    towards = fragments.normals
    if towards is None:
        towards = across(fragments.tangents, fragments.to_eye)[2]
    return _as_color(towards, context)


def tangents(fragments: Fragments, context: ShadingContext) -> FloatArray:
    """Return the directions of lines as the camera sees them, from [−1, 1] to [0, 1]."""
    return _as_color(fragments.tangents, context)


def _as_color(vectors: FloatArray, context: ShadingContext) -> FloatArray:
    right, up, forward = context.camera.axes().astype(np.float32)
    seen = np.stack([vectors @ right, vectors @ up, -(vectors @ forward)], axis=1)
    return np.asarray(((seen + 1) / 2) ** 2.2, np.float32)


@dataclass(frozen=True)
class Flat:
    """Colours that depend on nothing but the fragment."""

    color: Callable[[Fragments, ShadingContext], FloatArray]
    backdrop: Backdrop = BLACK
    rig: Rig = SOFT
    is_light: bool = field(default=False, init=False)
    has_ground: bool = field(default=False, init=False)

    def shade(self, fragments: Fragments, context: ShadingContext, sampler: Sampler) -> FloatArray:
        """Return the colour of each fragment, (n, 3) float32 linear."""
        return self.color(fragments, context)
