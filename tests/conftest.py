"""Fixtures that more than one test file uses."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

import fastlines as fl
import fastlines.io

# These hold assertions, though no tests: let pytest explain them all the same.
pytest.register_assert_rewrite("support")


@pytest.fixture
def load(tmp_path: Path) -> Callable[..., fastlines.io.Lines]:
    """Write bytes to a file and read it."""

    def write_and_read(data: bytes, name: str, **options):
        path = tmp_path / name
        path.write_bytes(data)
        return fastlines.io.read(path, **options)

    return write_and_read


@pytest.fixture
def in_own_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("FASTLINES_DEBUG", raising=False)


@pytest.fixture
def tree_file(tmp_path):
    fl.build(fl.scenes.make("spaghetti", 60).lines, "kd-d2").save(tmp_path / "s.flt")
    return "s.flt"
