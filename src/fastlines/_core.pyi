"""Types of the C++ core (cpp/bindings/core.cpp)."""

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

_Floats: TypeAlias = npt.NDArray[np.float32]
_Words: TypeAlias = npt.NDArray[np.uint32]
_Ints: TypeAlias = npt.NDArray[np.int64]
_Progress: TypeAlias = Callable[[float], object] | None

#: See cpp/bindings/build.hpp.
_Settings: TypeAlias = tuple[
    Sequence[tuple[str, int, tuple[int, int, float, int, int, float], int, float]],
    bool,
    tuple[Sequence[int], int, bool],
    tuple[float, float, int],
    tuple[int, int, int, int, float],
    tuple[int, int, int],
    bool,
    float,
    float,
    tuple[float, int],
    int,
]

def build(
    kind: str, data: _Floats, settings: _Settings, progress: _Progress
) -> tuple[_Words, _Words, tuple[int, int, int], tuple[int, int]]: ...
def reinsert(
    nodes: _Words,
    refs: _Words,
    rounds: int,
    max_depth: int,
    radius_hint: float,
    n_threads: int,
    progress: _Progress,
) -> tuple[_Words, _Words, int]: ...

#: The most levels that a tree has below its root.
MAX_DEPTH: int

def check(kind: str, data: _Floats, nodes: _Words, refs: _Words, cut: bool) -> tuple[int, str, str] | None: ...
def validate(
    kind: str, data: _Floats, nodes: _Words, refs: _Words, cut: bool, pieces: bool
) -> tuple[int, str, str] | None: ...
def cost(nodes: _Words, c_trav: float, c_prim: float) -> float: ...
def best_simd() -> str: ...
def planes(nodes: _Words, refs: _Words) -> tuple[_Words, _Words, int]: ...
def first_hit(*arguments: Any) -> tuple[_Floats, _Ints, _Floats, _Floats, _Floats | None]: ...
def any_hit(*arguments: Any) -> npt.NDArray[np.bool_]: ...
def count_hits(*arguments: Any) -> _Ints: ...
def list_hits(*arguments: Any) -> tuple[_Ints, tuple[_Floats, _Ints, _Floats, _Floats, _Floats | None]]: ...
