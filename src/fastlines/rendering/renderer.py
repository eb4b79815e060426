"""The progressive renderer: samples of all pixels, one after another, each in bands of rows."""

from __future__ import annotations

import sys
from dataclasses import fields, replace
from typing import Any

import numpy as np

from ..arrays import AnyArray, FloatArray
from ..camera import Camera
from ..errors import InputError
from ..geometry.offsets import NO_OFFSET
from ..progress import ProgressOption, check_progress, reporting
from .color.legend import ColorBar
from .color.palette import GOLDEN
from .looks import ColorOption, Look, MaterialOption
from .looks.solid import Solid
from .looks.traced_hair import TracedHair
from .measure_renderer import MeasureRenderer
from .measures import Measure
from .pictures.notebook import cell_of_notebook
from .pictures.picture import Picture
from .plan import PictureOptions, PicturePlan, plan_picture
from .progressive import Progressive
from .refinement import Pace, refined
from .sampling.sampler import Sampler
from .sampling.sobol import hashed, points_in_pixels
from .shading.aovs import find_aovs
from .shading.fragments import Cones, Fragments, Surfaces
from .shading.ground import Ground
from .shading.lighting import Rig
from .shading.shading_context import ShadingContext

#: The samples of a pixel if lines are thinner than one, and if not; and those of a camera with a lens.
THIN_SAMPLES, SAMPLES, LENS_SAMPLES = 4, 16, 64
#: The number of samples from which path tracing takes plain rays: cones take three times as long, and many rays cover
#: pixels as well.
MANY_SAMPLES = 32
#: The least time between two pictures that a cell of a notebook shows.
CELL_SECONDS = 1.0


class Renderer(Progressive):
    """Renders a picture sample by sample; `picture` returns what is there at any time.

    It can be interrupted at any point, saved, and resumed by another renderer with the same settings. The picture is
    then the same, bit for bit, as without the interruption.

    Parameters
    ----------
    plan : PicturePlan

    Examples
    --------
    >>> import fastlines as fl
    >>> from fastlines.rendering import PictureOptions, plan_picture
    >>> lines = fl.scenes.make("spaghetti", 100).lines
    >>> renderer = Renderer(plan_picture(lines, PictureOptions(width=32, height=32, samples=2)))
    >>> [renderer.picture().samples for _ in renderer.passes()]
    [1, 2]
    """

    def __init__(self, plan: PicturePlan) -> None:
        tree, camera, radius, options = plan.tree, plan.camera, plan.radius, plan.options
        if isinstance(plan.look, Measure):
            raise InputError(f"look={plan.look!r}; expected a Look")
        look = self.look = plan.look
        context = ShadingContext.of(tree, camera, plan.height, radius, options.lights or look.rig)
        samples = options.samples or (LENS_SAMPLES if camera.lens_radius else THIN_SAMPLES if context.thin else SAMPLES)
        super().__init__(context, plan.width, plan.height, samples, {"light": (3,), "alpha": (), "shadow": ()})
        opacity = (radius + tree.geometry.max_radius) / max(context.pixel, 1e-300)
        traces_many = isinstance(look, TracedHair) and samples >= MANY_SAMPLES
        thin = context.thin and not traces_many
        self._finder = Cones(tree, radius, camera.spread(plan.height), opacity) if thin else Surfaces(tree, radius)
        has_ground = look.has_ground if options.ground is None else options.ground
        self._ground = Ground(context) if has_ground and len(tree.geometry) else None

    def picture(self) -> Picture:
        """Return the picture of all samples so far."""
        return Picture(
            self._means("light").astype(np.float32),
            self._means("alpha").astype(np.float32),
            self.look.backdrop.light(self.width, self.height),
            self.done,
            shadow=self._means("shadow").astype(np.float32),
            is_light=self.look.is_light,
            legend=self.look.color.legend(self.context) if isinstance(self.look, Solid) else None,
            camera=self.context.camera,
            radius=self.context.radius,
            look=self.look,
            rig=self.context.rig if self.look.is_light else None,
        )

    def _sample(self, index: int, pixels: AnyArray) -> dict[str, AnyArray]:
        """Return the light, the alpha and the shadow of one sample of some pixels."""
        seeds = hashed(pixels.astype(np.uint32))
        x, y = points_in_pixels(index, pixels, self.width)
        origins, directions, _ = self.context.camera.ray(x, y, self.width, self.height)
        if self.context.camera.lens_radius:
            on_lens = Sampler(index, hashed(seeds, 4)).next_2d()
            origins, directions = self.context.camera.through_lens(directions, *on_lens)
        offsets = (seeds * 2.0**-32 + index * GOLDEN) % 1
        fragments = self._finder.find(origins, directions, offsets)
        found: dict[str, AnyArray] = {}
        if len(fragments):
            shaded = self.look.shade(fragments, self.context, Sampler.of_fragments(index, seeds, fragments.ray))
            found |= {"light": _summed(fragments, shaded, len(pixels)), "alpha": fragments.opacity}
        if self._ground is not None:
            numbers = Sampler(index, hashed(seeds, 3))
            found["shadow"] = self._ground.darkness(origins, directions, fragments.opacity, numbers)
        return found

    @property
    def _shader(self) -> Look:
        return self.look

    def _own_settings(self) -> dict[str, Any]:
        return {
            "look": self.look,
            "lights": self.context.rig,
            "kind of rays": type(self._finder).__name__,
            "ground": self._ground is not None,
        }


