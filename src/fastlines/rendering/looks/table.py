"""The looks by name, and the one that suits a geometry."""

from __future__ import annotations

from collections.abc import Container, Sequence
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from ...arrays import choice, did_you_mean
from ...errors import InputError
from ...geometry.any_geometry import AnyGeometry
from ...support.distinct import distinct
from ..color.palette import light_of
from ..hair.material import HairMaterial
from ..pictures.options import PictureRequest, check_options
from ..shading.lighting import SOFT
from . import flat
from .color import ATTRIBUTE, DISPLAY_COLOR, TYPE, WORDS, Color, make_color
from .look import Backdrop, Look
from .solid import SLIGHT_HAZE, Solid
from .surface_material import MATERIALS, SATIN, SurfaceMaterial

#: What colours lines: a word, "#rrggbb" or an attribute's name; or three numbers from 0 to 1.
ColorOption: TypeAlias = str | Sequence[float]
#: What lines are made of: hair, or fibres and tubes, of which some materials have names.
MaterialOption: TypeAlias = HairMaterial | SurfaceMaterial | str

#: The looks, and half a line about each.
LOOKS = {
    "hair": "hair and fur, with highlights and light that passes through",
    "fibre": "tracts, streamlines and wires, coloured by direction",
    "tube": "solid lines, for neurons, yarns and molecules",
    "depth": "lighter is nearer, as in the thesis",
    "id": "a colour for each strand",
    "normal": "the normals as the camera sees them",
    "tangent": "the directions of the lines as the camera sees them",
}
#: The looks that show a number of each ray, not lines (`rendering.measures`), and half a line about each.
NUMBERS = {
    "hits": "how many lines the ray of each pixel hits",
    "density": "the length of lines along the ray of each pixel, like an X-ray",
    "work": "how many nodes of the tree it visits",
}
#: How exact light is: scattered once and then as an estimate, or by paths of many bounces.
QUALITIES = ("normal", "high")
#: The colour map, unless another one is given.
DEFAULT_MAP = "viridis"
#: The least number of strands that looks like hair, if nothing says otherwise, and that of a groom.
HAIRS, GROOM = 1000, 100
#: The numbers of points of a strand that TressFX has.
GROOM_POINTS = (4, 8, 16, 32, 64)
#: Half of the turns of hair have a larger cosine.
SMOOTH = 0.8

PAPER = Backdrop("#eeeef0", "#c6c6cb")
#: Darker than lit hair, so that gaps between hairs look deep, and light from behind draws the outline.
SLATE = Backdrop("#5a5d65", "#212226")
NIGHT = Backdrop("#16181d", "#08080a")
#: The attribute of the number of a residue of a molecule.
RESIDUE = "residue"
#: Lines of a larger luminance are hardly seen before paper, and those of a smaller one before the night.
PALE, DIM = 0.6, 0.01
#: How much the farthest fibres fade; where colours are numbers, which must be read, it is `SLIGHT_HAZE`.
HAZE = 0.5
CLAY = "#c4a878"
AMBER = "#ffb45c"
#: The tilt of the scales of hair, whose strands run from the root to the tip, and its roughness along the strand.
TILT, ROUGHNESS = -2.0, 0.25
#: The least reflectance of hair: no fibre absorbs all light.
DARKEST = 1e-3
#: How much brighter or darker than the mean a hair is, for a head has hairs of many shades.
VARIETY = 0.25
#: The melanin and the redness of the colours of hair.
HAIR_COLORS = {
    "white": (0.0, 0.0),
    "blond": (0.26, 0.3),
    "red": (0.73, 1.0),
    "brown": (0.57, 0.28),
    "black": (0.985, 0.1),
}


