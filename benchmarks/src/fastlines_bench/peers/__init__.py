"""Embree as a peer: its scenes, its configurations, its tree, and the tuned lengths of its pieces."""
