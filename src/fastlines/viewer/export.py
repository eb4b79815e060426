"""A scene as one HTML file, which opens without a server and asks for nothing."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from ..errors import InputError
from ..support.atomic_write import atomic_write, check_target
from .choices import Choices
from .drawing import Drawing
from .pane import Pane
from .scene_frame import SceneFrame
from .server import start_server, stop_server
from .shot import vector_text
from .stage import Stage
from .tables import STYLE, block, paragraph
from .thinning import MAX_EXPORTED

#: The endings of pages.
ENDINGS = (".html", ".htm")
#: How the texts lie over the scene.
OVERLAY = (
    "<style>#fl{position:fixed;left:12px;top:12px;max-width:min(420px,40vw);max-height:calc(100vh - 24px);"
    "overflow:auto;z-index:10;background:#1b1d22e6;color:#dcdcdc;border-radius:6px;padding:6px 4px;"
    "font-family:system-ui,sans-serif}#fl summary{cursor:pointer;padding:0 10px;font-size:12px;font-weight:600}</style>"
)


def page_html(panes: Sequence[Pane], choices: Choices) -> str:
    """Return a page of what is chosen, with at most `MAX_EXPORTED` strokes for the lines of each tree."""
    # A server of viser holds the scene while it is written; nobody else learns of its port.
    server = start_server(0)
    try:
        drawing = Drawing(
            Stage(server, SceneFrame.around(panes[0].tree)),
            [replace(pane, most=min(pane.most, MAX_EXPORTED)) for pane in panes],
            replace(choices),
        )
        drawing.arrange()
        drawing.shoot()
        caption, legend = drawing.lines()
        level, path, way = drawing.level(), drawing.path(), drawing.way()
        ray = choices.ray
        asked = ""
        if ray is not None:
            both = f"origin {vector_text(ray.origin)}; direction {vector_text(ray.direction)}"
            asked = paragraph(f"{both}; radius {choices.radius:g}")
        texts = block(drawing.facts(), caption, legend, level, path, asked, way)
        scene = server.scene.as_html(dark_mode=True)
    finally:
        stop_server(server)
    overlay = f'{STYLE}{OVERLAY}<details id="fl" open><summary>fastlines</summary>{texts}</details>'
    head, body, rest = scene.rpartition("</body>")
    return f"{head}{overlay}{body}{rest}"


def check_page_path(path: str | os.PathLike[str]) -> None:
    """Refuse a path that cannot be written, or whose ending is not that of a page."""
    if Path(path).suffix.lower() not in ENDINGS:
        raise InputError(f"{path}: unknown extension for a page; expected .html")
    check_target(path)


def write_page(path: str | os.PathLike[str], panes: Sequence[Pane], choices: Choices) -> None:
    """Write a page, which appears whole or not at all."""
    check_page_path(path)
    html = page_html(panes, choices)
    with atomic_write(path) as partial:
        partial.write_text(html, encoding="utf-8")
