"""Sphinx configuration: `.ci/site` builds the site, and `.ci/site --serve` shows it too."""

import sys
from importlib.metadata import version as _version
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx

sys.path.insert(0, str(Path(__file__).parent / "_ext"))

project = "fastlines"
author = project_copyright = "The fastlines developers"
version = release = _version("fastlines")
extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
    "sphinx_copybutton",
    "declared",
    "mathml",
    "notebook_download",
    "repository",
    "search_words",
    "site_links",
]
exclude_patterns = ["_build"]

# Pages, and the notebook, whose cells all run for each build; a cell that raises fails the build.
myst_enable_extensions = ["colon_fence", "dollarmath"]
myst_heading_anchors = 3
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 300
nb_merge_streams = True

# The Python interface.
autodoc_member_order = "bysource"
autodoc_typehints = "none"
napoleon_google_docstring = False
napoleon_use_ivar = True  # attributes of that name are no targets of their own
toc_object_entries_show_parents = "hide"

# The look. Copied code is without prompts and output.
copybutton_prompt_text = r">>> |\.\.\. "
copybutton_prompt_is_regexp = True
html_theme = "furo"
html_title = "fastlines"
html_logo = "_static/logo.svg"
html_favicon = "_static/logo.svg"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_search_scorer = str(Path(__file__).parent / "_ext" / "search_scorer.js")
html_copy_source = False
html_math_renderer = "mathml"
pygments_style = "tango"
pygments_dark_style = "github-dark"


def setup(app: Sphinx) -> None:
    """Connect the functions below."""
    app.connect("doctree-read", drop_blank_ends)
    app.connect("html-page-context", scroll_by_keys)


def drop_blank_ends(app: Sphinx, doctree: nodes.document) -> None:
    """Drop the blank line with which examples end, because doctest needs it and readers don't."""
    for block in doctree.findall(nodes.literal_block):
        if isinstance(text := block.children[0], nodes.Text):
            block.rawsource = block.rawsource.rstrip()
            block.replace(text, nodes.Text(text.rstrip()))


def scroll_by_keys(app: Sphinx, pagename: str, template: str, context: dict[str, Any], doctree: object) -> None:
    """Let the Tab key reach tables, so that the arrow keys scroll those that are wider than the page."""
    if "body" in context:
        context["body"] = context["body"].replace('<div class="table-wrapper', '<div tabindex="0" class="table-wrapper')