def look_for(geometry: AnyGeometry) -> str:
    """Choose the look of a geometry.

    Lines with a radius are tubes, and so are all other shapes. Of lines without one, many smooth strands that are not
    flat and without a unit, or in metres, are hair. A thousand are many. So are a hundred if all have the same number
    of points, a power of two as TressFX needs it. Other lines are fibres.

    Examples
    --------
    >>> import fastlines as fl
    >>> look_for(fl.scenes.make("bun-hair").lines), look_for(fl.lines([[[0, 0, 0], [1, 1, 1]]]))
    ('hair', 'fibre')
    """
    parts, unit = geometry.each_part(), geometry.unit
    if geometry.max_radius > 0 or not all(part.has_axes for part in parts):
        return "tube"
    if unit == "Å":
        return "tube"
    is_hair = (
        _is_many(geometry) and not _is_flat(geometry) and unit in (None, "m", "cm") and all(map(_is_smooth, parts))
    )
    return "hair" if is_hair else "fibre"


def _is_many(geometry: AnyGeometry) -> bool:
    """Return whether there are as many strands as hairs, or as of a groom."""
    n_segments = geometry.strand_sizes()
    is_groom = len(distinct(n_segments)) == 1 and n_segments[0] + 1 in GROOM_POINTS
    return len(n_segments) >= (GROOM if is_groom else HAIRS)


def _is_smooth(part: AnyGeometry) -> bool:
    """Return whether strands go on in almost the same direction from segment to segment, as hair does."""
    turns = part.turns()
    return turns is None or (len(turns) > 0 and float(np.median(turns)) > SMOOTH)


def _is_tangled(part: AnyGeometry) -> bool:
    """Return whether strands turn sharply from segment to segment, as a random walk does."""
    turns = part.turns()
    return turns is not None and len(turns) > 0 and float(np.median(turns)) <= SMOOTH


def make_look(
    name: str | None,
    geometry: AnyGeometry,
    color: ColorOption | None = None,
    color_map: str | None = None,
    quality: str = "normal",
    material: MaterialOption | None = None,
    variation: float | None = None,
) -> Look:
    """Make a look by its name, or the one that suits the geometry.

    Parameters
    ----------
    name : str or None
        One of `LOOKS`.
    geometry : Lines or another container
    color : str or three numbers, optional
        Of hair: one of `HAIR_COLORS`, or a colour such as "#c08040". Of fibres and tubes: "direction", "strand", the
        name of an attribute, or a colour; "attribute:strand" is an attribute of the name of one of these words. Three
        numbers are a colour from 0 to 1, as a screen shows it.
    color_map : str, optional
        One of `palette.MAPS`, for an attribute; "viridis" by default.
    quality : str
        One of `QUALITIES`; "high" is for hair.
    material : HairMaterial, SurfaceMaterial or str, optional
        Of hair, in place of a colour; or of fibres and tubes, also one of `MATERIALS`.
    variation : float, optional
        How much brighter or darker than the mean a strand is; by default `VARIETY` in hair, else 0.
    """
    name = name or look_for(geometry)
    check_name(name, LOOKS)
    choice("quality", quality, QUALITIES)
    given = {"color": color, "color_map": color_map, "quality": quality, "material": material, "variation": variation}
    check_options(given, PictureRequest(look=name))
    if name == "hair":
        from .hair import Hair
        from .traced_hair import TracedHair

        kind = TracedHair if quality == "high" else Hair
        of_hair = _hair_material(color, material, geometry)
        return kind(of_hair, SLATE, variation=VARIETY if variation is None else variation)
    if name in ("fibre", "tube"):
        known = geometry.sample_names
        if color is None and name == "tube" and TYPE in known and geometry.unit == "µm":
            chosen = Color("neurite")
        else:
            usual = DISPLAY_COLOR if DISPLAY_COLOR in known else _usual_color(name, geometry)
            chosen = make_color(usual if color is None else color, color_map or DEFAULT_MAP, geometry)
        chosen = replace(chosen, variation=variation or 0.0)
        if name == "fibre":
            haze = SLIGHT_HAZE if chosen.has_bar(geometry) else HAZE
            fibres = Solid(chosen, NIGHT, SOFT, haze, _surface(material))
            return fibres.before(PAPER) if chosen.lightness(geometry) < DIM else fibres
        behind = SLATE if chosen.lightness(geometry) > PALE else PAPER
        return Solid(chosen, behind, material=_surface(material), has_ground=True)
    shown = {"depth": flat.depth, "id": flat.ids, "normal": flat.normals, "tangent": flat.tangents}
    return flat.Flat(shown[name])


