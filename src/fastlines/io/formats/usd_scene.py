"""The curves of a USD stage, prim by prim."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from ...errors import InputError
from ...support.texts import kinds_text
from ..source import UNPACK_BYTES, UNPACK_FACTOR, Source
from .usd_curves import Strokes, placed, strokes_of
from .usd_values import Remarks
from .usd_walk import Walk


class Scene:
    """A stage that is open, at a time.

    Parameters
    ----------
    source : Source
    path : Path
        The file, or a copy of it.
    time : number or None
        The time code; None is the earliest one.
    prim : str or None
        The path of the prim below which curves are read.

    Attributes
    ----------
    stage : Usd.Stage
    remarks : Remarks
        What is said of the prims that are read.
    """

    def __init__(self, source: Source, path: Path, time: float | None, prim: str | None) -> None:
        from pxr import Sdf, Usd

        if path != source.path:
            _find_assets(path, Path(source.name).absolute().parent)
        stage = Usd.Stage.Open(str(path.absolute()))
        for layer in stage.GetUsedLayers():
            # USD shares layers that this program has open elsewhere, even if their file has changed since.
            if layer.dirty:
                source.warn(f"this program has changed {layer.identifier} without saving it; it is read as changed")
            elif not layer.anonymous:
                layer.Reload()
        root = stage.GetPseudoRoot()
        if prim is not None:
            root = stage.GetPrimAtPath(prim) if Sdf.Path.IsValidPathString(prim) and prim.startswith("/") else None
            if not root:
                top = ", ".join(str(child.GetPath()) for child in stage.GetPseudoRoot().GetChildren()[:5]) or "nothing"
                raise InputError(f"there is no prim {prim!r}; at the top of the file there is {top}")
        layers = [Path(layer.realPath) for layer in stage.GetUsedLayers() if layer.realPath]
        n_bytes = sum(layer.stat().st_size for layer in layers if layer.is_file())
        self.stage, self._root, self._source = stage, root, source
        self._limit = UNPACK_FACTOR * max(n_bytes, source.size) + UNPACK_BYTES
        self._when = Usd.TimeCode.EarliestTime() if time is None else Usd.TimeCode(float(time))
        self.remarks = Remarks(source)

    def strokes(self, share: float = 1.0) -> Iterator[Strokes]:
        """Yield the segments of each prim at its places; strands and prims are counted over the whole stage.

        Parameters
        ----------
        share : number
            How much of the work it is, for the progress.
        """
        from pxr import Tf

        # Read each prim once, and copy it to its places.
        remarks, walk = self.remarks, Walk(self._source, self._when, self.remarks, self._limit)
        n_strands = n_prims = 0
        for curves, places in walk.curves(self._root):
            try:
                strokes = strokes_of(curves, self._when, remarks)
            except (Tf.ErrorException, TypeError, AttributeError, UnicodeDecodeError) as error:  # of a wrong type
                remarks.add(f"left out, as USD cannot read it: {reason_of(error)}", curves.GetPath())
                continue
            if strokes is None:
                continue
            # About twice what the file has of them: read, and parsed.
            self._source.advance(int(share * strokes.control.nbytes))
            values = [*strokes.attributes.values(), *strokes.end_attributes.values()]
            walk.spend((strokes.control.nbytes + sum(array.nbytes for array in values)) * len(places))
            made = placed(strokes, places, curves.GetPath(), remarks)
            if n_prims:
                made = replace(made, strands=made.strands + n_strands, prim=made.prim + n_prims)
            n_strands += made.n_strands
            n_prims += made.n_prims
            yield made
        if walk.other:
            kinds = kinds_text(walk.other)
            remarks.source.warn(f"prims that are not BasisCurves or HermiteCurves are not read: {kinds}")


def _find_assets(copy: Path, folder: Path) -> None:
    """Let a copy of a file, such as one that was packed, refer to what is beside the file itself."""
    from pxr import Sdf, UsdUtils

    if copy.suffix.lower() == ".usdz":  # which holds what it refers to
        return
    layer = Sdf.Layer.FindOrOpen(str(copy.absolute()))
    UsdUtils.ModifyAssetPaths(layer, lambda asset: str(folder / asset) if (folder / asset).is_file() else asset)
    if layer.dirty:
        layer.Save()


def reason_of(error: Exception) -> str:
    """Return what USD says in an error, without its functions and lines."""
    text = text_of(error)
    said = re.findall(r": '(.*?)'\s*(?:Error in|$)", text)
    return short(said[0] if said else text) or type(error).__name__


def text_of(said: object, attribute: str = "") -> str:
    """Return a text of USD in one line; it may hold bytes of the file that are not text."""
    try:
        return " ".join(str(getattr(said, attribute) if attribute else said).split())
    except UnicodeDecodeError:
        return "it holds bytes that are not UTF-8"


def short(words: str) -> str:
    """Return the first 200 characters of a text."""
    return words if len(words) <= 200 else f"{words[:200]} …"
