"""What ``fastlines render`` does: it checks the options, opens the lines, draws them, and writes the pictures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import fastlines as fl

from ..camera import Camera, Vector
from ..errors import InputError
from ..geometry.any_geometry import AnyGeometry
from ..query.rays import require_radius
from ..rendering import (
    MEASURES,
    Measure,
    check_image_path,
    complete_size,
    default_camera,
    default_size,
    finish,
    level_sheet,
    renderer_of,
    turntable_camera,
    write_picture,
)
from ..rendering.color.palette import check_map
from ..rendering.looks import Backdrop, Look, check_name, look_for, make_look
from ..rendering.pictures.options import LEVELS, PictureRequest, as_flag, check_options
from ..rendering.renderer import check_exposure, request_of
from ..rendering.shading.depth import SIZE, check_size
from ..rendering.suitable_radius import small, suitable_radius
from ..settings.methods import DEFAULT_METHOD, method_settings
from ..tree import Tree
from .files import Source, check_output, open_lines, show_progress
from .hint import hint_at_radius
from .options import refuse_given, vector
from .resume import add_samples, check_resume, keep_state, without_interrupts
from .sequence import check_sequence, write_sequence


@dataclass(frozen=True)
class Order:
    """The options of ``fastlines render``, by their names; None is not given."""

    source: str
    output: str
    look: str | None
    radius: float | None
    color: str | None
    color_map: str | None
    background: str | None
    legend: bool | None
    quality: str
    exposure: float
    width: int | None
    height: int | None
    samples: int | None
    direction: str | None
    up: str | None
    fov: float | None
    lens_radius: float | None
    focus_distance: float | None
    turntable: int | None
    radius_sweep: str | None
    seconds: float | None
    resume: bool
    levels: int
    method: str | None
    skip_invalid: bool
    format: str | None
    option: list[str] | None

    @property
    def many(self) -> str:
        """The option that makes many pictures; empty for one."""
        named = {"--turntable": self.turntable, "--radius-sweep": self.radius_sweep}
        return next((name for name, value in named.items() if value is not None), "")

    @property
    def is_transparent(self) -> bool:
        """Whether the picture has no backdrop."""
        return self.background == "transparent"

    @property
    def given(self) -> Mapping[str, object]:
        """The options as `check_options` takes them."""
        background = None if self.is_transparent else self.background
        return vars(self) | {"background": background, "transparent": self.is_transparent}


@dataclass(frozen=True)
class Plan:
    """An order that has been checked as far as that can be done without the lines."""

    order: Order
    extension: str
    radii: list[float]
    view: Vector | None
    up: Vector | None
    backdrop: Backdrop | None

    def check(self, request: PictureRequest) -> None:
        """Refuse options that would change nothing."""
        look = LEVELS if self.order.levels else request.look
        check_options(self.order.given, PictureRequest(look, request.color, self.extension, self.order.many), as_flag)


@dataclass(frozen=True)
class Scene:
    """The lines, with all that pictures of them need."""

    tree: Tree
    camera: Camera
    size: tuple[int, int]
    look: Look | Measure
    legend: bool
    radius: float
    #: Whether the radius was chosen to suit the lines.
    is_chosen: bool

    @property
    def focus(self) -> str:
        """Where the picture is in focus, in words; empty without a lens."""
        return f"in focus at a distance of {self.camera.focus:g}, " if self.camera.lens_radius else ""

    @property
    def thickness(self) -> str:
        """What was drawn, and how thick, in words."""
        is_thick = "radius" in self.tree.geometry.sample_names
        suits = ", which suits them; --radius sets another" if self.is_chosen else ""
        return f"{self.tree.geometry.count_text()}, radius {self.radius:g}{', and their own' if is_thick else suits}"


def draw(order: Order) -> str:
    """Write the pictures of an order; return what was written, in words."""
    plan = checked(order)
    scene = open_scene(plan)
    if order.levels:
        return write_levels(plan, scene)
    return write_many(plan, scene) if order.many else write_one(plan, scene)


def checked(order: Order) -> Plan:
    """Check an order before any work is done."""
    extension, radii = _output(order)
    if order.method is not None:
        method_settings(order.method)
    check_size(order.width or SIZE, order.height or SIZE)
    check_exposure(order.exposure)
    if order.color_map is not None:
        check_map(order.color_map)
    if order.look is not None:
        check_name(order.look)
    backdrop = None if order.background is None or order.is_transparent else Backdrop.of(order.background)
    view, up = vector(order.direction, "--direction"), vector(order.up, "--up")
    if order.focus_distance is not None and not order.lens_radius:
        raise InputError("--focus-distance does not apply without a lens; add --lens-radius, or leave it out")
    plan = Plan(order, extension, radii, view, up, backdrop)
    plan.check(PictureRequest(look=order.look))
    return plan


def _output(order: Order) -> tuple[str, list[float]]:
    """Check where pictures are written; return the extension, and the radii of a sweep."""
    if order.many:
        radii = check_sequence(order.output, order.radius_sweep, order.turntable)
        return Path(order.output).suffix.lower(), radii
    extension = check_image_path(order.output)
    check_output(order.output)
    check_resume(order.output, order.resume)
    return extension, []


def open_scene(plan: Plan) -> Scene:
    """Open the lines; choose the look, the camera and the radius; build the tree."""
    order = plan.order
    opened = open_lines(order.source, order.skip_invalid, order.format, order.option)
    if opened.tree is not None:
        refuse_given({"--method": order.method}, f"{order.source} is a tree already; 'fastlines build' makes another")
    look, legend = _look(plan, opened.geometry)
    camera, size = _view(plan, opened.geometry)
    tree = opened.tree or fl.build(opened.geometry, order.method or DEFAULT_METHOD, progress=show_progress())
    is_chosen = order.radius is None and not plan.radii and opened.geometry.needs_radius
    radius = _suitable(tree, opened) if is_chosen else order.radius or 0.0
    return Scene(tree, camera, size, look, legend, radius, is_chosen)


def _view(plan: Plan, geometry: AnyGeometry) -> tuple[Camera, tuple[int, int]]:
    """Choose the camera and the size of pictures; one that turns shows the lines at every angle."""
    order, size = plan.order, (SIZE, SIZE)
    if order.turntable is None and not order.levels:
        size = default_size(geometry, SIZE, direction=plan.view, up=plan.up)
    size = complete_size(order.width, order.height, size)
    check_size(*size)
    make = default_camera if order.turntable is None else turntable_camera
    aspect = 1.0 if order.levels else size[0] / size[1]
    fov = 30.0 if order.fov is None else order.fov
    camera = make(geometry, direction=plan.view, up=plan.up, fov_degrees=fov, aspect=aspect)
    return replace(camera, lens_radius=order.lens_radius or 0.0, focus_distance=order.focus_distance), size


def _look(plan: Plan, geometry: AnyGeometry) -> tuple[Look | Measure, bool]:
    """Make the look, and return whether its legend is drawn: unless the user says so, that of numbers."""
    order = plan.order
    name = order.look or look_for(geometry)
    plan.check(PictureRequest(look=name))
    made = MEASURES.get(name) or make_look(name, geometry, order.color, order.color_map, order.quality)
    request = request_of(name, made, geometry)
    plan.check(request)
    has_bar = request.color == "number" and plan.extension != ".exr"
    return made, has_bar if order.legend is None else order.legend


def _suitable(tree: Tree, opened: Source) -> float:
    """Choose a radius that suits the lines."""
    radius = suitable_radius(tree, opened.camera())
    require_radius(opened.geometry, radius)
    return radius or 0.0


def write_levels(plan: Plan, scene: Scene) -> str:
    """Write a sheet of the levels of the tree; return what was written, in words."""
    output, levels = plan.order.output, plan.order.levels
    sheet = level_sheet(scene.tree, scene.camera, scene.radius, levels, progress=show_progress())
    write_picture(output, sheet)
    return f"{output}: {levels} levels, {scene.thickness}"


def write_many(plan: Plan, scene: Scene) -> str:
    """Write the pictures of a turn or of a sweep; return what was written, in words."""
    order, radii = plan.order, plan.radii
    width, height = scene.size
    options = {
        **_finish(plan, scene),
        "width": width,
        "height": height,
        "radius": scene.radius,
        "look": scene.look,
        "samples": order.samples,
        "background": None if order.is_transparent else order.background,
    }
    turn = (order.turntable, order.seconds, order.is_transparent)
    written = write_sequence(order.output, scene.tree, scene.camera, radii, *turn, show_progress(), **options)
    what = f"radii {radii[0]:g} to {radii[-1]:g}" if radii else scene.thickness
    return f"{written}, {scene.focus}{what}"


def write_one(plan: Plan, scene: Scene) -> str:
    """Write one picture, of all samples or of those until Ctrl-C; return what was written, in words."""
    order, (width, height) = plan.order, scene.size
    renderer = renderer_of(
        scene.tree, scene.camera, width, height, scene.radius, scene.look, plan.backdrop, None, order.samples
    )
    is_whole = add_samples(renderer, order.output, order.resume, show_progress())
    with without_interrupts():
        if renderer.n_rows:  # else an older picture of this name is better
            finish(renderer, plan.backdrop, **_finish(plan, scene)).save(order.output, order.is_transparent)
        keep_state(renderer, order.output, is_whole, order.resume)
    if not scene.is_chosen:
        hint_at_radius(scene.tree, *scene.camera.rays(*small(width, height)), scene.radius)
    return f"{order.output}: {width} × {height} pixels, {scene.focus}{scene.thickness}"


def _finish(plan: Plan, scene: Scene) -> dict[str, Any]:
    """Return what does not depend on the samples of a picture."""
    return {"exposure": plan.order.exposure, "aovs": plan.extension == ".exr", "legend": scene.legend}
