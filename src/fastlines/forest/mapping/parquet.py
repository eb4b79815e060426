"""Rays from Parquet, and their answers to Parquet: some rays at a time, so that neither need fit into memory."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Unpack

import numpy as np
import numpy.typing as npt

from ...arrays import choice, count
from ...errors import FileFormatError, InputError
from ...progress import reporting
from ...query.hits import AllHits, FirstHits
from ...query.queries import QUERIES
from ...query.ray_arguments import RayOptions, shows_ray_options
from ...query.ray_queries import RayQueries
from ...support.atomic_write import atomic_write, check_target
from ...support.named_errors import naming
from ...support.optional import optional
from ...support.texts import listed

#: The columns of rays: origins and directions, and what else a ray may have.
VECTORS = ("x", "y", "z", "dx", "dy", "dz")
SCALARS = ("radius", "spread", "t_min", "t_max")

#: How many rays are read and answered at a time.
RAYS_AT_ONCE = 1 << 20


@shows_ray_options
def query_parquet(
    tree: RayQueries,
    rays: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    hits: str | os.PathLike[str],
    query: str = "first_hit",
    radius: npt.ArrayLike | None = None,
    *,
    rays_at_once: int = RAYS_AT_ONCE,
    at: str | None = None,
    k: int | None = None,
    rank: str | None = None,
    merge: str | None = None,
    kernel: str = "auto",
    **options: Unpack[RayOptions],
) -> int:
    """Answer rays in Parquet files, and write what they hit to another one; neither need fit into memory.

    Parameters
    ----------
    tree : Tree or Forest
        For the workers of Dask, `Forest.on`.
    rays : path, or several
        Files, or a folder of ``*.parquet`` files in the order of their names. The columns x, y, z hold origins and dx,
        dy, dz directions. The columns radius, spread, t_min and t_max are optional, and are used where the argument of
        that name is not given. All other columns are left out.
    hits : path
        The file to write. It appears whole or not at all.
    query : {"first_hit", "any_hit", "count_hits", "all_hits", "next_hits"}
    radius, at, k, rank, merge, kernel, spread, ignore, ignore_strands, parts, t_min, t_max, invalid, progress
        As the method of that name takes them. ``ignore`` and ``ignore_strands`` are for all rays.
    rays_at_once : int
        How many rays are read and answered at a time. Their hits are a row group of the file.

    Returns
    -------
    int
        The number of rays.

    Notes
    -----
    The column ``ray`` counts the rays of all files, from 0. ``first_hit`` writes a row for each ray, whose other
    columns are null for a miss: t, prim, u, distance, t_out unless ``at="closest"``, part, row and strand, as far as
    there are any. ``all_hits`` and ``next_hits`` write a row for each hit, sorted by ray. ``any_hit`` writes the column
    hit, and ``count_hits`` the column count.

    Raises
    ------
    FileFormatError
        If a file is no Parquet, or has not the columns of rays.
    InputError
        As the method does; rays are counted within those that are answered at a time.

    Examples
    --------
    >>> import fastlines as fl, pyarrow as pa, pyarrow.parquet as pq, tempfile
    >>> rays = pa.table({"x": [0.0, 9], "y": [0.0, 9], "z": [-5.0, -5], "dx": [0, 0], "dy": [0, 0], "dz": [1, 1]})
    >>> tree = fl.build([[[-1, -1, -1], [1, 1, 1]]])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     pq.write_table(rays, f"{folder}/rays.parquet")
    ...     fl.query_parquet(tree, f"{folder}/rays.parquet", f"{folder}/hits.parquet", radius=0.5)
    ...     pq.read_table(f"{folder}/hits.parquet", columns=["ray", "t", "prim"]).to_pylist()
    2
    [{'ray': 0, 't': 5.0, 'prim': 0}, {'ray': 1, 't': None, 'prim': None}]
    """
    parquet = optional("pyarrow.parquet", "reading rays in .parquet", "arrow")
    choice("query", query, QUERIES)
    rays_at_once = count("rays_at_once", rays_at_once, 1)
    chosen = {"at": at, "k": k, "rank": rank, "merge": merge, "kernel": kernel}
    given = {name: value for name, value in chosen.items() if value is not None}
    files = _files(rays)
    if any(os.path.realpath(file) == os.path.realpath(hits) for file in files):
        raise InputError(f"{hits} holds the rays; write the hits to another file")
    if Path(hits).suffix.lower() != ".parquet":
        raise InputError(f"{hits}: hits are written as Parquet; name a .parquet file")
    check_target(hits)
    opened = [_opened(parquet, file) for file in files]
    n_rays = sum(file.metadata.num_rows for file in opened)
    n_done, writer = 0, None
    progress = options.pop("progress", False)
    with reporting(progress, "rays in Parquet") as callback, atomic_write(hits) as partial:
        try:
            for batch in _batches(files, opened, rays_at_once) if n_rays else [_none()]:
                columns = {"radius": radius, **{name: batch[name] for name in SCALARS if name in batch}, **options}
                columns |= {} if radius is None else {"radius": radius}
                vectors = (np.stack([batch[name] for name in three], axis=-1) for three in (VECTORS[:3], VECTORS[3:]))
                answer = getattr(tree, query)(*vectors, **columns, **given)
                table = _table(query, answer, n_done, tree)
                writer = writer or parquet.ParquetWriter(str(partial), table.schema)
                writer.write_table(table)
                n_done += len(batch["x"])
                if callback is not None:
                    callback(n_done / max(1, n_rays))
        finally:
            if writer is not None:
                writer.close()
    return n_done


def _files(rays: Any) -> list[str]:
    """Return the paths of files of rays."""
    several = [rays] if isinstance(rays, str | os.PathLike) else [*rays]
    files: list[str] = []
    for path in [os.fspath(path) for path in several]:
        found = sorted(map(str, Path(path).glob("*.parquet"))) if os.path.isdir(path) else [path]
        if not found:
            raise InputError(f"{path} is a folder without *.parquet files")
        files += found
    if not files:
        raise InputError("rays names no files; expected a path, or several")
    return files


def _opened(parquet: Any, path: str) -> Any:
    """Open a file, and check that it has the columns of rays."""
    import pyarrow as pa

    try:
        with naming(path):
            file = parquet.ParquetFile(path)
    except (pa.ArrowInvalid, pa.ArrowException) as error:
        raise FileFormatError(f"{path} is not a Parquet file: {error}") from None
    names = set(file.schema_arrow.names)
    if missing := [name for name in VECTORS if name not in names]:
        raise FileFormatError(
            f"{path} has no columns {listed(missing)}; expected x, y, z of origins and dx, dy, dz of directions"
        )
    return file


def _batches(paths: Sequence[str], files: Sequence[Any], size: int) -> Iterator[dict[str, npt.NDArray[Any]]]:
    """Yield the columns of some rays of files at a time."""
    for path, file in zip(paths, files, strict=True):
        names = [name for name in (*VECTORS, *SCALARS) if name in file.schema_arrow.names]
        batches = file.iter_batches(size, columns=names)
        while True:
            with naming(path):
                batch = next(batches, None)
            if batch is None:
                break
            columns = {name: batch.column(name) for name in names}
            if nulls := [name for name, column in columns.items() if column.null_count]:
                raise FileFormatError(f"the columns {listed(nulls)} of rays hold nulls; leave such rays out")
            yield {name: column.to_numpy(zero_copy_only=False) for name, column in columns.items()}


def _none() -> dict[str, npt.NDArray[Any]]:
    return {name: np.zeros(0, np.float32) for name in VECTORS}


def _table(query: str, answer: Any, first: int, tree: Any) -> Any:
    """Return the rows of an answer, whose rays count from `first`."""
    import pyarrow as pa

    if isinstance(answer, FirstHits):
        ray, miss = np.arange(len(answer.prim)), ~answer.hit
    elif isinstance(answer, AllHits):
        ray, miss = answer.ray, None
    else:
        return pa.table({"ray": first + np.arange(len(answer)), "hit" if query == "any_hit" else "count": answer})
    geometry = tree.geometry
    names = ["t", "prim", "u", "distance", *["t_out"] * (answer.t_out is not None), *["part"] * geometry.has_parts]
    names += [*["row"] * (geometry.n_skipped > 0), *["strand"] * (geometry.n_strands > 0)]
    columns = {name: pa.array(getattr(answer, name), mask=miss) for name in names}
    return pa.table({"ray": first + ray, **columns})
