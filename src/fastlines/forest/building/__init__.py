"""Builds of forests: stages that each leave files, so that a second call goes on where the first ended."""
