"""The README's banner, composed of the pictures of a demo."""

from __future__ import annotations

from pathlib import Path

from PIL import Image

from fastlines.scenes import NAMES

WIDTH, GAP = 1280, 6


def row(paths: list[Path]) -> Image.Image:
    """Return pictures side by side, scaled to one height so that they fill the width of the banner."""
    pictures = [Image.open(path).convert("RGB") for path in paths]
    room = WIDTH - GAP * (len(pictures) - 1)
    height = round(room / sum(picture.width / picture.height for picture in pictures))
    strip = Image.new("RGB", (WIDTH, height), "white")
    x = 0
    for picture in pictures:
        width = round(height * picture.width / picture.height)
        strip.paste(picture.resize((width, height), Image.Resampling.LANCZOS), (x, 0))
        x += width + GAP
    return strip


def make_banner(demo: Path, output: Path) -> None:
    """Write the banner, from the folder that ``fastlines demo`` wrote."""
    images = demo / "images"
    rows = [
        row([images / f"{name}-M.png" for name in NAMES]),
        row([images / "spaghetti-bvh-d2.png", images / "straight-hair-kd-d2.png"]),
    ]
    banner = Image.new("RGB", (WIDTH, sum(strip.height for strip in rows) + GAP), "white")
    y = 0
    for strip in rows:
        banner.paste(strip, (0, y))
        y += strip.height + GAP
    banner.quantize(128).save(output, optimize=True)
