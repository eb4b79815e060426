"""Subjects of measurements: shapes of each kind, as our trees and as Embree's scenes take them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, ClassVar, TypeAlias

import numpy as np

import fastlines as fl
from fastlines import Camera, InputError, Lines, Tree, build

from ...harness.arrays import FloatArray, IntArray
from ...harness.internals import did_you_mean
from ...harness.rays import RayBatch, camera_rays, rays_through, tiled_rays
from ...harness.subjects import Subject, subjects_of, tapered
from ...harness.turns import query_tree
from ...peers import embree, tuning
from ...peers.embree import Build
from ..contest import OURS
from ..preset import EnginePreset
from .cubics import hair_curves
from .names import SHAPES
from .solids import MESHES, SPHERES, Solid

#: Answers a query, "first" or "all", on a batch of rays.
Query: TypeAlias = Callable[[str, RayBatch], Any]

#: A curve goes through about every STEP-th point of a strand.
STEP = 4


@dataclass(frozen=True)
class Ours:
    """Our tree, its queries, and how its primitives are named.

    Attributes
    ----------
    queries : dict of str to callable
        `OURS`, and others that take turns with it.
    owner : (n,) int64 or None
        The shape to which each primitive of the tree belongs, if these are not the same.
    note : str
        What the tree is built over, if that is not the shapes.
    """

    tree: Tree
    queries: dict[str, Query]
    owner: IntArray | None = None
    note: str = ""


@dataclass(frozen=True, eq=False)
class ShapeSubject(ABC):
    """Shapes of one kind, with a camera.

    Attributes
    ----------
    name : str
    radius : float
        The largest radius; 0 for triangles.
    camera : Camera
    bounds : (2, 3) float32
        The box through which random rays go.
    n_shapes : int
    """

    name: str
    radius: float
    camera: Camera
    bounds: FloatArray
    n_shapes: int

    shape: ClassVar[str]
    #: Hits agree if their t differ by at most this fraction of the box's diagonal, or of the radius.
    tolerance_of_box: ClassVar[float] = 1e-5
    tolerance_of_radius: ClassVar[float] = 0.0

    @property
    def tolerance(self) -> float:
        """The largest difference in t of hits that agree."""
        sides = np.diff(self.bounds.astype(np.float64), axis=0)
        return max(self.tolerance_of_box * float(np.sqrt((sides**2).sum())), self.tolerance_of_radius * self.radius)

    def rays(self, kind: str, n_rays: int) -> RayBatch:
        """Return camera, tiled or random rays."""
        if kind == "random":
            return rays_through(self.bounds, n_rays)
        return (tiled_rays if kind == "tiled" else camera_rays)(self.camera, n_rays)

    @abstractmethod
    def build(self, preset: EnginePreset) -> Ours:
        """Build our trees. Raises FastlinesError if fastlines cannot."""

    @abstractmethod
    def scenes(self, n_threads: int) -> embree.Scenes:
        """Return Embree's scenes."""

    @abstractmethod
    def builds(
        self, preset: EnginePreset, batches: list[RayBatch], say: Callable[[str], None]
    ) -> Mapping[str, list[Build]]:
        """Return the builds of Embree to try, for first and for all hits."""


def _surface(tree: Tree, preset: EnginePreset, radius: float = 0.0) -> Query:
    kernel = "single" if preset.one_by_one else "auto"
    return lambda query, rays: query_tree(tree, query, rays, radius, kernel, "surface")


@dataclass(frozen=True, eq=False)
class _Cones(ShapeSubject):
    """Lines that taper to a fifth of the radius along each strand; as well as lines and capsules of that radius.

    `trees` has the tree over the lines of a scene, once it is built, for all radii.
    """

    lines: Lines
    middle_radius: float
    trees: dict[str, Tree] = field(default_factory=dict)

    shape = "cones"

    def build(self, preset: EnginePreset) -> Ours:
        plain = self.trees.get("plain") or build(self.lines, preset.method, effort=preset.effort)
        self.trees["plain"] = plain
        cones = plain.refit(tapered(self.lines, self.radius))
        capsules = plain.refit(self.lines.with_radius(self.radius))
        queries = {
            OURS: _surface(cones, preset),
            "capsules": _surface(capsules, preset),
            "lines": _surface(plain, preset, self.radius),
        }
        return Ours(cones, queries)

    def scenes(self, n_threads: int) -> embree.Scenes:
        return self._scenes(self.radius, n_threads)

    def _scenes(self, radius: float, n_threads: int) -> embree.Scenes:
        return embree.Scenes(tapered(self.lines, radius), 0.0, self.camera.origin, n_threads)

    def builds(
        self, preset: EnginePreset, batches: list[RayBatch], say: Callable[[str], None]
    ) -> Mapping[str, list[Build]]:
        variants = [Build("round"), Build("round", compact=True)]
        found = tuning.tuned_builds(
            tapered(self.lines, self.middle_radius),
            self._scenes(self.middle_radius, preset.n_threads),
            batches,
            ("first", "all"),
            lengths=preset.lengths,
            variants=variants,
            retune=preset.retune,
            progress=say,
        )
        return {query: list(dict.fromkeys([*builds, *variants])) for query, builds in found.items()}


@dataclass(frozen=True, eq=False)
class _Hair(ShapeSubject):
    """Cubic curves along strands, which taper to a fifth of the radius along each."""

    control: FloatArray
    radii: FloatArray

    shape = "hair"
    tolerance_of_radius = 0.1

    def build(self, preset: EnginePreset) -> Ours:
        curves = fl.Curves.from_bezier(self.control, radius=self.radii)
        tree = build(curves, preset.method, effort=preset.effort)
        return Ours(
            tree, {OURS: _surface(tree, preset)}, note=f"{len(curves.pieces) / max(len(curves), 1):.0f} pieces a curve"
        )

    def scenes(self, n_threads: int) -> embree.Scenes:
        return embree.Scenes.of_shapes(np.concatenate([self.control, self.radii[..., None]], axis=2), n_threads)

    def builds(
        self, preset: EnginePreset, batches: list[RayBatch], say: Callable[[str], None]
    ) -> Mapping[str, list[Build]]:
        variants = [*(Build("bezier", halvings=n) for n in range(4)), Build("bezier", compact=True)]
        return {"first": variants, "all": variants}


