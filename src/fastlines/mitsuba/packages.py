"""Mitsuba and Dr.Jit, which the extra adds; and the variants that can be used."""

from __future__ import annotations

from typing import Any

from ..errors import InputError
from ..support.optional import optional

mi: Any = optional("mitsuba", "fastlines.mitsuba", "mitsuba")
dr: Any = optional("drjit", "fastlines.mitsuba", "mitsuba")

#: What `mitsuba.set_variant` takes so that photon beams can be drawn.
VARIANTS = ("llvm_ad_rgb", "cuda_ad_rgb")


def require_variant() -> None:
    """Raise an error unless Mitsuba's variant computes with arrays, in red, green and blue."""
    variant = mi.variant()
    if variant not in VARIANTS:
        raise InputError(
            f"the variant of Mitsuba is {variant!r}; photon beams need one that traces all rays of a picture at once, "
            f"in red, green and blue: call mitsuba.set_variant({VARIANTS[0]!r}) before the scene is loaded"
        )
