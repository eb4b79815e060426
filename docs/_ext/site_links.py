"""After the pages are written, check that each link within the site leads to a file, and to an anchor in it.

Sphinx checks what it resolves itself. This reads the HTML as a browser would: also links of the theme, of raw HTML and
of notebooks. A link that leads nowhere makes the build fail.
"""

from __future__ import annotations

import re
from html.parser import HTMLParser
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import unquote, urlsplit

if TYPE_CHECKING:
    from sphinx.application import Sphinx


class Page(HTMLParser):
    """The links and anchors of a page."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.links: list[str] = []
        self.anchors: set[str] = set()
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note the attributes of a tag that link, or that links lead to."""
        for name, value in attrs:
            if name == "id" or (tag, name) == ("a", "name"):
                self.anchors.add(value or "")
            elif name in ("href", "src", "poster") and value and tag != "base":
                self.links.append(value)


def broken_links(folder: Path) -> list[str]:
    """Return the links of a folder of HTML that lead nowhere, each as "page: link"."""
    pages = {path.resolve(): Page(path) for path in sorted(folder.rglob("*.html"))}
    broken = []
    for path, page in pages.items():
        for link in dict.fromkeys(page.links):
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            target = target / "index.html" if target.is_dir() else target
            anchor = unquote(parts.fragment)
            known = pages[target].anchors if target in pages else set()
            if not target.is_file() or (anchor and target in pages and anchor not in known):
                broken.append(f"{path.relative_to(folder.resolve())}: {link}")
    return broken


def check(app: Sphinx, error: Exception | None) -> None:
    """Warn about broken links, and fail the build."""
    from sphinx.util import logging

    if error is None and app.builder.format == "html":
        for link in broken_links(Path(app.outdir)):
            logging.getLogger(__name__).warning("this link leads nowhere: %s", link)
            app.statuscode = 1


def correct_backlinks(app: Sphinx, pagename: str, template: str, context: dict[str, Any], doctree: Any) -> None:
    """Lead from source to where names are documented.

    Sphinx takes the module of the first documented name for all names of a file. But `fastlines.view` and
    `fastlines.viewer.viewer.Viewer`, for example, are in one file.
    """
    if not pagename.startswith("_modules/"):
        return
    known = app.env.get_domain("py").objects  # type: ignore[attr-defined]
    module = pagename.removeprefix("_modules/").replace("/", ".")

    def documented(link: re.Match[str]) -> str:
        parts = link[2].split(".")
        names = [link[2], *(".".join([module, *parts[i:]]) for i in range(1, len(parts)))]
        return link[1] + next((name for name in names if name in known), link[2])

    context["body"] = re.sub(r'(class="viewcode-back" href="[^"#]*#)([\w.]+)', documented, context["body"])


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect the steps."""
    app.connect("html-page-context", correct_backlinks)
    app.connect("build-finished", check)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
