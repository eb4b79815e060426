"""The tree as data: its nodes, its layout, its files."""
