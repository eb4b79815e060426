"""Ray queries on lines with the interface that trimesh has for meshes."""

from .ray_lines import RayLines

__all__ = ["RayLines"]
