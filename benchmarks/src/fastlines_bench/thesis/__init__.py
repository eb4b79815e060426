"""Chapter 6 of the thesis repeated, with its own figures next to ours: ``fastlines-bench thesis``."""
