"""The C++ core of fastlines. Use the functions of the package; they check what they are given."""

from collections.abc import Sequence
from typing import overload

import numpy
from numpy.typing import NDArray

def best_simd() -> str: ...

class ObjectSweep:
    def __init__(self) -> None: ...

class PlaneEvents:
    def __init__(self) -> None: ...

class Median:
    def __init__(self) -> None: ...

class Midpoint:
    def __init__(self) -> None: ...

class PlaneGrid:
    def __init__(self, n_planes: int) -> None: ...

class BinnedPlanes:
    def __init__(
        self,
        *,
        n_planes: int,
        uncut_refs: int,
        uncut_only_refs: int,
        max_overlap: float,
        sample: int,
        gap_refs: int,
        gap: float,
        uncut_only_side: float,
    ) -> None: ...

class SizedSplitSet:
    def __init__(
        self,
        set: ObjectSweep | PlaneGrid | BinnedPlanes | PlaneEvents | Median | Midpoint,
        *,
        max_refs: int,
        min_overlap: float,
    ) -> None: ...

class Limits:
    def __init__(
        self, *, max_depth: int, max_leaf_refs: int, max_refs: int, leaf_refs: int, leaf_size: float
    ) -> None: ...

class Presplit:
    def __init__(self, *, area: float, max_refs: int) -> None: ...

class Settings:
    def __init__(
        self,
        *,
        splits: Sequence[SizedSplitSet],
        boxes: str,
        lookahead: Sequence[int],
        beam: int,
        exhaustive: bool,
        c_trav: float,
        c_prim: float,
        lanes: int,
        limits: Limits,
        bad_levels: int,
        bad_refs: int,
        bad_refines: int,
        prune: bool,
        radius_hint: float,
        min_spread: float,
        presplit: Presplit,
        n_threads: int,
    ) -> None: ...

class LayoutView:
    def __init__(
        self,
        kind: str,
        data: NDArray[numpy.float32],
        nodes: NDArray[numpy.uint8],
        leaves: NDArray[numpy.uint8],
        refs: NDArray[numpy.uint32],
        corners: Sequence[float],
        frame_corners: Sequence[float],
        mean_extent: float,
        max_radius: float | None = None,
    ) -> None: ...
    @property
    def frame(self) -> tuple[list[float], float, float]: ...

def build(
    kind: str, data: NDArray[numpy.float32], settings: Settings, progress: object | None
) -> tuple[NDArray[numpy.uint32], NDArray[numpy.uint32], tuple[int, int, int], tuple[int, int]]: ...
def reinsert(
    nodes: NDArray[numpy.uint32],
    refs: NDArray[numpy.uint32],
    rounds: int,
    max_depth: int,
    radius_hint: float,
    n_threads: int,
    progress: object | None,
) -> tuple[NDArray[numpy.uint32], NDArray[numpy.uint32], int]: ...
def planes(
    nodes: NDArray[numpy.uint32], refs: NDArray[numpy.uint32], frame_corners: Sequence[float]
) -> tuple[NDArray[numpy.uint32], NDArray[numpy.uint32], int]: ...

MAX_DEPTH: int = 4096

def check(
    kind: str, data: NDArray[numpy.float32], nodes: NDArray[numpy.uint32], refs: NDArray[numpy.uint32], boxes: str
) -> tuple[int, str, str] | None: ...
def validate(
    kind: str,
    data: NDArray[numpy.float32],
    nodes: NDArray[numpy.uint32],
    refs: NDArray[numpy.uint32],
    boxes: str,
    pieces: bool,
) -> tuple[int, str, str] | None: ...
def check_layout(layout: LayoutView) -> str | None: ...
def cost(nodes: NDArray[numpy.uint32], c_trav: float, c_prim: float) -> float: ...