def render(
    tree: Any,
    camera: Camera | None = None,
    *,
    width: int | None = None,
    height: int | None = None,
    look: str | Look | Measure | None = None,
    radius: float | None = None,
    samples: int | None = None,
    color: ColorOption | None = None,
    color_map: str | None = None,
    material: MaterialOption | None = None,
    variation: float | None = None,
    background: str | None = None,
    ground: bool | None = None,
    rig: Rig | str | None = None,
    exposure: float = 0.0,
    quality: str = "normal",
    aovs: bool = False,
    legend: bool | str = False,
    progress: ProgressOption = False,
) -> Picture:
    """Render a picture of lines.

    Parameters
    ----------
    tree : Tree, or what `build` takes
    camera : Camera, optional
        By default one that frames the geometry. If it has a lens, the picture has a depth of field.
    width, height : int, optional
        By default about 1024² pixels. The aspect ratio suits the lines, also if one of both is given; with a camera,
        the picture is square.
    look : str, Look or Measure, optional
        One of `LOOKS`; by default the one that suits the geometry. Or one of `MEASURES`, a number of each ray.
    radius : float, optional
        Half the thickness of the lines, which is added to their own. By default one that suits if they have none.
    samples : int, optional
        How many samples of a pixel are averaged. By default there are 16, or 4 if lines are thinner than a pixel, or 64
        if the camera has a lens; of a measure there is one, through the pixel's centre.
    color : str or three numbers, optional
        Of hair: "blond", "brown" and others, or "#rrggbb". Of fibres and tubes: "direction", "strand", the name of an
        attribute, or "#rrggbb"; "attribute:strand" is an attribute of the name of one of these words. Three numbers
        from 0 to 1 are red, green and blue as a screen shows them: (1, 0.5, 0) is "#ff8000".
    color_map : str, optional
        For an attribute: "viridis", "magma", "inferno", "coolwarm" or "gray".
    material : HairMaterial, SurfaceMaterial or str, optional
        What lines are made of. Hair takes a `HairMaterial`, in place of a colour. Fibres and tubes take a
        `SurfaceMaterial`, or the name of one: "matt", "satin", which is the default, "polished" or "metal".
    variation : float, optional
        How much brighter or darker than the mean a strand is, from 0 to 1; by default 0.25 in hair, and else 0.
    background : str, optional
        One colour, or those at the top and at the bottom: "#fff" or "#fff:#ccc".
    ground : bool, optional
        Whether the lines cast a shadow on the ground below them; by default tubes do.
    rig : Rig or str, optional
        The lights, or their name in `RIGS`; by default those of the look.
    exposure : float
        Multiply the light by 2 to this power.
    quality : {"normal", "high"}
        With "high", light in hair is scattered as often as it takes, by path tracing; that takes many samples.
    aovs : bool
        Find depths, positions, normals, tangents and ids too: `Picture.aovs`. They are those of a pinhole.
    legend : bool or str
        Draw what the colours mean: `Picture.with_legend`. A text is the title of a colour bar, such as "speed in m/s".
    progress : bool or callable

    Returns
    -------
    Picture
        It keeps its camera, radius, look and rig.

    Notes
    -----
    How long a picture takes is printed to stderr before it starts, if that is more than a minute. A cell of a notebook
    shows a picture that takes more than two seconds while it is made. Interrupting the kernel then stops the samples,
    and the picture is that of those that are done.

    Raises
    ------
    InputError
        If an option cannot be used, or would change nothing in this look.

    Examples
    --------
    >>> import fastlines as fl
    >>> picture = fl.render(fl.scenes.make("spaghetti", 100).lines, width=32, height=32)
    >>> picture
    <Picture: 32 × 32 pixels, 4 samples>
    """
    given = locals()
    check_progress(progress)
    names = [field.name for field in fields(PictureOptions) if field.name in given]
    plan = plan_picture(tree, PictureOptions(**{name: given[name] for name in names}))
    renderer, cell = renderer_of(plan), cell_of_notebook()
    pace = Pace(CELL_SECONDS)
    try:
        with reporting(progress, "render") as callback:
            for _ in refined(renderer, callback, _say):
                if cell is not None:
                    pace.show(renderer.seconds_left, lambda: cell.show(finish(renderer, plan, with_aovs=False)))
    except KeyboardInterrupt:
        if not pace.n_shown:
            raise
    picture = finish(renderer, plan)
    if cell is not None and pace.n_shown:
        cell.end(picture)
    return picture


