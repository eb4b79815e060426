"""A process of its own that reads a file: ``python file_reader.py READER SMALL FILE`` prints its seconds and memory.

Seconds are those of the clock and of the processor. The memory is the peak of the process less its peak before. By
then it has read the small file, so all libraries are imported.
"""

from __future__ import annotations

import importlib
import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any


def fastlines(path: str) -> Any:
    """Read lines by fastlines."""
    return importlib.import_module("fastlines").read(path)


def nibabel(path: str) -> Any:
    """Read streamlines by nibabel."""
    return importlib.import_module("nibabel.streamlines").load(path).streamlines


def nibabel_lines(path: str) -> Any:
    """Read streamlines by nibabel, and make lines of them."""
    streamlines = nibabel(path)
    return importlib.import_module("fastlines").Lines.from_points(streamlines.get_data(), streamlines._lengths)


def trx(path: str) -> Any:
    """Read streamlines by trx-python, with the positions in memory."""
    file = importlib.import_module("trx.trx_file_memmap").load(path)
    return file, importlib.import_module("numpy").array(file.streamlines._data)


def trx_lines(path: str) -> Any:
    """Read streamlines by trx-python, and make lines of them."""
    streamlines = importlib.import_module("trx.trx_file_memmap").load(path).streamlines
    return importlib.import_module("fastlines").Lines.from_points(streamlines._data, streamlines._lengths)


def usd(path: str) -> Any:
    """Read the arrays of all curves by usd-core."""
    pxr = importlib.import_module("pxr.Usd"), importlib.import_module("pxr.UsdGeom")
    stage = pxr[0].Stage.Open(path)
    curves = [pxr[1].Curves(prim) for prim in stage.Traverse() if prim.IsA(pxr[1].Curves)]
    numpy = importlib.import_module("numpy")
    return [
        [
            numpy.array(attribute.Get())
            for attribute in (each.GetPointsAttr(), each.GetCurveVertexCountsAttr(), each.GetWidthsAttr())
        ]
        for each in curves
    ]


def usd_lines(path: str) -> Any:
    """Read the points of all curves by usd-core, and make lines of them."""
    numpy, lines = importlib.import_module("numpy"), importlib.import_module("fastlines").Lines
    parts = usd(path)
    points, counts = (numpy.concatenate([part[i] for part in parts]) if len(parts) > 1 else parts[0][i] for i in (0, 1))
    return lines.from_points(points, counts)


#: Each reader: the modules that it needs, and the function that reads.
READERS: dict[str, tuple[tuple[str, ...], Callable[[str], Any]]] = {
    "fastlines": (("fastlines",), fastlines),
    "nibabel": (("nibabel.streamlines",), nibabel),
    "nibabel, as lines": (("nibabel.streamlines", "fastlines"), nibabel_lines),
    "trx-python": (("trx.trx_file_memmap",), trx),
    "trx-python, as lines": (("trx.trx_file_memmap", "fastlines"), trx_lines),
    "usd-core": (("numpy", "pxr.Usd", "pxr.UsdGeom"), usd),
    "usd-core, as lines": (("numpy", "pxr.Usd", "pxr.UsdGeom", "fastlines"), usd_lines),
}


def peak() -> int:
    """Return the peak of this process's memory in bytes."""
    status = Path("/proc/self/status")
    if status.exists():  # on Linux, ru_maxrss of a new process is that of its parent
        words = status.read_text().partition("VmHWM:")[2].split()
        return 1024 * int(words[0])
    import resource  # not on Windows

    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit


def main() -> None:
    """Read the files that the command line names."""
    _, read = READERS[sys.argv[1]]
    read(sys.argv[2])
    before, start, cpu = peak(), time.perf_counter(), time.process_time()
    kept = read(sys.argv[3])
    figures = {"seconds": time.perf_counter() - start, "cpu": time.process_time() - cpu, "bytes": peak() - before}
    del kept
    print(json.dumps(figures))


if __name__ == "__main__":
    main()
