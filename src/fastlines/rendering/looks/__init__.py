"""Looks: how the fragments of a picture are shaded."""

from .look import Backdrop, Look
from .table import LOOKS, check_name, look_for, make_look

__all__ = ["LOOKS", "Backdrop", "Look", "check_name", "look_for", "make_look"]
