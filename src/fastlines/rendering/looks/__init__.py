"""Looks: how the fragments of a picture are shaded."""

from .look import Backdrop, Look
from .table import LOOKS, look_for, make_look

__all__ = ["LOOKS", "Backdrop", "Look", "look_for", "make_look"]
