"""``fastlines query``: find what rays hit."""

from __future__ import annotations

import json
import re
import time
import zipfile
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt
import typer
from typer import Option

from ..errors import InputError
from ..geometry.any_geometry import AnyGeometry
from .options import Direction, Fov, Json, Radius, TreeFile, Up, refuse_given, size, vector

#: The choices of --kind, and the methods of a tree.
KINDS = {"first": "first_hit", "any": "any_hit", "all": "all_hits", "next": "next_hits", "count": "count_hits"}

#: The kinds whose answer has t, and the kinds that list several hits of each ray.
WITH_T, LISTS = ("first", "all", "next"), ("all", "next")


def query(
    tree_file: TreeFile,
    rays: Annotated[
        str | None,
        typer.Argument(
            metavar="[RAYS]", help="An array (n, 6) in a .npy file, or origins and directions (n, 3) in a .npz file."
        ),
    ] = None,
    radius: Radius = None,
    kind: Annotated[str, Option("--kind", "-k", metavar="KIND", help="first, any, all, next or count.")] = "first",
    nearest: Annotated[int | None, Option(metavar="N", help="The number of hits of each ray, for --kind next.")] = None,
    output: Annotated[
        str | None,
        Option("--output", "-o", metavar="FILE.npz", help="Write the answer to this file; else only print figures."),
    ] = None,
    camera: Annotated[
        str | None, Option(metavar="WxH", help="Trace a picture of this size, row by row, instead of RAYS.")
    ] = None,
    direction: Direction = None,
    up: Up = None,
    fov: Fov = None,
    t_min: Annotated[float, Option(help="The ray begins at this t, in units of its direction's length.")] = 0.0,
    t_max: Annotated[float, Option(help="The ray ends at this t.")] = float("inf"),
    at: Annotated[
        str | None,
        Option(
            metavar="WHERE",
            help="Take t at the closest approach (closest, the default) or surface; for first, all and next.",
        ),
    ] = None,
    as_json: Json = False,
) -> None:
    r"""Find what rays hit, with any radius, and write the answer as arrays.

    For the kinds first, all and next the file has the arrays t, prim, u and distance. For all and next it also has
    offsets: the hits of ray i are those from offsets\[i] to offsets\[i + 1]. For any it has hit, for count count.
    If rows of the input were skipped when the tree was built, row is the row of each prim in the input. If the lines
    have strands, strand is the strand of each prim. prim, row and strand are -1 for a miss.

    If less than 1 % of the rays that cross the box of the lines hit, a note on stderr names a radius with which a
    quarter of them would.

    [bold]Examples[/]

    [cyan]fastlines query hair.flt rays.npy --radius 0.001 -o hits.npz[/]

    [cyan]fastlines query hair.flt rays.npz --radius 0.001 --kind all -o hits.npz[/]

    [cyan]fastlines query hair.flt rays.npz --radius 0.001 --kind next --nearest 4 -o hits.npz[/]

    [cyan]fastlines query hair.flt --camera 640x480 --radius 0.001 --kind count[/]
    """
    from ..query.rays import require_radius
    from ..rendering import ViewOptions
    from ..rendering.shading.depth import check_size
    from .files import check_output, open_tree, show_progress, write_npz
    from .hint import hint_at_radius

    check_output(output, ".npz", inputs=(tree_file, rays))
    if kind not in KINDS:
        raise InputError(f"--kind {kind!r} is not a choice: use one of {', '.join(KINDS)}")
    if (rays is None) == (camera is None):
        raise InputError("give the rays either as a file or by --camera, such as --camera 640x480")
    if (kind == "next") != (nearest is not None):
        raise InputError("--kind next and --nearest go together: give the number of hits, such as --nearest 4")
    if kind not in WITH_T:
        refuse_given({"--at": at}, f"--kind {kind} returns no t")
    if camera is None:
        looks = {"--direction": direction, "--up": up, "--fov": fov}
        refuse_given(looks, "the rays come from a file, not from a camera")
    tree = open_tree(tree_file)
    require_radius(tree.geometry, radius)
    radius = radius or 0.0
    if camera is not None:
        width, height = size(camera, "--camera")
        check_size(width, height)
        view = ViewOptions(vector(direction, "--direction"), vector(up, "--up"), fov)
        origins, directions = view.camera(tree.geometry, width / height).rays(width, height)
    else:
        origins, directions = read_rays(str(rays))
    ask = getattr(tree, KINDS[kind])
    given = {"at": at, "k": nearest, "t_min": t_min, "t_max": t_max, "progress": show_progress()}
    options = {name: value for name, value in given.items() if value is not None}
    start = time.perf_counter()
    answer = ask(origins, directions, radius, **options)
    seconds = time.perf_counter() - start

    # Write the arrays, and report counts and time.
    if output is not None:
        write_npz(output, **_arrays(kind, answer, tree.geometry))
    hint_at_radius(tree, origins, directions, radius, t_min=t_min, t_max=t_max)
    n_rays, n_found = len(directions), _count(kind, answer)
    if as_json:
        counted = "n_hits" if kind in (*LISTS, "count") else "n_rays_that_hit"
        facts = {"n_rays": n_rays, "kind": kind, "radius": radius, counted: n_found}
        typer.echo(json.dumps({**facts, "seconds": seconds, "output": output}, indent=2))
        return
    found = f"{n_found:,} hits" if kind in (*LISTS, "count") else f"{n_found:,} of them hit something"
    rate = f", {n_rays / seconds / 1e6:.3g} million rays a second" if n_rays else ""
    typer.echo(f"{output or tree_file}: {n_rays:,} rays, {found}, in {seconds:.3f} s{rate}")


