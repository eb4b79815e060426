"""Pictures as data, and their files."""
