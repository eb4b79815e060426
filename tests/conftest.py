"""Fixtures that more than one test file uses."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import hypothesis
import pytest

import fastlines as fl
import fastlines.io
from fastlines.io import table

# These hold assertions, though no tests: let pytest explain them all the same.
pytest.register_assert_rewrite("support")
# An example may take any time, because machines are busy.
hypothesis.settings.register_profile("untimed", deadline=None)
hypothesis.settings.load_profile("untimed")


@pytest.fixture
def load(tmp_path: Path) -> Callable[..., fastlines.io.Lines]:
    """Write bytes to a file and read it."""

    def write_and_read(data: bytes, name: str, **options):
        path = tmp_path / name
        path.write_bytes(data)
        return fastlines.io.read(path, **options)

    return write_and_read


@pytest.fixture
def install_format(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., Path]]:
    """Install distributions of one module that have entry points of formats; return the folder on the path."""
    folder = tmp_path / "site"
    folder.mkdir()
    monkeypatch.syspath_prepend(folder)

    def install(distribution: str, code: str, points: dict[str, str]) -> Path:
        module = distribution.replace("-", "_")
        monkeypatch.delitem(sys.modules, module, raising=False)
        (folder / f"{module}.py").write_text(code)
        info = folder / f"{module}-1.0.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {distribution}\nVersion: 1.0\n")
        lines = [f"{name} = {value}" for name, value in points.items()]
        (info / "entry_points.txt").write_text("\n".join(["[fastlines.formats]", *lines]))
        return folder

    table._known_words.cache_clear()
    yield install
    table._known_words.cache_clear()


@pytest.fixture
def in_own_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("FASTLINES_DEBUG", raising=False)


@pytest.fixture
def tree_file(tmp_path):
    fl.build(fl.scenes.make("spaghetti", 60).lines, "kd-d2").save(tmp_path / "s.flt")
    return "s.flt"
