"""The tables of queries on a GPU."""

from __future__ import annotations

from ..harness.tables import format_3_digits, new_table, print_table, wide_console
from .resources import ResourcesResult
from .run import CudaCell, CudaResult, describe
from .variants import VariantsResult


def print_cuda(result: CudaResult) -> None:
    """Print the comparison of each scene, then a row for each query."""
    console = wide_console()
    compared = new_table(f"answers on {result.card}, beside brute force", ["scene"], ["queries", "decisions", "differ"])
    for each in result.comparisons:
        compared.add_row(each.scene, f"{each.n_queries:,}", f"{each.n_decisions:,}", str(len(each.differing)))
    print_table(console, compared)
    for each in result.comparisons:
        for differing in each.differing:
            console.print(f"{each.scene}: {differing}: the answer differs", highlight=False)
    heads = [
        "rays",
        "hits\na ray",
        "GPU\nMrays/s",
        "with copies\nMrays/s",
        "CPU\nMrays/s",
        "GPU / CPU",
        "Warp\nMrays/s",
        "GPU / Warp",
        "differ\n%",
    ]
    heads += ["nodes\na ray", "leaves", "tests", "kB\na ray", "GB/s", "same"]
    timed = new_table(f"queries on {result.card}", ["scene", "rays", "query"], heads)
    for cell in result.cells:
        rates = [cell.n_rays / seconds / 1e6 for seconds in (cell.gpu_s, cell.copied_s, cell.cpu_s)]
        steps = ["–"] * 3 if cell.steps is None else [f"{step:.1f}" for step in cell.steps]
        read = ["–"] * 2
        if cell.bytes_per_ray is not None:
            read = [f"{cell.bytes_per_ray / 1e3:.2f}", f"{cell.bytes_per_ray * cell.n_rays / cell.gpu_s / 1e9:.0f}"]
        timed.add_row(
            *(cell.scene, cell.kind, cell.query, f"{cell.n_rays:,}", f"{cell.n_hits / cell.n_rays:.2f}"),
            *(format_3_digits(rate) for rate in rates),
            f"{cell.cpu_s / cell.gpu_s:.1f}",
            *_beside_warp(cell),
            *steps,
            *read,
            "yes" if cell.same else "NO",
        )
    print_table(console, timed)
    console.print(
        f"Kernels: {', '.join(f'{name} {value}' for name, value in result.preset.tuning.items())}. "
        f"Uploads: {result.upload_gb_s:.1f} GB/s. {describe(result)}. kB: what a ray reads of the layout and of "
        f"segments, caches included. {result.seconds:.0f} s in all."
        + (f" Left out, for time: {', '.join(result.left_out)}." if result.left_out else ""),
        highlight=False,
    )


def print_variants(result: VariantsResult) -> None:
    """Print a table for each scene: a row for each variant, and a column for each query."""
    console = wide_console()
    for scene in dict.fromkeys(cell.scene for cell in result.cells):
        cells = [cell for cell in result.cells if cell.scene == scene]
        heads = dict.fromkeys(f"{cell.kind}\n{cell.query}" for cell in cells)
        table = new_table(f"{scene} on {result.card}: Mrays/s", ["variant"], heads)
        for variant in result.preset.variants:
            rates = [format_3_digits(cell.mrays) for cell in cells if cell.variant == variant]
            table.add_row(_name(variant), *rates)
        print_table(console, table)
    for cell in result.cells:
        if not cell.same:
            where = f"{cell.scene}, {cell.kind} rays, {cell.query}, {_name(cell.variant)}"
            console.print(f"{where}: the answer differs", highlight=False)
    console.print(
        f"{sum(result.compile_s):.0f} s to compile, {result.seconds:.0f} s in all."
        + (f" Left out, for time: {', '.join(result.left_out)}." if result.left_out else ""),
        highlight=False,
    )


def print_resources(result: ResourcesResult) -> None:
    """Print a row for each variant and kernel."""
    preset, console = result.preset, wide_console()
    title = f"kernels for {preset.primitives} on {preset.arch}, stacks of {preset.stack} entries, by {result.compiler}"
    heads = ["registers", "local\nbytes", "spilled\nbytes", "shared bytes\na block"]
    table = new_table(title, ["variant", "kernel"], heads)
    for row in result.rows:
        numbers = row.registers, row.local, row.spills, row.shared
        table.add_row(_name(row.variant), row.kernel, *(f"{number:,}" for number in numbers))
    print_table(console, table)


def _name(variant: dict[str, int]) -> str:
    return " ".join(f"{name.removeprefix('FASTLINES_')}={n}" for name, n in variant.items()) or "as in the package"


def _beside_warp(cell: CudaCell) -> list[str]:
    if cell.warp_s is None or cell.warp_differs is None:
        return ["–"] * 3
    rate, ratio = cell.n_rays / cell.warp_s / 1e6, cell.warp_s / cell.gpu_s
    return [format_3_digits(rate), f"{ratio:.2f}", f"{100 * cell.warp_differs:.2f}"]
