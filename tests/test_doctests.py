"""The examples in the docstrings, the README and the docs run, and print what they say."""

from __future__ import annotations

import doctest
import importlib
import pkgutil
import re
from pathlib import Path

import pytest

import fastlines

ROOT = Path(__file__).parents[1]
MODULES = [
    name
    for _, name, _ in pkgutil.walk_packages(fastlines.__path__, "fastlines.")
    if not name.endswith(("._core", "__main__"))
]
#: The Python of each page that has any.
PAGES = {
    page.name: "\n".join(re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL))
    for page in [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
    if "```python\n>>>" in page.read_text(encoding="utf-8")
}


@pytest.mark.parametrize("name", ["fastlines", *MODULES])
def test_docstrings(name: str) -> None:
    if name.startswith("fastlines.mitsuba"):
        pytest.importorskip("mitsuba")
    failed, _ = doctest.testmod(importlib.import_module(name))
    assert failed == 0


def test_pages_have_examples() -> None:
    assert {"README.md", "answers.md", "builder.md"} <= PAGES.keys()


@pytest.mark.parametrize("page", PAGES)
def test_page(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    parsed = doctest.DocTestParser().get_doctest(PAGES[page], {}, page, page, 0)
    assert len(parsed.examples) > 2
    assert doctest.DocTestRunner().run(parsed).failed == 0
