"""The differences between our figures and the thesis's, and their reasons as far as they are known."""

from __future__ import annotations

#: Each difference and its reason.
WHY: tuple[tuple[str, str], ...] = (
    (
        "Times are from another machine",
        "The thesis’s machine was from 2013, and the size of its picture is not given. So milliseconds are not "
        "comparable. Ratios within a table are, as far as both machines have similar strengths. Our times are on one "
        "thread, for the number of rays above each table.",
    ),
    (
        "Hair and beams are our own scenes",
        "Bun Hair, Straight Hair and Photon Beams are generated after the thesis’s text and pictures, with its numbers "
        "of segments. The lengths of segments and how they cross are our choice, and affect costs and nodes. The text "
        "defines Spaghetti, so there costs agree within a few percent.",
    ),
    (
        "c_trav is fitted",
        "The thesis does not give c_p and c_t of its tables. c_p = 1 and c_t = 2 for BVHs and 0.6 for KD trees "
        "reproduce its costs on spaghetti. So costs are comparable within a kind of tree, not between BVHs and KD "
        "trees.",
    ),
    (
        "SPLITS are our choice",
        "The thesis does not give the numbers of planes either. Ours are 8 per axis for BVHs and 12 for KD trees. "
        "KD::CL and KD::D2 choose from the same planes, because they hardly differ on hair in the thesis’s tables. "
        "With planes at the sides of boxes, where SAH has its extremes, KD::CL costs 5 to 7 % less on our hair and "
        "beams. Where lines are long and cross, our trees have several times as many nodes at about the same cost, and "
        "take longer to build.",
    ),
    (
        "The camera is unknown",
        "The thesis shows pictures, but does not give cameras. Ours fills a square picture with the lines. The share "
        "that they cover determines how many rays end early, and so how the times of first and all hits compare.",
    ),
    (
        "The traversal is ours",
        "The five binary trees are traversed one ray at a time, as in the thesis, but by our own code: a BVH by boxes, "
        "a KD tree by planes. All hits are sorted and have their place on the segment; where there are many, writing "
        "them takes time.",
    ),
    (
        "KD trees gain less than in the thesis",
        "In the thesis the time of KD trees follows their cost: both are about half of those of BVHs. On hair our KD "
        "trees cost 0.6 to 0.7 of our BVHs. On the other scenes they cost half, but the costs assume that a step "
        "through a plane takes 0.3 of a step through two boxes. Commit 8fa8e93, the last with the command "
        "“fastlines-bench calibrate --quick”, finds a half. The step of a plane depends on the step before it, while "
        "both boxes of a BVH’s step are tested in parallel.",
    ),
    (
        "Embree is another Embree",
        "Ours is a current version instead of that of 2013, with triangles as in the thesis: two per segment, facing "
        "the camera, without spatial splits, ray by ray. The thesis does not give the length to which it cut segments, "
        "nor the criterion. Ours is the least geometric mean of the times of first and all hits at the radius M. "
        "Embree is faster in packets and with user geometry: “fastlines-bench engine” measures its fastest "
        "configuration.",
    ),
    (
        "Nodes and cost of Embree",
        "The thesis read both from Embree’s tree. Embree 4 has no call that returns the tree of a scene. Our figures "
        "are of the tree that its builder interface, rtcBuildBVH, builds over the boxes of the same segments or "
        "pieces, with two children per node, c_trav = 2 and c_prim = 1. A scene’s tree has four or eight children per "
        "node and is over triangles, as in the thesis, so its figures are lower.",
    ),
    (
        "What we do not know",
        "On Photon Beams, the thesis’s BVH::CL has half the cost of ours, and Embree’s tree a tenth. The scene is "
        "ours, and no parameter that we tried explains both.",
    ),
)
