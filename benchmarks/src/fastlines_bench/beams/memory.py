"""The memory of a gather: a process that gathers by one query, or by lists of hits, and says what it took.

Run as ``python -m fastlines_bench.beams.memory JOB``; it prints the bytes.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

#: The bytes of a part of a list that holds all hits.
AT_ONCE = 1 << 36


def peak_bytes(way: str, n_beams: int, size: int, n_rays: int, radius: float, method: str) -> int | None:
    """Return the most memory that a gather of the cube takes beside beams, tree and rays; None but on Linux.

    Parameters
    ----------
    way : str
        "gather" or "lists".
    n_beams, size : int
        The cube, and the width of its picture.
    n_rays : int
        About how many of the picture's rays are traced.
    radius : float
    method : str
        How the tree is built.
    """
    if not Path("/proc/self/clear_refs").exists():
        return None
    job = json.dumps([way, n_beams, size, n_rays, radius, method])
    done = subprocess.run([sys.executable, "-m", __name__, job], capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"{way} of {n_beams:,} beams: {done.stderr.strip()[-2000:] or done.returncode}")
    return int(done.stdout)


def main(text: str) -> None:
    """Do a job, given as JSON, and print the bytes."""
    import fastlines as fl

    from .cube import make_cube

    way, n_beams, size, n_rays, radius, method = json.loads(text)
    cube = make_cube(n_beams, size)
    tree = fl.build(cube.lines, method)
    given, rays = cube.gathering(radius), cube.rays.part(n_rays)
    given.ours(tree, rays.take(slice(0, 64)), cube.powers)  # the layout, and what is loaded on first use
    Path("/proc/self/clear_refs").write_text("5", encoding="ascii")
    before = _peak()
    if way == "gather":
        given.ours(tree, rays, cube.powers)
    else:
        given.listed(tree, cube.lines, rays, cube.powers, AT_ONCE)
    print(_peak() - before)


def _peak() -> int:
    """Return the most bytes of memory that this process has had since the last reset."""
    found = re.search(r"^VmHWM:\s+(\d+) kB", Path("/proc/self/status").read_text(encoding="ascii"), re.MULTILINE)
    return 1024 * int(found[1]) if found else 0


if __name__ == "__main__":
    main(sys.argv[1])
