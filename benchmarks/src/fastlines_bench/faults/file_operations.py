"""The operations whose files fail: trees, lines in each format, pictures, drawings, forests, and the command line."""

from __future__ import annotations

import contextlib
import ctypes
import hashlib
import io
import os
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import fastlines as fl

from ..harness.internals import FastlinesError, app, known_formats
from .memory_operations import arrays_of, scene

#: The number of rays that compare trees and forests.
N_RAYS = 50


class CommandError(Exception):
    """A command that did not end with 0: its message, and whether it is one sentence."""

    def __init__(self, code: int, text: str) -> None:
        super().__init__(text)
        self.is_sentence = code in (1, 2) and text.startswith("error: ") and text.count("\n") == 1


def names_file(error: BaseException, path: Path) -> bool:
    """Return whether an error is one line that names a file."""
    if isinstance(error, CommandError):
        return error.is_sentence and str(path) in str(error)
    known = isinstance(error, OSError | FastlinesError)
    return known and "\n" not in str(error) and str(path) in str(error)


@dataclass(frozen=True)
class FileOperation:
    """A call that writes a file or a folder, what stands there before, and what is read of it.

    `goes_on` says that a call that fails may leave files, which the next call uses and removes.
    """

    name: str
    target: str
    write: Callable[[Path, int], Any]
    read: Callable[[Path], Any]
    goes_on: bool = False


def digest(path: Path) -> str:
    """Return a hash of the bytes of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


class FileOperations:
    """All operations; each writes one of two versions. Of formats, those that are named."""

    def __init__(self, folder: Path, formats: Sequence[str] | None = None) -> None:
        self.formats = (*written_formats(), ".tck.gz") if formats is None else formats
        first = scene()
        self.lines = [first, fl.Lines.from_strands(list(first.segments[::-1] + np.float32(1)))]
        self.trees = [fl.build(lines) for lines in self.lines]
        self.inputs = [folder / f"input{i}.npz" for i in range(2)]
        for path, lines in zip(self.inputs, self.lines, strict=True):
            fl.write(path, lines)
        rng = np.random.default_rng(3)
        self.rays = (rng.normal(0, 2, (N_RAYS, 3)), rng.normal(0, 1, (N_RAYS, 3)))
        self.ray_file = folder / "rays.parquet"
        write_rays(self.ray_file, self.rays)

    def __iter__(self) -> Iterator[FileOperation]:
        yield FileOperation("save", "a.flt", lambda path, i: self.trees[i].save(path), self._read_tree)
        yield FileOperation(
            "save with the layout", "a.flt", lambda path, i: self.trees[i].save(path, layout=True), self._read_tree
        )
        for extension in self.formats:
            yield FileOperation(f"write {extension}", f"a{extension}", self._write_lines, self._read_lines)
        yield FileOperation("picture", "a.png", lambda path, i: self._picture(i).save(path), digest)
        yield FileOperation("film", "a.gif", self._write_film, digest)
        yield FileOperation("query_parquet", "hits.parquet", self._query_parquet, self._read_parquet)
        yield FileOperation("library save", "a.flt", self._save_by_library, self._read_tree)
        yield FileOperation("build_forest", "forest", self._build_forest, self._read_forest, goes_on=True)
        yield from self._commands()

    def _commands(self) -> Iterator[FileOperation]:
        def command(*words: str) -> Callable[[Path, int], Any]:
            def call(path: Path, i: int) -> None:
                run_command([word.format(input=self.inputs[i], output=path) for word in words])

            return call

        yield FileOperation("fastlines build", "a.flt", command("build", "{input}", "-o", "{output}"), self._read_tree)
        yield FileOperation("fastlines convert", "a.trk", command("convert", "{input}", "{output}"), self._read_lines)
        size = ("--width", "24", "--radius", "0.01")
        yield FileOperation("fastlines render", "a.png", command("render", "{input}", "-o", "{output}", *size), digest)
        yield FileOperation(
            "fastlines draw", "a.png", command("draw", "{input}", "--kind", "levels", "-o", "{output}"), digest
        )
        yield FileOperation("fastlines view", "a.html", command("view", "{input}", "--export", "{output}"), digest)
        yield FileOperation(
            "fastlines forest build",
            "forest",
            command("forest", "build", "{input}", "-o", "{output}"),
            self._read_forest,
            goes_on=True,
        )

    def _write_lines(self, path: Path, i: int) -> None:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            fl.write(path, self.lines[i])

    def _read_lines(self, path: Path) -> Any:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return arrays_of(fl.read(path))

    def _read_tree(self, path: Path) -> Any:
        return arrays_of(fl.load(path).first_hit(*self.rays, 0.05))

    def _picture(self, i: int) -> fl.Picture:
        return fl.render(self.trees[i], width=24, height=16, samples=1, radius=0.01, look="depth")

    def _write_film(self, path: Path, i: int) -> None:
        from fastlines.rendering import write_frames

        write_frames(path, [self._picture(i), self._picture(1 - i)])

    def _query_parquet(self, path: Path, i: int) -> None:
        fl.query_parquet(self.trees[i], self.ray_file, path, radius=0.05)

    def _read_parquet(self, path: Path) -> Any:
        import pyarrow.parquet as pq

        return pq.read_table(path).to_pydict()

    def _save_by_library(self, path: Path, i: int) -> None:
        library = ctypes.CDLL(str(next(Path(fl.get_lib()).glob("libfastlines.so*"))))
        library.fl_error_message.restype = ctypes.c_char_p
        tree, rows = ctypes.c_void_p(), np.ascontiguousarray(self.lines[i].segments)
        if library.fl_build(rows.ctypes.data_as(ctypes.c_void_p), ctypes.c_size_t(len(rows)), None, ctypes.byref(tree)):
            raise AssertionError(library.fl_error_message().decode())
        status = library.fl_save(tree, os.fsencode(path))
        library.fl_free_tree(tree)
        if status:
            raise FastlinesError(library.fl_error_message().decode())

    def _build_forest(self, path: Path, i: int) -> None:
        fl.build_forest(self.inputs[i], path, max_segments=300)

    def _read_forest(self, path: Path) -> Any:
        return arrays_of(fl.Forest(path).first_hit(*self.rays, 0.05))


def write_rays(path: Path, rays: tuple[Any, Any]) -> None:
    """Write rays as a table."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    columns = dict(zip(("x", "y", "z", "dx", "dy", "dz"), np.hstack(rays).T, strict=True))
    pq.write_table(pa.table(columns), path)


def written_formats() -> list[str]:
    """Return the extensions of all formats that can be written here, one for each writer."""
    lines, known = scene(), []
    import tempfile

    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for extension, row in known_formats().items():
            if row.writes and type(lines) in row.writes:
                with contextlib.suppress(FastlinesError):
                    fl.write(Path(folder) / f"a{extension}", lines)
                    known.append(extension)
    return known


def run_command(words: list[str]) -> None:
    """Run ``fastlines`` in this process; raise `CommandError` if its exit code is not 0."""
    errors = io.StringIO()
    with contextlib.redirect_stderr(errors), contextlib.redirect_stdout(io.StringIO()):
        code = app(words, standalone_mode=False)
    if code:
        raise CommandError(code, errors.getvalue())
