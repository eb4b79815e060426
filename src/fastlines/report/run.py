"""Making the report: steps, then tables and claims, then the page, Markdown and JSON."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from ..atomic_write import atomic_write
from ..backend import simd
from ..bench import embree
from ..camera import Camera
from ..demo.machine import describe_machine
from ..demo.reference import THESIS
from ..errors import FastlinesError
from ..lines import Lines
from ..methods import DEFAULT_METHOD
from .answer import answer_section
from .claims import claims_of
from .depths import time_depth
from .document import Document, Section
from .markdown import markdown
from .page import html
from .peer import embree_step, embree_tree_step, sweep_step
from .plan import Plan
from .rows import Row, row_of, thesis_row
from .sections import claims_section, depths_section, method_points, subject_section, why_section
from .steps import Found, Results, Step, Store, run_steps
from .subject import Subject, lines_subject, scene_subject
from .trees import picture_step, tree_step

#: The folder of steps and pictures beside the page.
STEPS = "steps"
SWEEP, PEER, PEER_PS, PEER_TREES = "Embree’s lengths", "Embree", "Embree PS", "Embree’s trees"

#: About how many seconds steps take on a large scene, of which only the ratios count.
_WEIGHTS = {
    "pictures": 2.0,
    "bvh-cl": 14.0,
    "bvh-ss": 16.0,
    "bvh-d2": 27.0,
    "kd-cl": 25.0,
    "kd-d2": 52.0,
    DEFAULT_METHOD: 5.0,
    SWEEP: 20.0,
    PEER: 15.0,
    PEER_PS: 20.0,
    PEER_TREES: 8.0,
}


def report_thesis(directory: str | os.PathLike[str], plan: Plan, *, show_progress: bool = False) -> Path:
    """Make chapter 6 of the thesis again, and write it up.

    Parameters
    ----------
    directory : str or path-like
        Made if it does not exist. What is in its folder ``steps`` and was found by the same version with the same
        settings is not made again.
    plan : Plan
        How large it is.
    show_progress : bool
        Name the step that is on, and the time left, on stderr.

    Returns
    -------
    Path
        Of ``index.html``, which holds everything. Beside it are ``report.md`` and ``report.json``.

    Raises
    ------
    FastlinesError
        If two trees answer differently, or a tree is not valid.
    """
    missing = missing_peer(plan)
    subjects = [scene_subject(name, n_segments) for name, n_segments in plan.scenes.items()]
    steps = [Step(f"§4.3: depth {depth}", 1.0, _depth(depth)) for depth in plan.depths]
    store, results = _run(directory, plan, subjects, steps, missing, show_progress)
    ours = {subject.name: _rows(subject, plan, results) for subject in subjects}
    theirs = {name: {row: thesis_row(row, THESIS[name][row]) for row in THESIS[name]} for name in ours}
    sections = [
        claims_section(ours, theirs),
        *(
            subject_section(subject, plan, results, ours[subject.name], theirs[subject.name], missing)
            for subject in subjects
        ),
        depths_section([results[step.name] for step in steps]),
        why_section(),
    ]
    lead = (
        "Chapter 6 of Ivan Kuckir’s thesis “Datové struktury pro zobrazování nepolygonální geometrie” (Prague 2013), "
        "made again: its five scenes, five trees and Embree; its own figures beside ours."
    )
    if any(plan.scenes.values()):
        lead += " This is a quick report: some scenes are smaller than the thesis’s, and so are their costs and times."
    more = {
        "claims": [{**asdict(claim), "holds": claim.holds} for claim in claims_of(ours)],
        "thesis": _to_json(theirs),
    }
    return _write(store, plan, "The thesis, side by side", lead, sections, ours, results, missing, more)


def report_lines(
    directory: str | os.PathLike[str],
    plan: Plan,
    name: str,
    lines: Lines,
    camera: Camera,
    *,
    show_progress: bool = False,
) -> Path:
    """Ask of anybody's lines which tree suits them; see `report_thesis`.

    Parameters
    ----------
    name : str
        What the report calls them.
    lines : Lines
    camera : Camera
        Whose rays are asked.
    """
    missing = missing_peer(plan)
    subject = lines_subject(name, lines, camera)
    store, results = _run(directory, plan, [subject], [], missing, show_progress)
    rows = _rows(subject, plan, results)
    sections = [answer_section(rows), subject_section(subject, plan, results, rows, {}, missing)]
    others = "ours" if missing else "ours and Embree"
    lead = f"The five trees of Ivan Kuckir’s thesis (2013), {others}: built over these lines, asked and drawn."
    return _write(store, plan, subject.title, lead, sections, {subject.name: rows}, results, missing, {})


def missing_peer(plan: Plan) -> str:
    """Say why Embree is not measured, and what to do about it; "" if it is."""
    if not plan.peer:
        return "It was left out"
    try:
        embree.load(1)
    except FastlinesError as error:
        return str(error)
    return ""


def _run(
    directory: str | os.PathLike[str],
    plan: Plan,
    subjects: list[Subject],
    steps: list[Step],
    missing: str,
    show_progress: bool,
) -> tuple[Store, Results]:
    machine = describe_machine()
    key = machine["processor"], machine["fastlines"], simd(), asdict(plan), [each.digest for each in subjects]
    store = Store(Path(directory) / STEPS, key)
    every = [step for subject in subjects for step in _steps(subject, plan, store, missing)] + steps
    return store, run_steps(every, store, show_progress)


def _steps(subject: Subject, plan: Plan, store: Store, missing: str) -> list[Step]:
    """List the work on one subject; of what is missing there is none."""
    title = subject.title
    steps = [Step(f"{title}: pictures", _WEIGHTS["pictures"], lambda results: picture_step(subject, plan, store))]
    steps += [
        Step(f"{title}: {method}", _WEIGHTS[method], _tree(subject, method, plan, store)) for method in plan.methods
    ]
    if missing:
        return steps
    cut = f"{title}: {SWEEP}"
    return [
        *steps,
        Step(cut, _WEIGHTS[SWEEP], lambda results: sweep_step(subject, plan)),
        Step(f"{title}: {PEER}", _WEIGHTS[PEER], lambda results: embree_step(subject, plan, 0.0)),
        Step(
            f"{title}: {PEER_PS}", _WEIGHTS[PEER_PS], lambda results: embree_step(subject, plan, results[cut]["best"])
        ),
        Step(
            f"{title}: {PEER_TREES}",
            _WEIGHTS[PEER_TREES],
            lambda results: embree_tree_step(subject, results[cut]["best"]),
        ),
    ]


def _tree(subject: Subject, method: str, plan: Plan, store: Store) -> Callable[[Results], Found]:
    return lambda results: tree_step(subject, method, plan, store)


def _depth(depth: int) -> Callable[[Results], Found]:
    return lambda results: time_depth(depth)


def _rows(subject: Subject, plan: Plan, results: Results) -> dict[str, Row]:
    """Collect the rows of a table."""
    found: dict[str, Found] = {method: results[f"{subject.title}: {method}"] for method in plan.methods}
    for name, step in (("embree", PEER), ("embree-ps", PEER_PS)):
        measured = results.get(f"{subject.title}: {step}")
        if measured is not None:
            found |= {name: measured | results[f"{subject.title}: {PEER_TREES}"][name], f"{name}-filter": measured}
    return {name: row_of(name, measured) for name, measured in found.items()}


def _write(
    store: Store,
    plan: Plan,
    title: str,
    lead: str,
    sections: list[Section],
    rows: Mapping[str, Mapping[str, Row]],
    results: Results,
    missing: str,
    more: Mapping[str, Any],
) -> Path:
    machine = {**describe_machine(), "threads": 1, "simd": simd(), "embree": None if missing else embree.load(1)}
    seconds = sum(found["seconds"] for found in results.values())
    n_compared = sum(found.get("n_compared", 0) for found in results.values())
    text = [
        "Everything is timed with one thread, by its processor time; the best of up to three rounds counts.",
        f"All {n_compared:,} answers that were compared are those of “{DEFAULT_METHOD}” on its wide layout, bit for "
        "bit; all trees are valid.",
    ]
    if not missing:
        text[0] += f" Of Embree {machine['embree']} its calls alone are timed."
        text[1] += " Embree’s build is one for one radius; our trees serve all three."
    method = Section("method", "How it was measured", text, points=method_points(plan.methods))
    foot = (
        f"{machine['processor']}, {machine['system']}, {machine['simd']}; fastlines {machine['fastlines']}, Python "
        f"{machine['python']}; {machine['date']}. The steps of this {plan.name} report took {seconds:.0f} s."
    )
    lead += f" Embree is missing. {missing}." if missing else ""
    document = Document(title, lead, [*sections, method], foot)
    figures = {
        "format": "fastlines report 1",
        "title": title,
        "machine": machine,
        "plan": asdict(plan),
        "missing": {"Embree": missing} if missing else {},
        "n_compared": n_compared,
        "seconds": seconds,
        "rows": _to_json(rows),
        "steps": results,
        **more,
    }
    folder = store.folder.parent
    texts = {
        "report.json": json.dumps(_finite(figures), indent=1, allow_nan=False) + "\n",
        "report.md": markdown(document, STEPS),
        "index.html": html(document, store.folder),
    }
    for file, content in texts.items():
        with atomic_write(folder / file) as partial_file:
            partial_file.write_text(content, encoding="utf-8")
    return folder / "index.html"


def _to_json(tables: Mapping[str, Mapping[str, Row]]) -> dict[str, Any]:
    return {name: {row: asdict(figures) for row, figures in rows.items()} for name, rows in tables.items()}


def _finite(value: Any) -> Any:
    """JSON has no infinity: what did not finish is "not finished"."""
    if isinstance(value, Mapping):
        return {key: _finite(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(each) for each in value]
    return "not finished" if isinstance(value, float) and math.isinf(value) else value
