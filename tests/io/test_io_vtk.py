"""Line cells in files of VTK: legacy and XML, from hand-written bytes; and written .vtp."""

from __future__ import annotations

import re
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from support.line_files import POINTS, message_of
from support.vtk_files import CELL_NUMBERS, COLOUR, RADIUS, ROWS, STRANDS, legacy, xml

import fastlines as fl
from fastlines.errors import FastlinesError

LEFT_OUT = "1 vertices, 1 polygons left out: only lines and polylines are read"
PACKERS = ("", "vtkZLibDataCompressor", "vtkLZMADataCompressor")


def check(lines: fl.Lines) -> None:
    np.testing.assert_array_equal(lines.segments, POINTS[ROWS])
    np.testing.assert_array_equal(lines.strands, STRANDS)
    np.testing.assert_array_equal(lines.radius, RADIUS[ROWS])
    np.testing.assert_array_equal(lines.end_attributes["the colour"], COLOUR[ROWS])
    np.testing.assert_array_equal(lines.attributes["number"], CELL_NUMBERS)
    assert lines.attributes["number"].dtype == np.int32
    assert set(lines.attributes) == {"the colour", "number"}


@pytest.mark.parametrize("version", ["3.0", "4.2", "5.1"])
@pytest.mark.parametrize("binary", [False, True])
def test_legacy(load, version, binary):
    data = legacy(binary=binary, version=version)
    with pytest.warns(fl.FileWarning, match=LEFT_OUT):
        check(load(data, "a.vtk"))
    if not binary:
        with pytest.warns(fl.FileWarning, match=LEFT_OUT):
            check(load(data.replace(b"\n", b"\r\n"), "a.vtk"))


def test_a_radius_of_cells_beside_that_of_points_is_an_attribute(load):
    data = legacy().replace(b"SCALARS number int", b"SCALARS radius int")
    with pytest.warns(fl.FileWarning, match=LEFT_OUT):
        lines = load(data, "a.vtk")
    np.testing.assert_array_equal(lines.radius, RADIUS[ROWS])
    np.testing.assert_array_equal(lines.attributes["radius of cell"], CELL_NUMBERS)


def prefixed(text: bytes, n_bytes: int) -> bytes:
    """Return a text behind its length in so many bytes, which the highest two bits tell."""
    form = {1: 3, 2: 2, 4: 1, 8: 0}[n_bytes] << (8 * n_bytes - 2)
    return (form | len(text)).to_bytes(n_bytes, "big") + text


@pytest.mark.parametrize("binary", [False, True])
def test_legacy_texts_are_skipped_and_colours_follow_them(load, binary):
    sizes = [(1, 1), (2, 1), (63, 1), (64, 2), (300, 2), (20_000, 4), (70_000, 8)]
    texts = [prefixed(b"x" * n, n_bytes) if binary else b"x" * n + b"\n" for n, n_bytes in sizes]
    colours = COLOUR.tobytes() if binary else b" ".join(b"%r" % (value / 255) for value in COLOUR.ravel().tolist())
    parts = [legacy(binary=binary).partition(b"CELL_DATA")[0], b"FIELD more 1\nname 1 7 string\n", *texts]
    parts += [b"\nCOLOR_SCALARS shade 3\n", colours, b"\n"]
    with pytest.warns(fl.FileWarning, match="'name' holds no numbers, and is left out|" + LEFT_OUT):
        lines = load(b"".join(parts), "a.vtk")
    np.testing.assert_array_equal(lines.end_attributes["shade"], COLOUR[ROWS])
    assert lines.end_attributes["shade"].dtype == np.uint8


@pytest.mark.parametrize(
    "options",
    [
        {"form": "ascii"},
        *({"form": "binary", "packer": packer} for packer in PACKERS),
        *({"form": "appended", "packer": packer, "raw": raw} for packer in PACKERS for raw in (False, True)),
        {"form": "binary", "alone": False},
        {"form": "appended", "raw": False, "alone": False},
        {"form": "appended", "order": ">"},
        {"form": "binary", "size_type": "UInt64"},
        {"form": "binary", "size_type": "UInt64", "packer": PACKERS[1], "block": 8},
        {"form": "appended", "size_type": "UInt64", "order": ">", "packer": PACKERS[1], "block": 1 << 15},
    ],
    ids=str,
)
def test_xml_in_every_encoding(load, options):
    with pytest.warns(fl.FileWarning, match=LEFT_OUT):
        check(load(xml(**options), "a.vtp"))


