"""Words by which the search finds a page that says the same by others.

They are keywords of the page: browsers do not show them, and Sphinx puts them into the index of the search.
"""

from __future__ import annotations

import re
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx

#: American spelling of words that start so.
AMERICAN = {
    "behaviour": "behavior",
    "centre": "center",
    "colour": "color",
    "fibre": "fiber",
    "grey": "gray",
    "neighbour": "neighbor",
}
#: Words of other fields, by page.
OF_PAGES = {
    "distances": "tractography connectome",
    "from/dipy": "tractography tractogram StatefulTractogram fiber biopsy trajectory ROI",
    "from/navis": "neuron skeleton synapse SWC connectome",
    "from/trimesh": "Path3D Path2D toolpath polyline",
    "guide": "tractography ROI biopsy",
}


def words_of(page: str, text: str) -> list[str]:
    """Return the words to add to a page, without those that its text has."""
    there = {word.lower() for word in re.findall(r"\w+", text)}
    found = [word for british, word in AMERICAN.items() if any(each.startswith(british) for each in there)]
    words = dict.fromkeys([*OF_PAGES.get(page, "").split(), *found])
    return [word for word in words if word.lower() not in there]


def add_keywords(app: Sphinx, doctree: nodes.document) -> None:
    """Add the words to a page."""
    if words := words_of(app.env.docname, doctree.astext()):
        doctree.insert(0, nodes.meta(name="keywords", content=", ".join(words)))


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect the step."""
    app.connect("doctree-read", add_keywords)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
