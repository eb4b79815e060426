"""Links of the documents lead to files and headings that exist, and what is installed does not point to the docs."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGES = [
    *(ROOT / name for name in ("README.md", "benchmarks/README.md")),
    *(ROOT / f"{name}.md" for name in ("CHANGELOG", "CODE_OF_CONDUCT", "CONTRIBUTING", "SECURITY")),
    *sorted((ROOT / "docs").rglob("*.md")),
]


def prose(page: Path) -> str:
    """Return a page without its fenced code."""
    return re.sub(r"^( *)```.*?^\1```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)


def links(page: Path) -> list[str]:
    """Return the targets of links and images; those with a scheme, such as https:, lead elsewhere."""
    without_code = re.sub(r"`[^`]*`", "", prose(page))
    return [link for link in re.findall(r"\]\(([^)\s]+)\)", without_code) if not re.match(r"[a-z]+:", link)]


def anchors(page: Path) -> set[str]:
    """Return the slugs of the headings, as GitHub and MyST (`myst_heading_anchors = 3`) make them."""
    found: set[str] = set()
    for heading in re.findall(r"^#{1,3} +(.+?) *$", prose(page), re.MULTILINE):
        text = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading)
        slug = unique = re.sub(r"[^\w\- ]", "", text.lower()).replace(" ", "-")
        repeats = 0
        while unique in found:
            repeats += 1
            unique = f"{slug}-{repeats}"
        found.add(unique)
    return found


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_somewhere(page: Path) -> None:
    broken = []
    for link in links(page):
        path, _, anchor = link.partition("#")
        target = page.parent / path if path else page
        if not target.exists() or (anchor and anchor not in anchors(target)):
            broken.append(link)
    assert not broken


@pytest.mark.parametrize("folder", ["src/fastlines", "cpp/fastlines", "cpp/library"])
def test_what_is_installed_does_not_point_to_pages(folder: str) -> None:
    """No wheel holds the pages of the docs, so messages, docstrings and headers say what they mean."""
    files = [path for path in (ROOT / folder).rglob("*") if path.suffix in (".py", ".pyi", ".hpp", ".h", ".cpp")]
    assert files
    pointers = {
        f"{path.relative_to(ROOT)}: {pointer}"
        for path in files
        for pointer in re.findall(r"docs/[\w/-]*\.md", path.read_text(encoding="utf-8"))
    }
    assert not pointers


def test_links_are_found() -> None:
    assert {"docs/guide.md#large-coordinates", "examples/first_hit.cpp"} <= set(links(ROOT / "README.md"))
    assert "theorem-5-pruning" in anchors(ROOT / "docs/theory.md")
