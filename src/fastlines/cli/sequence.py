"""Many pictures from one tree: ``--turntable`` and ``--radius-sweep``."""

from __future__ import annotations

import time
from collections.abc import Iterator

from ..errors import InputError
from ..progress import reporting
from ..rendering import Picture, check_frames_path, numbered, report_if_long, spaced_radii, write_frames
from .files import check_output, note, show_progress


def swept_radii(text: str) -> tuple[float, ...]:
    """Read A:B:N, and space N radii from A to B."""
    try:
        first, last, n_radii = text.split(":")
        bounds, n = (float(first), float(last)), int(n_radii)
    except ValueError:
        raise InputError(f"--radius-sweep {text!r} is not A:B:N, such as 0.0005:0.05:60") from None
    return tuple(spaced_radii(*bounds, n))


def check_sequence(output: str) -> None:
    """Refuse, before any work, files that cannot be written."""
    extension = check_frames_path(output)
    check_output(str(numbered(output, 1)) if extension in (".png", ".exr") else output)


def write_sequence(
    output: str, pictures: Iterator[Picture], n_pictures: int, seconds: float | None, is_transparent: bool
) -> str:
    """Write pictures as they are made; return the names of the files, in words."""
    start = time.perf_counter()
    with reporting(show_progress(), "render") as callback:

        def shown() -> Iterator[Picture]:
            for i, picture in enumerate(pictures):
                if i == 0 < n_pictures - 1:
                    report_if_long(
                        f"these {n_pictures:,} pictures take", n_pictures * (time.perf_counter() - start), note
                    )
                if callback is not None:
                    callback((i + 1) / n_pictures)
                yield picture

        written = write_frames(output, shown(), seconds=seconds, transparent=is_transparent)
    return f"{written[0]} to {written[-1]}" if len(written) > 1 else f"{written[0]}"
