"""The report as Markdown."""

from __future__ import annotations

from .document import Cell, Document, Gallery, Section, Table


def markdown(document: Document, folder: str) -> str:
    """Return the whole report as Markdown that links to the pictures in `folder`."""
    lines = [f"# {document.title}", "", document.lead]
    for section in document.sections:
        lines += _section(section, folder)
    return "\n".join([*lines, "", document.foot]) + "\n"


def _section(section: Section, folder: str) -> list[str]:
    lines = ["", f"## {section.title}"]
    for text in section.text:
        lines += ["", text]
    lines += [""] if section.points else []
    lines += [f"- **{what}**: {why}" for what, why in section.points]
    for part in section.parts:
        lines += _table(part) if isinstance(part, Table) else _gallery(part, folder)
    return lines


def _table(table: Table) -> list[str]:
    lines = ["", f"{table.caption}:"] if table.caption else []
    rows = [[_cell(cell) for cell in row] for row in table.rows]
    lines += ["", *(f"| {' | '.join(row)} |" for row in [list(table.heads)])]
    lines += ["|---" * len(table.heads) + "|", *(f"| {' | '.join(row)} |" for row in rows)]
    for note in table.notes:
        lines += ["", note.replace("*", r"\*")]
    return lines


def _cell(cell: Cell) -> str:
    text = cell.text.replace("*", r"\*").replace("|", r"\|")
    return f"{text} ({cell.other})" if cell.other else text


def _gallery(gallery: Gallery, folder: str) -> list[str]:
    if not gallery.pictures:
        return []
    shown = [f"![{each.alt}]({folder}/{each.file} '{each.caption}')" for each in gallery.pictures]
    captions = " · ".join(each.caption for each in gallery.pictures)
    return ["", " ".join(shown), "", f"{gallery.caption.rstrip('.')}: {captions}"]
