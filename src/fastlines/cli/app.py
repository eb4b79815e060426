"""The application to which the commands belong, and its errors.

A run that fails prints one sentence on stderr. The exit codes are 0 for success, 1 if the work cannot be done, and 2
for a wrong command line. A bug in fastlines gives 70, Ctrl-C 130, and a closed output 141.
"""

from __future__ import annotations

import contextlib
import inspect
import os
import re
import shutil
import sys
import warnings
from collections.abc import Mapping
from importlib import import_module
from typing import Annotated, Any

import typer
from rich.text import Text
from typer import Option
from typer.core import TyperCommand, TyperGroup

from ..errors import FastlinesError
from ..support import library

#: The environment variable that makes errors show their traceback.
DEBUG = "FASTLINES_DEBUG"


#: The commands in the order of the help: the module that has the function of that name, and what it does. A module is
#: imported when its command runs.
COMMANDS: dict[str, tuple[str, str]] = {
    "demo": ("demo", "Compare trees over five scenes, or your lines, in a page of figures and pictures."),
    "report": ("demo", "Find which tree suits your lines."),
    "scene": ("build", "Make one of the five scenes of the thesis."),
    "build": ("build", "Build a tree and save it in a file."),
    "info": ("info", "Describe a file of lines or a tree, or the installation."),
    "validate": ("info", "Check that a tree satisfies the axioms of the thesis."),
    "convert": ("convert", "Write lines in another format."),
    "query": ("query", "Find what rays hit."),
    "nearest": ("nearest", "Find the line nearest to each point."),
    "within": ("nearest", "Find the lines within a distance of each point."),
    "pairs": ("pairs", "Find the lines that come near each other."),
    "render": ("render", "Render lines: hair, fibres, tubes; or draw the levels of a tree."),
    "view": ("view", "Show a tree in the browser: its lines, its boxes, and the way of a ray through it."),
    "draw": ("draw", "Draw a tree: its boxes, planes, cost, work and leaves."),
    "beams": ("beams", "Render light in fog, from photon beams."),
}

#: The groups of commands, what each is about, and its commands as in `COMMANDS`.
GROUPS: dict[str, tuple[str, dict[str, tuple[str, str]]]] = {
    "forest": (
        "Build and query forests: trees over lines that do not fit into memory.",
        {
            "build": ("forest", "Build a forest in a folder; a second call goes on where the first has ended."),
            "info": ("forest", "Describe a forest and its tiles."),
            "verify": ("forest", "Check every file of a forest."),
            "query": ("query", "Find what rays hit, as 'fastlines query' does."),
            "nearest": ("nearest", "Find the line nearest to each point, as 'fastlines nearest' does."),
            "within": ("nearest", "Find the lines within a distance of each point, as 'fastlines within' does."),
            "pairs": ("pairs", "Find the lines that come near each other, as 'fastlines pairs' does."),
            "render": ("render", "Render a picture, as 'fastlines render' does."),
        },
    ),
}

#: What begins with a minus and is not an option: three numbers, such as -1,2,3.
NEGATIVE = re.compile(r"-[.\d][^,]*,[^,]+,[^,]+")

#: The least number of columns for help in tables.
WIDE = 100

#: Settings of the application, and of each command.
TYPER: dict[str, Any] = {
    "add_completion": False,
    "rich_markup_mode": "rich",
    "pretty_exceptions_enable": False,
    "context_settings": {"help_option_names": ["-h", "--help"]},
}


class EndedError(Exception):
    """Wraps the error that ended a command, so that typer does not replace it."""


