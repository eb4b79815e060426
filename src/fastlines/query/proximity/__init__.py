"""Queries about points: the nearest primitives, and those within a radius."""