class BinaryView:
    @staticmethod
    def of_boxes(
        kind: str,
        data: NDArray[numpy.float32],
        nodes: NDArray[numpy.uint32],
        refs: NDArray[numpy.uint32],
        frame_corners: Sequence[float],
    ) -> BinaryView: ...
    @staticmethod
    def of_planes(
        kind: str,
        data: NDArray[numpy.float32],
        nodes: NDArray[numpy.uint32],
        refs: NDArray[numpy.uint32],
        depth: int,
        corners: Sequence[float],
        frame_corners: Sequence[float],
    ) -> BinaryView: ...
    @staticmethod
    def of_primitives(kind: str, data: NDArray[numpy.float32], all: NDArray[numpy.float32]) -> BinaryView: ...

def first_hit(
    tree: BinaryView,
    rays: tuple[
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32] | None,
    ],
    at: str,
    n_threads: int,
    progress: object | None,
) -> tuple[
    NDArray[numpy.float32],
    NDArray[numpy.int64],
    NDArray[numpy.float32],
    NDArray[numpy.float32],
    NDArray[numpy.float32] | None,
]: ...
def any_hit(
    tree: BinaryView,
    rays: tuple[
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32] | None,
    ],
    at: str,
    n_threads: int,
    progress: object | None,
) -> NDArray[numpy.bool_]: ...
def count_hits(
    tree: BinaryView,
    rays: tuple[
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32] | None,
    ],
    at: str,
    n_threads: int,
    progress: object | None,
) -> NDArray[numpy.int64]: ...
def list_hits(
    tree: BinaryView,
    rays: tuple[
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32] | None,
    ],
    at: str,
    k: int | None,
    by_distance: bool,
    n_threads: int,
    progress: object | None,
) -> tuple[
    NDArray[numpy.int64],
    tuple[
        NDArray[numpy.float32],
        NDArray[numpy.int64],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32] | None,
    ],
]: ...
def nearest(
    view: BinaryView,
    points: NDArray[numpy.float64],
    max_distance: NDArray[numpy.float32],
    k: int,
    surface: bool,
    seen: tuple[
        NDArray[numpy.uint8] | None,
        NDArray[numpy.int64] | None,
        Sequence[tuple[NDArray[numpy.int64], NDArray[numpy.int64] | None]],
    ],
    n_threads: int,
    progress: object | None,
) -> tuple[NDArray[numpy.float32], NDArray[numpy.int64], NDArray[numpy.float32]]: ...
def within(
    view: BinaryView,
    points: NDArray[numpy.float64],
    radius: NDArray[numpy.float32],
    surface: bool,
    seen: tuple[
        NDArray[numpy.uint8] | None,
        NDArray[numpy.int64] | None,
        Sequence[tuple[NDArray[numpy.int64], NDArray[numpy.int64] | None]],
    ],
    n_threads: int,
    progress: object | None,
) -> tuple[NDArray[numpy.int64], tuple[NDArray[numpy.float32], NDArray[numpy.int64], NDArray[numpy.float32]]]: ...
def count_within(
    view: BinaryView,
    points: NDArray[numpy.float64],
    radius: NDArray[numpy.float32],
    surface: bool,
    seen: tuple[
        NDArray[numpy.uint8] | None,
        NDArray[numpy.int64] | None,
        Sequence[tuple[NDArray[numpy.int64], NDArray[numpy.int64] | None]],
    ],
    n_threads: int,
    progress: object | None,
) -> NDArray[numpy.int64]: ...
@overload
def crossings(
    view: BinaryView,
    rays: tuple[
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32] | None,
    ],
    offsets: NDArray[numpy.int64],
    pieces: NDArray[numpy.int64],
    owner: NDArray[numpy.int64] | None,
    is_complete: bool,
    at: str,
    k: int | None,
    by_distance: bool,
    n_threads: int,
    progress: object | None,
) -> tuple[
    NDArray[numpy.int64],
    tuple[
        NDArray[numpy.float32],
        NDArray[numpy.int64],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32] | None,
    ],
]: ...
@overload
def crossings(
    view: LayoutView,
    rays: tuple[
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32] | None,
    ],
    offsets: NDArray[numpy.int64],
    pieces: NDArray[numpy.int64],
    owner: NDArray[numpy.int64] | None,
    is_complete: bool,
    at: str,
    k: int | None,
    by_distance: bool,
    n_threads: int,
    progress: object | None,
) -> tuple[
    NDArray[numpy.int64],
    tuple[
        NDArray[numpy.float32],
        NDArray[numpy.int64],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32] | None,
    ],
]: ...
def brute_force_pairs(
    prims: tuple[str, NDArray[numpy.float32]],
    other: tuple[str, NDArray[numpy.float32]] | None,
    known: tuple[
        tuple[NDArray[numpy.int64] | None, NDArray[numpy.int64] | None, NDArray[numpy.int32] | None],
        tuple[NDArray[numpy.int64] | None, NDArray[numpy.int64] | None, NDArray[numpy.int32] | None],
    ],
    options: tuple[float, bool, int, int, int, int],
    n_threads: int,
    progress: object | None,
) -> tuple[
    NDArray[numpy.int64], NDArray[numpy.int64], NDArray[numpy.float32], NDArray[numpy.float32], NDArray[numpy.float32]
]: ...
def in_box(
    kind: str,
    data: NDArray[numpy.float32],
    low: NDArray[numpy.float64],
    high: NDArray[numpy.float64],
    surface: bool,
    n_threads: int,
    progress: object | None,
) -> tuple[NDArray[numpy.int64], NDArray[numpy.int64]]: ...
def merge_pairs(
    lists: Sequence[
        tuple[
            NDArray[numpy.int64],
            NDArray[numpy.int64],
            NDArray[numpy.float32],
            NDArray[numpy.float32],
            NDArray[numpy.float32],
        ]
    ],
    n_threads: int,
    progress: object | None,
) -> tuple[
    NDArray[numpy.int64], NDArray[numpy.int64], NDArray[numpy.float32], NDArray[numpy.float32], NDArray[numpy.float32]
]: ...
def merge_lists(
    n_points: int,
    lists: Sequence[
        tuple[
            NDArray[numpy.int64],
            NDArray[numpy.int64],
            NDArray[numpy.int64],
            NDArray[numpy.float32] | None,
            NDArray[numpy.float32] | None,
        ]
    ],
    has_distance: bool,
    n_threads: int,
    progress: object | None,
) -> tuple[NDArray[numpy.int64], NDArray[numpy.int64], NDArray[numpy.float32], NDArray[numpy.float32]]: ...
def merge_nearest(
    best: tuple[NDArray[numpy.float32], NDArray[numpy.int64], NDArray[numpy.float32]],
    k: int,
    points: NDArray[numpy.int64],
    found: tuple[NDArray[numpy.float32], NDArray[numpy.int64], NDArray[numpy.float32]],
) -> None: ...

