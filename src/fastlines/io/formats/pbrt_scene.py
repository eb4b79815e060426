"""Collects the curves of a pbrt scene, with their transforms."""

from __future__ import annotations

from array import array
from collections import Counter
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..source import Source
from .pbrt_text import Includes, Words
from .pbrt_transform import Matrix, from_numbers, look_at, rotation, scaling, translation

#: Directives that neither make curves nor move them.
_IGNORED = frozenset(
    b"Accelerator AreaLightSource ColorSpace Film Integrator LightSource MakeNamedMaterial MakeNamedMedium Material "
    b"MediumInterface NamedMaterial Option PixelFilter Renderer ReverseOrientation Sampler SurfaceIntegrator Texture "
    b"TransformTimes Volume VolumeIntegrator WorldEnd".split()
)
#: What a curve can be: its basis and its degree.
KINDS = ((b"bezier", 3), (b"bspline", 3), (b"bezier", 2), (b"bspline", 2))
_KIND_OF = {(basis, b"%d" % degree): kind for kind, (basis, degree) in enumerate(KINDS)}
#: The parameters of a curve that are read.
_PARAMETERS = frozenset(b"P basis degree type width width0 width1".split())


class _State(NamedTuple):
    """What AttributeBegin keeps: the transform, its row in `Scene.matrices` or -1, and defaults of shapes."""

    transform: Matrix
    row: int
    defaults: dict[bytes, bytes]
    is_end_time: bool


