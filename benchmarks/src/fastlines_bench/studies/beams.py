"""Trees over photon beams: what each takes to build, and to query with a picture of 512² pixels.

Each tree is built in a fresh process, by one thread. Its row has references per beam, the processor time of the build
and of the layout, the peak of memory above the input, and the processor time of `count_hits` for each radius, the least
of three. The timed rays are rows of the picture, spread over it; their time stands for that of the whole. The same
number of random rays, which are incoherent, is timed for the first radius.
"""

from __future__ import annotations

import multiprocessing
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import fastlines as fl

from ..harness.clock import best_of, clock
from ..harness.internals import best_settings
from ..harness.rays import RayBatch, camera_rays, random_rays
from .memory import reset_peak, status

SIZES = (36_294, 200_000, 1_000_000)
RADII = (0.001, 0.002, 0.005)

#: The width and height of the picture, and how many of its rays and of random rays are timed.
SIDE, N_RAYS, N_RANDOM = 512, 1 << 15, 1 << 12

#: Bounds on the nodes that planes cut, in radii of the hint.
SIDES = (16, 32, 64, 128, 512)


def trees(n_beams: int) -> dict[str, dict[str, Any]]:
    """Return the arguments of `fl.build` for each tree: "best" with each of `SIDES`, "beams" and "bvh-cl"."""
    (planes,) = best_settings(n_prims=n_beams).splits
    assert isinstance(planes, fl.BinnedPlanes)
    cut = {f"cut from {n} radii": {"splits": replace(planes, uncut_only_side=n)} for n in SIDES}
    return {
        **{name: {"method": "best", **given} for name, given in cut.items()},
        **{name: {"method": name} for name in ("best", "beams", "bvh-cl")},
    }


def measure(n_beams: int, name: str, radii: Sequence[float]) -> dict[str, Any]:
    """Build a tree over photon beams, and query it."""
    fl.set_num_threads(1)
    scene, now = fl.scenes.make("photon-beams", n_beams), clock(1)
    fl.build(scene.lines.segments[:10])
    before, start = reset_peak(), now()
    tree = fl.build(scene.lines, **trees(n_beams)[name])
    build_s, start = now() - start, now()
    layout_bytes = tree.layout.n_bytes
    row: dict[str, Any] = {
        "beams": n_beams,
        "tree": name,
        "refs": tree.n_refs / n_beams,
        "build_s": build_s,
        "layout_s": now() - start,
        "peak_bytes": status("VmHWM") - before,
        "layout_bytes": layout_bytes,
    }
    few = camera_rays(scene.camera, SIDE * SIDE).part(N_RAYS)
    row["queries"] = [count_hits(tree, few, radius) for radius in radii]
    row["random"] = count_hits(tree, random_rays(scene.lines, N_RANDOM), radii[0])
    return row


def count_hits(tree: fl.Tree, rays: RayBatch, radius: float) -> dict[str, float]:
    """Count the hits of some rays; return the seconds that as many rays as the picture has would take."""
    seconds, counts = best_of(3, 1, lambda: tree.count_hits(rays.origins, rays.directions, radius))
    return {"radius": radius, "hits": int(counts.sum()), "rays": len(rays), "query_s": seconds * SIDE**2 / len(rays)}


def rows(sizes: Sequence[int], radii: Sequence[float], names: Sequence[str] | None) -> Iterator[dict[str, Any]]:
    """Yield the rows of all trees; raise an error if two trees have other hits."""
    context = multiprocessing.get_context("spawn")
    for n_beams in sizes:
        hits = None
        for name in names or trees(n_beams):
            with context.Pool(1) as pool:
                row = pool.apply(measure, (n_beams, name, tuple(radii)))
            found = [query["hits"] for query in row["queries"]]
            if hits not in (None, found):
                raise RuntimeError(f"{name} has {found} hits of {n_beams} beams, other trees have {hits}")
            hits = found
            yield row


def print_beams(
    sizes: Sequence[int] = SIZES, radii: Sequence[float] = RADII, names: Sequence[str] | None = None
) -> list[dict[str, Any]]:
    """Print a table of the trees over each number of beams, as Markdown; return its rows."""
    heads = ["beams", "tree", "references a beam", "build, s", "layout, s", "peak, MB"]
    heads += [f"query at {radius:g}, s" for radius in radii] + [f"all at {radius:g}, s" for radius in radii]
    heads += [f"random rays at {radii[0]:g}, s"]
    print(f"| {' | '.join(heads)} |\n|--:|---|{'--:|' * (len(heads) - 2)}", flush=True)
    found = []
    for row in rows(sizes, radii, names):
        found.append(row)
        queries = [query["query_s"] for query in row["queries"]]
        once = row["build_s"] + row["layout_s"]
        cells = [f"{row['beams']:,}", row["tree"], f"{row['refs']:.1f}", f"{row['build_s']:.2f}"]
        cells += [f"{row['layout_s']:.2f}", f"{row['peak_bytes'] / 1e6:,.0f}"]
        cells += [f"{seconds:.2f}" for seconds in (*queries, *(once + seconds for seconds in queries))]
        cells += [f"{row['random']['query_s']:.1f}"]
        print(f"| {' | '.join(cells)} |", flush=True)
    return found
