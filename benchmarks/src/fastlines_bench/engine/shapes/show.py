"""The tables of the benchmark of shapes."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table

from ...harness.rays import KINDS
from ...harness.tables import format_3_digits, new_table, print_table, wide_console
from .names import MOST_OF_LINES, SHAPES, Question
from .result import Result, ShapeCell

#: The sides of ours beside lines: cones and capsules.
SIDES = ("", "capsules")


def print_shapes(result: Result) -> None:
    """Print for each shape the ratios with their means and floors, then each cell, then the builds and the checks."""
    console = wide_console()
    for shape in result.preset["shapes"]:
        if not result.of(shape):
            continue
        if result.preset["peer"]:
            print_table(console, _ratios(result, shape))
        if shape == "cones":
            print_table(console, _times_of_lines(result))
        print_table(console, _details(result, shape))
        if result.preset["peer"] and SHAPES[shape].note:
            console.print(SHAPES[shape].note, highlight=False)
    print_table(console, _building(result))
    _print_checks(console, result)
    threads = result.preset["n_threads"]
    said = f"{threads} thread{'s' if threads > 1 else ''}, best of {result.preset['rounds']}. "
    if result.preset["one_by_one"]:
        said += "Each ray is traced alone. "
    if result.preset["peer"]:
        said += (
            f"Embree {result.machine['embree']}: its fastest configuration in each cell. Ratios are Embree's time "
            "divided by ours. rays differ: the share of rays whose answer differs; hits differ: the share of all hits "
            "that one side alone reports, or with another t. "
        )
    console.print(f"{said}{result.seconds:.0f} s in all.", highlight=False)
    for missing in result.missing:
        console.print(f"NOT MEASURED: {missing.shape}, {missing.scene}: {missing.why}", style="bold", highlight=False)


def _questions(result: Result, shape: str) -> list[Question]:
    return list(dict.fromkeys(cell.question for cell in result.of(shape)))


def _places(result: Result, shape: str) -> dict[tuple[str, float], dict[Question, ShapeCell]]:
    """Return the cells of each scene and radius by their question."""
    found: dict[tuple[str, float], dict[Question, ShapeCell]] = {}
    for cell in result.of(shape):
        found.setdefault((cell.cell.scene, cell.cell.radius), {})[cell.question] = cell
    return found


def _ratios(result: Result, shape: str) -> Table:
    """Return the table of ratios to Embree: a row for each scene and radius, a column for each question."""
    questions = _questions(result, shape)
    title = f"{shape}: {SHAPES[shape].title}, Embree's time divided by ours"
    table = new_table(title, ["scene"], ["radius", *(f"{kind} {query}" for kind, query in questions)])
    for (scene, radius), cells in _places(result, shape).items():
        table.add_row(scene, _radius(radius), *(f"{cells[question].cell.ratio:.2f}" for question in questions))
    floors = [SHAPES[shape].floors.get(question) for question in questions]
    table.add_section()
    table.add_row("geometric mean", "", *(_ratio(result.mean(shape, question)) for question in questions))
    table.add_row("floor", "", *(_ratio(floor) for floor in floors))
    return table


def _times_of_lines(result: Result) -> Table:
    """Return the table of our times as multiples of those of lines."""
    questions = _questions(result, "cones")
    title = "cones: our time for tapered cones / for capsules, divided by that for lines of the same radius"
    table = new_table(title, ["scene"], ["radius", *(f"{kind} {query}" for kind, query in questions)])
    for (scene, radius), cells in _places(result, "cones").items():
        pairs = ([cells[question].times_of_lines(side) for side in SIDES] for question in questions)
        table.add_row(scene, _radius(radius), *(" / ".join(map(_ratio, pair)) for pair in pairs))
    means = ([result.mean_of_lines(question, side) for side in SIDES] for question in questions)
    table.add_section()
    table.add_row("geometric mean", "", *(" / ".join(map(_ratio, pair)) for pair in means))
    table.add_row("at most", "", *(_ratio(MOST_OF_LINES) for _ in questions))
    return table


def _details(result: Result, shape: str) -> Table:
    peer = result.preset["peer"]
    heads = ["radius", "rays", "ours", *(["Embree", "ratio", "rays differ", "hits differ", "max Δt"] if peer else [])]
    title = f"{shape}: millions of rays per second"
    table = new_table(title, ["scene", "rays and query"], heads, ["Embree's configuration"] if peer else [])
    cells = result.of(shape)
    for kind in KINDS:
        for query in KINDS[kind]:
            for cell in cells:
                if cell.question == (kind, query):
                    table.add_row(*_detail_cells(cell))
    return table


def _detail_cells(of_shape: ShapeCell) -> list[str]:
    cell = of_shape.cell
    row = [cell.scene, f"{cell.kind} {cell.query}", _radius(cell.radius), f"{cell.n_rays:,}"]
    row.append(format_3_digits(cell.mrays))
    best = cell.best
    if best is None:
        return row
    difference = best.difference
    return [
        *row,
        format_3_digits(best.mrays),
        f"{cell.ratio:.2f}",
        _share(difference.share),
        _share(difference.n_hits_differ / difference.n_hits) if difference.n_hits else "–",
        f"{difference.max_dt:.0e}",
        str(best.config),
    ]


def _building(result: Result) -> Table:
    """Return the table of our builds, and of Embree's best for the last rays and query."""
    peer = result.preset["peer"]
    heads = ["radius", "shapes", "primitives", "tree s", "layout s", "ours MB"]
    heads += ["Embree s", "Embree MB"] if peer else []
    table = new_table("building: seconds and megabytes", ["shape", "scene"], heads, ["tree"])
    for built in result.built:
        row = [built.shape, built.scene, _radius(built.radius), f"{built.n_shapes:,}", f"{built.n_prims:,}"]
        row += [format_3_digits(figure) for figure in (built.build_s, built.layout_s, built.bytes / 1e6)]
        if peer:
            cells = _places(result, built.shape).get((built.scene, built.radius), {})
            side = next((cell.cell.best for cell in reversed(cells.values())), None)
            row += ["–"] * 2 if side is None else [format_3_digits(side.build_s), format_3_digits(side.bytes / 1e6)]
        table.add_row(*row, built.note)
    return table


def _print_checks(console: Console, result: Result) -> None:
    console.print("What is wanted of the means:")
    for check in result.checks():
        verdict = {True: "yes", False: "NO", None: "not measured"}[check.holds]
        bound = f"at least {check.least:g}" if check.least else f"at most {check.most:g}"
        console.print(f"  {verdict}: {check.what}: {_ratio(check.figure)}, {bound}", highlight=False)


def _radius(radius: float) -> str:
    return f"{radius:.3g}" if radius else "–"


def _ratio(ratio: float | None) -> str:
    return "–" if ratio is None else f"{ratio:.2f}"


def _share(share: float) -> str:
    return "0" if share == 0 else f"{share:.1e}"
