"""Random settings of a build: named trees, and any settings that fit together."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from typing import Any

import fastlines as fl

from .scenes import Random

#: The most references of a tree, so that copies of long lines do not take long.
MOST_REFS = 3000


def _splits(rng: Random, boxes: str, looks_ahead: bool) -> tuple[Any, ...]:
    """Return one to three sets of candidate splits; few planes for a search of several levels, which takes long."""
    n_planes = int(rng.choice([1, 2, 4, 8] if looks_ahead else [1, 2, 4, 8, 16, 300]))
    kinds: list[Any] = [
        fl.PlaneGrid(n_planes),
        fl.BinnedPlanes(n_planes),
        fl.PlaneEvents(max_refs=int(rng.choice([8, 100]))),
        fl.Median(),
        fl.Midpoint(),
    ]
    if boxes == "tight":
        kinds += [
            fl.ObjectSweep(max_refs=int(rng.choice([12, 10_000]))),
            fl.BinnedPlanes(n_planes, 128, 64, 0.6, sample=int(rng.choice([0, 128])), gap_refs=1000, gap=0.85),
            fl.PlaneGrid(8, min_overlap=1e-5),
        ]
    chosen = rng.permutation(len(kinds))[: int(rng.choice([1, 1, 2, 3]))]
    return tuple(kinds[i] for i in chosen)


def random_build(rng: Random, are_lines: bool, n_rows: int) -> dict[str, Any]:
    """Return arguments of `fl.build` for geometry of so many rows."""
    most = max(MOST_REFS, 2 * n_rows)
    limits: dict[str, Any] = {"max_refs": most}
    given: dict[str, Any] = {}
    if rng.random() < 0.5:
        given["method"] = str(rng.choice(list(fl.METHODS)))
        is_kd = given["method"].startswith("kd")
        if given["method"] == "best":
            if rng.random() < 0.5:
                given["effort"] = float(rng.choice([0.0, 0.3, 0.8, 1.0]))
            if rng.random() < 0.2:
                given["cost"] = fl.Cost(float(rng.choice([0.3, 2.0])))
            if rng.random() < 0.2:
                given["boxes"], is_kd = "cut", True
    else:
        boxes = str(rng.choice(["tight", "tight", "cut"]))
        is_kd = boxes == "cut"
        looks_ahead = rng.random() < 0.2
        given |= {"boxes": boxes, "splits": _splits(rng, boxes, looks_ahead)}
        given["cost"] = fl.Cost(float(rng.choice([1e-3, 0.01, 0.3, 2.0])))
        if looks_ahead:
            given["lookahead"] = ((0,), (1, 2), (2,), (1, 2, 3))[int(rng.integers(4))] if n_rows < 50 else (1, 2)
            limits["max_refs"] = min(most, 600) if n_rows < 300 else most
        for name, values in (
            ("bad_levels", (0, 3)),
            ("bad_refs", (0, 6)),
            ("bad_refines", (0, 2)),
            ("prune", (True, False)),
            ("radius_hint", (0.0, 0.01)),
            ("min_spread", (0.0, 0.0005)),
        ):
            if rng.random() < 0.2:
                given[name] = values[int(rng.integers(2))]
    if rng.random() < 0.15:
        limits["max_depth"] = int(rng.choice([0, 3, 20]))
    if rng.random() < 0.15:
        limits["leaf_refs"] = int(rng.choice([0, 4]))
    if not is_kd and "max_depth" not in limits and rng.random() < 0.15:
        limits["max_leaf_refs"] = int(rng.choice([1, 3, 16]))
    if are_lines and not is_kd:
        if rng.random() < 0.15:
            refs = float(rng.choice([1.0, 2.5]))
            given["presplit"] = fl.Presplit(refs=refs) if rng.random() < 0.7 else fl.Presplit(area=1e-2)
        if rng.random() < 0.15:
            given["reinsertion"] = int(rng.choice([1, 3]))
    return given | {"limits": fl.Limits(**limits)}


def builder_name(build: dict[str, Any]) -> str:
    """Return what tables call the builder."""
    name = build.get("method") or ("any KD tree" if build.get("boxes") == "cut" else "any BVH")
    return f"{name}, cut" if build.get("method") == "best" and build.get("boxes") == "cut" else str(name)


def text_of(value: Any) -> str:
    """Return Python that makes a value of settings: plain values, tuples, and dataclasses of fastlines."""
    if is_dataclass(value) and not isinstance(value, type):
        given = (f"{f.name}={text_of(got)}" for f in fields(value) if (got := getattr(value, f.name)) != f.default)
        return f"fl.{type(value).__name__}({', '.join(given)})"
    if isinstance(value, tuple):
        return f"({''.join(f'{text_of(one)}, ' for one in value)})"
    return repr(value)
