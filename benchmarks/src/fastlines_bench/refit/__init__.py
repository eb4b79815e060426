"""How fast trees follow moving lines, and what their queries lose: ``fastlines-bench refit``."""
