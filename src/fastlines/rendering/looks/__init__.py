"""Looks: how the fragments of a picture are shaded."""

from .look import Backdrop, Look
from .table import (
    LOOKS,
    QUALITIES,
    ColorOption,
    MaterialOption,
    check_color,
    check_material,
    check_name,
    look_for,
    make_look,
)

__all__ = [
    "LOOKS",
    "QUALITIES",
    "Backdrop",
    "ColorOption",
    "Look",
    "MaterialOption",
    "check_color",
    "check_material",
    "check_name",
    "look_for",
    "make_look",
]
