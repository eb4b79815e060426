"""The voxel grid of what is given as ``reference=``: an image, a tractogram, a header, or a file of one of these."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..arrays import FloatArray, kind_of
from ..errors import FileFormatError, InputError
from ..geometry.any_geometry import AnyGeometry
from ..geometry.lines import Lines
from ..geometry.voxel_grid import GRID, VoxelGrid
from ..support.optional import optional
from . import table
from .reading import check_path, open_source
from .source import reason

_EXPECTED = (
    "an image of nibabel, lines of a .trk or .trx, a header, the metadata 'grid', or the path of a .nii, .nii.gz, .trk "
    "or .trx file"
)


def grid_of(reference: Any) -> VoxelGrid:
    """Return the grid of a reference, which has a transform to the world."""
    name = f"reference {os.fspath(reference)!r}" if isinstance(reference, str | os.PathLike) else "reference"
    grid = _of_file(Path(reference)) if isinstance(reference, str | os.PathLike) else _of_object(reference)
    if grid is None or grid.voxel_to_rasmm is None:
        raise InputError(f"{name} has no voxel grid in the world; expected {_EXPECTED}")
    return grid


def grid_to_write(
    lines: Lines, points: FloatArray, reference: Any, in_world: bool = False
) -> tuple[VoxelGrid, list[str]]:
    """Return the grid of a reference, or that of the lines, or else one around points in RASMM; and what is to say."""
    given = lines.metadata.get(GRID)
    grid = None if given is None else VoxelGrid.from_mapping(given, f"the metadata {GRID!r}")
    if reference is not None:
        grid = grid_of(reference)
    if grid is None or (in_world and grid.voxel_to_rasmm is None):
        grid = VoxelGrid.around(points)
        shape, size = " × ".join(map(str, grid.dimensions)), grid.voxel_sizes[0]
        said = f"that no voxel grid is known (one of {shape} voxels of {size:g} mm, which holds the lines, is written: "
        return grid, [f"{said}reference= takes that of your image)"] if len(points) else []
    n = grid.count_outside(points)
    return grid, [
        f"that all points lie in the voxel grid ({n:,} are outside of it, and DIPY refuses such files)"
    ] if n else []


def _of_file(path: Path) -> VoxelGrid | None:
    check_path(path)
    row = table.of_folder(path) if path.is_dir() else table.known_formats().get(table.extension_of(path)[0])
    if row is not None:
        if not hasattr(row.code, "read_grid"):
            return None
        with open_source(path, row) as source:
            grid: VoxelGrid | None = row.code.read_grid(source)
        return grid
    nibabel = optional("nibabel", "an image as reference=", "nifti")
    try:
        image = nibabel.load(path)
    except Exception as error:  # each format of nibabel has its own
        raise FileFormatError(
            f"{path}: cannot be read as an image ({reason(error)}); expected {_EXPECTED.split(', or ')[1]}"
        ) from None
    return _of_object(image)


def _of_object(reference: Any) -> VoxelGrid | None:
    if isinstance(reference, AnyGeometry):
        return VoxelGrid.from_mapping(reference.metadata[GRID], "reference") if GRID in reference.metadata else None
    if (grid := VoxelGrid.of_tractogram(reference, "reference")) is not None:
        return grid
    header = getattr(reference, "header", reference)
    if isinstance(header, Mapping):
        return VoxelGrid.from_mapping(header, "reference")
    if hasattr(header, "get_best_affine"):
        return VoxelGrid.from_parts("reference", header.get_data_shape(), header.get_best_affine(), _sizes(header))
    if hasattr(reference, "affine") and hasattr(reference, "shape"):
        return VoxelGrid.from_parts("reference", reference.shape, reference.affine, _sizes(header))
    raise InputError(f"reference is {kind_of(reference)}; expected {_EXPECTED}")


def _sizes(header: Any) -> Any:
    """Return the voxel sizes of the header of an image; None if it has none."""
    return header.get_zooms()[:3] if hasattr(header, "get_zooms") else None
