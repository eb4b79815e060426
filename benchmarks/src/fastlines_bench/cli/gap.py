"""``fastlines-bench gap``: how far builders are from the optimum."""

from __future__ import annotations

from ..studies.optimum.gap import GapPreset, run_gap
from ..studies.optimum.show import draw_gap, print_gaps
from .app import app
from .options import JsonFile, PlotFile, Quick, check_files, progress_bar, write_json, write_plot


@app.command(short_help="How far builders are from the optimum, on tiny inputs.")
def gap(quick: Quick = False, json_file: JsonFile = None, plot: PlotFile = None) -> None:
    """Compare the trees of builders with the optimum, which dynamic programming finds for tiny inputs.

    Searches choose from the same planes as the optimum, so that a gap is due to the search alone. Builders without
    spatial splits are compared with the best classic BVH, and the core's builders with the best tree over a grid of
    planes.

    [bold]Examples[/]

    [cyan]fastlines-bench gap --quick[/]

    [cyan]fastlines-bench gap --json gap.json --plot gap.png[/]  some minutes
    """
    check_files(json_file, plot)
    with progress_bar() as progress:
        gaps = run_gap(GapPreset.of(quick), progress)
    print_gaps(gaps)
    write_json(json_file, gaps.to_json())
    write_plot(plot, draw_gap, gaps)
