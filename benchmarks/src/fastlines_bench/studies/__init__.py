"""Single questions, each of which reproduces a table of the docs."""
