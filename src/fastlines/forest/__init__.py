"""Forests: trees of tiles of a scene in a folder, which answer as one tree does."""
