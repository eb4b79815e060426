"""The voxel grid of .trk and .trx: read, kept by what is selected, written, taken from a reference, or made."""

from __future__ import annotations

import contextlib
import gzip
import json
import struct
import sys
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.line_files import POINTS, lost_by, trk, trx

import fastlines as fl
from fastlines.errors import FileFormatError, FileWarning, InputError, MissingExtraError
from fastlines.geometry.voxel_grid import VoxelGrid

nibabel = pytest.importorskip("nibabel")

#: Mirrored axes with voxels of three sizes, whose points are not at whole numbers in the world.
MIRRORED = np.array([[-2, 0, 0, 90.25], [0, 3, 0, -126.7], [0, 0, 4, -72], [0, 0, 0, 1]], np.float32)
OBLIQUE = np.array(
    [[0.96, -0.17, 0.22, 20], [0.19, 0.98, -0.1, -30], [-0.2, 0.14, 0.97, 40], [0, 0, 0, 1]], np.float32
) @ np.diag(np.array([2, 3, 4, 1], np.float32))
SIZES = (2, 3, 4)
INSIDE = np.random.default_rng(0).random((7, 3)) * [17, 23, 27]
#: 9 × 8 × 7 voxels of the size of SIZES, in the header of .trk of `support.line_files`.
DIMENSIONS = (9, 8, 7)


def trk_of(to_ras: np.ndarray, order: bytes, points: np.ndarray = INSIDE) -> bytes:
    """Make a .trk of three streamlines, in voxel millimetres, with all that its header may say of the orientation."""
    data = bytearray(trk(to_ras=to_ras, order=order, voxel_size=SIZES, counts=[3, 2, 2], names=()))
    data[952:956] = b"LAS\0"
    struct.pack_into("<6f", data, 956, 1, -0.0, 0, 0, -1, 0)
    data[982:988] = bytes([0, 1, 0, 1, 0, 0])
    at, i = 1000, 0
    while at < len(data):
        count = struct.unpack_from("<i", data, at)[0]
        data[at + 4 : at + 4 + 12 * count] = points[i : i + count].astype("<f4").tobytes()
        at, i = at + 4 + 12 * count, i + count
    return bytes(data)


@pytest.mark.parametrize("order", [b"RAS", b"LAS", b"LPI"])
@pytest.mark.parametrize("to_ras", [MIRRORED, OBLIQUE])
def test_a_trk_that_is_read_and_written_has_the_same_header_and_points(tmp_path, load, to_ras, order) -> None:
    data = trk_of(to_ras, order)
    lines = load(data, "a.trk")
    assert lines.metadata == {
        "grid": {
            "voxel_to_rasmm": tuple(map(tuple, to_ras.tolist())),
            "dimensions": DIMENSIONS,
            "voxel_sizes": SIZES,
            "voxel_order": order.decode(),
            "storage_order": "LAS",
            "image_orientation": (1, 0, 0, 0, -1, 0),
            "flips": (0, 1, 0, 1, 0, 0),
        }
    }
    assert lost_by(tmp_path / "b.trk", lines) == []
    written = (tmp_path / "b.trk").read_bytes()
    assert written[:1000] == data[:1000]
    before, after = (np.frombuffer(part[1000:], "<f4") for part in (data, written))
    np.testing.assert_allclose(after, before, rtol=1e-6, atol=1e-5)
    again = fl.read(tmp_path / "b.trk")
    np.testing.assert_allclose(again.segments, lines.segments, rtol=3e-7, atol=1e-5)
    if to_ras is MIRRORED:
        assert again.segments.tobytes() == lines.segments.tobytes()
    theirs = [nibabel.streamlines.load(str(tmp_path / name)) for name in ("a.trk", "b.trk")]
    for name in ("voxel_to_rasmm", "dimensions", "voxel_sizes", "voxel_order"):
        assert np.array_equal(theirs[0].header[name], theirs[1].header[name])
    for one, other in zip(theirs[0].streamlines, theirs[1].streamlines, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-6, atol=1e-4)


