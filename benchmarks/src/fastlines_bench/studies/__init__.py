"""``fastlines-bench study``: single questions about trees, each of which makes a table of the docs again."""
