"""Hair and other round fibres: the scattering model of Chiang, Bitterli, Tappan and Burley.

"A Practical and Controllable Hair and Fur Model for Production Path Tracing" (2016) is the model of pbrt's and
Mitsuba's ``hair``. It is a sum of lobes: light that is reflected (R), transmitted (TT), reflected inside once (TRT),
and what remains. `evaluate`, `sample` and `pdf` are for a ray that meets a fibre at a known offset from its axis.
`AveragedHair` is for fibres thinner than a pixel.
"""

from .averaged import AveragedHair
from .material import HairMaterial
from .scattering import evaluate, evaluate_angles, pdf, sample

__all__ = ["AveragedHair", "HairMaterial", "evaluate", "evaluate_angles", "pdf", "sample"]
