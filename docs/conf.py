"""Sphinx configuration: `pip install '.[docs]' && sphinx-build -W docs docs/_build`."""

from importlib.metadata import version as _version

project = "fastlines"
author = "The fastlines developers"
version = release = _version("fastlines")
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.viewcode"]
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3
autodoc_member_order = "bysource"
autodoc_typehints = "none"
napoleon_google_docstring = False
napoleon_use_ivar = True  # attributes of that name are no targets of their own
exclude_patterns = ["_build"]
html_theme = "furo"
html_title = "fastlines"
