"""Words by which the search finds a page that says the same in other words.

They are keywords of the page: browsers do not show them, and Sphinx puts them into the index of the search.
"""

from __future__ import annotations

import re
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx

#: What a page says, by the start of a word, and what others call it: American spelling, and words of other fields.
SYNONYMS = {
    "behaviour": "behavior",
    "centre": "center",
    "colour": "color",
    "fibre": "fiber",
    "grey": "gray",
    "neighbour": "neighbor",
    "neuron": "skeleton",
    "streamline": "streamtube",
    "tract": "tractography",
}
#: Words for single pages.
OF_PAGES = {
    "distances": "tractography connectome",
    "from/dipy": "tractography StatefulTractogram tractogram biopsy trajectory ROI fibre fiber",
    "from/embree": "curves rtcIntersect1",
    "from/navis": "neuron synapse SWC skeleton connectomics",
    "from/scipy": "KDTree cKDTree",
    "from/trimesh": "Path3D Path2D toolpath polyline",
    "guide": "tractography ROI biopsy",
}


def words_of(page: str, text: str) -> list[str]:
    """Return the words to add to a page, without those that its text has."""
    there = {word.lower() for word in re.findall(r"\w+", text)}
    found = [word for start, word in SYNONYMS.items() if any(each.startswith(start) for each in there)]
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
