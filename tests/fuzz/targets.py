"""What is fuzzed: a row for each reader of the package's own, with its seeds, its words and its comparisons."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import mutators
import seeds
import trees
from claims import check_usable, made_or_refused, require
from comparisons import Comparison, by_nibabel, by_numpy, from_file, in_chunks, packed, written
from mutators import Mutator
from support import line_files

import fastlines as fl
from fastlines.io import reading, table
from fastlines.io.formats.wkb import Wkb
from fastlines.io.source import Source

INVALID = ("error", "skip")


@dataclass(frozen=True)
class Target:
    """What is fuzzed.

    Attributes
    ----------
    name : str
        Its name on the command line, and that of the folder of its corpus.
    extension : str
        Of its files.
    seeds : callable
        Returns small whole files.
    run : callable
        Takes the bytes of a file, a random number that chooses options, and whether to compare the lines by one other
        way; None is by all. Returns whether the file is accepted; raises what may not happen.
    mutate : Mutator
    words : tuple of bytes
        What its files hold, beside numbers.
    needs : tuple of str
        The packages without which it cannot run.
    n_choices : int
        How many random numbers choose different options: from 0 on.
    """

    name: str
    extension: str
    seeds: Callable[[], list[bytes]]
    run: Callable[[bytes, int, bool | None], bool]
    mutate: Mutator = mutators.binary
    words: tuple[bytes, ...] = ()
    needs: tuple[str, ...] = ()
    n_choices: int = 2


def reader(
    extension: str,
    *more: bytes | Callable[[], list[bytes]],
    words: str | None = None,
    name: str | None = None,
    options: tuple[dict[str, Any], ...] = ({},),
    oracles: tuple[Comparison, ...] = (),
    chunks: bool = False,
    mutate: Mutator | None = None,
    needs: tuple[str, ...] = (),
) -> Target:
    """Return the target of a reader of lines, by the extension of its files."""
    row = table.named(extension)
    file = f"a.{extension}"
    ways: tuple[Comparison, ...] = (from_file, packed, *oracles, *([in_chunks] * (1 + 2 * chunks)))
    ways += (written, written) if fl.Lines in row.writes else ()

    def run(data: bytes, choice: int, compares: bool | None) -> bool:
        if not data:
            return False
        chosen: dict[str, Any] = {"invalid": INVALID[choice & 1], **options[(choice >> 1) % len(options)]}
        lines = made_or_refused(lambda: read(row, file, data, **chosen))
        is_read = not isinstance(lines, fl.FastlinesError)
        if is_read:
            check_usable(lines, may_skip=chosen["invalid"] == "skip")
        elif not needs:  # other packages raise what they will
            require(lines.__cause__ is None, f"no check refused the file, but {lines.__cause__!r} did")
        if compares is None:
            for way in dict.fromkeys(ways) if is_read else (in_chunks,):
                way(file, data, chosen, lines)
        elif compares:
            way = ways[(choice >> 16) % len(ways)] if is_read else in_chunks
            if is_read or chunks:
                way(file, data, chosen, lines)
        return is_read

    def files() -> list[bytes]:
        found = seeds.samples("." + extension)()
        for one in more:
            found += [one] if isinstance(one, bytes) else one()
        return found

    if mutate is None:
        mutate = mutators.binary if words is None else mutators.text(tokens(words))
    return Target(name or extension, extension, files, run, mutate, tokens(words or ""), needs, 2 * len(options))


def tokens(words: str) -> tuple[bytes, ...]:
    """Return words that blanks separate; ``~`` stands for a blank, and ``¶`` for the end of a line."""
    return tuple(word.replace("~", " ").replace("¶", "\n").encode() for word in words.split())


def read(row: table.Format, name: str, data: bytes, *, invalid: str, **options: Any) -> Any:
    """Read lines as `fl.read` does, from memory."""
    source = Source(data, name)
    return reading.parse(row, source.as_utf8() if row.text else source, invalid, options)


def run_wkb(data: bytes, choice: int, compares: bool | None) -> bool:
    """Find the line strings of a geometry."""
    found = Wkb()
    try:
        found.add(data, 0)
    except ValueError as error:
        require(str(error).isprintable(), "the error is not one line")
        return False
    points, counts, m = found.arrays()
    require(counts.sum() == len(points) and bool((counts > 0).all()), "the counts are not those of the points")
    require(m is None or m.shape == (len(points),), "m is no column")
    return True


XML = "<?xml~version='1.0'?> <![CDATA[ ]]> <!-- --> <!DOCTYPE~a~[<!ENTITY~b~'c'>]> &b; &amp; &#0; &#55296; xmlns='x'"

#: All targets, in the order of the table of formats.
TARGETS: tuple[Target, ...] = (
    reader("bcc", line_files.bcc(kind=b"C0"), options=({}, {"basis": "linear"})),
    reader(
        "dxf",
        words="0¶LINE¶ 0¶LWPOLYLINE¶ 0¶POLYLINE¶ 0¶VERTEX¶ 0¶SEQEND¶ 0¶ARC¶ 0¶SPLINE¶ 0¶INSERT¶ 0¶BLOCK¶ 0¶SECTION¶",
        needs=("ezdxf",),
    ),
    reader(
        "json",
        seeds.samples(".geojsonl"),
        name="geojson",
        options=({}, {"radius": "a"}),
        words='"crs": null "type":"LineString", "type":"GeometryCollection","geometries":[ "coordinates":[[0,0]], '
        '"properties":{"a":1}, \\u0000 \\ud800 [[ ]] {} "bbox":[], ¶{"type":"Point"}',
    ),
    reader(
        "gpx",
        words=XML + " <trkseg> </trkseg> <trk> </trk> <rte> </rte> <rtept~lat='1'~lon='1'/> <ele>1</ele> <wpt/> <hr> "
        "<time>2020-01-01T00:00:00Z</time> <extensions> </extensions> <name>x</name> <number>1</number>",
        options=({}, {"elevation": False}),
    ),
    reader("hair", seeds.hairs),
    reader("txt", name="mitsuba", options=({}, {"basis": "bspline"}), words="nan -inf 1e39 ¶¶ # 0~0~0~1¶ ,"),
    reader(
        "pdb",
        seeds.samples(".cif"),
        words="CONECT ATOM~~ HETATM MODEL ENDMDL TER END LINK SSBOND ANISOU _struct_conn. loop_ data_ HEADER CRYST1",
        needs=("gemmi",),
    ),
    reader("npy", seeds.arrays, oracles=(by_numpy,), chunks=True),
    reader(
        "npz",
        seeds.archives,
        mutate=mutators.archive(
            [
                f"{name}.npy"
                for name in (
                    "segments",
                    "points",
                    "counts",
                    "strands",
                    "control",
                    "radius",
                    "end_attributes/a",
                    "attributes/b",
                    "texts/a",
                    "up",
                    "unit",
                    "metadata",
                    "tolerance",
                    "x/../y",
                    "a",
                )
            ]
        ),
    ),
    reader("obj", words="v~0~0~0¶ l~1~2¶ l~-1~-2¶ f~1~2~3¶ vt~0~0¶ \\¶ # / // p~1¶ curv~1¶ vn~0~0~1¶ g~x¶ \r \t"),
    reader(
        "pbrt",
        words='AttributeBegin AttributeEnd ObjectBegin~"a" ObjectEnd ObjectInstance~"a" Identity Scale~1~1~1 '
        'Transform~[1~0~0~0~0~1~0~0~0~0~1~0~0~0~0~1] CoordSysTransform~"camera" Include~"a.pbrt" TransformBegin '
        '"integer~degree"~[2] "string~basis"~"bspline" "float~width0"~1 "float~width"~[1~2] ReverseOrientation '
        'WorldBegin WorldEnd Camera~"p" LookAt~0~0~1~0~0~0~0~1~0 ConcatTransform ActiveTransform~StartTime # [ ] "',
    ),
    reader(
        "ply",
        words="element~edge~1¶ element~vertex~1¶ element~face~1¶ property~float~radius¶ property~int~strand¶ "
        "property~list~uchar~int~a¶ property~uchar~a_0¶ property~double~x¶ property~int~vertex1¶ comment~x¶ "
        "format~binary_little_endian~1.0¶ format~binary_big_endian~1.0¶ format~ascii~1.0¶ end_header¶ obj_info¶",
    ),
    reader(
        "safetensors",
        words='"F32" "F64" "I64" "U8" "BF16" "BOOL" "F16" "shape":[1,2,3] "data_offsets":[0,24] "__metadata__":{} '
        '"segments" "points" "counts" "strands" "radius" "control" "end_attributes/a" "texts/a" "unit" "up" "metadata"',
    ),
    reader("swc", words="#~OFFSET~1~2~3¶ #~SCALE~2~2~2¶ 1~1~0~0~0~1~-1¶ 5~3~0~0~0~1~4¶ -1¶ , #~ \t nan 1e39"),
    reader(
        "tck",
        seeds.tracks,
        oracles=(by_nibabel,),
        chunks=True,
        words="count:~4¶ datatype:~Float32BE¶ datatype:~Float64LE¶ file:~.~60¶ END¶ ¶END¶ mrtrix~tracks¶ # :",
    ),
    reader("tfx"),
    reader("trk", seeds.tracts, oracles=(by_nibabel,), chunks=True),
    reader(
        "trx",
        seeds.bundles,
        chunks=True,
        options=({}, {"bundle": "left"}),
        mutate=mutators.archive(
            (
                "header.json",
                "positions.3.float32",
                "positions.3.float16",
                "positions.float64",
                "offsets.uint64",
                "offsets.int32",
                "dpv/fa.float32",
                "dpv/c.3.uint8",
                "dps/colour.2.float64",
                "groups/left.int32",
                "dpg/left/a.float32",
                "groups/right.uint32",
                "positions.3.float32/",
                "dpv/a.b.c",
                "dpv/x.bool",
                "a",
            )
        ),
    ),
    reader("data", name="usc"),
    reader(
        "vtk",
        seeds.vtk_texts,
        options=({}, {"radius": "fa"}),
        words="DATASET~POLYDATA¶ DATASET~UNSTRUCTURED_GRID¶ CELLS~1~3¶2~0~1¶ CELL_TYPES~1¶3¶ LINES~1~3¶2~0~1¶ "
        "POINTS~1~float¶0~0~0¶ POINT_DATA~1¶ CELL_DATA~1¶ SCALARS~a~float¶ FIELD~f~1¶ METADATA¶ OFFSETS~vtktypeint64¶ "
        "CONNECTIVITY~vtktypeint64¶ LOOKUP_TABLE~x~1¶ COLOR_SCALARS~c~3¶ TEXTURE_COORDINATES~t~2~float¶ bit string",
    ),
    reader(
        "vtp",
        seeds.vtk_xmls,
        seeds.samples(".vtu"),
        words=XML + " <Piece~NumberOfPoints='1'> </Piece> <DataArray~type='Float32'~format='ascii'> </DataArray> "
        "offset='0' NumberOfComponents='3' type='Int8' format='binary' Name='a' <FieldData> AAAA ==== <Verts> <Lines> "
        "<AppendedData~encoding='raw'>_ compressor='vtkZLibDataCompressor' header_type='UInt64'",
    ),
    reader(
        "csv",
        seeds.samples(".wkt"),
        name="wkt",
        options=({}, {"radius": "length"}, {"column": "the_geom"}),
        words="LINESTRING(0~0,1~1) MULTILINESTRING((0~0,1~1),(2~2,3~3)) GEOMETRYCOLLECTION( POINT(0~0) Z~ M~ ZM~ EMPTY "
        "SRID=4326; NULL \" ' ; | \t \r ¶ ( ) , nan geom # POLYGON((0~0,1~0,1~1,0~0))",
    ),
    Target("wkb", "wkb", seeds.geometries, run_wkb),
    Target("load", "flt", trees.seeds, trees.run, mutators.tree),
)
#: The readers that are not fuzzed, as another package parses their files.
LEFT_OUT = {"arrow": "pyarrow", "usd": "usd-core"}


def by_name(name: str) -> Target:
    """Return a target."""
    found = {target.name: target for target in TARGETS}
    if name not in found:
        raise SystemExit(f"there is no target {name!r}; there are {', '.join(found)}")
    return found[name]


def check(target: Target, data: bytes) -> bool:
    """Make all comparisons of a file, with each option; return whether any accepts it."""
    accepted = [target.run(data, choice, None) for choice in range(target.n_choices)]
    return any(accepted)
