"""Which options have an effect on which pictures: one table, for `render` and for the command line.

An option that would change nothing is refused, because whoever gave it expects a change. `EFFECTS` says for each option
in which looks, with which colours and in which files it has an effect; an option without a row there always has one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from ...errors import InputError

#: The looks that show light, colours that need none, and numbers.
SOLID, FLAT, NUMBERS = ("fibre", "tube"), ("depth", "id", "normal", "tangent"), ("hits", "density", "work")
#: What stands for an object with the members of `Look`, lit or not.
OWN_LIT, OWN_FLAT = "a lit look of your own", "a look of your own"
#: What stands for a sheet of the levels of a tree.
LEVELS = "levels"
LIT = ("hair", *SOLID, OWN_LIT)
DRAWN = (*LIT, *FLAT, *NUMBERS, OWN_FLAT)
#: The files for the eye, and those that last.
FILMS = (".gif", ".mp4")
SCREEN = (".png", *FILMS)
#: The values with which options change nothing, besides None; False for all others.
NEUTRAL = {"exposure": 0, "quality": "normal", "levels": 0, "repeats": True, "lens_radius": 0, "variation": 0}


@dataclass(frozen=True)
class PictureRequest:
    """What is known of a picture that is to be made; None is not known yet.

    Attributes
    ----------
    look : str, optional
        The name of the look, or `OWN_LIT`, `OWN_FLAT` or `LEVELS`.
    color : {"number", "direction", "strand", "plain", "other"}, optional
        What its colours depend on.
    file : str, optional
        The extension.
    many : {"", "--turntable", "--radius-sweep"}, optional
        The option that makes many pictures; "" for one.
    """

    look: str | None = None
    color: str | None = None
    file: str | None = None
    many: str | None = None

    @property
    def backdrop(self) -> str | None:
        """Whether a backdrop is "seen": not in an .exr, unless lines fade into it, as fibres do."""
        if self.file != ".exr" or self.look == "fibre":
            return "seen"
        return None if self.look is None else "not seen"


@dataclass(frozen=True)
class Limit:
    """One limit of the effect of an option: the values of a fact with which it has one, and why it has none else."""

    fact: str
    values: tuple[str, ...]
    why: str

    def advice(self, request: PictureRequest) -> str:
        """Say what to do."""
        if self.fact == "look" and request.look != LEVELS:
            return f"leave it out, or name the look: {_or([value for value in self.values if ' ' not in value])}"
        if self.fact == "file":
            return f"leave it out, or write a {_or(self.values)}"
        if self.fact == "color":
            return f"leave it out, or colour lines by {_or([COLORS[value] for value in self.values])}"
        return "leave one of them out" if request.look == LEVELS or self.fact == "many" else "leave it out"


#: What colours depend on, in words.
COLORS = {"number": "an attribute of numbers", "direction": "direction"}

_SHEET = (Limit("look", DRAWN, "levels of a tree are drawn in panels of a fixed size and look"),)
_LIGHT = (Limit("look", LIT, "{look} shows no light"),)

#: The options, in the order in which they are checked, and the limits of their effect.
EFFECTS: dict[str, tuple[Limit, ...]] = {
    "levels": (
        Limit("many", ("",), "{many} makes many pictures"),
        Limit("file", (".png",), "levels are drawn as .png"),
    ),
    "look": _SHEET,
    "width": _SHEET,
    "height": _SHEET,
    "samples": _SHEET,
    "color": (*_SHEET, Limit("look", ("hair", *SOLID), "{look} has colours of its own")),
    "color_map": (
        *_SHEET,
        Limit("look", SOLID, "{look} has colours of its own"),
        Limit("color", ("number",), "a map gives colours to the numbers of an attribute, and there are none"),
    ),
    "material": (*_SHEET, Limit("look", ("hair", *SOLID), "{look} has a material of its own")),
    "variation": (*_SHEET, Limit("look", ("hair", *SOLID), "{look} has colours of its own")),
    "ground": (*_LIGHT, Limit("file", SCREEN, "an .exr has no background to cast a shadow on")),
    "background": (*_SHEET, Limit("backdrop", ("seen",), "an .exr has no background")),
    "transparent": (
        *_SHEET,
        Limit("file", (".png",), "an .exr is always transparent, and a film never is"),
    ),
    "lens_radius": (*_SHEET, Limit("look", (*LIT, *FLAT, OWN_FLAT), "{look} counts along rays from a pinhole")),
    "rig": _LIGHT,
    "exposure": (*_SHEET, *_LIGHT),
    "quality": (*_SHEET, Limit("look", ("hair",), "paths of light are traced in hair only, and this is {look}")),
    "legend": (
        *_SHEET,
        Limit("look", (*SOLID, *NUMBERS, OWN_LIT, OWN_FLAT), "the colours of {look} have no legend"),
        Limit("color", ("number", "direction"), "such colours have no legend"),
        Limit("file", SCREEN, "an .exr holds numbers, without a legend"),
    ),
    "seconds": (Limit("file", FILMS, "only pictures of a film are shown for some time"),),
    "repeats": (Limit("file", (".gif",), "only a .gif says whether it starts again"),),
    "resume": (*_SHEET, Limit("many", ("",), "{many} makes many pictures")),
    "radius": (Limit("many", ("", "--turntable"), "{many} makes many pictures, each with its own radius"),),
}


def check_options(
    given: Mapping[str, object], request: PictureRequest, spell: Callable[[str, object], str] = "{}={!r}".format
) -> None:
    """Refuse options that would change nothing.

    Parameters
    ----------
    given : mapping of str to object
        Options by name. Those that have a neutral value are not given.
    request : PictureRequest
        What is known of the picture.
    spell : callable
        Takes the name and the value of an option, and returns what the user wrote.

    Raises
    ------
    InputError
        It says what was given, why it would change nothing, and what to do.

    Examples
    --------
    >>> check_options({"exposure": 1.0, "legend": False}, PictureRequest(look="hair"))
    >>> check_options({"exposure": 1.0}, PictureRequest(look="depth"))  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    fastlines.errors.InputError: exposure=1.0 does not apply: the look 'depth' shows no light; leave it out, or ...
    """
    for name, limits in EFFECTS.items():
        value = given.get(name)
        if value is None or (value == NEUTRAL[name] if name in NEUTRAL else value is False):
            continue
        for limit in limits:
            known = getattr(request, limit.fact)
            if known is not None and known not in limit.values:
                why = limit.why.format(look=_named(request.look), many=request.many)
                raise InputError(f"{spell(name, value)} does not apply: {why}; {limit.advice(request)}")


def as_flag(name: str, value: object) -> str:
    """Spell an option as on the command line.

    Examples
    --------
    >>> as_flag("color_map", "magma"), as_flag("transparent", True)
    ('--color-map', '--background transparent')
    """
    if name == "transparent":
        return "--background transparent"
    return "--legend-title" if name == "legend" and isinstance(value, str) else f"--{name.replace('_', '-')}"


def _named(look: str | None) -> str:
    """Return what errors call a look."""
    return look if look in (OWN_LIT, OWN_FLAT) else f"the look {look!r}"


def _or(words: tuple[str, ...] | list[str]) -> str:
    return " or ".join([", ".join(words[:-1])] * (len(words) > 1) + list(words[-1:]))
