"""The command ``faults`` on a few operations, and failures that operations of our own do not handle."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import done, refused

from fastlines_bench.faults.library import compile_library
from fastlines_bench.faults.run import Row
from fastlines_bench.faults.show import are_handled, faults_of

pytestmark = [
    pytest.mark.usefixtures("in_own_folder"),
    pytest.mark.skipif(not sys.platform.startswith("linux"), reason="faults are injected by LD_PRELOAD, on Linux"),
]

#: A writer that leaves half a file, and does not name it.
CARELESS = """
import os
from pathlib import Path
from fastlines_bench.faults.file_operations import FileOperation
from fastlines_bench.faults.files_worker import FileTrial

def write(path, i):
    with open(path, "wb", buffering=0) as file:
        for part in range(2):
            if file.write(bytes([i, part])) != 2:
                raise ValueError("?")

operation = FileOperation("careless", "a.bin", write, Path.read_bytes)
trial = FileTrial(operation, Path(os.path.realpath(".")), "ENOSPC")
for n in range(1, 5):
    print(*trial.run(n), sep="|")
"""


def test_memory():
    text = done("faults", "--only", "memory", "--operation", "any_hit, one ray", "--json", "f.json")
    assert "one allocation fails" in text
    rows = json.loads(Path("f.json").read_text())["memory"]
    assert [row["mode"] for row in rows] == ["once", "ever", "threads"]
    assert rows[0]["n_calls"] > 3
    assert not any(row["wrong"] for row in rows)


def test_files():
    done("faults", "--only", "files", "--operation", "write .trk", "--json", "f.json")
    rows = json.loads(Path("f.json").read_text())["files"]
    assert [row["mode"] for row in rows] == ["ENOSPC", "EIO", "EINTR"]
    assert all({"open", "write", "fsync", "rename"} <= set(row["calls"]) for row in rows)


def test_library():
    done("faults", "--only", "library", "--operation", "C load", "--json", "f.json")
    rows = json.loads(Path("f.json").read_text())["library"]
    assert [row["mode"] for row in rows] == ["once", "ever", "threads"]
    assert rows[0]["n_calls"] > 3
    assert not any(row["wrong"] for row in rows)


def test_reads():
    done("faults", "--only", "reads", "--operation", "read .tck.gz", "--json", "f.json")
    rows = json.loads(Path("f.json").read_text())["reads"]
    assert [row["mode"] for row in rows] == ["EIO", "EINTR", "short"]
    assert all(row["calls"].get("read", 0) > 1 for row in rows)


def test_a_careless_writer():
    library = compile_library("files", Path.cwd())
    environment = {**os.environ, "LD_PRELOAD": str(library)}
    run = subprocess.run([sys.executable, "-c", CARELESS], env=environment, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    opening, first, second, closing = run.stdout.splitlines()
    assert opening == "True|open|[]"
    for line in (first, second):
        assert line.startswith("True|write|")
        assert "no sentence" in line
        assert "the file is another one" in line
    assert closing.startswith("True|close|")


def test_what_was_not_handled():
    rows = {"memory": [Row("a", "once", 9), Row("b", "once", 9, ["3: it crashes"]), Row("c", "ever", 9, leaked=99.0)]}
    assert not are_handled(rows)
    assert [len(faults_of(row)) for row in rows["memory"]] == [0, 1, 1]
    assert are_handled({"memory": rows["memory"][:1]})


def test_refused():
    assert "disks" in refused("faults", "--only", "disks")[1]
    assert "no operation" in refused("faults", "--only", "memory", "--operation", "none such")[1]
