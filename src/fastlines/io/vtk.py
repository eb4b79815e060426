"""VTK files: legacy (``.vtk``), polydata (``.vtp``) and unstructured grids (``.vtu``), read by the library ``vtk``.

Formats: https://docs.vtk.org/en/latest/vtk_file_formats/index.html. Legacy files may be text or binary, of any version,
and hold polydata or an unstructured grid. `vtk_data` says what is read of them. What the library reports as an error is
one; it says so on stderr only, so its messages are collected.
"""

from __future__ import annotations

import re
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from ..lines import Lines
from .source import BAD_COPY, Source
from .vtk_data import library, lines_of

_READERS = {
    ".vtp": ("vtkIOXML", "vtkXMLPolyDataReader"),
    ".vtu": ("vtkIOXML", "vtkXMLUnstructuredGridReader"),
    ".vtk": ("vtkIOLegacy", "vtkGenericDataObjectReader"),
}
#: Where files state sizes: text before the number, and the number.
_SIZES = re.compile(
    rb"(?:^|\n)[ \t]*(POINTS|LINES|VERTICES|POLYGONS|TRIANGLE_STRIPS|CELLS|CELL_TYPES|POINT_DATA|CELL_DATA|OFFSETS"
    rb"|CONNECTIVITY|LOOKUP_TABLE +\w+|FIELD +\w+)[ \t]+(\d{1,30})"
    rb"|(NumberOf\w+|RangeMax)=[\"'](\d{1,30})[\"']"
)
#: Messages of all of VTK go to one place.
_LOCK = threading.Lock()


def read(source: Source, invalid: str) -> Lines:
    """Read the line and polyline cells of a VTK file, with their radius and the arrays of points and cells."""
    extension = _extension(source)
    _check_sizes(source, extension)
    module, name = _READERS[extension]
    reader = getattr(library(module), name)()
    with source.file(extension) as path, messages() as said:
        reader.SetFileName(str(path))
        reader.Update()
        data = reader.GetOutput()
    for kind, text in _split(said[0]):
        if kind == "ERROR" or "rror" in text:
            raise source.error(f"the library vtk cannot read it: {text[:160]}; {BAD_COPY}")
        source.warn(f"the library vtk says: {text[:160]}")
    if data is None or not (data.IsA("vtkPolyData") or data.IsA("vtkUnstructuredGrid")):
        kind = "nothing that it knows" if data is None else f"a {data.GetClassName()}"
        raise source.error(f"holds {kind}; expected polydata or an unstructured grid; convert it with ParaView")
    return lines_of(source, data, invalid)


def _extension(source: Source) -> str:
    """Return the extension of the format that the first bytes of a file show."""
    start = source.data[:4096]
    if start.lstrip()[:5].lower() == b"# vtk":
        return ".vtk"
    kind = re.search(rb"<VTKFile[^>]*\btype\s*=\s*[\"'](\w+)[\"']", start)
    kinds = {b"PolyData": ".vtp", b"UnstructuredGrid": ".vtu"}
    if kind is None or kind[1] not in kinds:
        what = f"XML of type {kind[1].decode('latin-1')!r}" if kind else f"a file that starts {start[:16]!r}"
        raise source.error(
            f'is {what}; expected \'# vtk DataFile\' or <VTKFile type="PolyData"> or "UnstructuredGrid"; check the '
            "extension"
        )
    return kinds[kind[1]]


def _check_sizes(source: Source, extension: str) -> None:
    """Refuse sizes that no file of this length can hold, before the library allocates them."""
    limit = len(source.data) if extension == ".vtk" else source.unpack_limit
    for match in _SIZES.finditer(source.data):
        what, number = (match[1], match[2]) if match[1] else (match[3], match[4])
        if what != b"RangeMax" and int(number) > limit:
            raise source.error(
                f"announces {int(number)} ({what.decode('latin-1')}), far more than its {len(source.data)} bytes can "
                f"hold; {BAD_COPY}"
            )


@contextmanager
def messages() -> Iterator[list[str]]:
    """Collect what VTK would print; the list has one text once the block ends."""
    core: Any = library("vtkCommonCore")
    collected: list[str] = []
    with _LOCK:
        before, window = core.vtkOutputWindow.GetInstance(), core.vtkStringOutputWindow()
        verbosity = core.vtkLogger.GetCurrentVerbosityCutoff()
        core.vtkLogger.SetStderrVerbosity(core.vtkLogger.VERBOSITY_OFF)
        core.vtkOutputWindow.SetInstance(window)
        try:
            yield collected
        finally:
            core.vtkOutputWindow.SetInstance(before)
            core.vtkLogger.SetStderrVerbosity(verbosity)
            collected.append(window.GetOutput())


def _split(text: str) -> list[tuple[str, str]]:
    """Return the kind and the text of each message: ``KIND: In FILE, line N`` and then ``Class (0x…): text``."""
    parts = re.split(r"^(ERROR|Warning|Generic Warning|Generic Error): In [^\n]*\n", text, flags=re.MULTILINE)
    messages = zip(parts[1::2], parts[2::2], strict=True)
    found = [(kind, re.sub(r"^\w+ \(0x[0-9a-f]+\): ", "", said.strip()).split("\n")[0]) for kind, said in messages]
    return [("ERROR" if "Error" in kind else kind, said) for kind, said in found] or (
        [("Warning", text.strip())] if text.strip() else []
    )
