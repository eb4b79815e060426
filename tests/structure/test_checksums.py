"""Checksums of tree files: whatever bit is flipped, it is found."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.tree_files import joined, refused, saved, split

import fastlines as fl
from fastlines.support import container


@pytest.mark.slow
def test_any_flipped_bit_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.flt"
    _, data = saved(path)
    for place in range(len(data)):
        changed = bytearray(data)
        changed[place] ^= 1 << place % 8
        path.write_bytes(changed)
        with pytest.raises(fl.FileFormatError):
            fl.load(path)
    header, body = split(data)
    changed = bytearray(body)
    changed[header["segments"]["data_offsets"][0]] ^= 1
    path.write_bytes(joined(header, bytes(changed)))
    with pytest.raises(fl.FileFormatError, match="changed since it was written: the checksum of its segments differs"):
        fl.load(path)


def test_checksums_can_be_passed_over(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.flt"
    tree, data = saved(path)
    header, body = split(data)
    changed = bytearray(body)
    changed[header["strands"]["data_offsets"][0]] ^= 4
    path.write_bytes(joined(header, bytes(changed)))
    assert fl.load(path, verify=False).geometry.strands[0] == tree.geometry.strands[0] ^ 4
    monkeypatch.setattr(container, "VERIFIED_BYTES", len(data) - 1)
    assert fl.load(path).geometry.strands[0] != tree.geometry.strands[0]
    with pytest.raises(fl.FileFormatError, match="the checksum of its strands differs"):
        fl.load(path, verify=True)


def test_files_without_checksums(tmp_path: Path) -> None:
    path = tmp_path / "a.flt"
    header, body = split(saved(path)[1])
    body = body[: header.pop("crc32")["data_offsets"][0]]
    refused(path, joined(header, body))
    with pytest.raises(fl.FileFormatError, match="has no checksums"):
        fl.load(path)


def test_fewer_checksums_than_sections(tmp_path: Path) -> None:
    path = tmp_path / "a.flt"
    header, body = split(saved(path)[1])
    begin = header["crc32"]["data_offsets"][0]
    header["crc32"] |= {"shape": [1, 4], "data_offsets": [begin, begin + 4]}
    before = joined(header, b"")
    right = container.checksum(np.frombuffer(before, np.uint8)).to_bytes(4, "little")
    path.write_bytes(before + body[:begin] + right)
    with pytest.raises(fl.FileFormatError, match="its checksums are not one for the header and each section before"):
        fl.load(path)


@pytest.mark.parametrize("change", [{"shape": [4]}, {"dtype": "F32"}, {"shape": [5, 1]}, {"shape": [1, 5]}], ids=str)
def test_lying_checksums(tmp_path: Path, change: Any) -> None:
    path = tmp_path / "a.flt"
    header, body = split(saved(path)[1])
    path.write_bytes(joined({**header, "crc32": {**header["crc32"], **change}}, body))
    with pytest.raises(fl.FileFormatError):
        fl.load(path, verify=True)