def read_rays(path: str) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    """Read rays from a .npy or .npz file."""
    if not path.lower().endswith((".npy", ".npz")):
        raise InputError(f"{path}: rays are read from .npy, an array (n, 6), or .npz, with origins and directions")
    try:
        if path.lower().endswith(".npz"):
            with open(path, "rb") as file, np.load(file, allow_pickle=False) as arrays:
                missing = {"origins", "directions"} - set(arrays)
                if missing:
                    raise InputError(f"{path}: has no array {' and no '.join(sorted(missing))}; expected both")
                return arrays["origins"], arrays["directions"]
        # Map the file: NumPy then compares it with its header before it allocates memory.
        loaded = np.load(path, mmap_mode="r", allow_pickle=False)
    except InputError:
        raise
    except (ValueError, EOFError, KeyError, zipfile.BadZipFile) as error:
        why = "it holds Python objects, not numbers" if re.search("pickle|objects", str(error)) else error
        raise InputError(f"{path}: cannot be read as an array of rays: {why}") from None
    if loaded.ndim != 2 or loaded.shape[1] != 6:
        raise InputError(f"{path}: has the shape {loaded.shape}; expected (n, 6): origin and direction of each ray")
    return np.asarray(loaded[:, :3]), np.asarray(loaded[:, 3:])


def _arrays(kind: str, answer: Any, geometry: AnyGeometry) -> dict[str, Any]:
    """Return the arrays of an answer by their names in the file."""
    if kind in ("any", "count"):
        return {"hit" if kind == "any" else "count": answer}
    names = ["t", "prim", "u", "distance"]
    names += ["offsets"] * (kind in LISTS) + ["t_out"] * (answer.t_out is not None)
    names += ["part"] * (answer.part is not None)
    names += ["row"] * (geometry.n_skipped > 0)
    names += ["strand"] * (geometry.n_strands > 0)
    return {name: getattr(answer, name) for name in names}


def _count(kind: str, answer: Any) -> int:
    """Return the number of hits, or of rays that hit."""
    if kind == "first":
        return int(answer.hit.sum())
    return len(answer) if kind in LISTS else int(answer.sum())
