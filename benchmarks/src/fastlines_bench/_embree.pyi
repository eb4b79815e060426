"""Types of the Embree peer (cpp/embree.cpp)."""

import numpy as np
import numpy.typing as npt

_Floats = npt.NDArray[np.float32]

def instruction_set() -> str: ...
def load(tbb: str, embree: str) -> tuple[int, int, int]: ...

class HitBuffers:
    def unpack(self) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64], _Floats]: ...

class Scene:
    radius: float
    def __init__(
        self,
        segments: _Floats,
        radii: _Floats,
        vertices: _Floats,
        index: npt.NDArray[np.uint32],
        kind: str,
        radius: float,
        piece_length: float,
        halvings: int,
        quality: str,
        compact: bool,
        device: str,
        eye: tuple[float, float, float],
    ) -> None: ...
    def first_hit(
        self,
        origins: _Floats,
        directions: _Floats,
        t_min: float,
        t_max: float,
        width: int,
        coherent: bool,
        n_threads: int,
    ) -> tuple[_Floats, npt.NDArray[np.int32]]: ...
    def any_hit(
        self,
        origins: _Floats,
        directions: _Floats,
        t_min: float,
        t_max: float,
        width: int,
        coherent: bool,
        n_threads: int,
    ) -> npt.NDArray[np.bool_]: ...
    def all_hits(
        self,
        origins: _Floats,
        directions: _Floats,
        t_min: float,
        t_max: float,
        width: int,
        coherent: bool,
        n_threads: int,
    ) -> HitBuffers: ...
    def gather(
        self,
        origins: _Floats,
        directions: _Floats,
        t_min: float,
        t_max: float,
        width: int,
        coherent: bool,
        n_threads: int,
        gather: tuple[float, float, float, float],
        powers: _Floats,
    ) -> _Floats: ...
    def is_native(self, width: int) -> bool: ...
    @property
    def n_pieces(self) -> int: ...
    @property
    def bytes(self) -> int: ...
