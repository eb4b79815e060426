"""The inputs and outputs of the commands."""

from __future__ import annotations

import math
import os
import re
import sys
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from .. import scenes
from ..builder import build
from ..camera import Camera
from ..errors import FileWarning, InputError
from ..forest.forest import AnyTree, Forest
from ..forest.manifest import BUILDING, FILE
from ..forest.mapping.connect import connected
from ..geometry.any_geometry import AnyGeometry
from ..geometry.collection import Geometry
from ..geometry.curves import Curves
from ..geometry.lines import Lines
from ..geometry.offsets import AUTO, OFFSET, Offset, check_offset
from ..io import Format, extension_of, format_of, read
from ..io.reading import check_path, thickness_oddity
from ..support.atomic_write import atomic_write, check_target
from ..support.texts import counted
from ..tree import Tree, load
from .options import format_options, n_bytes, refuse_given

TREE = ".flt"
SCENE = "scene:"
#: From this latitude on, degrees of longitude are not shortened in maps.
POLAR = 85.0
#: Where degrees of longitude are shortened to a larger fraction, no note says so.
ALIKE = 0.99


@dataclass(frozen=True)
class Source:
    """Lines, or what else a tree is over, with the tree, the scene or the format of the file that they came from."""

    name: str
    geometry: AnyGeometry
    tree: AnyTree | None = None
    scene: scenes.Scene | None = None
    format: Format | None = None

    @property
    def lines(self) -> Lines:
        """The lines, for what works with nothing else."""
        if not isinstance(self.geometry, Lines):
            kind = type(self.geometry).__name__
            raise InputError(f"{self.name}: holds {kind}; expected lines here, 'fastlines build' takes all kinds")
        return self.geometry

    def camera(self) -> Camera:
        """Return the camera of queries: it looks as that of the scene does, or else the default."""
        from ..rendering import default_camera

        if self.scene is None:
            return default_camera(self.geometry)
        x, y, z = self.scene.camera.axes()[2].tolist()
        return default_camera(self.geometry, direction=(x, y, z), up=self.scene.camera.up)


def open_lines(
    text: str,
    skip_invalid: bool = False,
    format: str | None = None,
    options: Sequence[str] | None = None,
    own_radius: bool = True,
    *,
    forests: bool = False,
) -> Source:
    """Read an input; refuse one without lines, which is most likely a mistake."""
    source = open_input(text, skip_invalid, format, options, own_radius, forests=forests)
    if len(source.geometry) == 0:
        raise InputError(f"{text}: holds no segments; expected at least one ('fastlines info' shows what is in a file)")
    return source


def open_input(
    text: str,
    skip_invalid: bool = False,
    format: str | None = None,
    options: Sequence[str] | None = None,
    own_radius: bool = True,
    *,
    forests: bool = False,
) -> Source:
    """Read a file of lines, a tree or a scene, as the argument INPUT names it; leave out the radius if wanted.

    The folder of a forest is refused unless `forests` are taken.
    """
    if is_forest(text):
        if not forests:
            raise InputError(
                f"{text}: is a forest; expected a file of lines, a tree or a scene (forests are taken by query, "
                "nearest, within, pairs, render, and by 'fastlines forest')"
            )
        refuse_given({"--format": format, "--option": options or None}, f"{text} is a forest")
        refuse_given({"--no-own-radius": None if own_radius else True}, f"{text} is a forest")
        forest = Forest(text)
        return Source(text, forest.geometry, forest)
    source = _open(text, skip_invalid, format, options)
    if not own_radius:
        return _without_radius(source)
    if source.tree is not None and (oddity := thickness_oddity(source.geometry)) is not None:
        warnings.warn(f"{text}: {oddity}", FileWarning, stacklevel=2)
    return source


def is_forest(text: str) -> bool:
    """Return whether a path names the folder of a forest, perhaps a half-built one."""
    return any(os.path.exists(os.path.join(text, name)) for name in (FILE, BUILDING))


