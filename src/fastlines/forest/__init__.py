"""Forests: folders of trees over tiles of one scene, queried as one tree."""
