"""The cost of a ray as the scene grows, and the speed-up by threads: ``fastlines-bench growth``."""
