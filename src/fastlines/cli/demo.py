"""``fastlines demo`` and ``fastlines report``: pages about trees over the five scenes, or over lines from a file."""

from __future__ import annotations

from typing import Annotated

import typer
from typer import Option

from ..errors import InputError
from .options import FormatName, FormatOptions, Input, Skip, refuse_given


def demo(
    source: Annotated[
        str | None,
        typer.Argument(
            metavar="INPUT",
            help="A file of lines, a tree (.flt) or a scene (scene:NAME); the five scenes by default.",
        ),
    ] = None,
    quick: Annotated[bool, Option("--quick", help="Use smaller scenes and fewer rays: under a minute.")] = False,
    output: Annotated[
        str, Option("--output", "-o", metavar="FOLDER", help="Write the page and its pictures to this folder.")
    ] = "fastlines-demo",
    skip_invalid: Skip = False,
    format: FormatName = None,
    option: FormatOptions = None,
) -> None:
    """Build all named trees, the five of the thesis among them, query and draw them, and write a page of the results.

    All trees must give the same answers, bit for bit.

    [bold]Examples[/]

    [cyan]fastlines demo --quick[/]

    [cyan]fastlines demo -o results[/]  takes some minutes

    [cyan]fastlines demo hair.tfx -o hair[/]  compares trees over your lines
    """
    _write_page(source, output, quick, skip_invalid, format, option, answer=False)


def report(
    source: Input,
    output: Annotated[
        str, Option("--output", "-o", metavar="FOLDER", help="Write the page to this folder.")
    ] = "fastlines-report",
    quick: Annotated[bool, Option("--quick", help="Use fewer rays and smaller pictures.")] = False,
    skip_invalid: Skip = False,
    format: FormatName = None,
    option: FormatOptions = None,
) -> None:
    """Build all named trees over your lines, and report which one suits them.

    [bold]Examples[/]

    [cyan]fastlines report hair.tfx -o hair-report[/]

    [cyan]fastlines report scene:bun-hair --quick[/]
    """
    if source == "thesis":
        raise InputError(
            "another command makes the thesis's chapter 6: in a checkout of the repository, run  "
            "pip install ./benchmarks  and then  fastlines-bench thesis"
        )
    _write_page(source, output, quick, skip_invalid, format, option, answer=True)


def _write_page(
    source: str | None,
    output: str,
    quick: bool,
    skip_invalid: bool,
    format: str | None,
    option: list[str] | None,
    *,
    answer: bool,
) -> None:
    """Compare trees over an input, or over the five scenes without one."""
    from ..report import FULL, QUICK, demo_page, report_page
    from .files import open_lines, show_progress

    preset, bar = QUICK if quick else FULL, show_progress()
    if source is None:
        refuse_given({"--format": format, "--option": option or None}, "the five scenes are not files")
        page = demo_page(output, preset, show_progress=bar)
    else:
        opened = open_lines(source, skip_invalid, format, option)
        lines, camera = opened.lines, opened.camera()
        page = report_page(output, preset, opened.name, lines, camera, answer=answer, show_progress=bar)
    typer.echo(f"the page is {page}")
