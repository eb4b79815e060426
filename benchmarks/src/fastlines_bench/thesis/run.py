"""Repeat the chapter: run the steps, compile tables and findings, and write HTML, Markdown and JSON."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from fastlines import FastlinesError

from ..harness import machine
from ..harness.internals import DEFAULT_METHOD, atomic_write
from ..harness.subjects import Subject, scene_subject
from ..peers import embree
from .depths import time_depth
from .document import Document, html
from .findings import findings_of
from .markdown import markdown
from .peer import embree_step, embree_tree_step, sweep_step
from .preset import ThesisPreset
from .reference import THESIS
from .rows import Row, row_of, thesis_row
from .sections import depths_section, findings_section, method_section, subject_section, why_section
from .store import Found, Results, Step, Store, run_steps
from .trees import picture_step, tree_step

#: The folder of steps and pictures next to the page.
STEPS = "steps"
TITLE = "The thesis, side by side"
SWEEP, PEER, PEER_PS, PEER_TREES = "Embree’s lengths", "Embree", "Embree PS", "Embree’s trees"

#: The approximate seconds of steps on a large scene; only their ratios matter.
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


def make_thesis(directory: str | os.PathLike[str], preset: ThesisPreset, *, show_progress: bool = False) -> Path:
    """Repeat chapter 6 of the thesis and write a report.

    Parameters
    ----------
    directory : str or path-like
        Created if it does not exist. Results in its folder ``steps`` are reused if they are of the same version and
        settings.
    preset : ThesisPreset
        The size of the report.
    show_progress : bool
        Show the current step and the time left on stderr.

    Returns
    -------
    Path
        The path of ``index.html``, which contains everything. Next to it are ``report.md`` and ``report.json``.

    Raises
    ------
    FastlinesError
        If two trees answer differently, or a tree is not valid.
    """
    missing = missing_peer(preset)
    where = machine.describe(threads=1, embree=None if missing else embree.load(1))
    subjects = [scene_subject(name, n_segments) for name, n_segments in preset.scenes.items()]

    # Run the steps without a stored result.
    names = ("processor", "fastlines", "simd")
    key = [where[name] for name in names], asdict(preset), [each.digest for each in subjects]
    store = Store(Path(directory) / STEPS, key)
    depths = [Step(f"§4.3: depth {depth}", 1.0, _depth(depth)) for depth in preset.depths]
    steps = [step for subject in subjects for step in _steps(subject, preset, store, missing)] + depths
    results = run_steps(steps, store, show_progress)

    # Compile the tables.
    ours = {subject.name: _rows(subject, preset, results) for subject in subjects}
    theirs = {name: {row: thesis_row(row, THESIS[name][row]) for row in THESIS[name]} for name in ours}
    seconds = sum(found["seconds"] for found in results.values())
    n_compared = sum(found.get("n_compared", 0) for found in results.values())
    sections = [
        findings_section(ours, theirs),
        *(
            subject_section(subject, preset, results, ours[subject.name], theirs[subject.name], missing)
            for subject in subjects
        ),
        depths_section([results[step.name] for step in depths]),
        why_section(),
        method_section(preset.methods, n_compared, where["embree"]),
    ]
    document = Document(TITLE, _lead(preset, missing), sections, _foot(where, preset, seconds))
    figures = {
        "format": "fastlines-bench thesis 1",
        "title": TITLE,
        "machine": where,
        "preset": asdict(preset),
        "missing": {"Embree": missing} if missing else {},
        "n_compared": n_compared,
        "seconds": seconds,
        "rows": _to_json(ours),
        "steps": results,
        "findings": [
            {"text": each.text, "holds": each.holds, "checks": [check.to_json() for check in each.checks]}
            for each in findings_of(ours)
        ],
        "thesis": _to_json(theirs),
    }

    # Write the report.
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


def _lead(preset: ThesisPreset, missing: str) -> str:
    lead = (
        "Chapter 6 of Ivan Kuckir’s thesis “Datové struktury pro zobrazování nepolygonální geometrie” (Prague 2013), "
        "repeated: its five scenes, five trees and Embree, with its own figures next to ours."
    )
    if any(preset.scenes.values()):
        lead += " This is a quick report: some scenes are smaller than the thesis’s, and so are their costs and times."
    return lead + (f" Embree is missing. {missing}." if missing else "")


def _foot(where: Mapping[str, Any], preset: ThesisPreset, seconds: float) -> str:
    return (
        f"{where['processor']}, {where['system']}, {where['simd']}; fastlines {where['fastlines']}, Python "
        f"{where['python']}; {where['date']}. The steps of this {preset.name} report took {seconds:.0f} s."
    )


def missing_peer(preset: ThesisPreset) -> str:
    """Return why Embree is not measured and what to do about it; "" if it is measured."""
    if not preset.peer:
        return "It was left out"
    try:
        embree.load(1)
    except FastlinesError as error:
        return str(error)
    return ""


def _steps(subject: Subject, preset: ThesisPreset, store: Store, missing: str) -> list[Step]:
    """Return the steps of one subject, without those of Embree if it is missing."""
    title = subject.title
    steps = [Step(f"{title}: pictures", _WEIGHTS["pictures"], lambda results: picture_step(subject, preset, store))]
    steps += [
        Step(f"{title}: {method}", _WEIGHTS[method], _tree(subject, method, preset, store)) for method in preset.methods
    ]
    if missing:
        return steps
    cut = f"{title}: {SWEEP}"
    return [
        *steps,
        Step(cut, _WEIGHTS[SWEEP], lambda results: sweep_step(subject, preset)),
        Step(f"{title}: {PEER}", _WEIGHTS[PEER], lambda results: embree_step(subject, preset, 0.0)),
        Step(
            f"{title}: {PEER_PS}", _WEIGHTS[PEER_PS], lambda results: embree_step(subject, preset, results[cut]["best"])
        ),
        Step(
            f"{title}: {PEER_TREES}",
            _WEIGHTS[PEER_TREES],
            lambda results: embree_tree_step(subject, results[cut]["best"]),
        ),
    ]


def _tree(subject: Subject, method: str, preset: ThesisPreset, store: Store) -> Callable[[Results], Found]:
    return lambda results: tree_step(subject, method, preset, store)


def _depth(depth: int) -> Callable[[Results], Found]:
    return lambda results: time_depth(depth)


def _rows(subject: Subject, preset: ThesisPreset, results: Results) -> dict[str, Row]:
    """Return the rows of a table."""
    found: dict[str, Found] = {method: results[f"{subject.title}: {method}"] for method in preset.methods}
    for name, step in (("embree", PEER), ("embree-ps", PEER_PS)):
        measured = results.get(f"{subject.title}: {step}")
        if measured is not None:
            found |= {name: measured | results[f"{subject.title}: {PEER_TREES}"][name], f"{name}-filter": measured}
    return {name: row_of(name, measured) for name, measured in found.items()}


def _to_json(tables: Mapping[str, Mapping[str, Row]]) -> dict[str, Any]:
    return {name: {row: asdict(figures) for row, figures in rows.items()} for name, rows in tables.items()}


def _finite(value: Any) -> Any:
    """Return a value with "not finished" instead of infinity, which JSON lacks."""
    if isinstance(value, Mapping):
        return {key: _finite(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(each) for each in value]
    return "not finished" if isinstance(value, float) and math.isinf(value) else value
