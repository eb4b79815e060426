"""The examples in the docstrings, the README and the docs run, and print what they say.

In the docs, ``python`` is a block that always runs. On the pages for who knows another package, ``py`` is a block that
needs this package.
"""

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


def python_of(page: Path, language: str = "python") -> str:
    """Return the blocks of a page in a language, or in one of several."""
    return "\n".join(re.findall(rf"```(?:{language})\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL))


#: The Python of each page that shows what it prints.
PAGES = {
    str(page.relative_to(ROOT)): python_of(page)
    for page in [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")), *sorted((ROOT / "docs/from").glob("*.md"))]
    if ">>>" in python_of(page)
}
#: The modules that need another package, or whose examples do.
NEEDED = {
    "fastlines.exchange.neurons": "navis",
    "fastlines.exchange.tractograms": "nibabel",
    "fastlines.geometry.mitsuba_shapes": "mitsuba",
    "fastlines.mitsuba": "mitsuba",
}
#: The pages that compare answers with another package, and the modules that these blocks import.
NEIGHBOURS = {
    "dipy": ["dipy"],
    "embree": ["embreex"],
    "mitsuba": ["mitsuba"],
    "navis": ["navis"],
    "pyvista": ["pyvista"],
    "scipy": ["scipy"],
    "trimesh": ["trimesh", "rtree"],
}


@pytest.mark.parametrize("name", ["fastlines", *MODULES])
def test_docstrings(name: str) -> None:
    for start, package in NEEDED.items():
        if name.startswith(start):
            pytest.importorskip(package)
    failed, _ = doctest.testmod(importlib.import_module(name))
    assert failed == 0


def test_pages_have_examples() -> None:
    assert {"README.md", "docs/answers.md", "docs/builder.md", "docs/from/scipy.md"} <= PAGES.keys()
    assert {f"docs/from/{name}.md" for name in NEIGHBOURS} <= PAGES.keys()


@pytest.mark.parametrize("page", PAGES)
def test_page(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(PAGES[page], page) > 2


@pytest.mark.filterwarnings("default")  # of other packages as they are imported
@pytest.mark.parametrize("name", NEIGHBOURS)
def test_page_beside_the_package(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for module in NEIGHBOURS[name]:
        pytest.importorskip(module)
    monkeypatch.chdir(tmp_path)
    page = ROOT / f"docs/from/{name}.md"
    assert ">>> " in python_of(page, "py")
    assert run(python_of(page, "python|py"), page.name) > 2


def run(text: str, page: str) -> int:
    """Run the examples of a page, and return how many there are."""
    parsed = doctest.DocTestParser().get_doctest(text, {}, page, page, 0)
    assert doctest.DocTestRunner().run(parsed).failed == 0
    return len(parsed.examples)
