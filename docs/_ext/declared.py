"""The directive `.. declared:: Tree load`, which describes names of the C++ and C headers by their comments.

Sphinx parses the declarations, and warns about those that it does not understand. Single backticks in comments enclose
code, and names in them become links.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from docutils import nodes
from docutils.statemachine import StringList
from headers import FOLDER, HEADERS, Declaration, read
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective


class Declared(SphinxDirective):
    """Describes the names that are its arguments."""

    required_arguments = 1
    final_argument_whitespace = True

    def run(self) -> list[nodes.Node]:
        """Return the nodes of the declarations."""
        declarations = [(domain, path, each) for domain in HEADERS for path in HEADERS[domain] for each in read(path)]
        lines = StringList([".. cpp:namespace:: fl", ""])
        for name in self.arguments[0].split():
            found = [(domain, path, each) for domain, path, each in declarations if each.name == name]
            if not found:
                raise self.error(f"no header declares {name}")
            for domain, path, each in found:
                lines.extend(StringList([*markup(each, domain)], source=f"<markup of {path}>"))
                self.env.note_dependency(str(FOLDER / path))
        parent = nodes.Element()
        self.state.nested_parse(lines, self.content_offset, parent)
        return parent.children


def markup(declaration: Declaration, domain: str, indent: str = "") -> Iterator[str]:
    """Yield the lines of a declaration in reStructuredText."""
    directive = f"{indent}.. {domain}:{declaration.kind}:: " if declaration.name else f"{indent}.. rubric:: "
    for i, signature in enumerate(declaration.signatures):
        yield (" " * len(directive) if i else directive) + signature
    for line in ("", *declaration.comment.splitlines(), ""):
        yield f"{indent}   {re.sub('`([^`]+)`', lambda code: markup_of_code(code[1], domain), line)}"
    for member in declaration.members:
        yield from markup(member, domain, indent + "   ")


def markup_of_code(code: str, domain: str) -> str:
    """Return the markup of code: a link if it is a name."""
    return f":{domain}:expr:`{code}`" if re.fullmatch(r"[\w:]+", code) else f"``{code}``"


def setup(app: Sphinx) -> dict[str, Any]:
    """Add the directive."""
    app.add_directive("declared", Declared)
    return {"parallel_read_safe": True}
