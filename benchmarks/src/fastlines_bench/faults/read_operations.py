"""The operations whose reads fail: trees, lines in each format, forests, rays in Parquet, and the command line."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import fastlines as fl

from .file_operations import N_RAYS, run_command, write_rays, written_formats
from .memory_operations import arrays_of, scene

#: If USD cannot map a package, its own code ends the process (usd-core 26.11).
LEFT_OUT = (".usdz",)


@dataclass(frozen=True)
class ReadOperation:
    """A call that reads a file or a folder, and returns arrays; and what makes the file."""

    name: str
    path: Path
    make: Callable[[Path], Any]
    read: Callable[[Path], Any]


class ReadOperations:
    """All operations, over files in a folder that nothing else is in; of formats, those that are named."""

    def __init__(self, folder: Path, formats: Sequence[str] | None = None) -> None:
        if formats is None:
            formats = [name for name in (*written_formats(), ".tck.gz") if name not in LEFT_OUT]
        self.formats = formats
        self.output = Path(os.path.realpath(folder))
        self.folder = self.output / "read"
        self.folder.mkdir()
        self.lines = scene()
        self.tree = fl.build(self.lines)
        rng = np.random.default_rng(3)
        self.rays = (rng.normal(0, 2, (N_RAYS, 3)), rng.normal(0, 1, (N_RAYS, 3)), 0.05)

    def __iter__(self) -> Iterator[ReadOperation]:
        def operation(name: str, file: str, make: Callable[[Path], Any], read: Callable[[Path], Any]) -> ReadOperation:
            return ReadOperation(name, self.folder / file, make, read)

        yield operation("load", "a.flt", self.tree.save, self._load)
        yield operation("load with a layout", "a.flt", lambda path: self.tree.save(path, layout=True), self._load)
        for extension in self.formats:
            yield operation(f"read {extension}", f"a{extension}", self._write, self._read)
        yield operation("read_chunks", "a.tck", self._write, self._chunks)
        yield operation("open a forest", "forest", self._build_forest, self._forest)
        yield operation("query_parquet", "rays.parquet", lambda path: write_rays(path, self.rays[:2]), self._parquet)
        yield operation("fastlines build", "a.trk", self._write, self._build)

    def _write(self, path: Path) -> None:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            fl.write(path, self.lines)

    def _build_forest(self, path: Path) -> None:
        fl.build_forest(self.lines, path, max_segments=300)

    def _load(self, path: Path) -> Any:
        return arrays_of(fl.load(path).first_hit(*self.rays))

    def _read(self, path: Path) -> Any:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return arrays_of(fl.read(path))

    def _chunks(self, path: Path) -> Any:
        return [arrays_of(chunk) for chunk in fl.read_chunks(path)]

    def _forest(self, path: Path) -> Any:
        return arrays_of(fl.Forest(path).first_hit(*self.rays))

    def _parquet(self, path: Path) -> Any:
        fl.query_parquet(self.tree, path, self.output / "hits.parquet", radius=0.05)
        return (self.output / "hits.parquet").read_bytes()

    def _build(self, path: Path) -> Any:
        run_command(["build", str(path), "-o", str(self.output / "built.flt")])
        return (self.output / "built.flt").read_bytes()