def check_color(color: object) -> None:
    """Refuse what is no colour: neither a text nor three numbers."""
    if isinstance(color, HairMaterial | SurfaceMaterial):
        raise InputError(f"color={color!r}; expected the name of a colour, '#rrggbb', or three numbers; use material=")
    if color is not None:
        light_of(color)


def check_material(material: object) -> None:
    """Refuse what is no material."""
    if isinstance(material, str):
        choice("material", material, MATERIALS)
    elif not (material is None or isinstance(material, HairMaterial | SurfaceMaterial)):
        raise InputError(
            f"material={material!r}; expected a HairMaterial, a SurfaceMaterial, or one of {', '.join(MATERIALS)}"
        )


def check_name(name: str, known: Container[str] = (*LOOKS, *NUMBERS)) -> None:
    """Refuse an unknown look."""
    if name not in known:
        raise InputError(f"there is no look {name!r}{did_you_mean(name, (*LOOKS, *NUMBERS))}")


def _usual_color(look: str, geometry: AnyGeometry) -> str:
    """Return the colour of fibres or tubes: by direction, by chains or residues of molecules, or one for all.

    Directions say nothing where lines are flat, or turn all the time.
    """
    if look == "fibre":
        return AMBER if _is_flat(geometry) or any(map(_is_tangled, geometry.each_part())) else "direction"
    if geometry.unit != "Å":
        return CLAY
    return RESIDUE if geometry.n_strands == 1 and RESIDUE in geometry.sample_names else "strand"


def _is_flat(geometry: AnyGeometry) -> bool:
    """Return whether an extent is zero, as that of a map."""
    return len(geometry) == 0 or bool((geometry.bounds[1] == geometry.bounds[0]).any())


def _surface(material: MaterialOption | None) -> SurfaceMaterial:
    """Return the material of fibres or tubes."""
    if isinstance(material, HairMaterial):
        raise InputError(
            "material is a HairMaterial, which is for the look 'hair'; name that look, or give a SurfaceMaterial"
        )
    if isinstance(material, SurfaceMaterial):
        return material
    return SATIN if material is None else MATERIALS[material]


def _hair_material(color: ColorOption | None, material: MaterialOption | None, geometry: AnyGeometry) -> HairMaterial:
    """Return hair of a natural colour, or of any, or the given material."""
    if isinstance(material, HairMaterial):
        if color is not None:
            raise InputError(
                f"color={color!r} does not apply: the material of hair has a colour of its own; give one of them"
            )
        return material
    if material is not None:
        raise InputError(
            f"material={material!r} is for the looks 'fibre' and 'tube', and this is 'hair'; name one of them, or give "
            "a HairMaterial"
        )
    color = "brown" if color is None else color
    shape = {"scale_tilt": TILT, "longitudinal_roughness": ROUGHNESS}
    light = light_of(color)
    if light is not None:
        red, green, blue = (max(channel, DARKEST) for channel in light)
        return HairMaterial.from_reflectance((red, green, blue), **shape)
    assert isinstance(color, str)
    if color not in HAIR_COLORS:
        known = geometry.sample_names
        if color in (*WORDS, *known) or color.startswith(ATTRIBUTE):
            raise InputError(f"color={color!r} is for the looks 'fibre' and 'tube', and this is 'hair'; name the look")
        raise InputError(f"there is no hair colour {color!r}{did_you_mean(color, (*HAIR_COLORS, '#rrggbb'))}")
    melanin, redness = HAIR_COLORS[color]
    return HairMaterial.from_melanin(melanin, redness, **shape)
