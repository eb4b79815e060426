"""The application to which all commands belong."""

from __future__ import annotations

import typer

from ..harness.internals import Group

app = typer.Typer(
    cls=Group,
    add_completion=False,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


@app.callback(invoke_without_command=True)
def root(context: typer.Context) -> None:
    """Benchmark fastlines: queries against Embree, builders, another version of itself, and chapter 6 of the thesis.

    [bold]Examples[/]

    [cyan]fastlines-bench engine --quick[/]

    [cyan]fastlines-bench builders --quick[/]

    [cyan]fastlines-bench thesis --quick[/]
    """
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())


def main() -> None:
    """Run the command line: the entry point ``fastlines-bench``."""
    app(prog_name="fastlines-bench")
