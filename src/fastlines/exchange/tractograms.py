"""Lines as a tractogram of nibabel, whose streamlines DIPY takes as they are."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ..arrays import AnyArray, IntArray
from ..errors import FileWarning
from ..geometry.lines import Lines
from ..geometry.vtk_cells import RADIUS
from ..io.formats.streamlines import UNIT, UP, split_values
from ..io.losses import conventions, strand_numbers
from ..io.polylines import polylines_of
from ..io.writing import to_written
from ..support.optional import optional
from ..support.warn_caller import warn_caller


def to_tractogram(lines: Any) -> Any:
    """Return lines as a ``nibabel.streamlines.Tractogram``: a streamline for each strand.

    ``tractogram.streamlines`` is what functions of DIPY take. A ``StatefulTractogram`` of these needs the image that
    they belong to: ``StatefulTractogram(tractogram.streamlines, "t1.nii.gz", Space.RASMM)``. `lines` reads either back.

    Parameters
    ----------
    lines : Lines, Curves, or what `fastlines.lines` takes
        Curves are cut into the pieces that queries test.

    Returns
    -------
    nibabel.streamlines.Tractogram
        Points in millimetres of the world, as they are: ``affine_to_rasmm`` is the identity. They are float32, or
        float64 if the lines have an offset, which is added. The radius is the value ``radius`` per point. Attributes of
        ends are values per point, and those that are equal all along a strand values per streamline.

    Raises
    ------
    InputError
        If `lines` are something else.
    MissingExtraError
        If nibabel is not installed.

    Warns
    -----
    FileWarning
        Of everything that a tractogram cannot hold, such as texts, or another unit than millimetres.

    Examples
    --------
    >>> import fastlines as fl
    >>> from dataclasses import replace
    >>> lines = fl.Lines.from_strands([[[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[5, 5, 5], [6, 6, 6]]])
    >>> tractogram = fl.to_tractogram(replace(lines, unit="mm"))
    >>> [len(streamline) for streamline in tractogram.streamlines]
    [3, 2]
    """
    nibabel = optional("nibabel.streamlines", "a tractogram of lines", "nifti")
    straight, lost = to_written(lines, (Lines,), "tractograms", "to_tractogram({})")
    parts = polylines_of(straight)
    per_point, per_strand, others = split_values(replace(parts, radius=None))
    lost += others
    per_point, per_strand = (
        {name: values for name, values in given.items() if _is_held(name, values, lost)}
        for given in (per_point, per_strand)
    )
    if parts.radius is not None:
        per_point[RADIUS] = parts.radius
    rows = {name: _sequence(nibabel, _table(values), parts.counts) for name, values in per_point.items()}
    tractogram = nibabel.Tractogram(
        _sequence(nibabel, parts.points, parts.counts),
        data_per_point=rows,
        data_per_streamline={name: _table(values) for name, values in per_strand.items()},
        affine_to_rasmm=np.eye(4),
    )
    lost += strand_numbers(parts.strand) + conventions(straight, UNIT, UP)
    if lost:
        warn_caller(f"not kept in the tractogram: {'; '.join(lost)}", FileWarning)
    return tractogram


def _sequence(nibabel: Any, rows: AnyArray, counts: IntArray) -> Any:
    """Return the rows of all streamlines as an ArraySequence, which others may change in place."""
    made = nibabel.ArraySequence()
    made._data = rows if rows.flags.writeable and rows.flags.owndata else rows.copy()
    made._lengths, made._offsets = counts.astype(np.intp), np.asarray(np.cumsum(counts) - counts, np.intp)
    return made


def _table(values: AnyArray) -> AnyArray:
    """Return values as the columns of a table, as nibabel wants them."""
    return values.reshape(len(values), -1) if values.ndim == 1 else values


def _is_held(name: str, values: AnyArray, lost: list[str]) -> bool:
    """Return whether a tractogram holds an attribute, and record if not; ``radius`` would be read as the radius."""
    if values.dtype.kind in "fiub" and values.ndim <= 2 and name != RADIUS:
        return True
    lost.append(f"{name!r}, {values.dtype} of shape {values.shape}")
    return False