def tree_of(source: Source) -> AnyTree:
    """Return the tree of an input, or build one; its layout is made, so that queries alone can be timed."""
    tree = source.tree or build(source.geometry, progress=show_progress())
    if isinstance(tree, Tree):
        tree.layout  # noqa: B018
    return tree


@contextmanager
def placed(source: Source, memory: str | None, scheduler: str | None) -> Iterator[Source]:
    """Yield an input whose forest uses so much memory, and the workers of a scheduler."""
    if memory is None and scheduler is None:
        yield source
        return
    forest = source.tree
    if not isinstance(forest, Forest):
        refuse_given({"--memory": memory, "--scheduler": scheduler}, f"{source.name} is not a forest")
        return
    if memory is not None:
        forest = Forest(source.name, memory=n_bytes(memory, "--memory"))
    if scheduler is None:
        yield replace(source, geometry=forest.geometry, tree=forest)
        return
    with connected(scheduler) as client:
        yield replace(source, geometry=forest.geometry, tree=forest.on(client))


def open_beside(first: Source, text: str, skip_invalid: bool, own_radius: bool) -> Source:
    """Read another input; a file of lines gets the offset of the first."""
    is_file = not text.startswith(SCENE) and Path(text).suffix.lower() != TREE and not is_forest(text)
    offset = f"{OFFSET}={','.join(map(repr, first.geometry.offset))}"
    return open_input(text, skip_invalid, options=[offset] if is_file else None, own_radius=own_radius, forests=True)


def _open(text: str, skip_invalid: bool, format: str | None, options: Sequence[str] | None) -> Source:
    path = Path(text)
    given = {"--format": format, "--option": options or None}
    if text.startswith(SCENE):
        refuse_given(given, f"{text} is a scene")
        scene = make_scene(text.removeprefix(SCENE))
        return Source(text, scene.lines, scene=scene)
    if not text:
        raise InputError("the name of a file is empty; expected a file of lines, a tree or a scene")
    if path.suffix.lower() == TREE:
        refuse_given(given, f"{text} is a tree")
        tree = open_tree(text)
        return Source(text, tree.geometry, tree)
    if text in scenes.NAMES and not path.exists():
        raise InputError(f"{text}: no such file; the scene of that name is {SCENE}{text}")
    check_path(path)
    if extension_of(path)[0] == TREE:
        raise InputError(f"{text}: trees are not compressed, so that they can be mapped into memory; unpack it first")
    invalid = "skip" if skip_invalid else "error"
    row = format_of(path, format)
    given_options = format_options(options, row.options() if options else {})
    if OFFSET in given_options:
        given_options[OFFSET] = offset_of(given_options[OFFSET])
    lines = read(path, invalid=invalid, format=format, progress=show_progress(), **given_options)
    if lines.n_skipped:
        what = counted(lines.n_skipped, "rows" if lines.has_parts else lines.noun)
        were = "was" if lines.n_skipped == 1 else "were"
        note(f"{text}: {what} with NaN or Inf {were} left out")
    return Source(text, lines, format=row)


def offset_of(text: str) -> Offset | str:
    """Read "auto" or three numbers separated by commas."""
    try:
        return check_offset(text if text == AUTO else text.split(","))
    except InputError:
        raise InputError(f"--option {OFFSET} is {text!r}; expected auto, or three numbers such as 500000,0,0") from None


