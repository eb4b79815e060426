"""Queries of round cones, cubic hair, spheres and triangles beside Embree's: ``fastlines-bench engine --shapes``."""
