"""A step of the report: one tree over one subject is built, checked, timed and drawn."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from fastlines import FastlinesError, Tree, render
from fastlines.rendering import level_sheet, write_picture

from ..builders.names import THESIS_COST, kind_of
from ..builders.trees import alternate_builds
from ..harness.compare import same
from ..harness.internals import DEFAULT_METHOD, grey, limit_notes, num_threads
from ..harness.rays import RayBatch, camera_rays
from ..harness.subjects import Subject
from ..harness.turns import count_hits, query_function, query_tree
from .heat import colour, visit_maps
from .measure import measure, some, timed_by
from .preset import ThesisPreset
from .rows import KINDS
from .store import Found, Store

#: The number of rays whose answers are compared with those of another tree, bit for bit.
CHECKED = 1024
#: The radius of the lines behind the boxes of a tree, as a fraction of the diagonal.
BEHIND = 0.001
#: The number of colours of a picture of levels.
N_COLOURS = 128


def picture_step(subject: Subject, preset: ThesisPreset, store: Store) -> Found:
    """Draw the subject with each radius; return the names of the files."""
    images = {}
    for letter, radius in subject.by_letter.items():
        path = store.path(f"{subject.title} {letter}", ".png")
        size: dict[str, Any] = {"width": preset.picture, "height": preset.picture, "samples": preset.samples}
        write_picture(path, grey(render(subject.best, subject.camera, look="depth", radius=radius, **size)))
        images[letter] = path.name
    return {"images": images}


def tree_step(subject: Subject, method: str, preset: ThesisPreset, store: Store) -> Found:
    """Build and time a tree on one thread: the binary tree of a thesis's method, or the wide layout of `best`."""
    kernel = "auto" if method == DEFAULT_METHOD else "binary"
    with num_threads(1):
        built = alternate_builds(subject.lines, [method], 1, preset.build_limit)[method]
        if built is None:
            return {"over_s": preset.build_limit}
        tree = built.tree
        tree.validate()
        # Use one cost model for all trees of a kind; "best" has its own.
        stats = tree.stats() | {"cost": tree.cost(model=THESIS_COST[kind_of(tree.settings)])}
        rays = camera_rays(subject.camera, preset.size**2)
        n_compared = check_answers(tree, subject, rays, method, kernel)
        times = {}
        for query in KINDS:
            for letter, radius in subject.by_letter.items():
                run = timed_by(query_function(tree, query, radius, 1, kernel), partial(count_hits, query))
                times[f"{query} {letter}"] = measure(run, query, rays, preset.budget, stats["cost"]).to_json()
    return {
        **stats,
        "limits": limit_notes(stats["limits_hit"]),
        "build_s": built.build_s,
        "n_compared": n_compared,
        "times": times,
        **draw(tree, subject, method, preset, store),
    }


def check_answers(tree: Tree, subject: Subject, rays: RayBatch, method: str, kernel: str) -> int:
    """Return the number of compared answers; raise an error if they differ from those of `best` on its layout."""
    few = some(rays, CHECKED)
    for query in KINDS:
        answers = [
            query_tree(each, query, few, subject.by_letter["M"], k)
            for each, k in ((tree, kernel), (subject.best, "auto"))
        ]
        if not same(*answers):
            raise FastlinesError(
                f"{subject.title}: {method} and best answer {query} hits differently; this is a bug in fastlines, "
                "please report it"
            )
    return len(few) * len(KINDS)


def draw(tree: Tree, subject: Subject, method: str, preset: ThesisPreset, store: Store) -> Mapping[str, Any]:
    """Draw the heat maps, and the levels of some trees; return the mean visits and the names of the files."""
    nodes, tests = visit_maps(tree, subject.camera, preset.heat, subject.by_letter["M"])
    images = {}

    def keep(what: str, picture: npt.NDArray[np.uint8]) -> None:
        path = store.path(f"{subject.title} {method} {what}", ".png")
        write_picture(path, picture)
        images[what] = path.name

    keep("nodes", colour(nodes))
    keep("tests", colour(tests))
    if method in preset.drawn:
        radius = BEHIND * subject.diagonal
        sheet = level_sheet(tree, subject.camera, radius, preset.levels, preset.panel, behind=subject.best)
        keep("levels", fewer_colours(sheet))
    return {"visits": {"nodes": float(nodes.mean()), "tests": float(tests.mean())}, "images": images}


def fewer_colours(picture: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """Return a picture with few colours, so that its file is small."""
    from PIL import Image

    image = Image.fromarray(picture).quantize(N_COLOURS, dither=Image.Dither.NONE)
    return np.asarray(image.convert("RGB"))
