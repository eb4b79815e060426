"""The material of a surface: how rough it is, and whether it is a metal.

Light is scattered evenly by the share 1 − metallic, in the colour of the line. Besides, there is a highlight about the
mirror direction, the normalised lobe of Blinn and Phong (Lafortune and Willems 1994), where h is halfway between the
light and the eye:

    highlight = tint · (exponent + 8) / 48 · (n · h)^exponent,   exponent = 2 / roughness⁴ − 2
    tint      = (1 − metallic) · gloss + metallic · 6/π · colour

So the highlight of a metal reflects all of its colour, and that of other surfaces a fraction of white light. Light of
the sky is scattered evenly, also by a metal. The relation of roughness and exponent is that of Burley ("Physically
Based Shading at Disney", 2012) with α = roughness².
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from ...arrays import check_fields, number

#: The exponent with which a highlight has the strength `gloss` in its middle.
USUAL_EXPONENT = 40.0


@dataclass(frozen=True)
class SurfaceMaterial:
    """What fibres and tubes are made of; their colour is the one of `color`.

    Parameters
    ----------
    roughness : float
        The width of the highlight, perceptually uniform, from 0.1, polished, to 1, chalk.
    metallic : float
        From 0, plastic, paint or wood, to 1, a metal: it reflects light in its own colour alone, and scatters none.
    gloss : float
        The strength of the highlight of what is no metal, from 0, matt, to 1.

    Raises
    ------
    InputError
        If a value is out of range.

    Examples
    --------
    >>> import fastlines as fl
    >>> copper = fl.SurfaceMaterial(roughness=0.3, metallic=1)
    >>> round(copper.exponent, 1), round(fl.SurfaceMaterial().exponent)
    (244.9, 40)
    >>> fl.SurfaceMaterial(roughness=2)
    Traceback (most recent call last):
    fastlines.errors.InputError: roughness=2; expected a roughness: a number from 0.1 to 1
    """

    roughness: float = 0.467
    metallic: float = 0.0
    gloss: float = 0.12

    def __post_init__(self) -> None:
        check_fields(self, ("roughness",), number, "a roughness: a number from 0.1 to 1", 0.1, 1.0)
        check_fields(self, ("metallic", "gloss"), number, "a fraction: a number from 0 to 1", 0.0, 1.0)

    @property
    def exponent(self) -> float:
        """The exponent of the highlight; the larger it is, the smaller is the highlight."""
        return 2 / self.roughness**4 - 2

    @property
    def shine(self) -> tuple[float, float]:
        """The middle of the highlight in white light, and in the colour of the line.

        Examples
        --------
        >>> [round(part, 2) for part in SurfaceMaterial().shine]
        [0.12, 0.0]
        """
        peak = (self.exponent + 8) / (USUAL_EXPONENT + 8)
        return peak * (1 - self.metallic) * self.gloss, peak * self.metallic * 6 / math.pi


SATIN = SurfaceMaterial()
#: The materials by name.
MATERIALS = {
    "matt": SurfaceMaterial(roughness=1.0, gloss=0.0),
    "satin": SATIN,
    "polished": SurfaceMaterial(roughness=0.25, gloss=0.2),
    "metal": SurfaceMaterial(roughness=0.4, metallic=1.0),
}
