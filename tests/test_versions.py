"""One version and one oldest Python, wherever they are written."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import fastlines as fl

ROOT = Path(__file__).parents[1]


def project(folder: str = ".") -> dict[str, Any]:
    return tomllib.loads((ROOT / folder / "pyproject.toml").read_text(encoding="utf-8"))


def test_all_files_name_the_same_version() -> None:
    version = project()["project"]["version"]
    assert project("benchmarks")["project"]["version"] == version
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert re.findall(r"^version: (.+)$", citation, re.MULTILINE) == [version]
    assert fl.__version__ == version


def test_the_wheel_is_for_the_oldest_python() -> None:
    settings = project()
    oldest = settings["project"]["requires-python"].removeprefix(">=")
    tag = "cp" + oldest.replace(".", "")
    assert settings["tool"]["scikit-build"]["wheel"]["py-api"] == tag
    assert settings["tool"]["cibuildwheel"]["build"] == f"{tag}-*"
    assert settings["tool"]["mypy"]["python_version"] == oldest
    assert project("benchmarks")["project"]["requires-python"] == f">={oldest}"


def test_both_distributions_build_with_the_same_nanobind() -> None:
    # Modules share types only if they are made for the same backend.
    ours, theirs = (project(folder)["build-system"]["requires"] for folder in (".", "benchmarks"))
    assert ours == theirs
