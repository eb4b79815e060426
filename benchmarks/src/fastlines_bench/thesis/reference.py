"""The figures of the thesis (§6), for comparison with ours. Its machine was from 2013."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Reference:
    """A row of the thesis's tables: one of its trees, Embree, or Embree with presplit segments ("embree-ps").

    Attributes
    ----------
    n_prims, n_nodes : int
    cost : float
    build_ms : int
    first_ms, all_ms : tuple of int or None
        For the radii W, M, N; None = "did not finish".
    """

    n_prims: int
    build_ms: int
    n_nodes: int
    cost: float
    first_ms: tuple[int, ...] | None
    all_ms: tuple[int, ...] | None


_NOT_FINISHED = None

THESIS: dict[str, dict[str, Reference]] = {
    "bun-hair": {
        "bvh-cl": Reference(82250, 1445, 22710, 124.52, (786, 1245, 1419), (1876, 1844, 1835)),
        "bvh-ss": Reference(82250, 3236, 121427, 103.82, (663, 1086, 1219), (1560, 1526, 1471)),
        "bvh-d2": Reference(82250, 3445, 125767, 103.68, (652, 1056, 1194), (1530, 1472, 1470)),
        "kd-cl": Reference(82250, 3741, 647015, 58.20, (365, 581, 657), (859, 807, 803)),
        "kd-d2": Reference(82250, 3773, 650074, 58.19, (361, 578, 655), (849, 810, 805)),
        "embree": Reference(82250, 725, 84293, 47.37, (298, 444, 508), (3118, 1128, 903)),
        "embree-ps": Reference(158090, 1344, 188920, 37.97, (267, 391, 434), (1843, 800, 680)),
    },
    "straight-hair": {
        "bvh-cl": Reference(87460, 1559, 36243, 149.75, (1488, 2271, 2580), (3068, 3016, 3019)),
        "bvh-ss": Reference(87460, 1571, 67669, 136.24, (1319, 2012, 2300), (2735, 2712, 2691)),
        "bvh-d2": Reference(87460, 1575, 68138, 136.15, (1319, 2007, 2341), (2734, 2692, 2756)),
        "kd-cl": Reference(87460, 2673, 563598, 79.49, (681, 1135, 1317), (1643, 1603, 1590)),
        "kd-d2": Reference(87460, 2670, 563804, 79.49, (677, 1137, 1309), (1655, 1604, 1592)),
        "embree": Reference(87460, 690, 97761, 47.87, (423, 680, 780), (1863, 1132, 1044)),
        "embree-ps": Reference(486950, 3377, 530879, 37.72, (365, 545, 606), (1550, 895, 803)),
    },
    "spaghetti": {
        "bvh-cl": Reference(2000, 17, 179, 1331.34, (5682, 6072, 6216), (6570, 6567, 6572)),
        "bvh-ss": Reference(2000, 2, 1, 2000.00, (9463, 9552, 9450), (10013, 9945, 9953)),
        "bvh-d2": Reference(2000, 436, 14962, 286.95, (461, 842, 969), (1151, 1140, 1144)),
        "kd-cl": Reference(2000, 2, 1, 2000.00, (8920, 9068, 8898), (9187, 9163, 9152)),
        "kd-d2": Reference(2000, 366, 76407, 138.00, (232, 422, 484), (595, 570, 566)),
        "embree": Reference(2000, 91, 1552, 971.77, (2889, 3282, 3455), (13923, 5522, 4621)),
        "embree-ps": Reference(264741, 1967, 335726, 94.52, (214, 332, 374), (709, 477, 450)),
    },
    "spaghetti-2": {
        "bvh-cl": Reference(8000, 85, 608, 4925.00, _NOT_FINISHED, _NOT_FINISHED),
        "bvh-ss": Reference(8000, 5, 1, 8000.00, _NOT_FINISHED, _NOT_FINISHED),
        "bvh-d2": Reference(8000, 3366, 115754, 579.99, (450, 942, 1346), (2394, 2345, 2345)),
        "kd-cl": Reference(8000, 9, 1, 8000.00, _NOT_FINISHED, _NOT_FINISHED),
        "kd-d2": Reference(8000, 2908, 602932, 276.34, (211, 468, 665), (1289, 1228, 1205)),
        "embree": Reference(8000, 143, 5913, 3724.86, _NOT_FINISHED, _NOT_FINISHED),
        "embree-ps": Reference(1229361, 10083, 1624314, 201.75, (221, 434, 653), (2462, 1417, 1297)),
    },
    "photon-beams": {
        "bvh-cl": Reference(36294, 597, 9924, 4399.96, _NOT_FINISHED, _NOT_FINISHED),
        "bvh-ss": Reference(36294, 4225, 151943, 589.37, (1539, 3305, 4224), (6247, 6023, 6012)),
        "bvh-d2": Reference(36294, 4767, 161798, 587.16, (1543, 3303, 4179), (6077, 5977, 5964)),
        "kd-cl": Reference(36294, 4106, 783608, 277.40, (622, 1508, 1967), (3021, 2959, 2867)),
        "kd-d2": Reference(36294, 4186, 796709, 276.70, (620, 1482, 1929), (3013, 2876, 2854)),
        "embree": Reference(36294, 617, 56946, 911.01, (1712, 4526, 5662), (27459, 12227, 10104)),
        "embree-ps": Reference(552225, 4836, 696996, 229.81, (592, 1291, 1655), (4704, 2853, 2611)),
    },
}
