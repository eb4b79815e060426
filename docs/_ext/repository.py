"""Links from pages to files of the repository lead to pages of the site.

A page that only includes a file, such as CONTRIBUTING.md, is the page of that file. Any other file of text, such as a
program in `examples/`, gets a page that shows it. Without this, Sphinx would copy the file for a download.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx import addnodes
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment

ROOT = Path(__file__).parents[2]
#: Where pages of files are in the site, and the suffix of the files that they show.
FOLDER = "repository"
SUFFIXES = (".py", ".cpp", ".hpp", ".c", ".h", ".md", ".toml")
#: A page that only includes a file.
INCLUDED = re.compile(r"\s*```\{include\} (\S+)\n```\s*")
#: The target of a link of Markdown to a file.
TARGET = re.compile(r"(?<=\]\()(?!\w+:|#)[^)\s]+")


def include(app: Sphinx, docname: str, source: list[str]) -> None:
    """Put the text of a file into the page that only includes it. Links start at the folder of the page then."""
    if not (found := INCLUDED.fullmatch(source[0])):
        return
    page = Path(app.env.doc2path(docname))
    file = (page.parent / found[1]).resolve()
    app.env.note_dependency(file)
    text = file.read_text(encoding="utf-8")
    source[0] = TARGET.sub(lambda target: os.path.relpath(file.parent / target[0], page.parent), text)


def pages_of_files(env: BuildEnvironment) -> dict[Path, str]:
    """Return the page of each file that a page includes."""
    sources = ((page, page.read_text(encoding="utf-8")) for page in Path(env.srcdir).glob("*.md"))
    return {
        (page.parent / found[1]).resolve(): page.stem for page, text in sources if (found := INCLUDED.fullmatch(text))
    }


def lead_to_pages(app: Sphinx, doctree: nodes.document) -> None:
    """Turn the links of a page to files into links to pages."""
    included = pages_of_files(app.env)
    for link in list(
        doctree.findall(lambda node: isinstance(node, addnodes.download_reference | addnodes.pending_xref))
    ):
        path = file_of(link, app.env)
        if path in included:
            link["reftarget"] = included[path]
        elif path is not None and path.suffix in SUFFIXES and not path.is_relative_to(app.srcdir):
            name = path.relative_to(ROOT).as_posix()
            files(app.env).setdefault(name, set()).add(app.env.docname)
            target = {"refdomain": "", "reftype": FOLDER, "reftarget": name}
            link.replace_self(addnodes.pending_xref("", *link.children, refdoc=app.env.docname, **target))


def file_of(link: nodes.Element, env: BuildEnvironment) -> Path | None:
    """Return the file that a link of MyST leads to. Where that is Markdown, MyST takes it for a page of the site."""
    if isinstance(link, addnodes.download_reference):
        return Path(env.relfn2path(link["reftarget"], env.docname)[1]).resolve()
    if link.get("refdomain") == "doc" and link["reftarget"] not in env.found_docs:
        return Path(env.srcdir, f"{link['reftarget']}.md").resolve()
    return None


def files(env: BuildEnvironment) -> dict[str, set[str]]:
    """Return the files that become pages, with the pages that link to them."""
    if not hasattr(env, "repository_files"):
        env.repository_files = {}  # type: ignore[attr-defined]
    return env.repository_files  # type: ignore[attr-defined, no-any-return]


def resolve(app: Sphinx, env: BuildEnvironment, node: addnodes.pending_xref, content: nodes.Element) -> Any:
    """Return the link to the page of a file."""
    if node["reftype"] != FOLDER:
        return None
    uri = app.builder.get_relative_uri(node["refdoc"], f"{FOLDER}/{node['reftarget']}")
    return nodes.reference("", "", content, internal=True, refuri=uri)


def write_pages(app: Sphinx) -> Iterator[tuple[str, dict[str, Any], str]]:
    """Yield the pages of files."""
    for name in sorted(files(app.env)):
        code = (ROOT / name).read_text(encoding="utf-8")
        lexer = {"md": "markdown", "hpp": "cpp", "h": "c"}.get(suffix := name.rpartition(".")[2], suffix)
        shown = app.builder.highlighter.highlight_block(code, lexer)  # type: ignore[attr-defined]
        yield f"{FOLDER}/{name}", {"title": name, "body": f"<h1>{name}</h1>\n{shown}"}, "page.html"


def forget(app: Sphinx, env: BuildEnvironment, docname: str) -> None:
    """Drop the links of a page that is read again."""
    for name, pages in list(files(env).items()):
        pages.discard(docname)
        if not pages:
            del files(env)[name]


def merge(app: Sphinx, env: BuildEnvironment, docnames: list[str], other: BuildEnvironment) -> None:
    """Add what another process has read."""
    for name, pages in files(other).items():
        files(env).setdefault(name, set()).update(pages)


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect the steps."""
    app.connect("source-read", include)
    app.connect("doctree-read", lead_to_pages, priority=400)  # before downloads are collected
    app.connect("missing-reference", resolve)
    app.connect("html-collect-pages", write_pages)
    app.connect("env-purge-doc", forget)
    app.connect("env-merge-info", merge)
    return {"version": "1", "env_version": 1, "parallel_read_safe": True, "parallel_write_safe": True}
