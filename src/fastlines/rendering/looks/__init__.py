"""Looks: how the fragments of a picture are shaded."""

from .look import Backdrop, Look
from .table import LOOKS, QUALITIES, ColorOption, check_color, check_name, look_for, make_look

__all__ = [
    "LOOKS",
    "QUALITIES",
    "Backdrop",
    "ColorOption",
    "Look",
    "check_color",
    "check_name",
    "look_for",
    "make_look",
]
