"""Arguments and options of several commands, and the parsers of their texts."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from typing import Annotated, Any

import typer
from typer import Option

from ..camera import Vector
from ..errors import InputError

INPUT_HELP = "A file of lines, a tree (.flt), or a scene: scene:NAME, scene:NAME:SEGMENTS or scene:NAME:SEGMENTS:SEED."
ASKED_HELP = f"{INPUT_HELP[:-1]}; or the folder of a forest."


def finite(value: float | None) -> float | None:
    """Refuse a bad radius before any work is done."""
    if value is not None and not 0 <= value < math.inf:
        raise typer.BadParameter(f"{value!r} is not a finite number that is 0 or more.")
    return value


def _above_0(value: float | None) -> float | None:
    """Refuse a bad distance before any work is done."""
    if value is not None and not 0 < value < math.inf:
        raise typer.BadParameter(f"{value!r} is not a finite number above 0.")
    return value


Input = Annotated[str, typer.Argument(metavar="INPUT", help=INPUT_HELP)]
AskedInput = Annotated[str, typer.Argument(metavar="INPUT", help=ASKED_HELP)]
OptionalInput = Annotated[str | None, typer.Argument(metavar="INPUT", help=INPUT_HELP, show_default=False)]
TreeFile = Annotated[str, typer.Argument(metavar="TREE", help="A tree file (.flt).")]
Method = Annotated[
    str, Option("--method", "-m", help="The tree: best, bvh-cl, bvh-ss, bvh-d2, kd-cl, kd-d2 or beams.", metavar="NAME")
]
Effort = Annotated[
    float | None,
    Option(
        help="For best: from 0, the fastest build, to 1, the best tree. The default is 0.5, or 0 for a large input."
    ),
]


def _radius(what: str, without: str) -> Any:
    """Return the option --radius of a command."""
    text = f"{what}, in the unit of the coordinates. It is added to the radius of the lines; {without}."
    return Option("--radius", "-r", callback=finite, help=text, show_default=False)


Radius = Annotated[float | None, _radius("How near a ray must come", "lines without one need it")]
PictureRadius = Annotated[
    float | None, _radius("Half the thickness of the lines", "by default 0, or for lines without one what suits them")
]
Distance = Annotated[
    float,
    Option("--radius", "-r", callback=finite, help="The greatest distance, in the unit of the coordinates."),
]
To = Annotated[
    str | None,
    Option(
        metavar="WHAT",
        help="Measure distances to the surface, the default where lines have a radius of their own, or to the axis.",
        show_default=False,
    ),
]
TableFile = Annotated[
    str | None,
    Option(
        "--output",
        "-o",
        metavar="FILE",
        help="Write the table to this .csv, .parquet or .npz file; else only print figures.",
    ),
]


def _own_radius(otherwise: str) -> Any:
    """Return the option --own-radius of a command."""
    text = f"Whether the radius that lines have of their own counts. If not, {otherwise}."
    return Option("--own-radius/--no-own-radius", help=text)


OwnRadius = Annotated[bool, _own_radius("--radius replaces it")]
OwnSurface = Annotated[bool, _own_radius("distances are to the axes")]
Memory = Annotated[
    str | None,
    Option(metavar="SIZE", help="How much memory to use for a forest, such as 4GB; by default half of what is free."),
]
Scheduler = Annotated[
    str | None,
    Option(
        metavar="ADDRESS",
        help="Query a forest on the workers of this Dask scheduler, or of one on this machine: local.",
    ),
]
Json = Annotated[bool, Option("--json", help="Print JSON.")]
Skip = Annotated[bool, Option("--skip-invalid", help="Leave out segments that hold NaN or Inf.")]
FormatName = Annotated[
    str | None, Option("--format", metavar="NAME", help="The format of the file, where its extension does not say it.")
]
FormatOptions = Annotated[
    list[str] | None,
    Option("--option", metavar="NAME=VALUE", help="An option of the file's format, such as model=2; may be repeated."),
]
Direction = Annotated[str | None, Option(metavar="X,Y,Z", help="The direction of view; chosen by default.")]
Up = Annotated[str | None, Option(metavar="X,Y,Z", help="The upward direction; chosen by default.")]
Fov = Annotated[float | None, Option(help="The camera's vertical field of view in degrees; 30 by default.")]
Lens = Annotated[
    float | None,
    Option(
        "--lens-radius",
        callback=finite,
        metavar="R",
        help="Blur what is out of focus, as a lens of this radius does, in the unit of the coordinates.",
        show_default=False,
    ),
]
Focus = Annotated[
    float | None,
    Option(
        "--focus-distance",
        callback=_above_0,
        metavar="D",
        help="The focus distance, from the camera along the view; by default that of the middle of the lines.",
        show_default=False,
    ),
]


def refuse_given(given: Mapping[str, object], why: str) -> None:
    """Refuse given options that would be ignored."""
    names = [name for name, value in given.items() if value is not None]
    if names:
        raise InputError(f"{' and '.join(names)} {'does' if len(names) == 1 else 'do'} not apply: {why}")


def vector(text: str | None, name: str) -> Vector | None:
    """Read three numbers separated by commas."""
    if text is None:
        return None
    try:
        x, y, z = (float(part) for part in text.split(","))
    except ValueError:
        raise InputError(f"{name} {text!r} is not three numbers separated by commas, such as 0,0,-1") from None
    if not all(map(math.isfinite, (x, y, z))) or not (x or y or z):
        raise InputError(f"{name} {text!r} is not a direction: expected three finite numbers, not all zero")
    return x, y, z


def size(text: str, name: str) -> tuple[int, int]:
    """Read a width and a height, such as 640x480."""
    width, _, height = text.lower().partition("x")
    try:
        return int(width), int(height)
    except ValueError:
        raise InputError(f"{name} {text!r} is not a width and a height, such as 640x480") from None


#: What an option of a type is, in errors.
_EXPECTED: dict[type[Any], str] = {bool: "true or false", int: "a whole number", float: "a number"}


def format_options(
    texts: Sequence[str] | None, types: Mapping[str, type[Any]], flag: str = "--option"
) -> dict[str, Any]:
    """Read options of a format, such as model=2, each by its type; those that the format does not have stay texts."""
    options: dict[str, Any] = {}
    for text in texts or ():
        name, equals, value = text.partition("=")
        if not name or not equals:
            raise InputError(f"{flag} {text!r} is not a name and a value, such as model=2")
        if name in options:
            raise InputError(f"{flag} {name} is given twice; give it once")
        kind = types.get(name, str)
        try:
            options[name] = {"true": True, "false": False}[value.lower()] if kind is bool else kind(value)
        except (ValueError, KeyError):
            raise InputError(f"{flag} {name} is {value!r}; expected {_EXPECTED[kind]}") from None
    return options


def n_bytes(text: str, name: str) -> int:
    """Read an amount of memory, such as 4000000000, 4e9, 4GB or 4GiB."""
    found = re.fullmatch(r"([+-]?[0-9.]+(?:e[+-]?[0-9]+)?) *(?:([kmgt])(i?))?b?", text.strip().lower())
    try:
        number, unit, binary = found.groups() if found else ("", None, None)
        factor = (1024 if binary else 1000) ** (" kmgt".index(unit) if unit else 0)
        return int(number) * factor if number.isdigit() else int(float(number) * factor)
    except (ValueError, OverflowError):
        raise InputError(f"{name} {text!r} is not an amount of memory; expected bytes, or 500MB, 4GB, 4GiB") from None