def test_pieces(load):
    with pytest.warns(fl.FileWarning, match="2 vertices, 2 polygons left out"):
        lines = load(xml(pieces=2, form="appended"), "a.vtp")
    np.testing.assert_array_equal(lines.segments, np.tile(POINTS[ROWS], (2, 1, 1)))
    np.testing.assert_array_equal(lines.strands, [*STRANDS, *np.add(STRANDS, 4)])
    np.testing.assert_array_equal(lines.attributes["number"], CELL_NUMBERS * 2)


def test_grid(load):
    data = legacy(lines=False, kind="UNSTRUCTURED_GRID").replace(
        b"\nPOINT_DATA",
        b"CELLS 5 16\n3 0 1 2\n2 3 4\n3 4 5 6\n2 5 6\n1 0\nCELL_TYPES 5\n4 3 21 3 1\n"
        b"CELL_DATA 5\nVECTORS v double\n0 1 2 3 4 5 6 7 8 9 10 11 12 13 14\nPOINT_DATA",
    )
    with pytest.warns(fl.FileWarning, match="1 quadratic edges, 1 other cells left out"):
        lines = load(data, "a.vtk")
    np.testing.assert_array_equal(lines.segments, POINTS[[[0, 1], [1, 2], [3, 4], [5, 6]]])
    np.testing.assert_array_equal(lines.strands, [0, 0, 1, 2])
    np.testing.assert_array_equal(lines.attributes["v"][:, 0], [0, 0, 3, 9])


def test_radius_of_cells(load):
    data = legacy().replace(b"SCALARS Radius", b"SCALARS thickness").replace(b"number", b"RADIUS")
    with pytest.warns(fl.FileWarning, match=LEFT_OUT):
        lines = load(data, "a.vtk")
    np.testing.assert_array_equal(lines.radius[:, 0], CELL_NUMBERS)
    assert set(lines.attributes) == {"thickness", "the colour"}


@pytest.mark.parametrize(("data", "name", "usual"), [(xml(), "a.vtp", "RADIUS"), (legacy(), "a.vtk", "Radius")])
@pytest.mark.filterwarnings("ignore::fastlines.FileWarning")
def test_radius_by_its_name(load, data, name, usual):
    lines = load(data, name, radius="number")
    np.testing.assert_array_equal(lines.radius, np.stack([CELL_NUMBERS] * 2, axis=1))
    assert set(lines.attributes) == {"the colour", f"{usual} of point"}
    again = load(data.replace(usual.encode(), b"weight"), name, radius="weight")
    np.testing.assert_array_equal(again.radius, RADIUS[ROWS])
    for wrong in ("the colour", "oak"):
        with pytest.raises(fl.InputError, match=f"no array '{wrong}' of one number each .* those are: '{usual}'"):
            load(data, name, radius=wrong)


def test_arrays_that_cannot_be_used_are_told(load):
    fields = '<FieldData><Array type="String" Name="unit" format="ascii">109 109 0</Array>'
    fields += '<DataArray type="Float32" Name="TIME" format="ascii">1.5</DataArray></FieldData>'
    text = xml(fields=fields).replace(b'Name="number"', b'Name="the colour"')
    text = text.replace(b"<PointData>", b'<PointData><DataArray type="Int8" Name="few">1 2</DataArray>')
    with pytest.warns(fl.FileWarning) as told:
        lines = load(text, "a.vtp")
    assert lines.unit == "mm"
    assert set(lines.attributes) == {"the colour", "the colour of cell"}
    messages = [str(each.message) for each in told]
    for said in ("'few' has 2 rows for 7 points", "field data 'TIME' are left out", LEFT_OUT):
        assert any(said in message for message in messages), messages


