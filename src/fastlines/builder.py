"""Building trees: the one general builder of thesis §4.1, by name or by settings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy.typing as npt

from . import _core
from .engines import engine
from .errors import InputError
from .primitives import Geometry, as_geometry, core_data
from .progress import ProgressOption, reporting
from .settings import (
    DEFAULT_METHOD,
    REF_LIMIT,
    BoxRule,
    Cost,
    Limits,
    PlaneOctets,
    Settings,
    SplitSet,
    best_settings,
    method_settings,
)
from .structure import NODE, REF
from .threads import get_num_threads
from .tree import Tree

#: "No limit", as the core counts.
NO_LIMIT = 2**64 - 1

#: Whoever says how to search means no method.
SEARCH = {"splits", "lookahead", "bad_levels", "prune"}


def build(
    geometry: Geometry | npt.ArrayLike,
    method: str | None = None,
    *,
    splits: SplitSet | Sequence[SplitSet] | None = None,
    boxes: BoxRule | None = None,
    lookahead: int | Sequence[int] | None = None,
    cost: Cost | None = None,
    limits: Limits | None = None,
    bad_levels: int | None = None,
    prune: bool | None = None,
    radius_hint: float | None = None,
    effort: float | None = None,
    invalid: str = "error",
    progress: ProgressOption = False,
) -> Tree:
    """Build an acceleration tree.

    Parameters
    ----------
    geometry : Lines, Triangles, Boxes or (n, 2, 3) array
        The primitives; an array is taken for segments.
    method : {"best", "bvh-cl", "bvh-ss", "bvh-d2", "kd-cl", "kd-d2"}
        "best", the default, makes the tree that queries are fastest on; with a `cost`, or cut boxes, the tree of least
        cost. The others are the trees of the thesis. The other arguments change the settings of the method. Without a
        method, `splits`, `lookahead`, `bad_levels` and `prune` change those of `Settings()`.
    splits : SplitSet or sequence of SplitSet, optional
        The candidate splits at each node: `PlaneGrid`, `PlaneOctets`, `ObjectSweep`, `PlaneEvents`, `Median`, `Middle`.
    boxes : {"tight", "cut"}, optional
        A BVH or a KD tree.
    lookahead : int or sequence of int, optional
        How many levels to search; of several, each is tried where the one before says leaf.
    cost : Cost, optional
        c_trav and c_prim.
    limits : Limits, optional
        Depth, leaf size, number of references. What is left at its default stays as the method has it.
    bad_levels, prune, radius_hint : optional
        How to get past levels that look no better than a leaf; see `Settings`.
    effort : float, optional
        Of "best": from 0, the fastest build, to 1, the best tree; 0.5 unless given.
    invalid : {"error", "skip"}
        What to do with segments that hold NaN or Inf: raise, or leave them out; then hits name positions among those
        that are left, and ``tree.geometry.rows`` has the rows of the input. See `Lines.from_segments`.
    progress : bool or callable
        Show a bar, or call back with the share that is done.

    Returns
    -------
    Tree

    Raises
    ------
    InputError
        If the geometry or a setting can not be used.

    Examples
    --------
    >>> tree = build([[[0, 0, 0], [1, 1, 1]], [[0, 1, 0], [1, 0, 1]]], "kd-d2")
    >>> tree.n_prims
    2
    """
    geometry = as_geometry(geometry, invalid=invalid)
    given: dict[str, Any] = {
        "splits": splits,
        "boxes": boxes,
        "lookahead": lookahead,
        "cost": cost,
        "limits": limits,
        "bad_levels": bad_levels,
        "prune": prune,
        "radius_hint": radius_hint,
    }
    given = {name: value for name, value in given.items() if value is not None}
    if method is None and not SEARCH & given.keys():
        method = DEFAULT_METHOD
    if method == DEFAULT_METHOD:
        aims = {name: given.pop(name) for name in ("boxes", "cost") if name in given}
        base = best_settings(0.5 if effort is None else effort, **aims)
    elif effort is None:
        base = Settings() if method is None else method_settings(method)
    else:
        raise InputError(f"effort={effort!r} is a knob of method='best'; leave it out or ask for 'best'")
    if isinstance(limits, Limits):
        given["limits"] = limits.over(base.limits)
    settings = replace(base, **given)
    limits = settings.limits
    if len(geometry) > REF_LIMIT:
        raise InputError(f"{len(geometry)} primitives are more than a tree can name ({REF_LIMIT}); split them up")
    if limits.max_refs is not None and limits.max_refs < len(geometry):
        raise InputError(
            f"max_refs={limits.max_refs} is less than the {len(geometry)} primitives, which need a reference each"
        )
    if limits.max_leaf_refs is not None and len(geometry) > limits.max_leaf_refs * 2**limits.max_depth:
        raise InputError(
            f"max_leaf_refs={limits.max_leaf_refs} can not be kept within max_depth={limits.max_depth} for "
            f"{len(geometry)} primitives; allow more of either"
        )
    with reporting(progress, "build") as callback:
        nodes, refs, hit = _build(geometry, settings, callback)
    nodes, refs = nodes.reshape(-1).view(NODE), refs.reshape(-1).view(REF)
    nodes.flags.writeable = refs.flags.writeable = False
    limits_hit = {limit: n for limit, n in zip(("max_depth", "max_refs", "max_leaf_refs"), hit, strict=True) if n}
    return Tree(geometry, nodes, refs, settings, "custom" if given or method is None else method, limits_hit)


def _build(geometry: Geometry, settings: Settings, callback: Any) -> Any:
    """Hand the build to the core; segments to the module for the instruction set in use."""
    kind, data = core_data(geometry)
    splits: list[SplitSet] = []
    for split in settings.splits:
        if isinstance(split, PlaneOctets) and kind != "segments":
            splits += split.for_any_primitive(settings.boxes)
        else:
            splits.append(split)
    limits = settings.limits
    args = (
        [
            (split.name, getattr(split, "n_planes", 0), getattr(split, "max_whole", 0), split.max_refs or NO_LIMIT)
            for split in splits
        ],
        settings.boxes == "cut",
        settings.lookahead,
        (settings.cost.c_trav, settings.cost.c_prim),
        (
            limits.max_depth,
            limits.max_leaf_refs or NO_LIMIT,
            limits.refs_for(len(geometry)),
            limits.leaf_refs,
            limits.leaf_size,
        ),
        settings.bad_levels,
        settings.prune,
        settings.radius_hint,
        get_num_threads(),
    )
    return engine().build(data, args, callback) if kind == "segments" else _core.build(kind, data, args, callback)
