"""The plan of a picture: its look, size, camera and radius. It is made once, here, for Python and the command line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, cast

import numpy as np

from ..arrays import choice, count, instance, number
from ..builder import build
from ..camera import Camera
from ..errors import InputError
from ..geometry.any_geometry import AnyGeometry
from ..geometry.collection import as_geometry
from ..geometry.offsets import NO_OFFSET, Offset
from ..progress import ProgressOption
from ..query.ray_queries import RayQueries
from ..query.rays import warn_of_radius
from ..tree import Tree
from .color.palette import check_map
from .default_view import ViewOptions, complete_size, default_size
from .hair.material import HairMaterial
from .looks import (
    QUALITIES,
    Backdrop,
    ColorOption,
    Look,
    MaterialOption,
    check_color,
    check_material,
    check_name,
    look_for,
    make_look,
)
from .looks.solid import Solid
from .looks.table import PAPER
from .measures import MEASURES, Measure
from .pictures.options import NUMBERS, OWN_FLAT, OWN_LIT, PictureRequest, check_options
from .shading.depth import SIZE, check_radius, check_size
from .shading.depth_tone import pixel_size
from .shading.lighting import Rig, find_rig
from .shading.own_frame import moved
from .suitable_radius import THICKEST, THICKEST_HAIR, suitable_radius

#: The most samples of a pixel.
MAX_SAMPLES = 1 << 16


@dataclass(frozen=True, kw_only=True)
class PictureOptions:
    """The options of `render`, as they are given: what is None is chosen to suit the lines.

    They are checked as far as that can be done without the lines.

    Attributes
    ----------
    camera : Camera or ViewOptions, optional
        A camera, or how to choose one.
    rig : Rig, optional
        Also given by its name.
    ground : bool, optional
        By default what the look has.
    side : int
        A picture without a width and a height has about side² pixels.
    legend : bool or str, optional
        By default the colours of numbers have a legend, unless the file holds numbers itself. A text is its title.
    file : str, optional
        The extension of the picture's file, if it is known.
    """

    camera: Camera | ViewOptions | None = None
    width: int | None = None
    height: int | None = None
    side: int = SIZE
    look: str | Look | Measure | None = None
    radius: float | None = None
    samples: int | None = None
    color: ColorOption | None = None
    color_map: str | None = None
    material: MaterialOption | None = None
    variation: float | None = None
    background: str | None = None
    ground: bool | None = None
    rig: Rig | str | None = None
    exposure: float = 0.0
    quality: str = "normal"
    aovs: bool = False
    legend: bool | str | None = False
    file: str | None = None

    def __post_init__(self) -> None:
        check_size(SIZE if self.width is None else self.width, SIZE if self.height is None else self.height)
        if self.samples is not None:
            count("samples", self.samples, 1, MAX_SAMPLES)
        number("exposure", self.exposure, "a number from -60 to 60", -60.0, 60.0)  # else light overflows or vanishes
        check_color(self.color)
        check_material(self.material)
        if self.variation is not None:
            number("variation", self.variation, "a fraction: a number from 0 to 1", 0.0, 1.0)
        if self.ground is not None:
            instance("ground", self.ground, bool, "True or False")
        choice("quality", self.quality, QUALITIES)
        instance("aovs", self.aovs, bool, "True or False")
        if not (self.legend is None or isinstance(self.legend, str)):
            instance("legend", self.legend, bool, "True, False, or the title of the legend")
        if self.color_map is not None:
            check_map(self.color_map)
        if not (self.camera is None or isinstance(self.camera, ViewOptions)):
            instance("camera", self.camera, Camera, "a Camera")
        _ = self.backdrop, self.lights
        if isinstance(self.look, str):
            check_name(self.look)
        elif not (self.look is None or isinstance(self.look, Measure) or hasattr(self.look, "shade")):
            raise InputError(f"look={self.look!r}; expected the name of a look, or an object with the members of Look")
        self.check(_request(self.look, MEASURES.get(self.look) if isinstance(self.look, str) else self.look))

    @property
    def lights(self) -> Rig | None:
        """The lights, if they are not those of the look."""
        return find_rig(self.rig)

    @property
    def backdrop(self) -> Backdrop | None:
        """What is behind the picture, if that is not what its look has."""
        return None if self.background is None else Backdrop.of(self.background)

    @property
    def given(self) -> Mapping[str, object]:
        """The options as `check_options` takes them."""
        return vars(self) | {"lens_radius": None if self.camera is None else self.camera.lens_radius}

    def check(self, known: PictureRequest) -> None:
        """Refuse options that would change nothing in a picture of which this is known."""
        check_options(self.given, replace(known, file=self.file))


@dataclass(frozen=True)
class PicturePlan:
    """All that a picture is made from.

    Attributes
    ----------
    tree : Tree
    camera : Camera
    width, height : int
    radius : float
        Added to the radius of the lines.
    look : Look or Measure
    options : PictureOptions
        The rest: the lights, the number of samples, the exposure, the backdrop and the AOVs.
    legend : bool
        Whether what the colours mean is drawn.
    is_suitable : bool
        Whether the radius was chosen to suit the lines.
    offset : three numbers
        The offset of the lines. The tree is over lines without it, and the camera is less it.
    """

    tree: Tree
    camera: Camera
    width: int
    height: int
    radius: float
    look: Look | Measure
    options: PictureOptions = field(default_factory=PictureOptions)
    legend: bool = False
    is_suitable: bool = False
    offset: Offset = NO_OFFSET

    @property
    def given_camera(self) -> Camera:
        """The camera in the coordinates in which lines and rays are given."""
        return moved(self.camera, self.offset)


def plan_picture(
    lines: Any,
    options: PictureOptions,
    *,
    radii: Sequence[float] = (),
    method: str | None = None,
    progress: ProgressOption = False,
) -> PicturePlan:
    """Choose all that the options leave open.

    Parameters
    ----------
    lines : Tree, Forest, or what `build` takes
    options : PictureOptions
    radii : sequence of numbers
        Those of a sweep, of which the plan has the first.
    method, progress
        Of the build, unless `lines` is a tree.

    Examples
    --------
    >>> import fastlines as fl
    >>> plan = plan_picture(fl.scenes.make("spaghetti", 100).lines, PictureOptions(width=32))
    >>> plan.height, plan.radius, type(plan.look).__name__
    (32, 0.002, 'Solid')
    """
    tree = cast(Tree, lines) if isinstance(lines, RayQueries) else None  # a forest answers as a tree does
    geometry = as_geometry(lines) if tree is None else tree.geometry
    offset = geometry.offset
    if offset != NO_OFFSET:
        geometry = geometry.without_offset()
        tree = None if tree is None else tree.without_offset()
        if isinstance(options.camera, Camera):
            options = replace(options, camera=moved(options.camera, np.negative(offset)))
    look, legend = _look(options, geometry)
    camera, width, height = choose_camera(options, geometry, max(radii, default=options.radius or 0.0))
    tree = tree or build(geometry, method, progress=progress)
    radius = radii[0] if len(radii) else options.radius
    is_suitable = radius is None and geometry.is_bare
    if is_suitable:
        thickest = THICKEST_HAIR if _is_hair(look) else THICKEST
        radius = suitable_radius(tree, camera, thickest) if len(geometry) else 0.0
        radius = max(radius, getattr(look, "least_radius", 0.0) * pixel_size(geometry, camera, height))
    radius = check_radius(tree, radius)
    if not geometry.takes_radius:
        warn_of_radius(geometry, radius)
        radius = 0.0
    return PicturePlan(tree, camera, width, height, radius, look, options, legend, is_suitable, offset)


def choose_camera(options: PictureOptions, geometry: AnyGeometry, radius: float) -> tuple[Camera, int, int]:
    """Return the camera, the width and the height of a picture of lines to whose own radius one is added."""
    view = options.camera or ViewOptions()
    suitable = (options.side, options.side)
    if isinstance(view, ViewOptions) and not view.turns:
        suitable = default_size(geometry, options.side, direction=view.direction, up=view.up)
    width, height = complete_size(options.width, options.height, suitable)
    check_size(width, height)
    if not isinstance(view, ViewOptions):
        return view, width, height
    return view.camera(geometry, width / height, radius if geometry.takes_radius else 0.0), width, height


def _is_hair(look: Look | Measure) -> bool:
    return isinstance(getattr(look, "material", None), HairMaterial)


def _look(options: PictureOptions, geometry: AnyGeometry) -> tuple[Look | Measure, bool]:
    """Return the look, and whether its legend is drawn; lines that fade do so into the backdrop."""
    name = look_for(geometry) if options.look is None else options.look
    made = MEASURES.get(name, name) if isinstance(name, str) else name
    if isinstance(made, str):
        options.check(PictureRequest(look=made))
        made = make_look(
            made,
            geometry,
            options.color,
            options.color_map,
            options.quality,
            material=options.material,
            variation=options.variation,
        )
    request = _request(name, made, geometry)
    options.check(request)
    if isinstance(options.legend, str) and request.color == "direction":
        raise InputError(
            f"the legend of directions has no title, and {options.legend!r} is given; draw it without, or colour lines "
            "by an attribute of numbers"
        )
    backdrop = options.backdrop or (PAPER if options.ground and request.look == "fibre" else None)
    if backdrop is not None and isinstance(made, Solid):
        made = made.before(backdrop)
    has_bar = request.color == "number" and options.file != ".exr"
    return made, has_bar if options.legend is None else options.legend is not False


def _request(
    look: str | Look | Measure | None, made: Look | Measure | None, geometry: AnyGeometry | None = None
) -> PictureRequest:
    """Return what is known of a picture from its look, as it was given and as it was made, and from its lines."""
    name = look if isinstance(look, str) else None
    if isinstance(made, Measure):
        return PictureRequest(look=name or NUMBERS[0], color="number")
    if made is None:
        return PictureRequest(look=name)
    name = name or (OWN_LIT if made.is_light else OWN_FLAT)
    if geometry is None:
        return PictureRequest(look=name)
    return PictureRequest(look=name, color=made.color.depends_on(geometry) if isinstance(made, Solid) else "other")