@pytest.mark.filterwarnings("ignore::fastlines.FileWarning")
@pytest.mark.parametrize("binary", [False, True])
def test_texts_of_all_lengths_take_little_memory(load, binary):
    n = 10_000
    texts = b"\xc1x" * n + (n + (2 << 14)).to_bytes(2, "big") if binary else b"x\n" * n
    data = legacy(binary=binary) + b"FIELD f 1\na 1 10001 string\n" + texts + b"y" * n + b"\n"
    tracemalloc.start()
    try:
        check(load(data, "a.vtk"))
        assert tracemalloc.get_traced_memory()[1] < 20e6
    finally:
        tracemalloc.stop()


def test_arrays_of_the_same_bytes_count_each(load):
    array, n = '<DataArray type="Int8" Name="a" format="appended" offset="0"/>', 1 << 20
    data = f'<VTKFile type="PolyData"><PolyData><Piece><PointData>{array * 300}</PointData></Piece></PolyData>'.encode()
    data += b'<AppendedData encoding="raw">_' + n.to_bytes(4, "little") + bytes(n) + b"</AppendedData></VTKFile>"
    assert "sizes before its array 'a' do not fit" in message_of(load, data, "a.vtp")


def test_points_without_lines(load):
    with pytest.warns(fl.FileWarning, match="its 7 points are left out, as no line joins them"):
        assert len(load(legacy(lines=False), "a.vtk")) == 0


@pytest.mark.parametrize(
    ("name", "data", "said"),
    [
        ("a.vtk", b"VTK" + legacy(), "its XML cannot be read"),
        ("a.vtk", legacy(version="9.0"), "is of version 9.0"),
        ("a.vtk", legacy().replace(b"ASCII", b"ASCIZ"), "'ASCIZ'; expected up to 5.1, ASCII or BINARY"),
        ("a.vtk", legacy(kind="STRUCTURED_GRID"), "holds STRUCTURED_GRID; expected POLYDATA or UNSTRUCTURED_GRID"),
        ("a.vtk", legacy().replace(b"POINTS 7", b"POINTS 8"), "points, from byte .* expected 24 numbers, found 21"),
        ("a.vtk", legacy().replace(b"POINTS 7", b"POINTS 99999999"), "'99999999' is not a number of values that its"),
        ("a.vtk", legacy(binary=True).replace(b"POINTS 7", b"POINTS 99"), "points .*do not fit"),
        (
            "a.vtk",
            legacy().replace(b"POINTS 7 float", b"POINTS 7 flout"),
            "points are of type 'flout', which",
        ),
        ("a.vtk", legacy().replace(b"POINTS 7 float", b"POINTS 7"), "its section 'POINTS' before byte .* lacks sizes"),
        ("a.vtk", legacy().replace(b"LINES 4", b"LINES 3"), "LINES announces 3 cells in 10 numbers"),
        ("a.vtk", legacy().replace(b"LINES 4 10\n3 0 1 2", b"LINES 4 10\n3 0 1 7"), "lines are of points 0 to 7"),
        ("a.vtk", legacy().replace(b"LINES 4 10\n3 0 1 2", b"LINES 4 10\n3 0 x 2"), "expected 10 numbers, found"),
        ("a.vtk", legacy(version="5.1").replace(b"OFFSETS", b"OFSETS"), "'OFSETS'; expected OFFSETS"),
        ("a.vtk", legacy(version="5.1").replace(b"0 3 5 5 6", b"0 3 5 4 6"), "offsets of its LINES do not rise"),
        ("a.vtk", legacy().replace(b"METADATA", b"METASTASIS"), "'METASTASIS' is not a section of the format"),
        ("a.vtk", legacy().replace(b"0.25", b"-0.25"), "values of 'Radius' must be finite and not negative"),
        ("a.vtp", xml().replace(b'"PolyData"', b'"ImageData"'), "XML of the type 'ImageData'; expected a VTKFile of"),
        ("a.vtp", b'<!DOCTYPE a [<!ENTITY b "c">]>' + xml()[21:], "defines entities"),
        ("a.vtp", xml().replace(b'="7"', b'="8"'), "it announces 8 points and has 7"),
        ("a.vtp", xml().replace(b'NumberOfLines="4"', b'NumberOfLines="5"'), "it announces 5 Lines and has 4"),
        ("a.vtp", xml().replace(b"LittleEndian", b"MiddleEndian"), "its byte order is 'MiddleEndian'"),
        ("a.vtp", xml().replace(b'"Float32"', b'"Float31"'), "'RADIUS' is of the type 'Float31'"),
        ("a.vtp", xml().replace(b'format="ascii"', b'format="morse"'), "has the format 'morse'"),
        ("a.vtp", xml(form="appended").replace(b'offset="0"', b'offset="99999"'), "at offset '99999', which is not in"),
        ("a.vtp", xml(form="binary", packer=PACKERS[1]).replace(b"ZLib", b"LZ4"), "packed by 'vtkLZ4DataCompressor'"),
        ("a.vtp", xml(form="binary").replace(b"\nHAAAAA==", b"\nHAAAAA!="), "'RADIUS' is not base64"),
        ("a.vtp", xml(form="binary").replace(b"\nHAAAAA==", b"\nHAAA!!!!AA=="), "'RADIUS' is not base64"),
        ("a.vtp", xml(form="binary").replace(b"\nHAAAAA==", b"\n//8AAA=="), "sizes before its array 'RADIUS' do not"),
        ("a.vtp", xml(form="binary").replace(b"\nHAAAAA==", b"\nHQAAAA=="), "'RADIUS' ends after 28 of 29 bytes"),
        ("a.vtu", b"PK" + bytes(50), "its XML cannot be read"),
    ],
)
def test_lies_are_told_in_one_sentence(load, name, data, said):
    assert re.search(said, message_of(load, data, name))


