"""How long each builder takes, what its tree costs, and how fast queries on it are: ``fastlines-bench builders``."""