class Group(TyperGroup):
    """The group of all commands; an error in a command becomes a sentence and an exit code."""

    def invoke(self, ctx: Any) -> Any:
        """Run a command."""
        try:
            return super().invoke(ctx)
        except (KeyboardInterrupt, OSError) as error:
            raise EndedError from error

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return a command by its name."""
        found = super().get_command(ctx, cmd_name)
        return found if found is None or isinstance(found, LazyCommand | TyperGroup) else fitted(found)

    def main(self, *args: Any, **extra: Any) -> Any:
        """Run a command and exit, or return its exit code."""
        standalone = extra.pop("standalone_mode", True)
        try:
            with warnings.catch_warnings():
                warnings.showwarning = warn
                code = super().main(*args, **{**extra, "standalone_mode": False}) or 0
            sys.stdout.flush()
        except (Exception, KeyboardInterrupt) as error:
            if os.environ.get(DEBUG):
                raise
            code, sentence = explain(error.__cause__ or error if isinstance(error, EndedError) else error)
            drop_output()
            if sentence:
                typer.echo(sentence, err=True)
        if standalone:
            sys.exit(code)
        return code


class LazyCommand(TyperCommand):
    """A command whose module is imported when it runs."""

    def __init__(self, name: str, module: str, short_help: str) -> None:
        super().__init__(name, short_help=short_help, rich_markup_mode="rich")
        self.module = module

    def make_context(self, info_name: str | None, args: list[str], *more: Any, **extra: Any) -> Any:
        """Parse the arguments of the command."""
        # A space before a negative number keeps it from being read as options.
        args = [f" {arg}" if NEGATIVE.fullmatch(arg) else arg for arg in args]
        assert self.name
        module = import_module(f".{self.module}", __package__)
        alone = typer.Typer(**TYPER)
        alone.command(self.name)(getattr(module, self.name))
        return fitted(typer.main.get_command(alone)).make_context(info_name, args, *more, **extra)


class LazyGroup(Group):
    """A group of commands whose modules are imported when they run."""

    def __init__(self, table: Mapping[str, tuple[str, str]] = COMMANDS, **extra: Any) -> None:
        super().__init__(**extra)
        for name, (module, short_help) in table.items():
            self.commands[name] = LazyCommand(name, module, short_help)


class Root(LazyGroup):
    """The group of `COMMANDS`, and of the `GROUPS`."""

    def __init__(self, **extra: Any) -> None:
        super().__init__(**extra)
        for name, (about, table) in GROUPS.items():
            group = LazyGroup(table, name=name, help=about, short_help=about, no_args_is_help=True)
            group.rich_markup_mode = "rich"
            group.context_settings = TYPER["context_settings"]
            self.commands[name] = group


def fitted(command: Any) -> Any:
    """Return a command whose help fits the terminal."""
    command.help = paragraphs(command.help or "")
    if shutil.get_terminal_size().columns < WIDE:
        # Rich leaves a few columns to the texts of options: write them without its tables.
        command.rich_markup_mode = None
        command.help = Text.from_markup(command.help).plain
    return command


def paragraphs(text: str) -> str:
    """Return a docstring with a line for each paragraph, so that help wraps at the width of the terminal.

    Examples
    --------
    >>> paragraphs("One" + chr(10) + "    and two." + 2 * chr(10) + "    Three.").splitlines()
    ['One and two.', '', 'Three.']
    """
    return "\n\n".join(" ".join(part.splitlines()) for part in inspect.cleandoc(text).split("\n\n"))


def warn(message: Warning | str, *_: Any, **__: Any) -> None:
    """Print a warning as one line on stderr."""
    typer.echo(f"warning: {' '.join(str(message).split())}", err=True)


def drop_output() -> None:
    """Drop output that cannot be written, or Python fails once more when it flushes it at exit."""
    try:
        sys.stdout.flush()
    except (OSError, ValueError):
        with contextlib.suppress(OSError, ValueError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def explain(error: BaseException) -> tuple[int, str]:
    """Turn an error into an exit code and one line."""
    code, text = 1, str(error)
    if isinstance(error, KeyboardInterrupt | typer.Abort):
        return 130, "stopped"
    if isinstance(error, BrokenPipeError):
        return 141, ""  # nobody reads the output
    if isinstance(error, MemoryError) and "fit into memory" not in text:
        text = "there is not enough memory for this; try fewer lines, rays, points or pixels, or a smaller radius"
    elif isinstance(error, OSError):
        text = ": ".join(str(part) for part in (error.filename, error.strerror or error) if part)
    elif hasattr(error, "format_message"):  # a wrong command line, from typer
        code, text = 2, error.format_message()
        context = getattr(error, "ctx", None)
        if context is not None:
            text = f"{text.rstrip('.')}; see {context.command_path} --help"
    elif not isinstance(error, FastlinesError | MemoryError):
        code = 70
        text = f"this is a bug in fastlines, please report it: {type(error).__name__}: {error} ({DEBUG}=1 shows more)"
    return code, "error: " + " ".join(text.split())


app = typer.Typer(cls=Root, **TYPER)


def _version(wanted: bool) -> None:
    if wanted:
        from .. import __version__

        typer.echo(f"fastlines {__version__}")
        raise typer.Exit


#: The panel of the options that are for C++ programs.
_CPP = "For C++ and C programs"


@app.callback(invoke_without_command=True)
def root(
    context: typer.Context,
    version: Annotated[
        bool, Option("--version", callback=_version, is_eager=True, help="Show the version and exit.")
    ] = False,
    cflags: Annotated[bool, Option("--cflags", help="Print the flags to compile with.", rich_help_panel=_CPP)] = False,
    libs: Annotated[bool, Option("--libs", help="Print the flags to link with.", rich_help_panel=_CPP)] = False,
    includedir: Annotated[
        bool, Option("--includedir", help="Print the folder of the headers.", rich_help_panel=_CPP)
    ] = False,
    libdir: Annotated[bool, Option("--libdir", help="Print the folder of the library.", rich_help_panel=_CPP)] = False,
    cmakedir: Annotated[
        bool, Option("--cmakedir", help="Print the folder of the CMake package.", rich_help_panel=_CPP)
    ] = False,
) -> None:
    """Acceleration trees for queries on lines: hair, fibres, beams, streamlines, wires.

    Start with [bold cyan]fastlines demo --quick[/], or with lines of your own:

    [cyan]fastlines info hair.tfx[/]

    [cyan]fastlines build hair.tfx -o hair.flt[/]

    [cyan]fastlines render hair.flt --radius 0.0005 -o hair.png[/]
    """
    wanted = {
        library.compiler_flags: cflags,
        library.linker_flags: libs,
        library.get_include: includedir,
        library.get_lib: libdir,
        library.get_cmake_dir: cmakedir,
    }
    if any(wanted.values()):
        typer.echo(" ".join(text() for text, is_wanted in wanted.items() if is_wanted))
        raise typer.Exit
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())


def main() -> None:
    """Run the command line: the entry point ``fastlines``."""
    app(prog_name="fastlines")
