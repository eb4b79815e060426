"""Forests: folders of trees over tiles of one scene, which are asked as one tree."""