def _without_radius(source: Source) -> Source:
    """Leave out the radius that lines have of their own."""
    geometry, leave_out = source.geometry, "leave out --no-own-radius"
    if all(part.radius is None for part in geometry.each_part()):
        raise InputError(f"{source.name}: has no radius of its own; {leave_out}")
    if not isinstance(source.tree, Tree):
        parts = [_bare(part) for part in geometry.each_part()]
        return replace(source, geometry=Geometry(parts) if geometry.has_parts else parts[0])
    if not isinstance(geometry, Lines):
        kind = type(geometry).__name__
        raise InputError(
            f"{source.name}: is a tree over {kind}, whose boxes hold its radius; build one with "
            f"'fastlines build INPUT --no-own-radius', or {leave_out}"
        )
    # The boxes of a tree over lines are those of the axes.
    tree = replace(source.tree, geometry=geometry.without_radius(), made_by_core=True)
    return replace(source, geometry=tree.geometry, tree=tree)


def _bare(part: AnyGeometry) -> AnyGeometry:
    if isinstance(part, Lines):
        return part.without_radius()
    return replace(part, radius=None) if isinstance(part, Curves) else part


def as_map(source: Source) -> Source:
    """Shorten degrees of longitude as maps do, and leave z at 0 where metres would be needles beside degrees.

    Trees are drawn as they are.
    """
    lines = source.geometry
    if source.tree is not None or not isinstance(lines, Lines) or lines.unit != "degree" or not len(lines):
        return source
    bounds = lines.bounds.astype(np.float64)
    *sides, height = np.ptp(bounds, axis=0).tolist()
    latitude = float(bounds[:, 1].mean()) + lines.offset[1]
    scales = [1.0, 1.0, 1.0]
    if abs(latitude) < POLAR:
        scales[0] = math.cos(math.radians(latitude))
    if scales[0] < ALIKE:
        shortened = f"to {scales[0]:.2g} of their length, as at latitude {latitude:.3g}°"
        note(f"{source.name}: pictures shorten degrees of longitude {shortened}")
    if height > max(sides):
        scales[2] = 0.0
        note(f"{source.name}: pictures leave z at 0, because x and y are in degrees, and z is in metres")
    return replace(source, geometry=replace(lines, segments=lines.segments * np.array(scales, np.float32)))


def open_tree(text: str) -> Tree:
    """Load a tree file."""
    path = Path(text)
    if path.suffix.lower() != TREE:
        raise InputError(f"{text}: expected a tree file ({TREE}), which 'fastlines build INPUT -o FILE{TREE}' makes")
    if path.is_dir():
        raise InputError(f"{text}: is a directory; expected a tree file")
    return load(path)


def make_scene(text: str) -> scenes.Scene:
    """Make the scene that NAME[:SEGMENTS[:SEED]] describes."""
    name, *numbers = text.split(":")
    if len(numbers) > 2 or not all(re.fullmatch("[0-9]{1,100}", number) for number in numbers):
        shown = text if len(text) < 100 else text[:100] + "…"
        raise InputError(f"{SCENE}{shown} is not {SCENE}NAME, {SCENE}NAME:SEGMENTS or {SCENE}NAME:SEGMENTS:SEED")
    return scenes.make(name, *map(int, numbers))


def check_output(path: str | None, *extensions: str, inputs: Sequence[str | None] = ()) -> None:
    """Refuse, before any work, an output file that cannot be written or that is an input."""
    if path is None:
        return
    target = Path(path)
    if any(text is not None and Path(text).resolve() == target.resolve() for text in inputs):
        raise InputError(f"{path}: is read from; write to another file")
    if extensions and target.suffix.lower() not in extensions:
        expected = " or ".join(extensions)
        raise InputError(f"{path}: unknown extension {target.suffix or '(none)'!r} for the output; expected {expected}")
    check_target(path)


def write_npz(path: str, **arrays: Any) -> None:
    """Write arrays to a .npz file, which appears whole or not at all."""
    with atomic_write(path) as partial, partial.open("wb") as file:
        np.savez_compressed(file, **arrays)


def show_progress() -> bool:
    """Return whether stderr is a terminal."""
    return sys.stderr.isatty()


def note(text: str) -> None:
    """Print a note to stderr, above a progress bar if there is one."""
    print(f"note: {text}", file=sys.stderr, flush=True)  # typer.echo would write past the bar
