"""The compiled engines: one module for each instruction set, of which one answers all queries."""

from __future__ import annotations

import functools
import importlib
import importlib.util
import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from . import _core
from .errors import FastlinesError, InputError

if TYPE_CHECKING:
    from . import _engine

#: The instruction sets that modules can be compiled for, the widest first.
SIMD_NAMES = ("avx512", "avx2", "sse42", "neon", "portable")

#: What FASTLINES_SIMD may also be, at install time and at run time, besides a list: the set of the processor, or all.
INSTALL_NAMES = ("host", "all")

_forced: str | None = None

#: The module that `use_engine` has put in the place of the others.
_given: Any = None


def set_simd(name: str | None) -> None:
    """Force an instruction set for all later queries; None = the first of `available_simd`.

    The environment variable ``FASTLINES_SIMD`` does it for a whole program. Answers do not depend on it. An
    installation from source has the widest set of its processor, and others only if it was compiled for them.

    Parameters
    ----------
    name : {"avx512", "avx2", "sse42", "neon", "portable"} or None
    """
    global _forced
    if name is not None:
        _check(name, "simd")
    _forced = name


def simd() -> str:
    """Return which instruction set queries use: "avx512", "avx2", "sse42", "neon" or "portable"."""
    if _forced is not None:
        return _forced
    given = os.environ.get("FASTLINES_SIMD")
    if given and given not in INSTALL_NAMES and ";" not in given:
        return _check(given, "FASTLINES_SIMD")
    return _require_simd()[0]


@functools.cache
def available_simd() -> tuple[str, ...]:
    """List the instruction sets that this machine and this build have, the widest first."""
    at_most = SIMD_NAMES.index(_core.best_simd())
    return tuple(name for name in SIMD_NAMES[at_most:] if _is_compiled(name))


def compiled_simd() -> tuple[str, ...]:
    """List the instruction sets that this installation is compiled for, the widest first."""
    return tuple(filter(_is_compiled, SIMD_NAMES))


def _is_compiled(name: str) -> bool:
    return importlib.util.find_spec(f"{__package__}._engine_{name}") is not None


def _require_simd() -> tuple[str, ...]:
    """Return the available instruction sets; raise an error if there are none."""
    available = available_simd()
    if not available:
        raise FastlinesError(
            f"this installation of fastlines is compiled for {', '.join(compiled_simd()) or 'no instruction set'}, and "
            f"this processor has {_core.best_simd()} at most: install it again on this machine, or with all "
            "sets: -C cmake.define.FASTLINES_SIMD=all"
        )
    return available


class _Engine:
    """The functions of the module for the instruction set in use; `_engine.pyi` has their types."""

    def __getattr__(self, name: str) -> Any:
        return getattr(_given or _module(simd()), name)


if TYPE_CHECKING:
    engine = _engine
else:
    engine = _Engine()


@functools.cache
def _module(name: str) -> Any:
    return importlib.import_module(f"{__package__}._engine_{name}")


def _check(name: str, what: str) -> str:
    available = _require_simd()
    if name not in available:
        advice = ""
        if name in SIMD_NAMES:
            advice = "; a source install has that of its processor, or all with -C cmake.define.FASTLINES_SIMD=all"
        raise InputError(f"{what}={name!r} is not available here; expected one of {', '.join(available)}{advice}")
    return name


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
    """Return whether `use_engine` is in force."""
    return _given is not None
