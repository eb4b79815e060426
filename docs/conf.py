"""Sphinx configuration: `pip install '.[docs]' && sphinx-build -W docs docs/_build`."""

import sys
from importlib.metadata import version as _version
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "_ext"))

project = "fastlines"
author = "The fastlines developers"
version = release = _version("fastlines")
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.viewcode", "declared"]
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3
autodoc_member_order = "bysource"
autodoc_typehints = "none"
napoleon_google_docstring = False
napoleon_use_ivar = True  # attributes of that name are no targets of their own
toc_object_entries_show_parents = "hide"
exclude_patterns = ["_build"]
html_theme = "furo"
html_title = "fastlines"
