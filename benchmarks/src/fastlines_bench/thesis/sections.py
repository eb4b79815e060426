"""The sections of the report: tables in the form of the thesis, text and pictures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from fastlines.scenes import NAMES

from ..builders.names import THESIS_COST
from ..harness.findings import Finding
from ..harness.internals import DEFAULT_METHOD, METHOD_NOTES
from ..harness.subjects import Subject
from ..harness.tables import format_3_digits
from .depths import C_TRAV, THESIS_DEPTHS
from .document import Cell, Gallery, Picture, Section, Table
from .findings import Tables, findings_of, ratio
from .heat import COLOURS, MAX_COUNT
from .preset import ThesisPreset
from .rows import MORE_TITLES, PEERS, TIMES, TITLES, Row
from .store import Found, Results
from .trees import CHECKED
from .why import WHY

#: The rows by whose times others are divided: the first one that both the thesis and we have.
BASES = ("bvh-cl", "embree", "embree-ps", "kd-d2")
COLUMNS = {"n_prims": "primitives", "build_ms": "build, ms", "n_nodes": "nodes", "cost": "cost"} | {
    time: time[0].upper() + time[1:] for time in TIMES
}
#: A description of each scene.
SCENE_NOTES = {
    "bun-hair": "hair with a bun, finely divided",
    "straight-hair": "long hair, segments a little longer",
    "spaghetti": "long segments that join two random points on opposite sides of a cube",
    "spaghetti-2": "the same, four times as many in the thesis",
    "photon-beams": "paths of light from a point in a mirrored cube filled with a translucent medium",
}
NOT_FINISHED = "not finished"
NOTHING = "–"
_COST_NOTE = (
    "the expected cost of a random line through the scene’s box (§3): for each inner node that it hits {} in a BVH and "
    "{} in a KD tree, and 1 for each primitive in a leaf that it hits"
).format(*(f"{cost.c_trav:g}" for cost in THESIS_COST.values()))


def shown(figure: float | None, column: str) -> str:
    """Return a figure in the format of its column."""
    if figure is None:
        return NOTHING
    if figure == float("inf"):
        return NOT_FINISHED
    if column in ("n_prims", "n_nodes"):
        return f"{figure:,.0f}"
    return f"{figure:,.2f}" if column == "cost" else format_3_digits(figure)


def figures_table(name: str, rows: Mapping[str, Row], thesis: Mapping[str, Row], missing: str) -> Table:
    """Return the table of all figures of a subject, with those of the thesis below each."""
    body = []
    for tree, title in {**TITLES, **MORE_TITLES}.items():
        row, other = rows.get(tree), thesis.get(tree)
        if row is None and other is None and not (missing and tree in PEERS):
            continue
        cells = [Cell(title)]
        for column in COLUMNS:
            figure = None if row is None else row.figure(column)
            text = shown(figure, column)
            if row is not None and row.over_s is not None and column == "build_ms":
                text = f"over {row.over_s:g} s"
            if missing and tree in PEERS and column == "n_prims":
                text = "not installed"
            if row is not None and row.parts and column in row.parts:
                text += "*"
            cells.append(Cell(text, figure, "" if other is None else shown(other.figure(column), column)))
        body.append(cells)
    notes = [part_note(rows)] if any(row.parts for row in rows.values()) else []
    caption = f"Figures; below each, that of the thesis’s table 6.{NAMES.index(name) + 1}" if thesis else "Figures"
    return Table(["tree", *COLUMNS.values()], body, caption, notes)


def part_note(rows: Mapping[str, Row]) -> str:
    """Return the note with the numbers of rays of the figures with a star."""
    said = []
    for row in rows.values():
        if row.parts:
            low, high = min(row.parts.values()), max(row.parts.values())
            said.append(f"{row.title}: {low:,}" + (f" to {high:,}" if high > low else ""))
    return f"* Measured on fewer rays, every k-th of every k-th row, and scaled up: {'; '.join(said)}."


def ratios_table(rows: Mapping[str, Row], thesis: Mapping[str, Row]) -> Table | None:
    """Return the table of figures as multiples of those of one row; None if no row qualifies."""
    base = next((name for name in BASES if all(_has_times(name, side) for side in (rows, thesis) if side)), None)
    if base is None:
        return None
    bases = {column: base if column in TIMES else "bvh-cl" for column in COLUMNS if column != "n_prims"}
    body = []
    for name, title in {**TITLES, **MORE_TITLES}.items():
        if name not in rows:
            continue
        cells = [Cell(title)]
        for column, to in bases.items():
            ours, theirs = (ratio(side, column, name, to) for side in (rows, thesis))
            other = shown(theirs, "ratio") if name in thesis else ""
            cells.append(Cell(shown(ours, "ratio"), ours, other))
        body.append(cells)
    said = "All as multiples of BVH::CL’s"
    if base != "bvh-cl":
        said = f"Build, nodes and cost as multiples of BVH::CL’s, times as multiples of {TITLES[base]}’s"
    heads = ["tree", *(COLUMNS[column].replace(", ms", "") for column in bases)]
    return Table(heads, body, said + ("; the thesis’s below each" if thesis else ""))


def _has_times(name: str, rows: Mapping[str, Row]) -> bool:
    return name in rows and rows[name].ms.get("first M", float("inf")) < float("inf")


def sweep_table(found: Found) -> Table:
    """Return the table of the lengths to which segments were cut for Embree."""
    rows = [
        [
            Cell("whole" if not each["share"] else f"1/{1 / each['share']:.0f}", each["share"]),
            Cell(f"{each['n_pieces']:,}", each["n_pieces"]),
            Cell(format_3_digits(1e3 * each["build_s"]), each["build_s"]),
            *(Cell(format_3_digits(ms), ms) for ms in (each["first M"]["ms"], each["all M"]["ms"], each["mean_ms"])),
            Cell("best", good=True) if each["share"] == found["best_share"] else Cell(""),
        ]
        for each in found["lengths"]
    ]
    heads = ["length / diagonal", "pieces", "build, ms", "First M", "All M by filter", "mean", "which"]
    return Table(heads, rows, "To what length segments are cut for Embree PS")


def subject_section(
    subject: Subject,
    preset: ThesisPreset,
    results: Results,
    rows: Mapping[str, Row],
    thesis: Mapping[str, Row],
    missing: str,
) -> Section:
    """Return the section of one scene."""
    radii = ", ".join(f"{letter} = {radius:.3g}" for letter, radius in subject.by_letter.items())
    n_thesis = thesis["bvh-cl"].n_prims if thesis else None
    size = f"{len(subject.lines):,} segments: {SCENE_NOTES[subject.name]}."
    if n_thesis not in (None, len(subject.lines)):
        size += f" The thesis has {n_thesis:,}, so ratios compare only roughly."
    text = [
        size,
        f"Times are milliseconds for {preset.size}² = {preset.size**2:,} rays of a camera: First finds the nearest hit "
        f"of each, All lists all of its hits. Lines have the radius {radii}.",
    ]
    parts: list[Table | Gallery] = [depth_gallery(subject, results), figures_table(subject.name, rows, thesis, missing)]
    ratios = ratios_table(rows, thesis)
    parts += [ratios] if ratios else []
    trees = {method: results[f"{subject.title}: {method}"] for method in preset.methods}
    titles = {**TITLES, **MORE_TITLES}
    limited = [f"{titles[tree]}: {', '.join(found['limits'])}" for tree, found in trees.items() if found.get("limits")]
    text += [f"Some builds hit a limit. {'; '.join(limited)}."] if limited else []
    sweep, embree = (results.get(f"{subject.title}: {name}") for name in ("Embree’s lengths", "Embree"))
    if embree:
        differs = embree["differs"]
        text.append(
            f"Of {min(CHECKED, preset.size**2):,} rays, Embree reports another first segment than we do for "
            f"{differs['first']:.2%}, and another set of hits for {differs['all']:.2%}, because ribbons have no round "
            f"ends. Repeated first hits find {differs['repeated']:.2%} of the hits that a filter finds."
        )
    parts += [sweep_table(sweep)] if sweep else []
    parts += tree_galleries(subject, trees)
    return Section(subject.name, subject.title, text, parts)


def depth_gallery(subject: Subject, results: Results) -> Gallery:
    """Return the pictures of the subject with each radius."""
    images = results[f"{subject.title}: pictures"]["images"]
    return Gallery(
        [
            Picture(file, f"{letter} = {subject.by_letter[letter]:.3g}", f"{subject.title} with the radius {letter}")
            for letter, file in images.items()
        ],
        3,
        caption="Lighter is nearer",
    )


def tree_galleries(subject: Subject, trees: Mapping[str, Found]) -> list[Gallery]:
    """Return the heat maps of each tree, and the levels of some."""
    galleries = []
    titles = {**TITLES, **MORE_TITLES}
    for what, words in (("nodes", "nodes visited"), ("tests", "primitives tested")):
        pictures = [
            Picture(
                found["images"][what],
                f"{titles[method].split(',')[0]}: {format_3_digits(found['visits'][what])}",
                f"{subject.title}: {words} in each pixel by {titles[method]}",
            )
            for method, found in trees.items()
            if "images" in found
        ]
        caption = f"{words.capitalize()} by the ray of each pixel, all hits, radius M; with the mean."
        galleries.append(Gallery(pictures, 6, caption=caption, scale=(COLOURS.tolist(), MAX_COUNT)))
    sheets = [
        Picture(
            found["images"]["levels"], titles[method], f"{subject.title}: boxes of the first levels of {titles[method]}"
        )
        for method, found in trees.items()
        if "levels" in found.get("images", {})
    ]
    return [*galleries, Gallery(sheets, 3, 300, caption="The first levels of the trees")]


def findings_section(ours: Tables, thesis: Tables) -> Section:
    """Return the section of the thesis's findings, and whether they hold in our tables and in its own."""
    mine, theirs = findings_of(ours), findings_of(thesis)
    verdicts = [
        [Cell(finding.text), _verdict(finding), _verdict(other)] for finding, other in zip(mine, theirs, strict=True)
    ]
    figures = [
        [
            Cell(check.what),
            Cell(shown(check.figure, "ratio"), check.figure, good=check.holds),
            Cell(shown(other.figure, "ratio"), other.figure, good=other.holds),
            Cell(
                f"≤ {check.most:.3g}"
                if check.least == 0
                else f"≥ {check.least:.3g}"
                if check.most == float("inf")
                else f"{check.least:.3g} to {check.most:.3g}"
            ),
        ]
        for finding, reference in zip(mine, theirs, strict=True)
        for check, other in zip(finding.checks, reference.checks, strict=True)
    ]
    n_held = sum(finding.holds is True for finding in mine)
    return Section(
        "findings",
        "What the thesis found",
        [
            f"{n_held} of its {len(mine)} findings hold in our tables. A tree counts as collapsed if it costs more "
            "than three times as much as the D2 tree of its kind; Embree counts as collapsed if its cost and the time "
            "of its first hits are more than three times those with segments cut. About half means up to 0.6."
        ],
        [
            Table(["finding", "in our tables", "in the thesis’s"], verdicts),
            Table(["figure", "ours", "the thesis’s", "expected"], figures, "The figures of the findings"),
        ],
    )


