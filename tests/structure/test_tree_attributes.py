"""What a tree file keeps of its lines beside segments: attributes of every type that it can, and what is up."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from support import nasty

import fastlines as fl
from fastlines.support import container

SEGMENTS = nasty.crossing(np.random.default_rng(0), 15).astype(np.float32)


def back(tmp_path, **more):
    """Save a tree over lines with more, and return the lines that are loaded again."""
    tree = fl.build(fl.Lines.from_segments(SEGMENTS, **more))
    tree.save(tmp_path / "a.flt")
    loaded = fl.load(tmp_path / "a.flt")
    rays = SEGMENTS[:, 0] - [0, 0, 5], [0, 0, 1]
    assert loaded.all_hits(*rays, 0.2).prim.tolist() == tree.all_hits(*rays, 0.2).prim.tolist()
    return loaded.geometry


@pytest.mark.parametrize("dtype", ["?", *"bhilBHILefd", ">i2", ">f8"])
@pytest.mark.parametrize("row", [(), (3,), (2, 3)])
def test_attributes_of_numbers_are_kept(tmp_path, dtype, row):
    values = np.random.default_rng(1).integers(0, 100, (15, *row)).astype(dtype)
    lines = back(tmp_path, attributes={"odd": np.arange(15, dtype=np.int8), "a/b ü": values, "id": np.arange(15)})
    assert lines.attributes.keys() == {"odd", "a/b ü", "id"}
    got = lines.attributes["a/b ü"]
    assert got.dtype == values.dtype.newbyteorder("<")
    assert got.shape == values.shape
    assert (got == values).all()
    for array in lines.attributes.values():
        assert not array.flags.writeable
        assert array.flags.aligned
        assert isinstance(array, np.memmap), "attributes are mapped, not read"


def test_skipped_rows_and_no_rows(tmp_path):
    ends = SEGMENTS.copy()
    ends[4] = np.nan
    tree = fl.build(fl.Lines.from_segments(ends, attributes={"id": np.arange(15)}, invalid="skip"))
    tree.save(tmp_path / "a.flt")
    assert fl.load(tmp_path / "a.flt").geometry.attributes["id"].tolist() == [i for i in range(15) if i != 4]
    fl.build(fl.Lines.from_segments(SEGMENTS[:0], attributes={"id": np.zeros((0, 2))})).save(tmp_path / "b.flt")
    assert fl.load(tmp_path / "b.flt").geometry.attributes["id"].shape == (0, 2)


def test_attributes_that_can_not_be_kept_are_named(tmp_path):
    lost = {
        "wide": np.zeros(15, np.longdouble),
        "wave": np.zeros(15, complex),
        "deep": np.zeros((15, 1, 1, 1)),
        "object": np.full(15, None),
    }
    tree = fl.build(fl.Lines.from_segments(SEGMENTS, attributes={**lost, "id": np.arange(15)}))
    with pytest.warns(UserWarning, match=r"a\.flt does not keep the attributes .* convert them, or save") as told:
        tree.save(tmp_path / "a.flt")
    assert all(f"{name!r} (" in str(told[0].message) for name in lost)
    assert "'id'" not in str(told[0].message)
    assert told[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert fl.load(tmp_path / "a.flt").geometry.attributes.keys() == {"id"}


def test_texts_are_kept(tmp_path):
    names = np.array(["oak", "", "ölm\n", "oak", "\ud800"] * 3, object)
    ends = np.stack([names, names[::-1]], axis=1)
    lines = back(tmp_path, attributes={"name": names, "kind": np.full(15, "x")}, end_attributes={"atom": ends})
    assert lines.attributes["name"].tolist() == names.tolist()
    assert lines.attributes["kind"].tolist() == ["x"] * 15
    assert lines.end_attributes["atom"].tolist() == ends.tolist()
    assert lines.attributes["atom"].tolist() == names.tolist()
    with pytest.raises(ValueError, match="read-only"):
        lines.attributes["name"][0] = "elm"


@pytest.mark.parametrize(
    "wrong",
    [
        {"texts/attributes/name": np.frombuffer(b'["oak"]', np.uint8)},
        {"texts/attributes/name": np.frombuffer(b"[1, 2]", np.uint8)},
        {"texts/attributes/name": np.frombuffer(b'["oak', np.uint8)},
        {"attributes/name": np.full(15, -1, np.int32)},
        {"attributes/name": np.zeros(15)},
    ],
)
def test_texts_that_do_not_fit_are_refused(tmp_path, wrong):
    fl.build(fl.Lines.from_segments(SEGMENTS, attributes={"name": ["oak", "elm", "ash"] * 5})).save(tmp_path / "a.flt")
    arrays, metadata = container.read(tmp_path / "a.flt")
    arrays = {name: np.array(array) for name, array in arrays.items()}
    container.write(tmp_path / "b.flt", {**arrays, **wrong}, metadata)
    with pytest.raises(fl.FileFormatError, match="not a usable tree file"):
        fl.load(tmp_path / "b.flt")


def test_an_attribute_without_a_row_for_each_segment_is_refused(tmp_path):
    fl.build(fl.Lines.from_segments(SEGMENTS, attributes={"id": np.arange(15)})).save(tmp_path / "a.flt")
    arrays, metadata = container.read(tmp_path / "a.flt")
    arrays = {name: np.array(array) for name, array in arrays.items()}
    for wrong in (np.arange(14), np.zeros((), np.int64)):
        container.write(tmp_path / "b.flt", {**arrays, "attributes/id": wrong}, metadata)
        with pytest.raises(fl.FileFormatError, match="one row for each of 15 segments"):
            fl.load(tmp_path / "b.flt")


def test_names_that_no_header_can_hold_are_refused_before_the_file_is_written(tmp_path):
    tree = fl.build(fl.Lines.from_segments(SEGMENTS, attributes={"x" * (1 << 20): np.arange(15)}))
    with pytest.raises(fl.InputError, match="shorten them"):
        tree.save(tmp_path / "a.flt")
    assert not list(tmp_path.iterdir())


def test_a_file_that_makes_up_an_axis_is_refused(tmp_path):
    fl.build(SEGMENTS).save(tmp_path / "a.flt")
    arrays, metadata = container.read(tmp_path / "a.flt")
    assert "up" not in metadata
    container.write(tmp_path / "b.flt", arrays, {**metadata, "up": "w"})
    with pytest.raises(fl.FileFormatError, match="up='w' is not a choice"):
        fl.load(tmp_path / "b.flt")
