"""Builds of trees, by name or by settings: the general builder of thesis §4.1."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import fields, replace
from itertools import count
from typing import Any

import numpy.typing as npt

from . import _core
from .arrays import FloatArray, instance
from .engines import engine
from .errors import InputError
from .geometry.any_geometry import AnyGeometry
from .geometry.collection import as_geometry
from .geometry.user_primitives import Primitives
from .progress import ProgressCallback, ProgressOption, reporting
from .settings.methods import DEFAULT_METHOD, best_settings, method_settings
from .settings.settings import REF_LIMIT, Cost, Limits, Presplit, Settings
from .settings.splits import BoxRule, SplitSet
from .structure.frame import frame_around
from .structure.tree_data import NODE, REF
from .support.immutable import own
from .support.texts import counted
from .threads import get_num_threads
from .tree import Tree

#: The core's number for "no limit".
NO_LIMIT = 2**64 - 1

#: Settings with the same name in the core.
SAME = {"boxes", "lookahead", "exhaustive", "lanes", "prune", "radius_hint", "min_spread"}
SAME |= {"bad_levels", "bad_refs", "bad_refines"}

#: Arguments that describe a search; with one of them, "best" is not the default.
SEARCH = {"splits", "lookahead", "beam", "exhaustive", "bad_levels", "bad_refs", "bad_refines", "prune"}


def build(
    geometry: AnyGeometry | Primitives | npt.ArrayLike,
    method: str | None = None,
    *,
    splits: SplitSet | Sequence[SplitSet] | None = None,
    boxes: BoxRule | None = None,
    lookahead: int | Sequence[int] | None = None,
    beam: int | None = None,
    exhaustive: bool | None = None,
    cost: Cost | None = None,
    limits: Limits | None = None,
    bad_levels: int | None = None,
    bad_refs: int | None = None,
    bad_refines: int | None = None,
    prune: bool | None = None,
    radius_hint: float | None = None,
    min_spread: float | None = None,
    lanes: int | None = None,
    effort: float | None = None,
    presplit: Presplit | None = None,
    reinsertion: int | None = None,
    own_radius: bool = True,
    invalid: str = "error",
    frame: npt.ArrayLike | None = None,
    progress: ProgressOption = False,
) -> Tree:
    """Build an acceleration tree.

    Parameters
    ----------
    geometry : Lines, Spheres, Curves, Triangles, Boxes, Geometry, Primitives, (n, 2, 3) array, or what `lines` takes
        The primitives; an array is taken for segments, and a list of (m, 3) arrays for polylines. Lines with a `radius`
        of their own are round cones to queries. `Geometry` holds several kinds, and `Primitives` is the protocol of a
        class of your own.
    method : {"best", "bvh-cl", "bvh-ss", "bvh-d2", "kd-cl", "kd-d2", "beams"}
        "best", the default, makes the tree that queries are fastest on. With a `cost`, or cut boxes, it makes the tree
        of least cost, but does not cut lines that run along each other (`min_spread`). "beams" is for dense long lines
        that are queried once or a few times, such as the photon beams of a pass: its build and one query of all hits
        take the least time together. The others are the trees of the thesis. The other arguments change the settings of
        the method. Without a method, arguments of the search (`splits`, `lookahead`, `beam`, `exhaustive`,
        `bad_levels`, `bad_refs`, `bad_refines` or `prune`) change the settings of `Settings()`.
    splits : SplitSet or sequence of SplitSet, optional
        The candidate splits at each node: `PlaneGrid`, `BinnedPlanes`, `ObjectSweep`, `PlaneEvents`, `Median`,
        `Midpoint`.
    boxes : {"tight", "cut"}, optional
        A BVH or a KD tree.
    lookahead, beam, exhaustive, bad_levels, bad_refs, bad_refines, prune, radius_hint : optional
        How deep to search, and how to get past levels that look no better than a leaf; see `Settings`.
    cost : Cost, optional
        c_trav and c_prim.
    limits : Limits, optional
        Depth, leaf size, number of references. Fields at their defaults stay as the method has them.
    min_spread, lanes : optional
        Which lines are not cut, and how many references are tested at once; see `Settings`. "best" has a `min_spread`
        of 0.0005, and for queries 16 lanes, or as many as fit into leaves of `max_leaf_refs`.
    effort : float, optional
        Of "best": from 0, the fastest build, to 1, the best tree; 0.5 by default. For queries the default is 0 from
        262,144 primitives on, where more effort takes at least twice the time and memory.
    presplit, reinsertion : optional
        Cut lines before the build, and move subtrees after it; see `Presplit` and `Settings`.
    own_radius : bool
        Whether the radius of the lines counts. If not, the tree is over the same lines without a radius; a refit to
        lines with one has it again.
    invalid : {"error", "skip"}
        Refuse segments that hold NaN or Inf, or leave them out; see `Lines.from_segments`.
    frame : (2, 3) array, optional
        The low and the high corner of a box that holds all primitives, less the offset if they have one. Its centre and
        size define the coordinates that queries compute in; the default is the primitives' own box. Trees over parts of
        a scene, with the frame of the whole, answer bit for bit as one tree does.
    progress : bool or callable
        Show a bar, or call back with the fraction that is done.

    Returns
    -------
    Tree

    Raises
    ------
    InputError
        If the geometry or a setting cannot be used.

    Examples
    --------
    >>> tree = build([[[0, 0, 0], [1, 1, 1]], [[0, 1, 0], [1, 0, 1]]], "kd-d2")
    >>> tree.n_prims
    2
    """
    arguments = locals()
    given: dict[str, Any] = {
        field.name: arguments[field.name] for field in fields(Settings) if arguments[field.name] is not None
    }
    geometry = as_geometry(geometry, invalid=invalid)
    instance("own_radius", own_radius, bool, "True or False")
    if not own_radius:
        geometry = geometry.without_radius()
    kind, rows = geometry.build_data()
    n_prims = len(rows)
    if method is None and not SEARCH & given.keys():
        method = DEFAULT_METHOD
    if method == DEFAULT_METHOD:
        aims = {name: given.pop(name) for name in ("boxes", "cost") if name in given}
        base = best_settings(effort, n_prims=n_prims, **aims)
    elif effort is None:
        base = Settings() if method is None else method_settings(method)
    else:
        raise InputError(f"effort={effort!r} is a knob of method='best'; leave it out, or choose 'best'")
    if isinstance(limits, Limits):
        given["limits"] = limits.over(base.limits)
        n_first = max(n_prims, first_refs(n_prims, replace(base, presplit=presplit)))
        if limits.max_leaf_refs is None and not given["limits"].hold(n_first):
            given["limits"] = replace(given["limits"], max_leaf_refs=None)
        leaf = given["limits"].max_leaf_refs
        if lanes is None and leaf is not None and leaf < base.lanes:
            given["lanes"] = 2 ** (leaf.bit_length() - 1)
    settings = replace(base, **given)
    limits = settings.limits
    most = limits.refs_for(n_prims, settings.boxes)
    if n_prims > REF_LIMIT:
        raise InputError(f"{n_prims:,} primitives are more than a tree can index, {REF_LIMIT}; build several trees")
    if limits.max_refs is not None and limits.max_refs < n_prims:
        raise InputError(
            f"max_refs={limits.max_refs} is less than one for each of the {counted(n_prims, 'primitives')}"
        )
    if limits.max_bytes is not None and most < n_prims:
        raise InputError(
            f"max_bytes={limits.max_bytes} is less than a tree over {counted(n_prims, 'primitives')} takes; allow "
            f"{limits.bytes_for(n_prims, settings.boxes)} or more"
        )
    if not limits.hold(n_prims):
        raise InputError(
            f"max_leaf_refs={limits.max_leaf_refs} cannot be kept within max_depth={limits.max_depth} for "
            f"{counted(n_prims, 'primitives')}; raise one of them"
        )
    if kind != "segments" and (settings.presplit is not None or settings.reinsertion > 0):
        raise InputError(f"presplit and reinsertion are for lines, these are {type(geometry).__name__}; leave them out")
    wanted = first_refs(n_prims, settings)
    if wanted > most:
        raise InputError(
            f"{settings.presplit} makes {wanted} references, but the limits allow {most}; lower refs or raise max_refs"
        )
    if not limits.hold(wanted):
        raise InputError(
            f"{settings.presplit} makes {wanted} references, but leaves of max_leaf_refs={limits.max_leaf_refs} within "
            f"max_depth={limits.max_depth} cannot hold them; lower refs, or raise one of the limits"
        )
    box = frame_around(geometry.bounds, frame)
    bounded = replace(base, limits=replace(base.limits, max_refs=limits.max_refs, max_bytes=limits.max_bytes))
    name = method if method is not None and settings == bounded and given.keys() <= {"limits"} else "custom"
    with reporting(progress, "build") as callback:
        if settings.presplit == Presplit():
            return _cheapest_presplit(geometry, settings, name, box, callback)
        return _build(geometry, settings, name, box, callback)


def first_refs(n_prims: int, settings: Settings) -> int:
    """Return how many references a presplit with the bound `refs` makes; 0 without that bound."""
    presplit = settings.presplit
    return 0 if presplit is None or presplit.refs is None else max(n_prims, int(presplit.refs * n_prims))


def _cheapest_presplit(
    geometry: AnyGeometry, settings: Settings, name: str, frame: FloatArray | None, callback: ProgressCallback | None
) -> Tree:
    """Build with 1, 2, 4, … references a line as long as the next tree is cheaper by one part in a hundred."""
    n_prims = len(geometry.build_data()[1])
    best: Tree | None = None
    for doubling in count():
        more = replace(settings, presplit=Presplit(refs=2.0**doubling))
        if best is not None and first_refs(n_prims, more) > _most_first_refs(n_prims, settings):
            return best
        tree = _build(geometry, more, name, frame, _stage(callback, 1 - 2.0**-doubling, 1 - 2.0 ** -(doubling + 1)))
        if best is not None and not tree.cost() < 0.99 * best.cost():
            return best
        best = tree
    raise AssertionError


def _stage(callback: ProgressCallback | None, first: float, last: float) -> ProgressCallback | None:
    """Return a callback for a stage, which reports its progress as the part from `first` to `last` of the whole."""
    return None if callback is None else lambda done: callback(first + (last - first) * done)


def _most_first_refs(n_prims: int, settings: Settings) -> int:
    """Return the most references that a build within the limits can start with."""
    limits = settings.limits
    most = limits.refs_for(n_prims, settings.boxes)
    return most if limits.max_leaf_refs is None else min(most, limits.max_leaf_refs * 2**limits.max_depth)


def _build(
    geometry: AnyGeometry, settings: Settings, name: str, frame: FloatArray | None, callback: ProgressCallback | None
) -> Tree:
    splits = settings.splits
    kind, rows = geometry.build_data()
    if kind != "segments":
        splits = tuple(exact for split in splits for exact in split.for_any_primitive(settings.boxes))
    limits, presplit = settings.limits, settings.presplit
    core_settings = _core.Settings(
        splits=[_core_split_set(split) for split in splits],
        beam=settings.beam or NO_LIMIT,
        c_trav=settings.cost.c_trav,
        c_prim=settings.cost.c_prim,
        limits=_core.Limits(
            max_depth=limits.max_depth,
            max_leaf_refs=limits.max_leaf_refs or NO_LIMIT,
            max_refs=limits.refs_for(len(rows), settings.boxes),
            leaf_refs=limits.leaf_refs,
            leaf_size=limits.leaf_size,
        ),
        presplit=_core.Presplit(
            area=math.inf if presplit is None else presplit.area or 0.0,
            max_refs=first_refs(len(rows), settings) or _most_first_refs(len(rows), settings),
        ),
        n_threads=get_num_threads(),
        **{name: getattr(settings, name) for name in SAME},
    )
    first = callback if settings.reinsertion == 0 else _stage(callback, 0.0, 0.5)
    if kind == "segments":
        nodes, refs, hit, searched = engine.build(rows, core_settings, first)
    else:
        nodes, refs, hit, searched = _core.build(kind, rows, core_settings, first)
    limits_hit = {limit: n for limit, n in zip(("max_depth", "max_refs", "max_leaf_refs"), hit, strict=True) if n}
    if settings.reinsertion > 0:
        rounds, depth, hint = settings.reinsertion, limits.max_depth, settings.radius_hint
        last = _stage(callback, 0.5, 1.0)
        nodes, refs, n_too_deep = _core.reinsert(nodes, refs, rounds, depth, hint, get_num_threads(), last)
        if n_too_deep:
            limits_hit["max_depth"] = limits_hit.get("max_depth", 0) + n_too_deep
    nodes, refs = own(nodes).reshape(-1).view(NODE), own(refs).reshape(-1).view(REF)
    counts = dict(zip(("candidates", "carried_out"), searched, strict=True)) if searched[0] else {}
    return Tree(geometry, nodes, refs, settings, name, limits_hit, searched=counts, frame=frame, made_by_core=True)


def _core_split_set(split: SplitSet) -> _core.SizedSplitSet:
    """Return the core's split set with the same name and fields."""
    given = {field.name: getattr(split, field.name) for field in fields(split)}
    max_refs, min_overlap = given.pop("max_refs"), given.pop("min_overlap")
    kind = getattr(_core, type(split).__name__)
    return _core.SizedSplitSet(kind(**given), max_refs=max_refs or NO_LIMIT, min_overlap=min_overlap)