def test_what_is_selected_keeps_the_grid(tmp_path, load) -> None:
    lines = load(trk_of(MIRRORED, b"LAS"), "a.trk")
    some = lines.select(strands=[2, 0])
    for name in ("b.trk", "b.trk.gz", "b.trx"):
        assert lost_by(tmp_path / name, some) == ["the numbers of strands, which are counted from 0"]
        again = fl.read(tmp_path / name)
        assert again.segments.tobytes() == some.segments.tobytes()
        grid = again.metadata["grid"]
        assert grid["dimensions"] == DIMENSIONS
        assert np.array_equal(grid["voxel_to_rasmm"], MIRRORED)
        assert (grid["voxel_sizes"], grid["voxel_order"]) == (SIZES, "LAS")
    # The grid goes through trees and our own files as well.
    tree = fl.build(some)
    tree.save(tmp_path / "a.flt")
    fl.write(tmp_path / "a.npz", fl.load(tmp_path / "a.flt").geometry)
    fl.write(tmp_path / "c.trk", fl.read(tmp_path / "a.npz").select(strands=[0]))
    assert fl.read(tmp_path / "c.trk").metadata == lines.metadata


def test_a_trk_without_a_transform_is_written_without_one(tmp_path, load) -> None:
    data = trk(voxel_size=SIZES, to_ras=np.zeros((4, 4)), order=b"LPS", counts=[3, 4], names=())
    with pytest.warns(FileWarning, match="no transform to the world"):
        lines = load(data, "a.trk")
    grid = {"dimensions": DIMENSIONS, "voxel_sizes": SIZES, "voxel_order": "LPS"}
    assert lines.metadata == {"grid": grid}
    fl.write(tmp_path / "b.trk", lines)
    assert (tmp_path / "b.trk").read_bytes()[:1000] == data[:1000]
    with pytest.warns(FileWarning, match="no transform to the world"):
        assert fl.read(tmp_path / "b.trk").segments.tobytes() == lines.segments.tobytes()
    with pytest.warns(FileWarning, match="no voxel grid is known"):
        fl.write(tmp_path / "b.trx", lines)
    with pytest.raises(InputError, match="reference has no voxel grid in the world"):
        fl.write(tmp_path / "c.trk", lines, reference=lines)


def test_the_grid_of_a_trx(tmp_path, load) -> None:
    to_ras = np.diag([-1.25, 1.25, 2.5, 1]) + 1e-9
    to_ras[3] = 0, 0, 0, 1
    header = {"DIMENSIONS": [192, 193, 55], "VOXEL_TO_RASMM": to_ras.tolist(), "NB_STREAMLINES": 2, "NB_VERTICES": 7}
    lines = load(trx(header=json.dumps(header), counts=[3, 4]), "a.trx")
    assert lines.metadata["grid"]["voxel_order"] == "LAS"
    assert lines.metadata["grid"]["dimensions"] == (192, 193, 55)
    np.testing.assert_allclose(lines.metadata["grid"]["voxel_sizes"], [1.25, 1.25, 2.5])
    with pytest.warns(FileWarning, match="outside of it"):
        fl.write(tmp_path / "b.trx", lines)
    with zipfile.ZipFile(tmp_path / "b.trx") as archive:
        assert json.loads(archive.read("header.json")) == header


@pytest.mark.parametrize(
    "header",
    [{"DIMENSIONS": [1, 2, 3]}, {"DIMENSIONS": "a"}, {"DIMENSIONS": [2] * 3, "VOXEL_TO_RASMM": [[0] * 4] * 4}],
)
def test_a_trx_without_a_grid_that_can_be_used(load, header) -> None:
    with pytest.warns(FileWarning, match="its voxel grid is not read"):
        lines = load(trx(header=json.dumps(header | {"NB_STREAMLINES": 4, "NB_VERTICES": 7})), "a.trx")
    assert lines.metadata == {}


def test_a_trx_without_a_grid(load) -> None:
    assert load(trx(header='{"NB_STREAMLINES": 4, "NB_VERTICES": 7}'), "a.trx").metadata == {}


@pytest.mark.parametrize(("dimensions", "kept"), [([9.0, 8, 7.0], True), ([9.5, 8, 7], False), ([9, [8], 7], False)])
def test_numbers_of_voxels_may_be_written_as_floats(load, dimensions, kept) -> None:
    grid = {"DIMENSIONS": dimensions, "VOXEL_TO_RASMM": np.eye(4).tolist()}
    with contextlib.nullcontext() if kept else pytest.warns(FileWarning, match="its dimensions are"):
        lines = load(trx(header=json.dumps(grid | {"NB_STREAMLINES": 4, "NB_VERTICES": 7})), "a.trx")
    assert ("grid" in lines.metadata) == kept


