"""``index.html``: everything that the demonstration found, as a page that needs nothing but its own folder."""

from __future__ import annotations

from html import escape
from importlib import resources
from pathlib import Path

from ..methods import METHOD_NOTES
from ..scenes import RADII
from .result import QUERIES, Result, Row, SceneResult
from .tables import limits_note, mrays, ms, part_note, tree_cells

#: What each scene is, in a line.
SCENE_NOTES = {
    "bun-hair": "hair with a bun, finely divided",
    "straight-hair": "long hair, segments a little longer",
    "spaghetti": "long segments that join two random points on opposite sides of a cube",
    "spaghetti-2": "the same, four times as many in the thesis",
    "photon-beams": "paths of light from a point in a mirrored cube filled with a translucent medium",
}


def write_page(folder: Path, result: Result) -> Path:
    """Write ``index.html`` to a folder that has the images already."""
    style = (resources.files(__package__) / "page.css").read_text(encoding="utf-8")
    sections = "\n".join(_section(scene, result) for scene in result.scenes)
    links = " · ".join(f'<a href="#{escape(scene.name)}">{escape(scene.title)}</a>' for scene in result.scenes)
    page = folder / "index.html"
    page.write_text(
        f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>fastlines: five trees over five scenes</title>
<style>
{style}</style>
</head>
<body>
<main>
<header>
<h1>Five trees over five scenes</h1>
<p class="lead">What Ivan Kuckir’s thesis
<cite lang="cs">Datové struktury pro zobrazování nepolygonální geometrie</cite> (Prague 2013)
tried on lines, done again by fastlines {escape(str(result.machine["fastlines"]))}.</p>
{_verdicts(result)}
<nav>{links}</nav>
</header>
{_legend(result)}
{sections}
<footer>{_footer(result)}</footer>
</main>
</body>
</html>
""",
        encoding="utf-8",
    )
    return page


def _verdicts(result: Result) -> str:
    agree = "✓ Answers agree: yes" if result.answers_agree else "Answers agree: not compared"
    verdicts = {
        agree: f"{result.n_compared:,} answers of one tree equal those of another, bit for bit",
        f"✓ Valid trees: {len(result.rows)} of {len(result.rows)}": "axioms 1 to 5, the BVH or KD axiom, Theorem 4",
        "✓ f = g: yes": f"Theorem 1 holds; both sums differ by {result.largest_difference:.0e} at most",
    }
    items = "".join(
        f"<li><strong>{escape(what)}</strong><span>{escape(why)}</span></li>" for what, why in verdicts.items()
    )
    return f'<ul class="verdicts">{items}</ul>'


def _legend(result: Result) -> str:
    methods = "".join(
        f"<dt>{escape(name)}</dt><dd>{escape(METHOD_NOTES.get(name, ''))}</dd>" for name in result.plan.methods
    )
    radii = ", ".join(f"<b>{name}</b> = {value:g}" for name, value in RADII.items())
    rays = result.plan.rays
    return f"""<section class="legend">
<dl>{methods}</dl>
<p>The <b>cost</b> is the thesis’s (§3.3): what a random line through the scene is expected to meet, with
c_prim = 1, and c_trav = 2 for a BVH, 0.6 for a KD tree. Times are for {rays} × {rays} = {rays**2:,} camera rays:
milliseconds, and below them millions of rays a second (a longer bar is faster).
<b>First</b> finds the nearest line, <b>All</b> lists every
line that is hit. Lines have the radius {radii}; no tree is built again for another radius.</p>
</section>"""


def _section(scene: SceneResult, result: Result) -> str:
    pictures = "".join(
        _figure(file, f"{scene.title} with the radius {radius}", f"{radius} = {RADII[radius]:g}", result.plan.picture)
        for radius, file in scene.pictures.items()
    )
    sheets = "".join(
        _figure(file, f"{scene.title}: boxes of the first levels of {method}", f"The first levels of {method}", None)
        for method, file in scene.sheets.items()
    )
    same = scene.n_segments == scene.n_thesis
    size = f"{scene.n_segments:,} segments" + ("" if same else f" (the thesis’s costs are for {scene.n_thesis:,})")
    notes = [note for note in (part_note(scene), limits_note(scene)) if note]
    return f"""<section id="{escape(scene.name)}">
<h2>{escape(scene.title)}</h2>
<p>{size}: {escape(SCENE_NOTES.get(scene.name, ""))}.</p>
<div class="pictures">{pictures}</div>
{_trees_table(scene)}
{_queries_table(scene)}
{"".join(f'<p class="note">{escape(note)}</p>' for note in notes)}
<div class="sheets">{sheets}</div>
</section>"""


def _trees_table(scene: SceneResult) -> str:
    heads = ["primitives", "references", "nodes", "depth", "cost", "thesis’s cost", "build, s"]
    rows = "".join(_row(row, [f"<td>{cell}</td>" for cell in tree_cells(row)]) for row in scene.rows)
    return _table("".join(f"<th>{head}</th>" for head in heads), rows)


def _queries_table(scene: SceneResult) -> str:
    best = {query: max(row.timings[query].mrays for row in scene.rows) for query in QUERIES}
    rows = ""
    for row in scene.rows:
        cells = []
        for query in QUERIES:
            timing = row.timings[query]
            share = 100 * timing.mrays / best[query]
            figures = f"{escape(ms(timing))}<small>{escape(mrays(timing))}</small>"
            cells.append(f'<td class="bar" style="--share:{share:.0f}%">{figures}</td>')
        rows += _row(row, cells)
    heads = "".join(f"<th>{kind.capitalize()} {radius}</th>" for kind, radius in QUERIES)
    return _table(heads, rows)


def _table(heads: str, rows: str) -> str:
    return f'<div class="scroll"><table><thead><tr><th>tree</th>{heads}</tr></thead><tbody>{rows}</tbody></table></div>'


def _row(row: Row, cells: list[str]) -> str:
    return f"<tr><th>{escape(row.method)}</th>{''.join(cells)}</tr>"


def _figure(file: str, alt: str, caption: str, size: int | None) -> str:
    shape = f' width="{size}" height="{size}"' if size else ""
    return (
        f'<figure><a href="{escape(file)}"><img src="{escape(file)}" alt="{escape(alt)}"{shape} loading="lazy"></a>'
        f"<figcaption>{escape(caption)}</figcaption></figure>"
    )


def _footer(result: Result) -> str:
    machine = result.machine
    again = "fastlines demo --quick" if result.plan.name == "quick" else "fastlines demo"
    return (
        f"<p>{escape(str(machine['processor']))}, {machine['threads']} threads, {escape(str(machine['system']))}; "
        f"Python {machine['python']}, NumPy {machine['numpy']}; {machine['date']}. "
        f"The {escape(result.plan.name)} run took {result.seconds:.0f} s; <code>{again}</code> makes it again. "
        '<a href="table.md">table.md</a> and <a href="table.json">table.json</a> have all figures.</p>'
    )
