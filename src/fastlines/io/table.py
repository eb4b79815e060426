"""The table of file formats, and how the format of a file is found."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path

from ..arrays import did_you_mean, kind_of
from ..errors import FileFormatError, InputError
from ..geometry.collection import Geometry
from ..geometry.curves import Curves
from ..geometry.lines import Lines
from ..support.atomic_write import check_target
from . import plugins
from .format import Format

#: One row for each format of this package; its module says what is read and what is dropped.
TABLE: tuple[Format, ...] = (
    Format(
        "arrow",
        (".parquet", ".feather", ".arrow"),
        "tables of Parquet and Arrow: a row a segment, a point or, in GeoParquet, a geometry",
        magic=(b"PAR1", b"ARROW1"),
        writes=(Lines,),
        strands="kept",
        metadata="kept",
        folder="*.parquet",
    ),
    Format("bcc", (".bcc",), "yarns, Cem Yuksel's Binary Curve Collections", magic=(b"BCC\x44",)),
    Format("dxf", (".dxf",), "drawings, DXF", magic=(b"AutoCAD Binary DXF",), up="z", text=True),
    Format(
        "geojson",
        (".geojson", ".geojsonl", ".ndjson", ".json"),
        "maps, GeoJSON, also one feature a line",
        writes=(Lines,),
        up="z",
        text=True,
    ),
    Format("gpx", (".gpx",), "tracks and routes, GPX", up="z", unit="degree", text=True),
    Format("hair", (".hair",), "hair, Cem Yuksel's HAIR files", magic=(b"HAIR", b"hair"), writes=(Lines,)),
    Format(
        "mitsuba", (".txt", ".curves"), "curves of Mitsuba 3, linearcurve and bsplinecurve", writes=(Lines,), text=True
    ),
    Format("molecules", (".pdb", ".ent", ".cif", ".mmcif"), "bonds of molecules, PDB and mmCIF", unit="Å", text=True),
    Format(
        "npy",
        (".npy",),
        "NumPy array of segments, (n, 2, 3) or (n, 6)",
        magic=(b"\x93NUMPY",),
        writes=(Lines,),
        strands="none",
    ),
    Format(
        "npz",
        (".npz",),
        "NumPy arrays: 'segments', 'points' and 'counts', or 'control'; optionally 'radius' and others",
        writes=(Lines, Curves),
        strands="kept",
        metadata="kept",
    ),
    Format("obj", (".obj",), "lines of Wavefront OBJ", writes=(Lines,), text=True),
    Format("pbrt", (".pbrt",), "curves of pbrt scenes, versions 3 and 4", text=True),
    Format("ply", (".ply",), "edges of PLY", magic=(b"ply\n", b"ply\r"), writes=(Lines,), strands="kept", text=True),
    Format(
        "safetensors",
        (".safetensors",),
        "tensors: the same arrays as in .npz",
        writes=(Lines, Curves),
        strands="kept",
        metadata="kept",
    ),
    Format("swc", (".swc",), "neurons, SWC", writes=(Lines,), unit="µm", text=True),
    Format("tck", (".tck",), "streamlines, MRtrix", magic=(b"mrtrix tracks",), writes=(Lines,), up="z", unit="mm"),
    Format("tfx", (".tfx",), "hair, AMD TressFX versions 3 and 4", up="y"),
    Format(
        "trk",
        (".trk",),
        "streamlines, TrackVis",
        magic=(b"TRACK",),
        writes=(Lines,),
        metadata=("grid",),
        up="z",
        unit="mm",
    ),
    Format(
        "trx",
        (".trx",),
        "streamlines, TRX",
        writes=(Lines,),
        metadata=("grid",),
        up="z",
        unit="mm",
        folder="header.json",
    ),
    Format("usc", (".data",), "hair of the USC-HairSalon database", up="y"),
    Format(
        "usd",
        (".usd", ".usda", ".usdc", ".usdz"),
        "scenes, USD BasisCurves and HermiteCurves",
        magic=(b"#usda", b"PXR-USDC"),
        writes=(Lines, Curves, Geometry),
        up="y",
        text=True,
    ),
    Format(
        "vtk",
        (".vtk", ".vtu"),
        "polylines, VTK legacy files and unstructured grids",
        magic=(b"# vtk DataFile",),
        text=True,
    ),
    Format("vtp", (".vtp",), "polylines, VTK polydata", writes=(Lines,), text=True),
    Format("wkt", (".csv", ".tsv", ".wkt"), "well-known text, alone or in a column of a table", up="z", text=True),
)

#: Formats that are known by name only, and what to do with them.
NOT_READ = {
    ".abc": (
        "is Alembic, which is not read; import it in Blender or Houdini, and export its curves as USD (.usdc), or read "
        "it with Alembic's own library and pass its points to Curves.from_strands or Lines.from_points"
    ),
    ".flt": "is a tree, not a file of lines; fl.load reads it",
    **dict.fromkeys(
        (".shp", ".gpkg", ".fgb", ".kml"),
        "is a format of maps that is not read; read it by geopandas.read_file, and pass the frame to fl.lines",
    ),
}


@cache
def _known_words() -> dict[str, Format]:
    """Return the formats of this package and of others by what `named` takes."""
    return by_word([("fastlines", row) for row in TABLE] + plugins.find())


def by_word(rows: Sequence[tuple[str, Format]]) -> dict[str, Format]:
    """Return formats by their names and their extensions without dots; refuse a word that two of them claim.

    Parameters
    ----------
    rows : sequence of (str, Format)
        The distribution of each format, and the format.
    """
    names = [(row.name, owner, row) for owner, row in rows]
    claims = names + [(extension, owner, row) for owner, row in rows for extension in row.extensions]
    found: dict[str, tuple[str, Format]] = {}
    for claim, owner, row in claims:
        first, other = found.setdefault(claim.removeprefix("."), (owner, row))
        if other is not row:
            others = [distribution for distribution in (owner, first) if distribution != "fastlines"]
            what_to_do = f"uninstall {others[0]}" if others else "remove it from one of them"
            raise InputError(
                f"two formats claim {claim!r}: {other.name!r} of {first} and {row.name!r} of {owner}; {what_to_do}"
            )
    return {word: row for word, (_, row) in found.items()}


def known_formats() -> dict[str, Format]:
    """Return the formats by extension, those of other distributions included; a file may also be packed by gzip."""
    return {extension: row for row in _rows() for extension in row.extensions}


def _rows() -> Iterable[Format]:
    """Return each format once, in the order of the table."""
    return dict.fromkeys(_known_words().values())


def path_of(path: str | os.PathLike[str]) -> Path:
    """Return the path of an argument."""
    try:
        return Path(path)
    except TypeError:
        raise InputError(f"path is {kind_of(path)}; expected a str or a path") from None


def extension_of(path: Path) -> tuple[str, bool]:
    """Return the extension that names the format, in lower case, and whether ``.gz`` follows it."""
    packed = path.suffix.lower() == ".gz"
    return Path(path.stem if packed else path.name).suffix.lower(), packed


def named(name: str) -> Format:
    """Return the format of a name or an extension."""
    words, word = _known_words(), name.lower().removeprefix(".")
    if word not in words:
        raise InputError(f"format {name!r} is unknown{did_you_mean(word, words)}")
    return words[word]


def of_folder(path: Path) -> Format | None:
    """Return the format of which a folder is a file, by its extension, or else by what is in it; None if it is not."""
    row = known_formats().get(path.suffix.lower())
    if row is not None and row.folder:
        return row
    folders = (row for row in _rows() if row.folder and any(file.is_file() for file in path.glob(row.folder)))
    return next(folders, None)


def find(path: Path, start: bytes) -> Format:
    """Return the format of a file by its extension, or else by its first bytes."""
    extension, _ = extension_of(path)
    known = known_formats()
    if path.is_dir() and (folder := of_folder(path)):
        return folder
    if extension in known:
        return known[extension]
    if extension in NOT_READ:
        raise FileFormatError(f"{path}: {NOT_READ[extension]}")
    for row in _rows():
        if row.magic and start.startswith(row.magic):
            return row
    raise FileFormatError(
        f"{path}: unknown extension {extension or '(none)'!r}{did_you_mean(extension, known)}, each also with .gz; "
        "name the format by format= (--format on the command line), or pass its points to Lines.from_strands"
    )


def to_write(path: Path) -> Format:
    """Return the format in which a file of this name is written."""
    if path.is_dir():
        check_target(path)
    extension, _ = extension_of(path)
    if extension == ".flt":
        raise InputError(
            f"{path}: is the name of a tree, not of a file of lines; fl.build(lines).save(path) builds a tree and "
            "saves it, and so does 'fastlines build INPUT -o FILE.flt'"
        )
    known = known_formats()
    written = {name: row for name, row in known.items() if row.writes}
    if extension not in written:
        hint = f"; known: {', '.join(written)}" if extension in known else did_you_mean(extension, written)
        raise InputError(f"{path}: files of extension {extension or '(none)'!r} are not written{hint}")
    return written[extension]
