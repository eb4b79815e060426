"""The modules that answer queries on the wide layout: the same source, compiled for each instruction set."""

from __future__ import annotations

import functools
import importlib
import importlib.util
import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from . import _core
from .checks import choice
from .errors import InputError

#: All instruction sets that there is a module for somewhere, the widest first.
SIMD_NAMES = ("avx512", "avx2", "sse42", "neon", "portable")

#: How each kernel is called in the modules; "binary" is the search through the tree as it was built.
KERNELS = {"auto": 0, "single": 1, "wave": 2, "bundle": 3, "binary": -1}

_forced: str | None = None
_given: Any = None


def set_simd(name: str | None) -> None:
    """Force an instruction set for all later queries; None = the widest that the machine has.

    The environment variable ``FASTLINES_SIMD`` does it for a whole program. Answers do not depend on it.

    Parameters
    ----------
    name : {"avx512", "avx2", "sse42", "neon", "portable"} or None
    """
    global _forced
    if name is not None:
        _check(name, "simd")
    _forced = name


def simd() -> str:
    """Tell which instruction set queries use: "avx512", "avx2", "sse42", "neon" or "portable"."""
    if _forced is not None:
        return _forced
    given = os.environ.get("FASTLINES_SIMD")
    if given:
        return _check(given, "FASTLINES_SIMD")
    return _core.best_simd()


def available_simd() -> tuple[str, ...]:
    """List the instruction sets that this machine and this build have, the widest first."""
    at_most = SIMD_NAMES.index(_core.best_simd())
    return tuple(
        name for name in SIMD_NAMES[at_most:] if importlib.util.find_spec(f"{__package__}._engine_{name}") is not None
    )


def engine() -> Any:
    """Return the module for the instruction set in use."""
    return _given or _module(simd())


@functools.cache
def _module(name: str) -> Any:
    return importlib.import_module(f"{__package__}._engine_{name}")


def _check(name: str, what: str) -> str:
    if name not in available_simd():
        raise InputError(f"{what}={name!r} can not be had here; expected one of {', '.join(available_simd())}")
    return name


def kernel_number(kernel: str) -> int:
    """Look up a kernel."""
    choice("kernel", kernel, tuple(KERNELS))
    return KERNELS[kernel]


@contextmanager
def use_engine(module: Any) -> Iterator[None]:
    """Answer queries with another module for a while, such as one that counts its steps; one thread at a time."""
    global _given
    before, _given = _given, module
    try:
        yield
    finally:
        _given = before


def is_given() -> bool:
    """Whether `use_engine` is in force."""
    return _given is not None