@pytest.mark.filterwarnings("ignore::fastlines.FileWarning", "ignore::fastlines.PrecisionWarning")
@pytest.mark.parametrize(
    "data",
    [
        legacy(),
        legacy(binary=True),
        legacy(version="5.1"),
        xml(),
        xml(form="appended"),
        xml(form="binary", packer=PACKERS[1]),
        xml(form="appended", packer=PACKERS[2], raw=False),
    ],
    ids=["text", "binary", "5.1", "ascii", "raw", "zlib", "lzma"],
)
def test_damaged_files_raise_nothing_else(load, data):
    rng = np.random.default_rng(2024)
    name = "a.vtk" if data.startswith(b"#") else "a.vtp"
    messages = []
    for trial in range(250):
        damaged = bytearray(data)
        for at in rng.integers(len(data), size=1 + trial % 3):
            damaged[at] = rng.integers(256) if trial % 2 else damaged[at] ^ 1 << rng.integers(8)
        try:
            lines = load(bytes(damaged[: rng.integers(len(data)) if trial % 5 == 0 else None]), name)
            assert len(lines.segments) == len(lines.strands)
        except FastlinesError as error:
            messages.append(str(error))
    assert messages
    assert not any("\n" in message for message in messages)


# --- Written files ---


def test_round_trip(tmp_path, load):
    with pytest.warns(fl.FileWarning, match=LEFT_OUT):
        lines = load(xml(), "a.vtp")
    lines = replace(lines, unit="mm", up="z", strands=np.array([0, 0, 1, 2]))
    fl.write(tmp_path / "b.vtp.gz", lines)
    again = fl.read(tmp_path / "b.vtp.gz")
    np.testing.assert_array_equal(again.segments.view(np.int32), lines.segments.view(np.int32))
    np.testing.assert_array_equal(again.strands, lines.strands)
    np.testing.assert_array_equal(again.radius, lines.radius)
    assert (again.unit, again.up, set(again.end_attributes)) == ("mm", "z", {"the colour"})
    for name, values in lines.attributes.items():
        np.testing.assert_array_equal(again.attributes[name], values)
        assert again.attributes[name].dtype == values.dtype


