"""Files of more than 2³² bytes. They are sparse, so that they take little of the disk."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import fastlines as fl
from fastlines.support import container

BYTES = 2**32 + 64


@pytest.mark.slow
def test_a_tree_behind_a_section_of_more_than_4_gigabytes(tmp_path: Path) -> None:
    segments = np.random.default_rng(0).random((2000, 2, 3)).astype(np.float32)
    tree = fl.build(segments)
    tree.save(tmp_path / "small.flt", layout=True)
    data = (tmp_path / "small.flt").read_bytes()
    begin = 8 + int.from_bytes(data[:8], "little")

    # The large section comes first; it has more rows than 32 bits count.
    header = json.loads(data[8:begin])
    sections = {"more/large": {"dtype": "U8", "shape": [BYTES], "data_offsets": [0, BYTES]}}
    for name, section in header.items():
        if name not in ("__metadata__", "crc32"):
            moved = [BYTES + offset for offset in section["data_offsets"]]
            sections[name] = {**section, "data_offsets": moved}
    end = max(section["data_offsets"][1] for section in sections.values())
    n_sums = 1 + len(sections)
    sections["crc32"] = {"dtype": "U8", "shape": [n_sums, 4], "data_offsets": [end, end + 4 * n_sums]}
    text = json.dumps({"__metadata__": header["__metadata__"], **sections}).encode()
    text += b" " * (-(8 + len(text)) % 128)
    path = tmp_path / "large.flt"
    head = len(text).to_bytes(8, "little") + text
    with path.open("wb") as file:
        file.write(head)
        file.seek(BYTES, 1)
        file.write(data[begin : begin + end - BYTES] + bytes(4 * n_sums))
    parts = [head, *list(container.read(path)[0].values())[:-1]]
    sums = np.array([container.checksum(part) for part in parts], "<u4").tobytes()
    with path.open("r+b") as file:
        file.seek(-len(sums), 2)
        file.write(sums)

    rays = np.random.default_rng(1).normal(size=(2, 500, 3))
    for verify in (None, True):
        loaded = fl.load(path, verify=verify)
        assert loaded.layout.nodes.tobytes() == tree.layout.nodes.tobytes()
        assert loaded.all_hits(*rays, 0.01).prim.tobytes() == tree.all_hits(*rays, 0.01).prim.tobytes()
    with path.open("r+b") as file:
        file.seek(2**32)
        file.write(b"1")
    with pytest.raises(fl.FileFormatError, match="the checksum of its more/large differs"):
        fl.load(path, verify=True)


@pytest.mark.slow
def test_chunks_of_an_array(tmp_path: Path) -> None:
    n, path = BYTES // 24, tmp_path / "a.npy"
    last = np.arange(6, dtype="<f4")
    with path.open("wb") as file:
        np.lib.format.write_array_header_1_0(file, {"descr": "<f4", "fortran_order": False, "shape": (n, 2, 3)})
        file.seek(24 * (n - 1), 1)
        file.write(last.tobytes())
    n_read = 0
    for chunk in fl.read_chunks(path, 2**24):
        n_read += len(chunk)
    assert n_read == n
    assert chunk.segments[-1].ravel().tolist() == last.tolist()


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::fastlines.FileWarning")
def test_chunks_of_streamlines(tmp_path: Path) -> None:
    n_points, path = 2**22, tmp_path / "a.trk"
    n = BYTES // (4 + 12 * n_points) + 1
    points = np.zeros((2, 3), np.float32)
    fl.write(path, fl.Lines.from_points(points, [2]))
    header = bytearray(path.read_bytes()[:1000])
    header[988:992] = n.to_bytes(4, "little")
    last = np.arange(3, dtype="<f4")
    with path.open("wb") as file:
        file.write(header)
        for _ in range(n):
            file.write(n_points.to_bytes(4, "little"))
            file.seek(12 * (n_points - 1), 1)
            file.write(last.tobytes())
    n_read = 0
    for chunk in fl.read_chunks(path, n_points):
        n_read += len(chunk)
    assert path.stat().st_size > 2**32
    assert n_read == n * (n_points - 1)
    assert np.ptp(chunk.segments[-1], axis=0).any()