@dataclass(frozen=True, eq=False)
class _Solids(ShapeSubject):
    """Spheres or a mesh."""

    solid: Solid

    def scenes(self, n_threads: int) -> embree.Scenes:
        index = () if self.solid.index is None else self.solid.index
        return embree.Scenes.of_shapes(self.solid.vertices, n_threads, index)


class _Spheres(_Solids):
    shape = "spheres"

    def build(self, preset: EnginePreset) -> Ours:
        spheres = fl.Spheres.from_centres(self.solid.vertices[:, :3], self.solid.vertices[:, 3])
        tree = build(spheres, preset.method, effort=preset.effort)
        return Ours(tree, {OURS: _surface(tree, preset)})

    def builds(
        self, preset: EnginePreset, batches: list[RayBatch], say: Callable[[str], None]
    ) -> Mapping[str, list[Build]]:
        variants = [Build("sphere"), Build("sphere", compact=True)]
        return {"first": variants, "all": variants}


class _Triangles(_Solids):
    shape = "triangles"

    def build(self, preset: EnginePreset) -> Ours:
        corners = self.solid.vertices[self.solid.index]
        tree = build(fl.Triangles(corners), preset.method, effort=preset.effort)
        return Ours(tree, {OURS: partial(_query_triangles, tree, preset)})

    def builds(
        self, preset: EnginePreset, batches: list[RayBatch], say: Callable[[str], None]
    ) -> Mapping[str, list[Build]]:
        every = [Build("triangle", quality=quality) for quality in ("high", "medium")]
        variants = [replace(build, compact=compact) for build in every for compact in (False, True)]
        return {"first": variants, "all": [build for build in variants if not build.splits_space]}


def _query_triangles(tree: Tree, preset: EnginePreset, query: str, rays: RayBatch) -> Any:
    method: Any = {"first": tree.first_hit, "all": tree.all_hits}[query]
    kernel = "single" if preset.one_by_one else "auto"
    return method(rays.origins, rays.directions, t_min=rays.t_min, t_max=rays.t_max, kernel=kernel)


# --- Subjects of the options ---


def shape_subjects(
    shapes: tuple[str, ...], scene: list[str], file: list[str], radius: str | None, quick: bool
) -> list[ShapeSubject]:
    """Return the subjects of the options --shape, --scene, --file and --radius.

    A scene belongs to each of the shapes that has one of its name; files are lines, so cones and hair. --radius is for
    these two.
    """
    known = {name: [scene.partition(":")[0] for scene in SHAPES[name].scenes] for name in shapes}
    for text in scene:
        if not any(text.partition(":")[0] in names for names in known.values()):
            names = list(dict.fromkeys(name for some in known.values() for name in some))
            raise InputError(
                f"--scene {text!r} is not a scene of {', '.join(shapes)}{did_you_mean(text.partition(':')[0], names)}; "
                f"known: {', '.join(names)}"
            )
    if file and not {"cones", "hair"} & set(shapes):
        raise InputError(f"--file is for the shapes cones and hair, these are {', '.join(shapes)}")
    found: list[ShapeSubject] = []
    for shape in shapes:
        chosen = [text for text in scene if text.partition(":")[0] in known[shape]]
        if not scene and not file:
            chosen = list(SHAPES[shape].quick_scenes if quick else SHAPES[shape].scenes)
        if shape in ("cones", "hair"):
            if chosen or file:
                for subject in subjects_of(chosen, file, radius, quick):
                    found.extend(_of_lines(shape, subject))
        else:
            found.extend(_of_solids(shape, text) for text in chosen)
    return found


def _of_lines(shape: str, subject: Subject) -> Iterator[ShapeSubject]:
    lines, trees = subject.lines, dict[str, Tree]()
    for radius in subject.radii:
        place = (subject.name, radius, subject.camera, lines.bounds)
        if shape == "cones":
            yield _Cones(*place, len(lines), lines, subject.middle_radius, trees)
        else:
            control, radii = hair_curves(lines, STEP, radius)
            yield _Hair(*place, len(control), control, radii)


def _of_solids(shape: str, text: str) -> ShapeSubject:
    """Return the subject of NAME, NAME:SIZE or NAME:SIZE:SEED."""
    name, *numbers = text.split(":")
    generate, n_usual = (SPHERES if shape == "spheres" else MESHES)[name]
    if len(numbers) > 2 or not all(number.isdecimal() for number in numbers):
        raise InputError(f"--scene {text!r} is not NAME, NAME:SIZE or NAME:SIZE:SEED")
    size, seed = (*map(int, numbers), *(n_usual, 0)[len(numbers) :])
    if not 1 <= size <= 50_000_000:
        raise InputError(f"--scene {text!r}: expected a size from 1 to 50,000,000")
    solid = generate(size, seed)
    points = solid.vertices[:, :3]
    bounds = np.stack([points.min(axis=0), points.max(axis=0)])
    camera = Camera.framing(points, (-0.4, -0.6, -0.8) if name == "terrain" else (-0.2, -0.15, -1.0))
    radius = float(solid.vertices[:, 3].max()) if shape == "spheres" else 0.0
    return (_Spheres if shape == "spheres" else _Triangles)(text, radius, camera, bounds, len(solid), solid)
