"""Queries of points, and pairs of lines that touch, beside peers: ``fastlines-bench nearest`` and ``pairs``."""
