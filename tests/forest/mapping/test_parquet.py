"""Rays from Parquet, and hits to Parquet."""

from __future__ import annotations

import errno
from pathlib import Path

import numpy as np
import pytest
from test_mapped_rays import rays, scene

import fastlines as fl

pa = pytest.importorskip("pyarrow")
pq = pytest.importorskip("pyarrow.parquet")

NAMES = ("x", "y", "z", "dx", "dy", "dz")


@pytest.fixture(scope="module")
def tree() -> fl.Tree:
    return fl.build(scene())


def write_rays(path: Path, n: int = 500, **more) -> tuple[np.ndarray, np.ndarray]:
    origins, directions = (part.astype(np.float32) for part in rays(n))
    columns = dict(zip(NAMES, [*origins.T, *directions.T], strict=True))
    pq.write_table(pa.table({"name": ["ray"] * n, **columns, **more}), path)
    return origins, directions


def test_first_hits(tree, tmp_path):
    given = write_rays(tmp_path / "rays.parquet")
    done = []
    options = {"radius": 0.03, "at": "surface", "rays_at_once": 120, "progress": done.append}
    assert fl.query_parquet(tree, tmp_path / "rays.parquet", tmp_path / "hits.parquet", **options) == 500
    file = pq.ParquetFile(tmp_path / "hits.parquet")
    assert file.metadata.num_row_groups == 5
    assert done == sorted(done)
    found, expected = file.read(), tree.first_hit(*given, 0.03, at="surface")
    assert found.column_names == ["ray", "t", "prim", "u", "distance", "t_out", "strand"]
    assert found["ray"].to_pylist() == list(range(500))
    hit = expected.hit
    assert 0 < hit.sum() < 500
    for name in ("t", "prim", "u", "distance", "t_out", "strand"):
        column = found[name].combine_chunks()
        assert np.array_equal(np.asarray(column.is_valid()), hit)
        assert np.array_equal(np.asarray(column.drop_null()), getattr(expected, name)[hit])


def test_lists_of_a_folder_by_a_map(tree, tmp_path):
    folder = tmp_path / "rays"
    folder.mkdir()
    given = [write_rays(folder / f"{i}.parquet", n) for i, n in enumerate((300, 400))]
    given = [np.concatenate(parts) for parts in zip(*given, strict=True)]
    tree.save(tmp_path / "tree.flt")
    forest = fl.Forest(tmp_path / "tree.flt").on(map)
    for query, options in (("all_hits", {}), ("next_hits", {"k": 1})):
        options = {"radius": 0.03, "rays_at_once": 350, **options}
        assert fl.query_parquet(forest, folder, tmp_path / "hits.parquet", query, **options) == 700
        del options["rays_at_once"]
        found, expected = pq.read_table(tmp_path / "hits.parquet"), getattr(tree, query)(*given, **options)
        for name in ("ray", "t", "prim", "u", "distance", "strand"):
            assert np.array_equal(found[name].to_numpy(), getattr(expected, name))


def test_any_and_count_with_columns_of_rays(tree, tmp_path):
    radius, t_max = np.random.default_rng(0).uniform(0, 0.2, (2, 500)).astype(np.float32)
    given = write_rays(tmp_path / "rays.parquet", radius=radius, t_max=t_max * 20)
    for query, name in (("any_hit", "hit"), ("count_hits", "count")):
        fl.query_parquet(tree, tmp_path / "rays.parquet", tmp_path / "hits.parquet", query)
        expected = getattr(tree, query)(*given, radius, t_max=t_max * 20)
        assert np.array_equal(pq.read_table(tmp_path / "hits.parquet")[name].to_numpy(), expected)
    # What is given counts for all rays.
    fl.query_parquet(tree, tmp_path / "rays.parquet", tmp_path / "hits.parquet", "any_hit", 0.03, t_max=np.inf)
    expected = tree.any_hit(*given, 0.03)
    assert np.array_equal(pq.read_table(tmp_path / "hits.parquet")["hit"].to_numpy(), expected)


def test_no_rays(tree, tmp_path):
    write_rays(tmp_path / "rays.parquet", 0)
    for query in ("first_hit", "all_hits", "count_hits"):
        assert fl.query_parquet(tree, tmp_path / "rays.parquet", tmp_path / "hits.parquet", query, 0.03) == 0
        assert len(pq.read_table(tmp_path / "hits.parquet")) == 0


def test_errors_leave_no_file(tree, tmp_path):
    path, hits = tmp_path / "rays.parquet", tmp_path / "hits.parquet"
    pq.write_table(pa.table({"x": [1.0], "dx": [1.0]}), path)
    with pytest.raises(fl.FileFormatError, match=r"rays\.parquet has no columns y, z, dy, dz; expected x, y, z of"):
        fl.query_parquet(tree, path, hits, radius=0.1)
    path.write_bytes(b"no Parquet")
    with pytest.raises(fl.FileFormatError, match=r"rays\.parquet is not a Parquet file"):
        fl.query_parquet(tree, path, hits, radius=0.1)
    pq.write_table(pa.table({name: [1.0, None] for name in NAMES}), path)
    with pytest.raises(fl.FileFormatError, match="the columns x, y, z, dx, dy, dz of rays hold nulls"):
        fl.query_parquet(tree, path, hits, radius=0.1)
    pq.write_table(pa.table({name: [1.0, float("nan")] for name in NAMES}), path)
    with pytest.raises(fl.InputError, match="row 1"):
        fl.query_parquet(tree, path, hits, radius=0.1, rays_at_once=2)
    with pytest.raises(fl.InputError, match="holds the rays; write the hits to another file"):
        fl.query_parquet(tree, path, path, radius=0.1)
    with pytest.raises(fl.InputError, match=r"is a folder without \*\.parquet files"):
        fl.query_parquet(tree, (tmp_path / "empty").mkdir() or tmp_path / "empty", hits, radius=0.1)
    with pytest.raises(fl.InputError, match="query='first' is not a choice"):
        fl.query_parquet(tree, path, hits, "first", 0.1)
    with pytest.raises(FileNotFoundError):
        fl.query_parquet(tree, tmp_path / "none.parquet", hits, radius=0.1)
    assert [entry.name for entry in tmp_path.iterdir() if entry.name.startswith("hits")] == []


def test_hits_are_written_as_parquet_alone(tree, tmp_path):
    with pytest.raises(fl.InputError, match=r"hits.csv: hits are written as Parquet; name a .parquet file"):
        fl.query_parquet(tree, tmp_path / "rays.parquet", tmp_path / "hits.csv", radius=0.1)


def test_a_disk_that_cannot_read_the_rays_is_named(tree, tmp_path, monkeypatch):
    """Not the file of hits, which is written at the same time."""

    class Broken:
        def __init__(self, path):
            self.file = real(path)

        def iter_batches(self, *_, **__):
            yield from self.file.iter_batches(100)
            raise OSError(errno.EIO, "Input/output error")

        def __getattr__(self, name):
            return getattr(self.file, name)

    write_rays(tmp_path / "rays.parquet")
    real = pq.ParquetFile
    monkeypatch.setattr(pq, "ParquetFile", Broken)
    with pytest.raises(OSError, match=r"^\[Errno 5\] Input/output error: '.*rays\.parquet'$"):
        fl.query_parquet(tree, tmp_path / "rays.parquet", tmp_path / "hits.parquet")
    assert not (tmp_path / "hits.parquet").exists()