# --- References ---

TO_WORLD = np.array([[-2, 0, 0, 90.0], [0, 2, 0, -100], [0, 0, 2, -70], [0, 0, 0, 1]])
SHAPE = (91, 109, 91)
IN_WORLD = fl.Lines.from_strands([[[0, 0, 0], [1 / 3, 1, -20]], [[-80, 90, 60], [-70, 80, 60.5], [0, 1, 2]]])


@pytest.fixture
def image(tmp_path: Path) -> Path:
    found = nibabel.Nifti1Image(np.zeros((*SHAPE, 2), np.int8), TO_WORLD)
    nibabel.save(found, tmp_path / "t1.nii.gz")
    return tmp_path / "t1.nii.gz"


def references(image: Path) -> dict[str, object]:
    loaded = nibabel.load(image)
    fl.write(image.parent / "own.trk", IN_WORLD, reference=loaded)
    fl.write(image.parent / "own.trx", IN_WORLD, reference=loaded)
    packed = image.parent / "packed.trk.gz"
    packed.write_bytes(gzip.compress((image.parent / "own.trk").read_bytes()))
    with zipfile.ZipFile(image.parent / "own.trx") as archive:
        archive.extractall(image.parent / "folder")
    mgh = nibabel.MGHImage(np.zeros(SHAPE, np.float32), TO_WORLD)
    nibabel.save(mgh, image.parent / "t1.mgz")
    tractogram = nibabel.streamlines.load(str(image.parent / "own.trk"))

    class Stateful:
        space_attributes = TO_WORLD, np.array(SHAPE, "i2"), np.array([2, 2, 2], "f4"), "LAS"

    return {
        "path of an image": image,
        "text": str(image),
        "image": loaded,
        "header of an image": loaded.header,
        "another image": mgh,
        "path of another image": image.parent / "t1.mgz",
        "path of a .trk": image.parent / "own.trk",
        "path of a .trk.gz": packed,
        "path of a .trx": image.parent / "own.trx",
        "path of a folder of .trx": image.parent / "folder",
        "tractogram": tractogram,
        "header of a tractogram": tractogram.header,
        "header of a .trx": {"DIMENSIONS": np.array(SHAPE), "VOXEL_TO_RASMM": TO_WORLD},
        "grid": {"dimensions": SHAPE, "voxel_to_rasmm": TO_WORLD.tolist()},
        "lines": fl.read(image.parent / "own.trk"),
        "StatefulTractogram": Stateful(),
    }


@pytest.mark.filterwarnings("ignore:.*that the unit is not known:fastlines.FileWarning")
@pytest.mark.parametrize("extension", [".trk", ".trx"])
def test_references(tmp_path: Path, image: Path, extension: str) -> None:
    for what, reference in references(image).items():
        path = tmp_path / f"a{extension}"
        fl.write(path, IN_WORLD, reference=reference)
        again = fl.read(path)
        grid = again.metadata["grid"]
        assert np.array_equal(grid["voxel_to_rasmm"], TO_WORLD), what
        assert (grid["dimensions"], grid["voxel_sizes"], grid["voxel_order"]) == (SHAPE, (2, 2, 2), "LAS"), what
        np.testing.assert_allclose(again.segments, IN_WORLD.segments, atol=1e-5)
        if extension == ".trk":
            theirs = nibabel.streamlines.load(str(path))
            assert np.array_equal(theirs.header["voxel_to_rasmm"], TO_WORLD)
            for mine, other in zip(IN_WORLD.to_strands(), theirs.streamlines, strict=True):
                np.testing.assert_allclose(other, mine, atol=1e-4)


def test_a_reference_replaces_the_grid_of_the_lines(tmp_path, load, image) -> None:
    lines = load(trk_of(MIRRORED, b"LAS"), "a.trk")
    with pytest.warns(FileWarning, match="7 are outside of it"):
        fl.write(tmp_path / "b.trk", lines, reference=image)
    again = fl.read(tmp_path / "b.trk").metadata["grid"]
    assert set(again) == {"voxel_to_rasmm", "dimensions", "voxel_sizes", "voxel_order"}
    assert again["dimensions"] == SHAPE