def test_what_is_lost_is_told(tmp_path):
    values = {
        "<&\">'ü": np.arange(7.0), "Radius": np.arange(7), "half": np.arange(7, dtype="f2"),
        "yes": np.ones(7, np.bool_), "word": np.array(["a"] * 7), "cube": np.ones((7, 2, 2)), "a\nb": np.ones(7),
    }  # fmt: skip
    lines = fl.Lines.from_points(POINTS, [3, 1, 2, 1], attributes=values)
    with pytest.warns(fl.FileWarning) as told:
        fl.write(tmp_path / "a.vtp", lines)
    for said in ("'Radius of lines' is written", "'yes' is boolean", "'word', <U1", "'cube', float64", "'a?b' is writ"):
        assert said in str(told[0].message)
    again = fl.read(tmp_path / "a.vtp")
    assert again.radius is None
    assert set(again.attributes) == {"<&\">'ü", "Radius of lines", "half", "yes", "a?b"}
    np.testing.assert_array_equal(again.attributes["half"], lines.attributes["half"])
    fl.write(tmp_path / "b.vtp", np.empty((0, 2, 3)))
    assert len(fl.read(tmp_path / "b.vtp")) == 0


def test_names_that_become_the_same_are_kept_apart(tmp_path):
    of_points = {"a\nb": np.full(7, 1), "a?b": np.full(7, 2)}
    made = fl.Lines.from_points(POINTS, [3, 1, 2, 1], attributes=of_points)
    of_lines = {"a\tb": np.full(len(made), 3)}
    lines = fl.Lines(made.segments, made.strands, attributes=of_lines, end_attributes=made.end_attributes)
    with pytest.warns(fl.FileWarning) as told:
        fl.write(tmp_path / "a.vtp", lines)
    assert all(said in str(told[0].message) for said in (r"'a\nb' ('a?b_' is", r"'a\tb' ('a?b__' is"))
    read = {name: values[0] for name, values in fl.read(tmp_path / "a.vtp").attributes.items()}
    assert read == {"a?b_": 1, "a?b": 2, "a?b__": 3}


# --- The library vtk ---


def test_the_library_reads_what_is_written(tmp_path):
    library = pytest.importorskip("vtkmodules.vtkIOXML")
    support = pytest.importorskip("vtkmodules.util.numpy_support")
    lines = fl.Lines.from_points(POINTS, [3, 1, 2, 1], radius=RADIUS, attributes={"colour": COLOUR})
    fl.write(tmp_path / "a.vtp", replace(lines, unit="mm"))
    reader = library.vtkXMLPolyDataReader()
    reader.SetFileName(str(tmp_path / "a.vtp"))
    reader.Update()
    data = reader.GetOutput()
    assert data.GetNumberOfLines() == 4
    written = POINTS[[0, 1, 2, 3, 3, 4, 5, 6, 6]]
    np.testing.assert_array_equal(support.vtk_to_numpy(data.GetPoints().GetData()), written)
    np.testing.assert_array_equal(support.vtk_to_numpy(data.GetPointData().GetArray("radius"))[:3], RADIUS[:3])
    assert data.GetFieldData().GetAbstractArray("unit").GetValue(0) == "mm"


@pytest.mark.parametrize("mode", ["ASCII", "binary", "appended", "4.2", "5.1", "4.2 binary", "5.1 binary"])
def test_files_of_the_library(tmp_path, mode):
    xml_library, old = pytest.importorskip("vtkmodules.vtkIOXML"), pytest.importorskip("vtkmodules.vtkIOLegacy")
    path = tmp_path / "hand.vtp"
    path.write_bytes(xml())
    reader = xml_library.vtkXMLPolyDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    if mode[0].isdigit():
        writer, path = old.vtkPolyDataWriter(), tmp_path / "a.vtk"
        writer.SetFileVersion(int(mode[0] + mode[2]))
        (writer.SetFileTypeToBinary if mode.endswith("y") else writer.SetFileTypeToASCII)()
    else:
        writer, path = xml_library.vtkXMLPolyDataWriter(), tmp_path / "a.vtp"
        writer.SetDataMode(("ASCII", "binary", "appended").index(mode))
    writer.SetInputData(reader.GetOutput())
    writer.SetFileName(str(path))
    writer.Write()
    with pytest.warns(fl.FileWarning, match=LEFT_OUT):
        lines = fl.read(path)
    np.testing.assert_array_equal(lines.strands, STRANDS)
    np.testing.assert_array_equal(lines.attributes["number"], CELL_NUMBERS)
    # The library writes text with fewer digits than it takes to keep all bits.
    np.testing.assert_allclose(lines.segments, POINTS[ROWS], rtol=1e-5)
    np.testing.assert_array_equal(lines.end_attributes["the colour"], COLOUR[ROWS])
