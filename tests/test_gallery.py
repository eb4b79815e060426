"""Small versions of the gallery's pictures: its commands and its Python run, and write the same picture."""

from __future__ import annotations

import re
import shlex
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from PIL import Image
from support.command_line import done

import fastlines as fl

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "gallery.md").read_text(encoding="utf-8")
#: Of each picture: its command, and its Python, if it has any.
CODE = [
    (command, python)
    for command, python in re.findall(r"```sh\n(.*?)\n```\n(?:\n```python\n(.*?)```\n)?:::\n", PAGE, re.DOTALL)
]
SIZE = {"width": 24, "height": 16}
#: The commands that show trees, and the package that each needs.
TREES = re.compile("fastlines (draw|view)")
NEEDS = {"draw": "matplotlib", "view": "viser"}
#: How many segments stand for a scene, and for a file that is not in the repository.
FEW = 60


def small(command: str) -> list[str]:
    """Return the arguments of a command, with a small picture of few lines in place of its own."""
    name, what, *options = shlex.split(command)[1:]
    if name != "beams":
        what = what if what.startswith("scene:") else "scene:bun-hair"
        what = what if what.count(":") == 2 else f"{what}:{FEW}"
    size = [text for key in SIZE for text in (f"--{key}", str(SIZE[key]))]
    options += {
        "render": [*size, "--samples", "1"],
        "beams": [*size, "--passes", "1"],
        "draw": [],
        "view": ["--export", "view.html"],
    }[name]
    return [name, what, *options]


@pytest.fixture
def small_fl() -> Any:
    """Return a stand-in for the package, which makes small pictures of few lines."""
    make = fl.scenes.make
    few = SimpleNamespace(make=lambda name, n_segments=FEW: make(name, n_segments))
    beams = SimpleNamespace(render=partial(fl.beams.render, **SIZE, passes=1), example=fl.beams.example)
    read = lambda path: make("bun-hair", FEW).lines  # noqa: E731
    render = partial(fl.render, **SIZE, samples=1)
    return SimpleNamespace(render=render, scenes=few, beams=beams, read=read, build=fl.build, drawing=fl.drawing)


def test_all_pictures_have_code() -> None:
    shown = re.findall(r"\]\(images/\S+?\)", PAGE)
    assert len(shown) == len(CODE) > 20
    assert sum(bool(python) for _, python in CODE) > 15


@pytest.mark.parametrize(
    ("command", "python"),
    # What shows trees takes seconds, and has tests of its own.
    [pytest.param(*code, id=code[0], marks=[pytest.mark.slow] * bool(TREES.match(code[0]))) for code in CODE],
)
def test_code_of_a_picture(
    command: str, python: str, small_fl: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    if command.startswith("python "):  # tests/test_examples.py runs it
        assert (ROOT / command.split()[1]).is_file()
        return
    arguments = small(command)
    if arguments[0] in NEEDS:
        pytest.importorskip(NEEDS[arguments[0]])
    done(*arguments)
    if python:
        name = arguments[arguments.index("-o") + 1]
        by_command = np.asarray(Image.open(name))
        Path(name).unlink()
        exec(python, {"fl": small_fl})
        by_python = np.asarray(Image.open(name))
        assert by_python.std() > 0
        # The command names the scene in its drawings.
        assert arguments[0] == "draw" or np.array_equal(by_python, by_command)
