"""``fastlines-bench study``: single questions about trees, each of which reproduces a table of the docs."""