def draw(plan: PicturePlan, progress: ProgressOption = False) -> Picture:
    """Make the picture of a plan."""
    renderer = renderer_of(plan)
    with reporting(progress, "render") as callback:
        for _ in renderer.passes(callback):
            pass
    return finish(renderer, plan)


def _say(sentence: str) -> None:
    print(f"fastlines: {sentence}", file=sys.stderr, flush=True)


def renderer_of(plan: PicturePlan) -> Renderer | MeasureRenderer:
    """Return the renderer of a look or of a measure."""
    return MeasureRenderer(plan) if isinstance(plan.look, Measure) else Renderer(plan)


def finish(renderer: Progressive, plan: PicturePlan, *, with_aovs: bool = True) -> Picture:
    """Return the picture of all samples so far, and what does not depend on them."""
    picture, options, size = renderer.picture(), plan.options, (plan.width, plan.height)
    if options.backdrop is not None:
        picture = replace(picture, backdrop=options.backdrop.light(*size))
    found = find_aovs(renderer.context, *size) if options.aovs and with_aovs else {}
    if plan.offset != NO_OFFSET:
        picture = replace(picture, camera=plan.given_camera)
        found |= {name: values + np.array(plan.offset) for name, values in found.items() if name == "position"}
    if isinstance(options.legend, str) and isinstance(picture.legend, ColorBar):
        picture = replace(picture, legend=replace(picture.legend, title=options.legend))
    return replace(picture, exposure=options.exposure, aovs=found | picture.aovs, shows_legend=plan.legend)


def _summed(fragments: Fragments, light: FloatArray, n_rays: int) -> FloatArray:
    """Sum the light of the fragments of each ray."""
    weighted = light * fragments.weight[:, None]
    return np.stack([np.bincount(fragments.ray, weighted[:, axis], minlength=n_rays) for axis in range(3)], axis=1)