class RayRoutes:
    def arrays(self) -> tuple[NDArray[numpy.int64], NDArray[numpy.int64], NDArray[numpy.float32]]: ...
    @property
    def n_steps(self) -> int: ...

class TopTree:
    def __init__(
        self, boxes: NDArray[numpy.float32], max_radius: NDArray[numpy.float32], frame: Sequence[float]
    ) -> None: ...
    def nearest_tiles(
        self, points: NDArray[numpy.float64], k: int, surface: bool, n_threads: int, progress: object | None
    ) -> tuple[NDArray[numpy.float64], NDArray[numpy.int64]]: ...
    def tiles_within(
        self, points: NDArray[numpy.float64], radius: NDArray[numpy.float32], surface: bool
    ) -> tuple[NDArray[numpy.int64], NDArray[numpy.int64]]: ...
    def tiles_in_boxes(
        self, low: NDArray[numpy.float64], high: NDArray[numpy.float64], surface: bool
    ) -> tuple[NDArray[numpy.int64], NDArray[numpy.int64]]: ...

class Walk:
    def next_tile(self, is_open: NDArray[numpy.uint8]) -> int: ...
    def n_waiting(self) -> int: ...

class FirstHitWalk(Walk):
    def __init__(
        self,
        rays: tuple[
            NDArray[numpy.float32],
            NDArray[numpy.float32],
            NDArray[numpy.float32],
            NDArray[numpy.float32],
            NDArray[numpy.float32],
            NDArray[numpy.float32],
            NDArray[numpy.float32] | None,
        ],
        routes: RayRoutes,
        with_t_out: bool,
        n_threads: int,
    ) -> None: ...
    def take(
        self, tile: int
    ) -> tuple[
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
    ]: ...
    def give(
        self,
        found: tuple[
            NDArray[numpy.float32],
            NDArray[numpy.int64],
            NDArray[numpy.float32],
            NDArray[numpy.float32],
            NDArray[numpy.float32] | None,
        ],
        ids: NDArray[numpy.int64] | None,
    ) -> None: ...
    def hits(
        self,
    ) -> tuple[
        NDArray[numpy.float32],
        NDArray[numpy.int64],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32] | None,
    ]: ...

