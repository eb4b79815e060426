"""Embree as a peer: its scenes, its configurations, its tree, and how long its pieces are best."""
