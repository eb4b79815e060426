"""What ``fastlines render`` does: it checks the options, opens the lines, draws them, and writes the pictures."""

from __future__ import annotations

from dataclasses import dataclass, replace

from ..errors import InputError
from ..forest.forest import Forest
from ..rendering import (
    PictureOptions,
    PicturePlan,
    ViewOptions,
    check_image_path,
    finish,
    level_sheet,
    plan_picture,
    renderer_of,
    write_picture,
)
from ..rendering.pictures.options import LEVELS, PictureRequest, as_flag, check_options
from ..rendering.sequences import swept, turned
from ..rendering.suitable_radius import small
from ..settings.methods import method_settings
from ..support.texts import counted
from .files import as_map, check_output, open_lines, placed, show_progress
from .hint import hint_at_radius
from .options import refuse_given
from .resume import add_samples, check_resume, keep_state, without_interrupts
from .sequence import check_sequence, write_sequence


@dataclass(frozen=True, kw_only=True)
class Order(PictureOptions):
    """The options of ``fastlines render``: those of a picture, and those that only the command line has."""

    source: str
    output: str
    camera: ViewOptions
    transparent: bool
    turntable: int | None
    radii: tuple[float, ...]
    seconds: float | None
    resume: bool
    levels: int
    method: str | None
    skip_invalid: bool
    format: str | None
    option: list[str] | None
    own_radius: bool
    memory: str | None
    scheduler: str | None

    def __post_init__(self) -> None:
        """Check the options as far as that can be done without the lines."""
        if self.turntable is not None and self.radii:
            raise InputError("--turntable and --radius-sweep are both given; give one of them")
        if self.many:
            check_sequence(self.output)
        else:
            check_image_path(self.output)
            check_output(self.output)
            check_resume(self.output, self.resume)
        if self.method is not None:
            method_settings(self.method)
        if self.camera.focus_distance is not None and not self.camera.lens_radius:
            raise InputError("--focus-distance does not apply without a lens; add --lens-radius, or leave it out")
        super().__post_init__()

    @property
    def many(self) -> str:
        """The option that makes many pictures; empty for one."""
        return "--turntable" if self.turntable is not None else "--radius-sweep" if self.radii else ""

    def check(self, known: PictureRequest) -> None:
        """Refuse options that would change nothing, as `PictureOptions.check` does."""
        look = LEVELS if self.levels else known.look
        check_options(self.given, replace(known, look=look, file=self.file, many=self.many), as_flag)


def draw(order: Order) -> str:
    """Write the pictures of an order; return what was written, in words."""
    reading = order.skip_invalid, order.format, order.option, order.own_radius
    opened = as_map(open_lines(order.source, *reading, forests=True))
    if isinstance(opened.tree, Forest):
        refuse_given({"--levels": order.levels or None}, f"{order.source} is a forest, which has no levels of its own")
    if opened.tree is not None:
        refuse_given({"--method": order.method}, f"{order.source} is a tree already; 'fastlines build' makes another")
    with placed(opened, order.memory, order.scheduler) as asked:
        lines = asked.tree or asked.geometry
        plan = plan_picture(lines, order, radii=order.radii, method=order.method, progress=show_progress())
        if order.levels:
            return write_levels(order, plan)
        return write_many(order, plan) if order.many else write_one(order, plan)


def write_levels(order: Order, plan: PicturePlan) -> str:
    """Write a sheet of the levels of the tree; return what was written, in words."""
    sheet = level_sheet(plan.tree, plan.camera, plan.radius, order.levels, progress=show_progress())
    write_picture(order.output, sheet)
    return f"{order.output}: {counted(order.levels, 'levels')}, {thickness(plan)}"


def write_many(order: Order, plan: PicturePlan) -> str:
    """Write the pictures of a turn or of a sweep; return what was written, in words."""
    n_pictures = order.turntable or len(order.radii)
    pictures = swept(plan, order.radii) if order.radii else turned(plan, n_pictures)
    written = write_sequence(order.output, pictures, n_pictures, order.seconds, order.transparent)
    what = f"radii {order.radii[0]:g} to {order.radii[-1]:g}" if order.radii else thickness(plan)
    return f"{written}: {counted(n_pictures, 'pictures')} of {plan.width} × {plan.height} pixels, {focus(plan)}{what}"


def write_one(order: Order, plan: PicturePlan) -> str:
    """Write one picture, of all samples or of those until Ctrl-C; return what was written, in words."""
    renderer = renderer_of(plan)

    def show() -> None:
        write_picture(order.output, finish(renderer, plan).to_bytes(order.transparent), is_final=False)

    early = show if order.file == ".png" else None  # whoever reads numbers wants those of all samples
    is_whole = add_samples(renderer, order.output, order.resume, early)
    with without_interrupts():
        if renderer.has_picture:  # else an older picture of this name is better
            finish(renderer, plan).save(order.output, order.transparent)
        rows = f"{renderer.n_rows} of {renderer.height} rows of pixels"
        done = f"{renderer.done} of {renderer.samples} samples a pixel" if renderer.done else rows
        keep_state(renderer, order.output, is_whole, order.resume, done)
    if not plan.is_suitable:
        hint_at_radius(plan.tree, *plan.camera.rays(*small(plan.width, plan.height)), plan.radius)
    return f"{order.output}: {plan.width} × {plan.height} pixels, {focus(plan)}{thickness(plan)}"


def focus(plan: PicturePlan) -> str:
    """Return where the picture is in focus, in words; empty without a lens."""
    return f"in focus at a distance of {plan.camera.focus:g}, " if plan.camera.lens_radius else ""


def thickness(plan: PicturePlan) -> str:
    """Return what was drawn, and how thick, in words."""
    geometry = plan.tree.geometry
    is_thick = "radius" in geometry.sample_names
    suits = ", which suits them; --radius sets another" if plan.is_suitable else ""
    return f"{geometry.count_text()}, radius {plan.radius:g}{', and their own' if is_thick else suits}"
