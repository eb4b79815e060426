"""Where our figures differ from the thesis's, and why: what is known and what is not."""

from __future__ import annotations

#: What is said, and the reason.
WHY: tuple[tuple[str, str], ...] = (
    (
        "Times are of another machine",
        "The thesis’s is one of 2013, and its picture’s size is not told. So milliseconds do not compare; ratios "
        "within a table do, as far as both machines like the same things. Ours are of one thread, for the number "
        "of rays that is said above each table.",
    ),
    (
        "Hair and beams are scenes of our own",
        "Bun Hair, Straight Hair and Photon Beams are made by generators after the thesis’s words and pictures, "
        "with its numbers of segments. How long segments are and how they cross is ours, and costs and nodes with "
        "it. Spaghetti is defined by its words, so there costs come within a few parts in a hundred.",
    ),
    (
        "c_trav is fitted",
        "The thesis does not tell c_p and c_t of its tables. With c_p = 1, c_t = 2 for BVHs and 0.6 for KD trees "
        "its costs on spaghetti come out. So costs compare within a kind of tree, not between BVHs and KD trees.",
    ),
    (
        "SPLITS are chosen by us",
        "How fine the grids of planes are is not told either: ours have 8 planes an axis for BVHs, 12 for KD trees. "
        "KD::CL and KD::D2 choose from the same planes, for in the thesis’s tables they hardly differ on hair; with "
        "planes at the sides of boxes, where SAH has its extremes, KD::CL costs 5 to 7 % less on our hair and beams. "
        "Where lines are long and cross, ours have several times as many nodes at about the same cost, and take longer "
        "to build.",
    ),
    (
        "The camera is unknown",
        "The thesis shows pictures, not cameras. Ours fills a square picture with the lines; how much of it they "
        "cover decides how many rays end early, and so how first hits compare with all hits.",
    ),
    (
        "The search of a tree is ours",
        "The five trees are searched one ray at a time through the binary tree as it was built, as the thesis "
        "did, but by code of our own: a BVH by boxes, a KD tree by planes. All hits come sorted, with their place on "
        "the segment; where there are many, writing them takes its time.",
    ),
    (
        "KD trees gain less than in the thesis",
        "In the thesis the time of KD trees follows their cost: both are about half of those of BVHs. On hair our KD "
        "trees cost 0.6 to 0.7 of our BVHs. On the other scenes they cost half, but the costs assume that a step "
        "through a plane takes 0.3 of a step through two boxes; “fastlines-bench calibrate --quick” finds a half. "
        "A plane’s step waits for the plane that the step before has chosen, while both boxes of a BVH’s step are "
        "tested side by side.",
    ),
    (
        "Embree is another Embree",
        "Today’s version instead of that of 2013, with triangles as then: two a segment, facing the camera, "
        "without spatial splits, ray by ray. Which length the thesis cut to is not told, nor by which figure it "
        "was best; here it is the geometric mean of first and all hits at the radius M. Embree answers faster in "
        "packets and with user geometry: “fastlines-bench engine” measures it at its best.",
    ),
    (
        "Nodes and cost of Embree",
        "The thesis read both out of Embree’s tree. Embree 4 has no call that gives the tree of a scene. What "
        "stands there is of the tree that its builder interface, rtcBuildBVH, makes of the boxes of the same "
        "segments or pieces, with two children a node, c_trav = 2 and c_prim = 1. A scene’s tree has four or "
        "eight children a node and is over triangles, as the thesis’s was, so its figures are lower.",
    ),
    (
        "What we do not know",
        "Why BVH::CL has half the cost of ours on Photon Beams, and Embree’s tree there a tenth: the scene is "
        "ours, and no parameter that we tried explains both.",
    ),
)