@pytest.mark.parametrize(
    ("reference", "error", "said"),
    [
        ("none.nii", FileNotFoundError, "no such file"),
        (7, InputError, "reference is an int; expected an image of nibabel"),
        (b"t1.nii", InputError, "reference is (a )?bytes"),
        ({}, InputError, "reference: expected a mapping with 'dimensions' and 'voxel_to_rasmm'"),
        ({"dimensions": [1, 2]}, InputError, r"its dimensions are \[1, 2\]; expected three numbers of voxels"),
        ({"dimensions": [1, 2, 0], "voxel_to_rasmm": np.eye(4)}, InputError, "its dimensions are"),
        ({"dimensions": [1, 2, 3.5], "voxel_to_rasmm": np.eye(4)}, InputError, "its dimensions are"),
        ({"dimensions": [1, 2, 3], "voxel_to_rasmm": np.zeros((4, 4))}, InputError, "cannot be inverted"),
        ({"dimensions": [1, 2, 3], "voxel_to_rasmm": np.full((4, 4), np.nan)}, InputError, "expected finite numbers"),
        ({"dimensions": [1, 2, 3], "voxel_to_rasmm": "x"}, InputError, "its voxel_to_rasmm are 'x'"),
        (
            {"dimensions": [1, 2, 3], "voxel_to_rasmm": np.eye(4), "voxel_order": "XYZ"},
            InputError,
            "its voxel_order is 'XYZ'; expected three directions",
        ),
        (
            {"dimensions": [1, 2, 3], "voxel_to_rasmm": np.eye(4), "voxel_sizes": [1, 0, 1]},
            InputError,
            "its voxel_sizes are .*not 0",
        ),
        (IN_WORLD, InputError, "reference has no voxel grid in the world"),
        ({"dimensions": [40_000, 1, 1], "voxel_to_rasmm": np.eye(4)}, InputError, ".trk counts up to 32767"),
    ],
)
def test_references_that_are_none(tmp_path, monkeypatch, reference, error, said) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(error, match=said):
        fl.write(tmp_path / "a.trk", IN_WORLD, reference=reference)
    assert list(tmp_path.iterdir()) == []


def test_files_that_are_no_reference(tmp_path, monkeypatch) -> None:
    (tmp_path / "a.nii").write_bytes(b"no image")
    fl.write(tmp_path / "a.npz", IN_WORLD)
    for name, error, said in (
        ("a.nii", FileFormatError, "a.nii: cannot be read as an image"),
        ("a.npz", InputError, "a.npz' has no voxel grid in the world"),
    ):
        with pytest.raises(error, match=said):
            fl.write(tmp_path / "b.trk", IN_WORLD, reference=tmp_path / name)
    monkeypatch.setitem(sys.modules, "nibabel", None)
    with pytest.raises(MissingExtraError, match="needs the extra 'nifti'"):
        fl.write(tmp_path / "b.trk", IN_WORLD, reference=tmp_path / "a.nii")


def test_a_grid_in_the_metadata_that_is_none(tmp_path) -> None:
    for grid in ("a", {"dimensions": [1, 2, 3], "voxel_to_rasmm": 7}):
        with pytest.raises(InputError, match=r"b\.trk: the metadata 'grid': "):
            fl.write(tmp_path / "b.trk", replace(IN_WORLD, metadata={"grid": grid}))


def test_formats_without_the_option(tmp_path) -> None:
    for name in ("a.tck", "a.npz"):
        with pytest.raises(InputError, match=r"has no option 'reference' of its writer; it has no options"):
            fl.write(tmp_path / name, IN_WORLD, reference="t1.nii")
    with pytest.raises(InputError, match="no option 'referense' of its writer; did you mean 'reference'"):
        fl.write(tmp_path / "a.trk", IN_WORLD, referense="t1.nii")


# --- Grids that are made ---

coordinates = st.floats(-1e9, 1e9, width=32) | st.floats(-500, 500, width=32) | st.floats(0, 512, width=32)