class AnyHitWalk(Walk):
    def __init__(
        self,
        rays: tuple[
            NDArray[numpy.float32],
            NDArray[numpy.float32],
            NDArray[numpy.float32],
            NDArray[numpy.float32],
            NDArray[numpy.float32],
            NDArray[numpy.float32],
            NDArray[numpy.float32] | None,
        ],
        routes: RayRoutes,
        n_threads: int,
    ) -> None: ...
    def take(
        self, tile: int
    ) -> tuple[
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
    ]: ...
    def give(self, found: NDArray[numpy.bool_]) -> None: ...
    def found(self) -> NDArray[numpy.bool_]: ...

class NextHitWalk(Walk):
    def __init__(
        self,
        rays: tuple[
            NDArray[numpy.float32],
            NDArray[numpy.float32],
            NDArray[numpy.float32],
            NDArray[numpy.float32],
            NDArray[numpy.float32],
            NDArray[numpy.float32],
            NDArray[numpy.float32] | None,
        ],
        routes: RayRoutes,
        k: int,
        with_t_out: bool,
        n_threads: int,
    ) -> None: ...
    def take(
        self, tile: int
    ) -> tuple[
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
    ]: ...
    def give(
        self,
        found: tuple[
            NDArray[numpy.int64],
            tuple[
                NDArray[numpy.float32],
                NDArray[numpy.int64],
                NDArray[numpy.float32],
                NDArray[numpy.float32],
                NDArray[numpy.float32] | None,
            ],
        ],
        ids: NDArray[numpy.int64] | None,
    ) -> None: ...
    def lists(
        self,
    ) -> tuple[
        NDArray[numpy.int64],
        tuple[
            NDArray[numpy.float32],
            NDArray[numpy.int64],
            NDArray[numpy.float32],
            NDArray[numpy.float32],
            NDArray[numpy.float32] | None,
        ],
    ]: ...

class Visit:
    def __init__(
        self,
        rays: tuple[
            NDArray[numpy.float32],
            NDArray[numpy.float32],
            NDArray[numpy.float32],
            NDArray[numpy.float32],
            NDArray[numpy.float32],
            NDArray[numpy.float32],
            NDArray[numpy.float32] | None,
        ],
        routes: RayRoutes,
        n_threads: int,
    ) -> None: ...
    def n_rays_of(self, tile: int) -> int: ...
    def take(
        self, tile: int
    ) -> tuple[
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
    ]: ...
    def add_counts(self, tile: int, found: NDArray[numpy.int64], counts: NDArray[numpy.int64]) -> None: ...
    def add_lists(
        self,
        tile: int,
        found: tuple[
            NDArray[numpy.int64],
            tuple[
                NDArray[numpy.float32],
                NDArray[numpy.int64],
                NDArray[numpy.float32],
                NDArray[numpy.float32],
                NDArray[numpy.float32] | None,
            ],
        ],
    ) -> None: ...
    def merge(
        self, with_t_out: bool, k: int | None, by_distance: bool, progress: object | None
    ) -> tuple[
        NDArray[numpy.int64],
        tuple[
            NDArray[numpy.float32],
            NDArray[numpy.int64],
            NDArray[numpy.float32],
            NDArray[numpy.float32],
            NDArray[numpy.float32] | None,
        ],
    ]: ...
