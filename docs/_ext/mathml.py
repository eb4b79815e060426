"""Formulas as MathML, which browsers draw by themselves: pages need no script and nothing from the network."""

from __future__ import annotations

import re
from typing import Any

from docutils import nodes
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError

#: The large delimiters of TeX that docutils does not know; it knows the same as opening ones: \\bigl.
BIG = re.compile(r"\\([bB]igg?)(?![a-zA-Z])")


def markup(node: nodes.math | nodes.math_block, as_block: bool) -> str:
    """Return the MathML of a formula in TeX."""
    tex = BIG.sub(r"\\\1l", node.astext())
    try:
        return str(tex2mathml(tex, as_block=as_block))
    except MathError as error:
        raise ExtensionError(f"{node.source}:{node.line}: no MathML for {node.astext()!r}: {error}") from error


def visit_inline(self: Any, node: nodes.math) -> None:
    """Write a formula in a line of text."""
    self.body.append(markup(node, as_block=False))
    raise nodes.SkipNode


def visit_block(self: Any, node: nodes.math_block) -> None:
    """Write a formula that stands alone."""
    self.body.append(f'<div class="math">{markup(node, as_block=True)}</div>\n')
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, Any]:
    """Add the renderer."""
    app.add_html_math_renderer("mathml", (visit_inline, None), (visit_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
