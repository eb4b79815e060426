"""The pictures that are timed: those of the gallery, files of the user's, and a head of a million strands."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import fastlines as fl

from ...harness.internals import SCENE, open_lines

#: The pictures of docs/gallery.md that one command makes: a file or a scene, and the options besides its name.
GALLERY: dict[str, tuple[str, ...]] = {
    "sintel": ("sintel_hair_16points.tfx",),
    "bear": ("bear.tfx",),
    "mohawk": ("Ratboy_mohawk.tfx",),
    "straight-hair": ("scene:straight-hair",),
    "bun-hair": ("scene:bun-hair",),
    "brain": ("stroke.trk.gz",),
    "bundle": ("example.vtp",),
    "power-lines": ("lines.csv",),
    "neuron": ("Neuron.swc",),
    "protein": ("3GQP.pdb",),
    "rna": ("4UPY.pdb", "--lens-radius", "8"),
    "trees": ("curve-scales-flat.usd",),
    "metal": (
        *("scene:spaghetti:150", "--look", "tube", "--radius", "0.03"),
        *("--color", "#d8a848", "--material", "metal"),
    ),
    "spaghetti": ("scene:spaghetti",),
    "spaghetti-2": ("scene:spaghetti-2",),
    "photon-beams": ("scene:photon-beams",),
}
#: Those of a quick run, and how small they are.
QUICK = {"straight-hair": ("scene:straight-hair:10000",), "spaghetti": ("scene:spaghetti:1000",)}
SMALL = ("--width", "192", "--height", "192", "--samples", "2")
#: The radius of the hairs of a dense head is the longest side of the guides divided by this number.
HAIRS_ACROSS = 7000


@dataclass(frozen=True)
class Case:
    """A picture.

    Attributes
    ----------
    name, source : str
        What it is called; and a file, a tree or a scene, as ``fastlines render`` takes it.
    options : tuple of str
        The options of ``fastlines render``.
    """

    name: str
    source: str
    options: tuple[str, ...] = ()

    @property
    def is_there(self) -> bool:
        """Whether the source exists."""
        return self.source.startswith(SCENE) or Path(self.source).exists()


def gallery(data: str | None, names: Iterable[str] | None, quick: bool) -> tuple[list[Case], list[Case]]:
    """Return the pictures of the gallery of which the files are there, and those of which they are not.

    Parameters
    ----------
    data : str, optional
        The folder of the files.
    names : iterable of str, optional
        Some of `GALLERY`; by default all, or `QUICK` in a quick run.
    quick : bool
        Whether pictures are small.

    Examples
    --------
    >>> found, missing = gallery(None, ["spaghetti", "bear"], quick=False)
    >>> [case.name for case in found], [case.name for case in missing]
    (['spaghetti'], ['bear'])
    """
    rows = GALLERY | QUICK if quick else GALLERY
    cases = []
    for name in names or (QUICK if quick else GALLERY):
        source, *options = rows[name]
        path = source if source.startswith(SCENE) or data is None else str(Path(data) / source)
        cases.append(Case(name, path, (*options, *(SMALL if quick else ()))))
    return [case for case in cases if case.is_there], [case for case in cases if not case.is_there]


def dense_head(folder: Path, data: str | None, n_strands: int, size: int, samples: int) -> Case:
    """Make a tree over hair between guides, in a file; return its picture, for which light is traced.

    The guides are the hair of Sintel, or straight hair where the folder of data does not hold that.
    """
    file = Path(data or ".") / GALLERY["sintel"][0]
    guides = open_lines(str(file)).lines if file.exists() else fl.scenes.make("straight-hair", 20_000).lines
    ends = guides.segments.reshape(guides.n_strands, -1, 2, 3)
    points = np.concatenate([ends[:, :, 0], ends[:, -1:, 1]], axis=1)
    path = folder / "dense.flt"
    fl.build(fl.scenes.dense_hair(points, n_strands)).save(path, layout=True)
    radius = float(np.ptp(guides.bounds, axis=0).max()) / HAIRS_ACROSS
    given = {"look": "hair", "quality": "high", "samples": samples, "radius": radius, "width": size, "height": size}
    options = [text for name, value in given.items() for text in (f"--{name}", str(value))]
    return Case(f"{n_strands:,} strands", str(path), tuple(options))
