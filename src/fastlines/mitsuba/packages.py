"""Mitsuba and Dr.Jit, which the extra adds; and the variants that can be used."""

from __future__ import annotations

from typing import Any

from ..errors import InputError
from ..support.optional import optional

mi: Any = optional("mitsuba", "fastlines.mitsuba", "mitsuba")
dr: Any = optional("drjit", "fastlines.mitsuba", "mitsuba")

#: What `mitsuba.set_variant` takes so that photon beams can be drawn.
VARIANTS = ("llvm_ad_rgb", "cuda_ad_rgb")
#: The first version of LLVM that compiles Mitsuba's kernels; earlier ones end the process.
LEAST_LLVM = 17


def require_variant() -> None:
    """Raise an error unless Mitsuba's variant computes with arrays, in red, green and blue."""
    variant = mi.variant()
    if variant not in VARIANTS:
        raise InputError(
            f"the variant of Mitsuba is {variant!r}; photon beams need one that traces all rays of a picture at once, "
            f"in red, green and blue: call mitsuba.set_variant({VARIANTS[0]!r}) before the scene is loaded"
        )
    if variant.startswith("llvm"):
        version = dr.detail.llvm_version()
        if version[0] < LEAST_LLVM:
            raise InputError(
                f"Mitsuba found LLVM {'.'.join(map(str, version))}, which ends the process when it compiles Mitsuba's "
                f"kernels; install LLVM {LEAST_LLVM} or later, or set DRJIT_LIBLLVM_PATH to its library"
            )