class Scene:
    """The curves of a scene as they stand, one entry of each list for each, and where they appear.

    Attributes
    ----------
    points : list of bytes
        The text of the control points, in one line.
    kinds : array of int
        Rows of `KINDS`.
    widths : array of float
        The widths at both ends, one after the other.
    rows : array of int
        Rows of `matrices`.
    runs : list of [int, int, int]
        The first curve that appears, the one after the last, and the row of the transform of the instance, or -1.
    """

    def __init__(self, source: Source) -> None:
        self.source = source
        self.points: list[bytes] = []
        self.kinds = array("b")
        self.widths = array("d")
        self.rows = array("q")
        self.runs: list[list[int]] = []
        self.matrices: list[Matrix] = []
        self.others: Counter[str] = Counter()
        self.n_ribbons = 0
        self.includes = Includes(source)
        self._state = _State(np.eye(4), -1, {}, False)
        self._stack: list[_State] = []
        self._named: dict[bytes, Matrix] = {b"world": np.eye(4)}
        self._objects: dict[bytes, tuple[int, int]] = {}
        self._object: tuple[bytes, int] | None = None
        self._is_moving = False
        self._transforms: dict[bytes, tuple[int, Callable[..., Matrix | None]]] = {
            b"Translate": (3, translation),
            b"Scale": (3, scaling),
            b"Rotate": (4, rotation),
            b"LookAt": (9, look_at),
            b"ConcatTransform": (16, lambda *numbers: from_numbers(list(numbers))),
            b"Transform": (16, lambda *numbers: from_numbers(list(numbers))),
        }
        self._directives: dict[bytes, Callable[[Words], None]] = {
            b"Shape": self._shape,
            b"AttributeBegin": self._push,
            b"TransformBegin": self._push,
            b"AttributeEnd": lambda words: self._pop(words),
            b"TransformEnd": lambda words: self._pop(words, only_transform=True),
            b"Identity": lambda _: self._move(np.eye(4)),
            b"ActiveTransform": self._activate,
            b"CoordinateSystem": self._name,
            b"CoordSysTransform": self._use_named,
            b"WorldBegin": self._begin_world,
            b"Camera": self._camera,
            b"Attribute": self._attribute,
            b"ObjectBegin": self._begin_object,
            b"ObjectEnd": self._end_object,
            b"ObjectInstance": self._instance,
            b"Include": self._include,
            b"Import": self._import,
        }

    def read(self) -> None:
        """Read the file and all that it includes."""
        words = Words(self.source)
        self._read(words)
        if self._object is not None or self._stack:
            n_open = len(self._stack)
            self.source.warn(f"{n_open} of its blocks, such as AttributeBegin, do not end; it may be cut short")
        if self._is_moving:
            self.source.warn("some of its transforms change with time; those of the start are read")

    def _read(self, words: Words) -> None:
        while True:
            while (given := words.plain_curve()) is not None:
                self._curve(words, given)
            if not (word := words.next()):
                return
            if (directive := self._directives.get(word)) is not None:
                directive(words)
            elif (made := self._transforms.get(word)) is not None:
                n_numbers, make = made
                matrix = make(*words.numbers(n_numbers, word.decode()))
                if matrix is None:
                    raise words.error(f"the matrix of {word.decode()} is a projection; curves take affine ones")
                self._move(matrix if word == b"Transform" else self._state.transform @ matrix)
            elif word in _IGNORED:
                words.skip()
            else:
                raise words.error(f"{word[:30].decode('latin-1')!r} is not a directive of pbrt")

    def _shape(self, words: Words) -> None:
        kind = words.string("the kind of a shape")
        if kind != b"curve":
            self.others[kind[:30].decode("latin-1")] += 1
            words.skip()
            return
        self._curve(words, dict(words.parameters()))

    def _curve(self, words: Words, given: dict[bytes, bytes]) -> None:
        if self._state.defaults:
            given = {**self._state.defaults, **given}
        points = given.get(b"P")
        if points is None:
            raise words.error("a curve has no parameter P, its control points")
        try:
            width = given.get(b"width", b"1")
            self.widths.append(float(given.get(b"width0", width)))
            self.widths.append(float(given.get(b"width1", width)))
            self.kinds.append(_KIND_OF[given.get(b"basis", b"bezier").strip(), given.get(b"degree", b"3").strip()])
        except (ValueError, KeyError):
            raise words.error(
                "a curve has a width, a basis or a degree that it cannot have; expected numbers, 'bezier' or "
                "'bspline', and 2 or 3"
            ) from None
        self.n_ribbons += given.get(b"type", b"").strip() == b"ribbon"
        self.points.append(b" ".join(points.splitlines()) if b"\n" in points or b"\r" in points else points)
        self.rows.append(self._state.row if self._state.row >= 0 else self._row())
        n_curves = len(self.points)
        if self._object is None:
            last = self.runs[-1] if self.runs else None
            if last is not None and last[2] == -1 and last[1] == n_curves - 1:
                last[1] = n_curves
            else:
                self.runs.append([n_curves - 1, n_curves, -1])

    def _row(self) -> int:
        """Return the row of the current transform."""
        if self._state.row < 0:
            self.matrices.append(self._state.transform)
            self._state = self._state._replace(row=len(self.matrices) - 1)
        return self._state.row

    def _move(self, transform: Matrix) -> None:
        if self._state.is_end_time:
            self._is_moving = True
        else:
            with np.errstate(all="ignore"):
                self._state = self._state._replace(transform=transform, row=-1)

    def _push(self, words: Words) -> None:
        self._stack.append(self._state)

    def _pop(self, words: Words, *, only_transform: bool = False) -> None:
        if not self._stack:
            raise words.error("a block ends that does not begin")
        before = self._stack.pop()
        self._state = before._replace(defaults=self._state.defaults) if only_transform else before

    def _activate(self, words: Words) -> None:
        self._state = self._state._replace(is_end_time=words.next() == b"EndTime")

    def _name(self, words: Words) -> None:
        self._named[words.string("the name of a coordinate system")] = self._state.transform

    def _use_named(self, words: Words) -> None:
        name = words.string("the name of a coordinate system")
        if name not in self._named:
            raise words.error(f"there is no coordinate system {name[:30].decode('latin-1')!r}")
        self._move(self._named[name])

    def _begin_world(self, words: Words) -> None:
        self._named[b"world"] = np.eye(4)
        self._state = _State(np.eye(4), -1, {}, False)

    def _camera(self, words: Words) -> None:
        try:
            self._named[b"camera"] = np.asarray(np.linalg.inv(self._state.transform), np.float64)
        except np.linalg.LinAlgError:
            self._named[b"camera"] = np.full((4, 4), np.nan)
        words.skip()

    def _attribute(self, words: Words) -> None:
        if words.string("the target of Attribute") == b"shape":
            given = {name: value for name, value in words.parameters() if name in _PARAMETERS}
            self._state = self._state._replace(defaults={**self._state.defaults, **given})
        else:
            words.skip()

    def _begin_object(self, words: Words) -> None:
        if self._object is not None:
            raise words.error("an object begins inside another one")
        self._push(words)
        self._object = words.string("the name of an object"), len(self.points)

    def _end_object(self, words: Words) -> None:
        if self._object is None:
            raise words.error("an object ends that does not begin")
        name, first = self._object
        self._objects[name] = first, len(self.points)
        self._object = None
        self._pop(words)

    def _instance(self, words: Words) -> None:
        name = words.string("the name of an object")
        if self._object is not None or name not in self._objects:
            shown = name[:30].decode("latin-1")
            raise words.error(f"an instance of {shown!r} is inside an object, or there is no such object before it")
        self.runs.append([*self._objects[name], self._row()])

    def _include(self, words: Words) -> None:
        inner = self.includes.open(words, words.string("the name of a file"))
        self.includes.depth += 1
        self._read(inner)
        self.includes.depth -= 1

    def _import(self, words: Words) -> None:
        before = self._state
        self._include(words)
        self._state = before
