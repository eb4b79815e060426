"""An installed copy of fastlines in a process of its own, so that two versions can be measured in turn."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from fastlines import FastlinesError, InputError

from . import copy_worker


class Copy:
    """A worker process with an installed fastlines.

    Parameters
    ----------
    where : str
        A Python that has fastlines, or a folder that ``pip install --target`` made.
    n_threads : int
    """

    def __init__(self, where: str, n_threads: int = 1) -> None:
        environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
        program = where
        if os.path.isdir(where):
            if not (Path(where) / "fastlines").is_dir():
                raise InputError(f"{where}: holds no fastlines; expected a folder that pip install --target made")
            environment["PYTHONPATH"] = os.path.abspath(where)
            program = sys.executable
        command = [program, "-P", copy_worker.__file__]
        self.where = where
        try:
            self._process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                text=True,
                env=environment,
                cwd=tempfile.gettempdir(),
            )
        except OSError as error:
            raise InputError(f"{where}: is neither a Python nor a folder of an installed fastlines ({error})") from None
        self.about: dict[str, Any] = self.request("hello", n_threads=n_threads)
        if os.path.isdir(where) and not Path(self.about["folder"]).is_relative_to(Path(where).resolve()):
            raise InputError(
                f"{where}: the worker imported {self.about['folder']} instead; expected a folder without an editable "
                "install"
            )

    def request(self, method: str, /, **arguments: Any) -> Any:
        """Call a method of the worker; return its result."""
        assert self._process.stdin
        assert self._process.stdout
        try:
            print(json.dumps({"method": method, "arguments": arguments}), file=self._process.stdin, flush=True)
            line = self._process.stdout.readline()
        except OSError:
            line = ""
        if not line:
            raise FastlinesError(f"the worker process of {self.where} has ended; its error is above")
        reply = json.loads(line)
        if "error" in reply:
            raise FastlinesError(f"the request {method!r} to the fastlines of {self.where} failed: {reply['error']}")
        return reply["result"]

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._process.kill()
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe:
                pipe.close()
