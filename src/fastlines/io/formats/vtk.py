"""VTK's legacy files (``.vtk``) and unstructured grids (``.vtu``).

Formats: https://docs.vtk.org/en/latest/vtk_file_formats/index.html. `vtk_legacy` and `vtk_xml` decode files, and
`vtk_data` says what is read of them. The library ``vtk`` is not used: a damaged file can end the process in it.
"""

from __future__ import annotations

from ...geometry.lines import Lines
from ..source import Source
from .vtk_data import lines_of
from .vtk_legacy import read_legacy
from .vtk_xml import read_xml


def read(source: Source, invalid: str, *, radius: str | None = None) -> Lines:
    """Read the line and polyline cells of a file, their radius, and arrays of points and cells as attributes.

    The first bytes tell a legacy file from XML, whatever its extension.

    Parameters
    ----------
    radius : str, optional
        The array of points or cells that is the radius; by default the one of the name ``radius``, in either case.
    """
    is_legacy = source.data[:64].lstrip()[:5].lower() == b"# vtk"
    return lines_of(source, (read_legacy if is_legacy else read_xml)(source), invalid, radius)
