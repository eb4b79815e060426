"""Path-traced hair beside Mitsuba 3: the picture, its time, and its rays: ``fastlines-bench mitsuba``."""
