"""Cards: what notebooks show of a geometry, a tree or hits."""
