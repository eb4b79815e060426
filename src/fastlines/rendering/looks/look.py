"""What a look is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ...arrays import FloatArray
from ...errors import InputError
from ..color.palette import hexadecimal
from ..color.tone import linear, srgb
from ..sampling.sampler import Sampler
from ..shading.fragments import Fragments
from ..shading.lighting import Rig
from ..shading.shading_context import ShadingContext


@dataclass(frozen=True)
class Backdrop:
    """What is behind a picture: colours such as "#e8e8ec" at its top and its bottom."""

    top: str
    bottom: str

    @classmethod
    def of(cls, text: str) -> Backdrop:
        """Read one colour, or those at the top and at the bottom: "#fff" or "#fff:#ccc".

        Examples
        --------
        >>> Backdrop.of("#fff:#ccc")
        Backdrop(top='#fff', bottom='#ccc')
        """
        if not isinstance(text, str):
            raise InputError(f"background={text!r}; expected a colour such as '#fff', or two such as '#fff:#ccc'")
        top, _, bottom = text.partition(":")
        made = cls(top, bottom or top)
        made.light(1, 1)
        return made

    def light(self, width: int, height: int) -> FloatArray:
        """Return the backdrop of a picture in linear light, (height, width, 3)."""
        place = ((np.arange(height) + 0.5) / height)[:, None]
        top, bottom = (srgb(np.array(hexadecimal(color))) for color in (self.top, self.bottom))
        rows = linear(top + place * (bottom - top))
        return np.broadcast_to(rows[:, None], (height, width, 3))


class Look(Protocol):
    """How the fragments of a picture are shaded."""

    @property
    def backdrop(self) -> Backdrop:
        """What is behind."""

    @property
    def rig(self) -> Rig:
        """The lights, unless others are given."""

    @property
    def is_light(self) -> bool:
        """Whether colours are light, which the filmic curve brings to the screen; else they are what it shows."""

    @property
    def has_ground(self) -> bool:
        """Whether the lines cast a shadow on the ground."""

    def shade(self, fragments: Fragments, context: ShadingContext, sampler: Sampler) -> FloatArray:
        """Return the light of each fragment towards the eye, (n, 3) float32 linear."""
