"""Many pictures from one tree: ``--turntable`` and ``--radius-sweep``."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ..camera import Camera
from ..errors import InputError
from ..progress import reporting
from ..rendering import Picture, check_frames_path, numbered, radius_sweep, spaced_radii, turntable, write_frames
from ..tree import Tree
from .files import check_output


def swept_radii(text: str) -> list[float]:
    """Read A:B:N, and space N radii from A to B."""
    try:
        first, last, n_radii = text.split(":")
        bounds, n = (float(first), float(last)), int(n_radii)
    except ValueError:
        raise InputError(f"--radius-sweep {text!r} is not A:B:N, such as 0.0005:0.05:60") from None
    return spaced_radii(*bounds, n)


def check_sequence(output: str, sweep: str | None, n_turns: int | None) -> list[float]:
    """Check the options of many pictures; return the radii of a sweep."""
    if sweep is not None and n_turns is not None:
        raise InputError("--turntable and --radius-sweep are both given; give one of them")
    extension = check_frames_path(output)
    check_output(str(numbered(output, 1)) if extension in (".png", ".exr") else output)
    return [] if sweep is None else swept_radii(sweep)


def write_sequence(
    output: str,
    tree: Tree,
    camera: Camera,
    radii: list[float],
    n_turns: int | None,
    seconds: float | None,
    is_transparent: bool,
    progress: bool,
    **options: Any,
) -> str:
    """Write the pictures of a turn, or of a sweep of the radius; return what was written, in words."""
    if radii:
        del options["radius"]
        pictures, n_pictures = radius_sweep(tree, radii, camera, **options), len(radii)
    else:
        assert n_turns is not None
        pictures, n_pictures = turntable(tree, n_turns, camera, **options), n_turns
    with reporting(progress, "render") as callback:

        def shown() -> Iterator[Picture]:
            for i, picture in enumerate(pictures):
                if callback is not None:
                    callback((i + 1) / n_pictures)
                yield picture

        written = write_frames(output, shown(), seconds=seconds, transparent=is_transparent)
    size = f"{n_pictures} pictures of {options['width']} × {options['height']} pixels"
    return f"{written[0]} to {written[-1]}: {size}" if len(written) > 1 else f"{written[0]}: {size}"
