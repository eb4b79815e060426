"""Cards: what notebooks show of a geometry or a tree."""
