"""USD scenes, written by hand."""

from __future__ import annotations

import warnings

from fastlines.errors import FileWarning

SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
SEVEN = [(i, i % 3, i % 2) for i in range(7)]


def curves(
    points=SQUARE, counts=None, name="c", kind="linear", basis=None, wrap=None, widths=None, more="", of="BasisCurves"
) -> str:
    """Write one prim of curves; `widths` are their interpolation and values."""
    lines = [
        f"point3f[] points = {[tuple(map(float, point)) for point in points]}",
        f"int[] curveVertexCounts = {[len(points)] if counts is None else counts}",
        f'uniform token type = "{kind}"' if of == "BasisCurves" else "",
        f'uniform token basis = "{basis}"' if basis else "",
        f'uniform token wrap = "{wrap}"' if wrap else "",
        f'float[] widths = {widths[1]} (interpolation = "{widths[0]}")' if widths else "",
        more,
    ]
    return f'def {of} "{name}" {{\n' + "\n".join(lines) + "\n}\n"


def usda(*prims: str, head: str = "") -> bytes:
    return "\n".join([f"#usda 1.0\n({head})", *prims, ""]).encode()


def xform(inner: str, *, name: str = "x", move=(0, 0, 0), scale=(1, 1, 1), more: str = "") -> str:
    ops = '"xformOp:translate", "xformOp:scale"'
    return (
        f'def Xform "{name}" {more} {{\ndouble3 xformOp:translate = {move}\nfloat3 xformOp:scale = {scale}\n'
        f"uniform token[] xformOpOrder = [{ops}]\n{inner}}}\n"
    )


def warned(load, data: bytes, name: str = "a.usda", **options):
    """Read a file and return what was read, and all warnings as one text."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        made = load(data, name, **options)
    assert all(issubclass(one.category, FileWarning) for one in caught)
    return made, "\n".join(str(one.message) for one in caught)


def instancer(inner: str, *, name="p", indices=(0, 1, 0), targets="</p/a>, </p/b>", more="") -> str:
    positions = [(10.0 * (i + 1), 0.0, 0.0) for i in range(len(indices))]
    return (
        f'def PointInstancer "{name}" {{\nint[] protoIndices = {list(indices)}\npoint3f[] positions = {positions}\n'
        f"rel prototypes = [{targets}]\n{more}\n{inner}}}\n"
    )
