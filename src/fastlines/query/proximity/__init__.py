"""Queries besides rays: the primitives near points, and those in boxes."""
