"""The tables of the times of steps, and of the rank correlations of figures with query times."""

from __future__ import annotations

from rich.table import Table

from ..harness.rays import QUESTIONS
from ..harness.tables import format_3_digits, new_table, print_table, wide_console
from .calibrate import Calibration
from .predict import PREDICTORS, Correlation


def print_calibration(calibration: Calibration) -> None:
    """Print the times of steps, then the rank correlations."""
    console = wide_console()
    preset = calibration.preset
    if calibration.samples:
        print_table(console, _fits(calibration))
        for name, ratio in calibration.c_trav().items():
            said = "unknown: the fit gives no time to tests" if ratio is None else f"{ratio:.2f}"
            console.print(f"c_trav/c_prim, {name}: {said}", highlight=False)
        for rank, title in (("spearman", "Spearman's ρ"), ("kendall", "Kendall's τ")):
            print_table(console, _correlations(calibration, rank, title))
    for scene, builder in calibration.over:
        console.print(f"{scene}: {builder} did not end within {preset.limit:g} s and is left out", highlight=False)
    notes = "; ".join(f"{name}: {note}" for name, note in PREDICTORS.items())
    mix = calibration.mix()
    console.print(
        f"One thread, {calibration.machine['simd']}. binary: the traversal of the binary tree, random rays, all hits; "
        "its tests are the references in the leaves that are hit. "
        f"{notes} (α = {mix.alpha:g}, fitted to these figures). "
        "Scenes, all: the geometric mean of the four query times; then each query alone, over all scenes. regret: how "
        "much slower the tree with the lowest figure is than the fastest, mean over the scenes. "
        f"{calibration.seconds:.0f} s in all.",
        highlight=False,
    )


def _fits(calibration: Calibration) -> Table:
    fits = calibration.fits()
    steps = list(dict.fromkeys(step for fit in fits for step in fit.ns))
    table = new_table("what a step takes: nanoseconds, fitted", [""], [*steps, "trees", "error", "worst"])
    for fit in fits:
        cells = [format_3_digits(fit.ns[step]) if fit.ns.get(step) else "–" for step in steps]
        table.add_row(fit.what, *cells, f"{fit.n}", f"{fit.error:.0%}", f"{fit.worst:.0%}")
    return table


def _correlations(calibration: Calibration, rank: str, title: str) -> Table:
    predictors = calibration.predictors()
    questions = ["\n".join(question) for question in QUESTIONS]
    scenes = [scene.replace("-", "-\n").replace(":", "\n") for scene in predictors[0].scenes]
    table = new_table(f"{title} with query times", [""], [*scenes, "all", *questions, "regret"])

    def cell(correlation: Correlation) -> str:
        value = getattr(correlation, rank)
        return "–" if value is None else f"{value:.2f}"

    for predictor in predictors:
        found = [*predictor.scenes.values(), predictor.overall, *predictor.questions.values()]
        table.add_row(predictor.name, *map(cell, found), f"{predictor.regret:.1%}")
    return table
