"""Prints what the pictures and the times of both sides are."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

from ...harness.internals import filmic, srgb, to_bytes
from ...harness.tables import format_3_digits, new_table, print_table, wide_console
from ...peers.hair_scene import SHAPES
from .run import BLOCK, OURS, THEIRS, PathsResult


def print_paths(result: PathsResult) -> None:
    """Print a table of the pictures, one of the rays, and what they say."""
    console = wide_console()
    preset = result.preset
    title = (
        f"{result.subject}: {result.n_prims:,} pieces ({preset.shape}), radius {result.radius:.3g}, "
        f"{preset.size}² pixels, {preset.samples} samples, {preset.max_bounces} bounces"
    )
    table = new_table(title, ["side"], ["build, s", "picture, s", "mean R", "mean G", "mean B", "noise of blocks"])
    for name in (OURS, THEIRS):
        table.add_row(
            name if name == OURS else f"{name} {result.version} {preset.variant}",
            format_3_digits(result.build_seconds[name]),
            format_3_digits(result.seconds[name]),
            *(f"{each:.4f}" for each in result.means[name]),
            f"{result.noise[name]:.4f}",
        )
    print_table(console, table)
    console.print(f"Hairs are {SHAPES[preset.shape]}.", highlight=False)
    ours, theirs = (np.asarray(result.means[name]) for name in (OURS, THEIRS))
    relative = ", ".join(f"{each:+.2%}" for each in ours / theirs - 1)
    noise = float(np.hypot(result.noise[OURS], result.noise[THEIRS]))
    console.print(
        f"Our mean radiance beside Mitsuba's: {relative}. Root mean square difference of blocks of {BLOCK}² pixels: "
        f"{result.difference:.4f}, of which noise explains {noise:.4f}; relative to the mean {theirs.mean():.3f}: "
        f"{result.difference / theirs.mean():.2%}.",
        highlight=False,
    )
    total, rays = sum(result.query_seconds.values()), sum(result.query_rays.values())
    console.print(
        f"Our picture has {rays:,} rays. Queries of the tree take {total:.2f} s of {preset.n_threads} threads, "
        f"{total / max(result.seconds[OURS] * preset.n_threads, 1e-9):.0%} of their time: "
        f"{rays * preset.n_threads / max(total, 1e-9) / 1e6:.2f} Mrays/s.",
        highlight=False,
    )
    if result.rays:
        figures = ["rays", "ours, Mrays/s", "Mitsuba, Mrays/s", "ours / Mitsuba", "same answers"]
        table = new_table("the rays alone, best times", ["rays"], figures)
        for cell in result.rays:
            speeds = [cell.n_rays / max(seconds, 1e-9) / 1e6 for seconds in (cell.ours, cell.theirs)]
            ratio = f"{speeds[0] / speeds[1]:.2f}"
            table.add_row(
                cell.kind, f"{cell.n_rays:,}", *(format_3_digits(each) for each in speeds), ratio, f"{cell.agree:.2%}"
            )
        print_table(console, table)


def draw_paths(results: list[PathsResult], path: Path) -> None:
    """Draw the pictures of both sides side by side, with a row for each result."""
    rows = [np.concatenate([result.pictures[name] for name in (OURS, THEIRS)], axis=1) for result in results]
    Image.fromarray(to_bytes(srgb(filmic(np.concatenate(rows))))).save(path, "png")
