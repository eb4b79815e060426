"""All builders that the thesis names, as settings of the one builder, so that one table compares them on equal terms.

Those of one kind of box share the costs of a step and of a test, but for "best": compare all under one model,
``tree.cost(model=fl.Cost(2.0))``, or those of cut boxes under ``fl.Cost(0.6)``.
"""

from __future__ import annotations

from typing import Any

from ..settings import Cost, Limits, Median, Middle, ObjectSweep, PlaneEvents, PlaneGrid, Presplit

_CUT: dict[str, Any] = {"boxes": "cut", "cost": Cost(c_trav=0.6)}

#: What `fastlines.build` is told, by name.
BUILDERS: dict[str, dict[str, Any]] = {
    "best": {"method": "best"},
    # Tight boxes.
    "median": {"splits": Median(), "limits": Limits(max_leaf_refs=8)},
    "middle": {"splits": Middle(), "bad_levels": 3},
    "bvh-cl": {"method": "bvh-cl"},
    "bvh-ss": {"method": "bvh-ss"},
    "bvh-d2": {"method": "bvh-d2"},
    "sbvh": {"splits": (ObjectSweep(), PlaneGrid(16, min_overlap=1e-5))},
    "presplit": {"method": "bvh-cl", "presplit": Presplit()},
    "presplit-area": {"method": "bvh-cl", "presplit": Presplit(area=1e-4)},
    "bvh-cl-reinsertion": {"method": "bvh-cl", "reinsertion": 10},
    "bvh-d2-reinsertion": {"method": "bvh-d2", "reinsertion": 10},
    "presplit-reinsertion": {"method": "bvh-cl", "presplit": Presplit(), "reinsertion": 10},
    "best-reinsertion": {"method": "best", "reinsertion": 10},
    # Cut boxes.
    "kd-median": {"splits": Median(), "bad_levels": 3, **_CUT},
    "kd-middle": {"splits": Middle(), "bad_levels": 3, **_CUT},
    "kd-cl": {"method": "kd-cl"},
    "kd-d2": {"method": "kd-d2"},
    "bad-refines": {"splits": (PlaneEvents(), Middle()), "bad_levels": 3, "prune": False, **_CUT},
}