def _verdict(finding: Finding) -> Cell:
    words = {True: "holds", False: "does not hold", None: "not measured"}
    return Cell(words[finding.holds], {True: 2.0, None: 1.0, False: 0.0}[finding.holds], good=finding.holds)


def depths_section(found: Sequence[Found]) -> Section:
    """Return the section of the table of thesis §4.3."""
    rows = []
    for row in found:
        cost, ms = THESIS_DEPTHS[row["depth"]]
        rows.append(
            [
                Cell(str(row["depth"]), row["depth"]),
                Cell(f"{row['cost']:.1f}", row["cost"], f"{cost:.1f}"),
                Cell(f"{row['n_nodes']:,}", row["n_nodes"]),
                Cell(format_3_digits(row["exhaustive_ms"]), row["exhaustive_ms"], format_3_digits(ms)),
                Cell(format_3_digits(row["build_ms"]), row["build_ms"]),
            ]
        )
    text = (
        "100 thin cylinders of length 1 in a cube of side 4; a KD tree, 16 planes an axis, c_prim = 1, c_trav = "
        f"{C_TRAV}. The thesis evaluated all candidates; branch and bound finds the same tree."
    )
    heads = ["depth", "cost", "nodes", "exhaustive, ms", "branch and bound, ms"]
    return Section("depths", "Lookahead (§4.3)", [text], [Table(heads, rows, "The thesis’s below ours")])


