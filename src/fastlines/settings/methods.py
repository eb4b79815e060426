"""The named trees: settings with a name, and those of "best", which suit the input and its use."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

from ..arrays import choice, did_you_mean, number
from ..errors import InputError
from .settings import REF_LIMIT, Cost, Limits, Settings
from .splits import BinnedPlanes, BoxRule, ObjectSweep, PlaneGrid


class Methods(Mapping[str, Settings]):
    """The named trees: the `Settings` that `build` has for each name. They cannot be changed.

    ========  ==========================================================================================
    best      the default, the tree that queries are fastest on; with a cost or cut boxes, of least cost
    bvh-cl    BVH over whole primitives, SAH
    bvh-ss    BVH over primitives that are cut by a grid of planes, SAH
    bvh-d2    as bvh-ss; where SAH says leaf, it looks two levels ahead
    kd-cl     KD tree over a grid of planes, SAH
    kd-d2     as kd-cl; where SAH says leaf, it looks two levels ahead
    beams     for dense long lines that are queried once, such as photon beams: least build and query
    ========  ==========================================================================================

    All but "best" and "beams" are those of the thesis (§5). Of "best" these are the settings for small inputs: `build`
    suits them to the input and the arguments.

    Examples
    --------
    >>> import fastlines as fl
    >>> list(fl.METHODS)
    ['best', 'bvh-cl', 'bvh-ss', 'bvh-d2', 'kd-cl', 'kd-d2', 'beams']
    >>> fl.METHODS["kd-d2"].lookahead
    (1, 2)
    """

    def __init__(self, settings: Mapping[str, Settings]) -> None:
        self._settings = dict(settings)

    def __getitem__(self, method: str) -> Settings:
        return self._settings[method]

    def __iter__(self) -> Iterator[str]:
        return iter(self._settings)

    def __len__(self) -> int:
        return len(self._settings)

    def __repr__(self) -> str:
        return f"<Methods: {', '.join(self)}>"


#: c_trav of the thesis's trees, fitted to its tables.
C_TRAV: dict[BoxRule, float] = {"tight": 2.0, "cut": 0.6}

#: From this many primitives on, a tree for fast queries is built with the least effort by default. More effort takes at
#: least twice the time and memory there, and gains little.
LARGE = 2**18

#: `min_spread` of "best": half the radius that it measures boxes with. A ray that hits one line then hits nearly all.
MIN_SPREAD = 0.0005

#: The planes of "best" with the least effort.
FAST_PLANES = BinnedPlanes(8, 128, 64, 0.6, sample=128, gap_refs=REF_LIMIT, gap=0.85)

#: The planes of "beams": only nodes of a quarter of the scene or more are cut.
BEAM_PLANES = replace(FAST_PLANES, uncut_only_side=256.0)


def best_effort(n_prims: int) -> float:
    """Return the default effort of "best" for queries."""
    return 0.0 if n_prims >= LARGE else 0.5


def best_settings(
    effort: float | None = None, boxes: BoxRule = "tight", cost: Cost | None = None, n_prims: int = 0
) -> Settings:
    """Return the settings of "best" for an aim and an effort, over `n_prims` primitives.

    With neither a cost nor cut boxes the aim is the speed of queries. Leaves then fill the 16 lanes that are tested at
    once, and boxes are measured grown by a small radius. Else the aim is the tree of least cost; a step costs 2.0 (BVH)
    or 0.6 (KD tree) unless given. The effort, which `build` explains, sets the number of planes an axis: 8 to 128 for a
    cost, to 32 for queries.
    """
    for_queries = cost is None and boxes == "tight"
    if effort is None:
        effort = best_effort(n_prims) if for_queries else 0.5
    effort = number("effort", effort, "a number from 0 (fastest) to 1 (best tree)", 0.0, 1.0)
    choice("boxes", boxes, ("tight", "cut"))
    if for_queries:
        if effort < 0.25:
            return _for_queries(FAST_PLANES)
        if effort < 0.75:
            return _for_queries(BinnedPlanes(16, 128, 64, 0.6, sample=512, gap_refs=REF_LIMIT))
        return _for_queries(BinnedPlanes(16 if effort < 0.875 else 32, 128, 32))
    octets = BinnedPlanes(8 * 2 ** round(4 * effort), 16 if boxes == "tight" else 0)
    cost = Cost(C_TRAV[boxes]) if cost is None else cost
    settings = Settings((octets,), boxes, bad_levels=3, min_spread=MIN_SPREAD, cost=cost)
    if effort >= 0.75:
        return settings
    return replace(settings, bad_refs=int(min(8 * cost.c_trav / cost.c_prim, REF_LIMIT)))


def _for_queries(planes: BinnedPlanes) -> Settings:
    """Return the settings of a tree for fast queries, with these planes."""
    return Settings(
        splits=(planes,),
        bad_levels=3,
        prune=False,
        radius_hint=0.001,
        min_spread=MIN_SPREAD,
        lanes=16,
        cost=Cost(c_trav=4.0),
        limits=Limits(max_leaf_refs=16, leaf_refs=16),
    )


#: The best builder, the five trees of the thesis (§5), and a builder for lines that are queried once.
METHODS = Methods(
    {
        "best": best_settings(),
        "bvh-cl": Settings(splits=(ObjectSweep(),)),
        "bvh-ss": Settings(splits=(PlaneGrid(8),)),
        "bvh-d2": Settings(splits=(PlaneGrid(8),), lookahead=(1, 2)),
        "kd-cl": Settings(splits=(PlaneGrid(12),), boxes="cut", cost=Cost(C_TRAV["cut"])),
        "kd-d2": Settings(splits=(PlaneGrid(12),), boxes="cut", lookahead=(1, 2), cost=Cost(C_TRAV["cut"])),
        "beams": _for_queries(BEAM_PLANES),
    }
)

DEFAULT_METHOD = "best"

#: The named trees of the thesis.
THESIS_METHODS = tuple(method for method in METHODS if method not in (DEFAULT_METHOD, "beams"))

#: A line of description for each named tree.
METHOD_NOTES: dict[str, str] = {
    "best": "a grid of planes, through up to 3 bad levels; for queries, or for a given cost",
    "bvh-cl": "whole primitives, SAH",
    "bvh-ss": "primitives cut by a grid of planes, SAH",
    "bvh-d2": "as bvh-ss; where SAH says leaf, look two levels ahead",
    "kd-cl": "space cut by a grid of planes, SAH",
    "kd-d2": "as kd-cl; where SAH says leaf, look two levels ahead",
    "beams": "lines cut in the first levels alone; for dense long lines that are queried once",
}


def method_settings(method: str) -> Settings:
    """Return the settings of a named tree."""
    try:
        return METHODS[method]
    except (KeyError, TypeError):
        raise InputError(f"unknown method {method!r}{did_you_mean(method, METHODS)}") from None
