"""Trees over segments and queries on them, for one instruction set. Use the functions of the package."""

from collections.abc import Sequence

import numpy
from numpy.typing import NDArray

import fastlines._core

simd: str

def build(
    segments: NDArray[numpy.float32], settings: fastlines._core.Settings, progress: object | None
) -> tuple[NDArray[numpy.uint32], NDArray[numpy.uint32], tuple[int, int, int], tuple[int, int]]: ...
def refit_tree(
    segments: NDArray[numpy.float32],
    nodes: NDArray[numpy.uint32],
    refs: NDArray[numpy.uint32],
    n_threads: int,
    progress: object | None,
) -> NDArray[numpy.uint32]: ...
def build_layout(
    kind: str,
    data: NDArray[numpy.float32],
    nodes: NDArray[numpy.uint32],
    refs: NDArray[numpy.uint32],
    frame_corners: Sequence[float],
    radius_hint: float,
    n_threads: int,
    progress: object | None,
) -> tuple[NDArray[numpy.uint8], NDArray[numpy.uint8], NDArray[numpy.uint32], float]: ...
def refit_layout(
    layout: fastlines._core.LayoutView, n_threads: int, progress: object | None
) -> tuple[NDArray[numpy.uint8], NDArray[numpy.uint8], float]: ...
def check_rays(
    rays: tuple[
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32] | None,
    ],
    largest_radius: float,
    farthest: float,
    n_threads: int,
) -> tuple[bool, int]: ...
def first_hit(
    layout: fastlines._core.LayoutView,
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
    kernel: int,
    n_threads: int,
    progress: object | None,
) -> tuple[
    NDArray[numpy.float32],
    NDArray[numpy.int64],
    NDArray[numpy.float32],
    NDArray[numpy.float32],
    NDArray[numpy.float32] | None,
]: ...
def first_crossing(
    layout: fastlines._core.LayoutView,
    rays: tuple[
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32] | None,
    ],
    owner: NDArray[numpy.int64],
    at: str,
    kernel: int,
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
    layout: fastlines._core.LayoutView,
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
    kernel: int,
    n_threads: int,
    progress: object | None,
) -> NDArray[numpy.bool_]: ...
def count_hits(
    layout: fastlines._core.LayoutView,
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
    kernel: int,
    n_threads: int,
    progress: object | None,
) -> NDArray[numpy.int64]: ...
def list_hits(
    layout: fastlines._core.LayoutView,
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
    kernel: int,
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
def gather(
    layout: fastlines._core.LayoutView,
    rays: tuple[
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32] | None,
    ],
    rule: tuple[
        str,
        int,
        Sequence[float],
        Sequence[float],
        float | None,
        bool,
        NDArray[numpy.float32] | None,
        NDArray[numpy.float32] | None,
    ],
    with_squares: bool,
    kernel: int,
    n_threads: int,
    progress: object | None,
) -> tuple[NDArray[numpy.float64], NDArray[numpy.float64] | None, NDArray[numpy.int64]] | None: ...
def gather_lists(
    rays: tuple[
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32] | None,
    ],
    hits: tuple[
        NDArray[numpy.int64],
        NDArray[numpy.float32],
        NDArray[numpy.int64],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
    ],
    lines: NDArray[numpy.float32],
    rule: tuple[
        str,
        int,
        Sequence[float],
        Sequence[float],
        float | None,
        bool,
        NDArray[numpy.float32] | None,
        NDArray[numpy.float32] | None,
    ],
    with_squares: bool,
    n_threads: int,
    progress: object | None,
) -> tuple[NDArray[numpy.float64], NDArray[numpy.float64] | None, NDArray[numpy.int64]]: ...
def nearest(
    view: fastlines._core.LayoutView,
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
    view: fastlines._core.LayoutView,
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
    view: fastlines._core.LayoutView,
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
def pairs(
    layout: fastlines._core.LayoutView,
    other: fastlines._core.LayoutView | None,
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
def brute_force_pairs(
    layout: fastlines._core.LayoutView,
    other: fastlines._core.LayoutView | None,
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
    layout: fastlines._core.LayoutView,
    low: NDArray[numpy.float64],
    high: NDArray[numpy.float64],
    surface: bool,
    n_threads: int,
    progress: object | None,
) -> tuple[NDArray[numpy.int64], NDArray[numpy.int64]]: ...
def ray_routes(
    top: fastlines._core.TopTree,
    rays: tuple[
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32] | None,
    ],
    n_threads: int,
    progress: object | None,
) -> fastlines._core.RayRoutes: ...
def on_curves(
    piece: NDArray[numpy.int64],
    s: NDArray[numpy.float32],
    curve: NDArray[numpy.int64],
    begin: NDArray[numpy.float32],
    end: NDArray[numpy.float32],
) -> tuple[NDArray[numpy.int64], NDArray[numpy.float32]]: ...
def hit_points(
    axes: tuple[
        NDArray[numpy.float32],
        tuple[
            NDArray[numpy.float32],
            NDArray[numpy.float32] | None,
            NDArray[numpy.int64],
            NDArray[numpy.float32],
            NDArray[numpy.float32],
        ]
        | None,
    ],
    places: tuple[NDArray[numpy.int64], NDArray[numpy.float64], NDArray[numpy.float64], NDArray[numpy.int64] | None],
    rays: tuple[
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
    ],
    surface: bool,
    lift: NDArray[numpy.float64] | None,
    n_threads: int,
    progress: object | None,
) -> NDArray[numpy.float64]: ...
def hit_normals(
    axes: tuple[
        NDArray[numpy.float32],
        tuple[
            NDArray[numpy.float32],
            NDArray[numpy.float32] | None,
            NDArray[numpy.int64],
            NDArray[numpy.float32],
            NDArray[numpy.float32],
        ]
        | None,
    ],
    places: tuple[NDArray[numpy.int64], NDArray[numpy.float64], NDArray[numpy.float64], NDArray[numpy.int64] | None],
    rays: tuple[
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
    ],
    surface: bool,
    n_threads: int,
    progress: object | None,
) -> NDArray[numpy.float64]: ...
def hit_tangents(
    axes: tuple[
        NDArray[numpy.float32],
        tuple[
            NDArray[numpy.float32],
            NDArray[numpy.float32] | None,
            NDArray[numpy.int64],
            NDArray[numpy.float32],
            NDArray[numpy.float32],
        ]
        | None,
    ],
    prim: NDArray[numpy.int64],
    u: NDArray[numpy.float64],
    n_threads: int,
    progress: object | None,
) -> NDArray[numpy.float64]: ...
def hit_radii(
    axes: tuple[
        NDArray[numpy.float32],
        tuple[
            NDArray[numpy.float32],
            NDArray[numpy.float32] | None,
            NDArray[numpy.int64],
            NDArray[numpy.float32],
            NDArray[numpy.float32],
        ]
        | None,
    ],
    prim: NDArray[numpy.int64],
    u: NDArray[numpy.float64],
    n_threads: int,
    progress: object | None,
) -> NDArray[numpy.float64]: ...
def hit_frames(
    axes: tuple[
        NDArray[numpy.float32],
        tuple[
            NDArray[numpy.float32],
            NDArray[numpy.float32] | None,
            NDArray[numpy.int64],
            NDArray[numpy.float32],
            NDArray[numpy.float32],
        ]
        | None,
    ],
    places: tuple[NDArray[numpy.int64], NDArray[numpy.float64], NDArray[numpy.float64], NDArray[numpy.int64] | None],
    rays: tuple[
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
    ],
    lift: float,
    n_threads: int,
    progress: object | None,
) -> tuple[
    NDArray[numpy.float32],
    NDArray[numpy.float32],
    NDArray[numpy.float32],
    NDArray[numpy.float32],
    NDArray[numpy.float32],
]: ...
def hair_evaluate(
    material: Sequence[float],
    to_eye: NDArray[numpy.float32],
    tangents: NDArray[numpy.float32],
    h: NDArray[numpy.float32],
    towards: NDArray[numpy.float32],
) -> NDArray[numpy.float32]: ...
def hair_pdf(
    material: Sequence[float],
    to_eye: NDArray[numpy.float32],
    tangents: NDArray[numpy.float32],
    h: NDArray[numpy.float32],
    towards: NDArray[numpy.float32],
) -> NDArray[numpy.float32]: ...
def hair_sample(
    material: Sequence[float],
    to_eye: NDArray[numpy.float32],
    tangents: NDArray[numpy.float32],
    h: NDArray[numpy.float32],
    u4: NDArray[numpy.float32],
) -> tuple[NDArray[numpy.float32], NDArray[numpy.float32], NDArray[numpy.float32]]: ...
def averaged_hair(
    material: Sequence[float],
    azimuths: NDArray[numpy.float32],
    inclinations: NDArray[numpy.float32],
    sin_o: NDArray[numpy.float32],
    sin_i: NDArray[numpy.float32],
    phi: NDArray[numpy.float32],
) -> NDArray[numpy.float32]: ...
def averaged_attenuations(
    material: Sequence[float],
    azimuths: NDArray[numpy.float32],
    inclinations: NDArray[numpy.float32],
    sin_theta: NDArray[numpy.float32],
) -> tuple[NDArray[numpy.float32], NDArray[numpy.float32]]: ...
def sample_numbers(
    index: int, seeds: NDArray[numpy.uint32], dimension: int, count: int
) -> list[NDArray[numpy.float32]]: ...
def scatter_paths(
    scene: tuple[NDArray[numpy.float32], Sequence[float], Sequence[float], float],
    step: tuple[int, int, int],
    vertices: tuple[
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
    ],
    paths: tuple[NDArray[numpy.int64], NDArray[numpy.float32], NDArray[numpy.uint32]],
) -> tuple[
    list[
        tuple[
            NDArray[numpy.int64],
            NDArray[numpy.float32],
            NDArray[numpy.float32],
            NDArray[numpy.float32],
            NDArray[numpy.float32],
        ]
    ],
    tuple[
        NDArray[numpy.int64],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
    ],
    int,
]: ...
def add_offered(
    light: NDArray[numpy.float32],
    path: NDArray[numpy.int64],
    vertex: NDArray[numpy.int64],
    offered: NDArray[numpy.float32],
    free: NDArray[numpy.bool_],
) -> None: ...
def add_sky(
    light: NDArray[numpy.float32],
    path: NDArray[numpy.int64],
    weight: NDArray[numpy.float32],
    directions: NDArray[numpy.float32],
    away: NDArray[numpy.bool_],
    sky: Sequence[float],
) -> None: ...
def cone_fragments(
    hits: tuple[
        NDArray[numpy.int64],
        NDArray[numpy.int64],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32],
        NDArray[numpy.float32] | None,
    ],
    origins: NDArray[numpy.float32],
    directions: NDArray[numpy.float32],
    axes: NDArray[numpy.float32],
    settings: Sequence[float],
    chances: NDArray[numpy.float32],
) -> tuple[NDArray[numpy.int64], NDArray[numpy.int64], NDArray[numpy.float32], NDArray[numpy.float32]]: ...
def smooth_tangents(
    segments: NDArray[numpy.float32],
    strands: NDArray[numpy.int64],
    prim: NDArray[numpy.int64],
    u: NDArray[numpy.float32],
    tangents: NDArray[numpy.float32],
) -> NDArray[numpy.float32]: ...
def interpolated(
    x: NDArray[numpy.float32], places: NDArray[numpy.float64], values: NDArray[numpy.float64]
) -> NDArray[numpy.float32]: ...
def density_grid(
    axes: NDArray[numpy.float32],
    end_radii: NDArray[numpy.float32],
    radius: float,
    box: tuple[Sequence[float], Sequence[int]],
    n_threads: int,
    progress: object | None,
) -> tuple[NDArray[numpy.float32], NDArray[numpy.float32]]: ...
def optical_depth(
    box: tuple[Sequence[float], Sequence[int]],
    voxels: NDArray[numpy.float32],
    blocks: NDArray[numpy.float32],
    points: NDArray[numpy.float32],
    tangents: NDArray[numpy.float32],
    towards: NDArray[numpy.float32],
    jitter: NDArray[numpy.float32],
    radius: float,
    far: float,
    end: float,
) -> tuple[NDArray[numpy.float32], NDArray[numpy.float32]]: ...
def attenuated(light: NDArray[numpy.float32], crossed: NDArray[numpy.float32]) -> NDArray[numpy.float32]: ...
def light_samples(
    lamps: NDArray[numpy.float32], sky: Sequence[float], numbers: tuple[int, NDArray[numpy.uint32], int]
) -> tuple[NDArray[numpy.float32], NDArray[numpy.float32], NDArray[numpy.float32], NDArray[numpy.float32]]: ...
def light_of_hair(
    hair: tuple[Sequence[float], NDArray[numpy.float32], NDArray[numpy.float32]],
    axes: tuple[NDArray[numpy.float32], NDArray[numpy.float32]],
    light: tuple[NDArray[numpy.float32], NDArray[numpy.float32], NDArray[numpy.float32], NDArray[numpy.float32]],
    is_sharp: bool,
    density: float,
) -> NDArray[numpy.float32]: ...
def light_of_solids(
    axes: tuple[NDArray[numpy.float32], NDArray[numpy.float32]],
    base: NDArray[numpy.float32],
    is_thin: bool,
    material: Sequence[float],
    lamps: NDArray[numpy.float32],
    sky: Sequence[float],
    numbers: tuple[int, NDArray[numpy.uint32], int],
) -> tuple[
    tuple[NDArray[numpy.float32], NDArray[numpy.float32]],
    tuple[NDArray[numpy.float32], NDArray[numpy.float32]],
    NDArray[numpy.float32],
]: ...
