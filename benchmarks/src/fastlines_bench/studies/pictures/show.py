"""Prints how long pictures take."""

from __future__ import annotations

from ...harness.tables import format_3_digits, new_table, print_table, wide_console
from .run import PicturesResult, PictureTimes


def print_pictures(result: PicturesResult) -> None:
    """Print a row for each picture."""
    console = wide_console()
    preset = result.preset
    figures = ["CPU, s", "whole, s", "first, s", "PyVista: CPU, s", "whole, s", "ours / PyVista, CPU"]
    table = new_table(f"pictures with {preset.n_threads} thread(s)", ["picture"], figures)
    for cell in result.cells:
        ratio = "" if cell.peer is None else f"{cell.ours.cpu / max(cell.peer.cpu, 1e-9):.2f}"
        peer = ["", ""] if cell.peer is None else _texts(cell.peer)[:2]
        table.add_row(cell.name, *_texts(cell.ours), *peer, ratio)
    print_table(console, table)
    console.print(
        f"Medians of {preset.rounds} round(s), each in a new process, from its start to its end: imports, reading, "
        "building and writing count. first: until the first picture is there. PyVista draws the same lines as tubes of "
        "the same size in pixels, without shadows.",
        highlight=False,
    )
    if result.missing:
        names = ", ".join(result.missing)
        console.print(f"Left out, because their files are not there (--data names their folder): {names}.")
    for why in dict.fromkeys(cell.why for cell in result.cells if cell.why):
        names = ", ".join(cell.name for cell in result.cells if cell.why == why)
        console.print(f"Without PyVista's tubes: {names}: {why}.", highlight=False)


def _texts(times: PictureTimes) -> list[str]:
    return [format_3_digits(each) for each in (times.cpu, times.seconds, times.first)]