def why_section() -> Section:
    """Return the section of the reasons for differences."""
    return Section("why", "Where our figures differ, and why", points=WHY)


def method_section(methods: Sequence[str], n_compared: int, embree: object) -> Section:
    """Return the section of the method of measurement; `embree` is the version of Embree, or None."""
    text = [
        "Everything is timed on one thread, by its processor time; the fastest of up to three rounds counts.",
        f"All {n_compared:,} compared answers are the same as those of “{DEFAULT_METHOD}” on its wide layout, bit for "
        "bit; all trees are valid.",
    ]
    if embree:
        text[0] += f" Of Embree {embree}, only the calls are timed."
        text[1] += " Embree builds a scene for each radius; our trees serve all three."
    return Section("method", "How the figures were measured", text, points=method_points(methods))


def method_points(methods: Sequence[str]) -> tuple[tuple[str, str], ...]:
    """Return explanations of the rows and of some columns."""
    titles = {**TITLES, **MORE_TITLES}
    more = (
        (
            "Embree",
            "two triangles per segment, facing the camera, built for each radius; all hits by repeated first hits",
        ),
        ("Embree PS", "the same, with segments cut to the length at which it is best"),
        (
            "by filter",
            "all hits of the same scenes in one pass: a filter records each hit and lets the traversal continue",
        ),
        ("nodes", "the inner nodes and leaves of the binary tree"),
        ("cost", _COST_NOTE),
    )
    return (*((titles[method], _titled(METHOD_NOTES[method])) for method in methods), *more)


def _titled(note: str) -> str:
    """Return a note with the trees' names of the tables."""
    for name, title in TITLES.items():
        note = note.replace(f"as {name};", f"as {title};")
    return note
