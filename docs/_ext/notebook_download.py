"""The page of a notebook begins with a link to the notebook, below its title."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx import addnodes
from sphinx.application import Sphinx


def add_link(app: Sphinx, doctree: nodes.document) -> None:
    """Add the link to a page that is read from a notebook."""
    notebook = Path(app.env.doc2path(app.env.docname))
    title = next(doctree.findall(nodes.title), None)
    if notebook.suffix != ".ipynb" or title is None:
        return
    text = nodes.literal(text=notebook.name)
    link = addnodes.download_reference("", "", text, reftarget=notebook.name, refdoc=app.env.docname)
    title.parent.insert(1, nodes.paragraph("", "Download this notebook: ", link))


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect the step."""
    app.connect("doctree-read", add_link, priority=400)  # before downloads are collected
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
