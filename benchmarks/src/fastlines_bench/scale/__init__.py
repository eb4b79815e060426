"""Scenes beyond memory: forests of trees, out of core and on several workers."""
