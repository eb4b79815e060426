"""The builders that are compared: their names and the arguments of `fastlines.build`. All of the thesis are included.

A name with an @ belongs to a sweep of efforts: the builder before the @ is swept, and plots connect it by a line.
"best" has a cost model of its own, so all trees are compared with one model, `THESIS_COST`.
"""

from __future__ import annotations

from typing import Any

from fastlines import Cost, Limits, Median, Midpoint, ObjectSweep, PlaneEvents, PlaneGrid, Presplit, Settings

#: The cost model of each kind of trees, as in the thesis's figures.
THESIS_COST = {"bvh": Cost(2.0), "kd": Cost(0.6)}

_CUT: dict[str, Any] = {"boxes": "cut", "cost": THESIS_COST["kd"]}

#: "best" for queries, and for the thesis's cost as a BVH and as a KD tree.
_BEST: dict[str, dict[str, Any]] = {
    "best": {"method": "best"},
    "best-bvh": {"method": "best", "cost": THESIS_COST["bvh"]},
    "best-kd": {"method": "best", **_CUT},
}

#: The arguments of `fastlines.build`, by name.
BUILDERS: dict[str, dict[str, Any]] = {
    **_BEST,
    **{
        f"{name}@{effort:g}": {**given, "effort": effort}
        for name, given in _BEST.items()
        for effort in (0, 0.25, 0.75, 1)
    },
    # Tight boxes.
    "median": {"splits": Median(), "limits": Limits(max_leaf_refs=8)},
    "middle": {"splits": Midpoint(), "bad_levels": 3},
    "bvh-cl": {"method": "bvh-cl"},
    "bvh-ss": {"method": "bvh-ss"},
    "bvh-d2": {"method": "bvh-d2"},
    "sbvh": {"splits": (ObjectSweep(), PlaneGrid(16, min_overlap=1e-5))},
    "presplit": {"method": "bvh-cl", "presplit": Presplit()},
    "presplit-area": {"method": "bvh-cl", "presplit": Presplit(area=1e-4)},
    "bvh-cl-reinsertion": {"method": "bvh-cl", "reinsertion": 10},
    "bvh-d2-reinsertion": {"method": "bvh-d2", "reinsertion": 10},
    "presplit-reinsertion": {"method": "bvh-cl", "presplit": Presplit(), "reinsertion": 10},
    "best-bvh-reinsertion": {**_BEST["best-bvh"], "reinsertion": 10},
    # Cut boxes.
    "kd-median": {"splits": Median(), "bad_levels": 3, **_CUT},
    "kd-middle": {"splits": Midpoint(), "bad_levels": 3, **_CUT},
    "kd-cl": {"method": "kd-cl"},
    "kd-d2": {"method": "kd-d2"},
    "kd-d2-exhaustive": {"method": "kd-d2", "exhaustive": True},  # the same tree, searched as the thesis does
    "kd-events": {"method": "kd-cl", "splits": PlaneEvents()},
    "kd-bad-refines": {"method": "kd-cl", "bad_refines": 3, "prune": False},
}


def kind_of(settings: Settings) -> str:
    """Return the kind of the trees that these settings build: "bvh" or "kd"."""
    return "kd" if settings.boxes == "cut" else "bvh"
