"""Queries: checked rays, backends that answer them, and hits."""
