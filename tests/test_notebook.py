"""The notebook of the manual: what is stored of it, and that all cells run. `.ci/site` runs and shows it."""

from __future__ import annotations

import ast
import json
import re
import sys
from pathlib import Path
from typing import Any

import pytest

NOTEBOOK = Path(__file__).parents[1] / "docs" / "notebooks" / "equal-boxes.ipynb"
STORED = json.loads(NOTEBOOK.read_text(encoding="utf-8"))


def cells(kind: str) -> list[Any]:
    """Return the cells of a kind, "code" or "markdown"."""
    return [cell for cell in STORED["cells"] if cell["cell_type"] == kind]


def text(cell: Any) -> str:
    """Return the text of a cell."""
    return "".join(cell["source"])


def test_no_output_is_stored() -> None:
    assert all(cell["outputs"] == [] and cell["execution_count"] is None for cell in cells("code"))


def test_any_python_can_run_it() -> None:
    assert STORED["metadata"]["kernelspec"]["name"] == "python3"
    assert set(STORED["metadata"]["language_info"]) == {"name"}  # not the version that saved it


def test_it_is_one_lesson() -> None:
    titles = [line for cell in cells("markdown") for line in text(cell).splitlines() if line.startswith("# ")]
    assert len(titles) == 1
    assert 12 <= len(cells("code")) <= 20


def test_it_imports_only_the_package_and_its_extra() -> None:
    imported: set[str] = set()
    for node in ast.walk(ast.parse("\n".join(text(cell) for cell in cells("code")))):
        if isinstance(node, ast.Import):
            imported |= {alias.name.split(".")[0] for alias in node.names}
        if isinstance(node, ast.ImportFrom):
            imported.add(str(node.module).split(".")[0])
    assert {"fastlines"} < imported <= {"fastlines", "matplotlib", "numpy", *sys.stdlib_module_names}


def test_its_claims_are_checked() -> None:
    checked = [any(isinstance(node, ast.Assert) for node in ast.walk(ast.parse(text(cell)))) for cell in cells("code")]
    assert sum(checked) >= len(checked) / 2


def test_links_lead_somewhere() -> None:
    links = [link for cell in cells("markdown") for link in re.findall(r"\]\(([^)#]+)", text(cell))]
    assert links
    assert [link for link in links if not (NOTEBOOK.parent / link).exists()] == []


@pytest.mark.slow
def test_all_cells_run() -> None:
    nbformat = pytest.importorskip("nbformat")
    nbclient = pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    pytest.importorskip("matplotlib")
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    nbformat.validate(notebook)
    nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3").execute()
    pictures = [
        output for cell in notebook.cells for output in cell.get("outputs", []) if "image/png" in output.get("data", {})
    ]
    assert len(pictures) >= 12