@given(st.lists(st.tuples(coordinates, coordinates, coordinates), min_size=1, max_size=8))
def test_a_grid_that_is_made_holds_the_points(points: list[tuple[float, float, float]]) -> None:
    given_points = np.array(points, np.float32)
    grid = VoxelGrid.around(given_points)
    assert grid.count_outside(given_points) == 0
    assert grid.dimensions.min() >= 1
    assert grid.dimensions.max() <= 515
    assert grid.voxel_to_rasmm is not None
    assert np.array_equal(grid.voxel_to_rasmm, grid.voxel_to_rasmm.astype(np.float32))
    # Points in voxel millimetres are not negative, and come back.
    matrix = grid.to_rasmm()
    stored = (given_points - matrix[:, 3]).astype(np.float32)
    assert stored.min() >= 0
    scale = np.ptp(given_points, axis=0).max() + np.abs(given_points).max() * 2.0**-20 + 1
    assert np.abs(stored + matrix[:, 3] - given_points).max() <= scale * 2.0**-22


def test_a_grid_that_is_made_is_told(tmp_path) -> None:
    lines = replace(IN_WORLD, unit="mm", strands=np.array([0, 1, 1]))
    said = "that no voxel grid is known (one of 83 × 91 × 83 voxels of 1 mm, which holds the lines, is written: "
    for name in ("a.trk", "a.trx"):
        assert lost_by(tmp_path / name, lines) == [f"{said}reference= takes that of your image)"]
        again = fl.read(tmp_path / name)
        np.testing.assert_allclose(again.segments, lines.segments, atol=1e-5)
        # What was made is kept from then on.
        assert lost_by(tmp_path / name, again) == []
        assert lost_by(tmp_path / name, replace(lines[:0], metadata={})) == []


def test_points_outside_of_the_grid_are_counted(tmp_path) -> None:
    grid = {"dimensions": [10, 10, 10], "voxel_to_rasmm": np.eye(4)}
    lines = fl.Lines.from_points([[0, 0, 0], [-0.5, 9.5, 0], [-0.6, 0, 0], [0, 0, 9.6]], [4])
    lines = replace(lines, unit="mm", metadata={"grid": grid})
    said = ["that all points lie in the voxel grid (2 are outside of it, and DIPY refuses such files)"]
    assert lost_by(tmp_path / "a.trk", lines) == lost_by(tmp_path / "a.trx", lines) == said
    assert np.array_equal(fl.read(tmp_path / "a.trk").segments, lines.segments)


def test_formats_without_a_grid_say_so(tmp_path, load) -> None:
    lines = load(trk_of(MIRRORED, b"LAS"), "a.trk")
    assert lost_by(tmp_path / "a.tck", lines) == ["the metadata 'grid'"]
    assert lost_by(tmp_path / "a.npz", lines) == lost_by(tmp_path / "a.safetensors", lines) == []
    assert lost_by(tmp_path / "a.trk", replace(lines, metadata={**lines.metadata, "subject": 7})) == [
        "the metadata 'subject'"
    ]


def test_values_of_points_and_streamlines_by_one_name_keep_it(tmp_path) -> None:
    lines = fl.Lines.from_points(POINTS, [3, 4], attributes={"fa": np.arange(7.0)})
    lines = replace(lines, attributes={**lines.attributes, "fa of streamline": np.array([1, 1, 2, 2, 2])})
    for name in ("a.trk", "a.trx"):
        lost_by(tmp_path / name, lines)
        again = fl.read(tmp_path / name)
        assert sorted(again.attributes) == ["fa", "fa of streamline"]
        assert again.attributes["fa of streamline"].tolist() == [1, 1, 2, 2, 2]
    header = nibabel.streamlines.load(str(tmp_path / "a.trk")).tractogram
    assert list(header.data_per_streamline) == list(header.data_per_point) == ["fa"]


@pytest.mark.parametrize(("name", "value"), [("flips", "abc"), ("image_orientation", (1, 2)), ("flips", (300,) * 6)])
def test_an_orientation_that_does_not_fit_is_refused(tmp_path, name, value) -> None:
    grid = {"dimensions": SHAPE, "voxel_to_rasmm": TO_WORLD, name: value}
    with pytest.raises(InputError, match=f"the metadata 'grid': its {name} is "):
        fl.write(tmp_path / "a.trk", replace(IN_WORLD, metadata={"grid": grid}))
