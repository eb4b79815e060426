"""``fastlines-bench hair``: the scattering of hair beside Mitsuba's, and tables of averaged hair beside sums."""

from .run import MATERIALS, HairPreset, run_hair
from .show import print_hair

__all__ = ["MATERIALS", "HairPreset", "print_hair", "run_hair"]
