"""The progressive renderer: samples of all pixels, one after another, each in bands of rows."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ..arrays import AnyArray, FloatArray, count, instance, number
from ..builder import build
from ..camera import Camera
from ..errors import InputError
from ..geometry.any_geometry import AnyGeometry
from ..progress import ProgressOption, check_progress, reporting
from ..tree import Tree
from .color.palette import GOLDEN, check_map
from .default_view import complete_size, default_camera, default_size
from .looks import Backdrop, Look, check_name, look_for, make_look
from .looks.solid import Solid
from .looks.traced_hair import TracedHair
from .measures import MEASURES, Measure, MeasureRenderer
from .pictures.options import NUMBERS, OWN_FLAT, OWN_LIT, PictureRequest, check_options
from .pictures.picture import Picture
from .progressive import Progressive
from .sampling.sampler import Sampler
from .sampling.sobol import hashed, points_in_pixels
from .shading.aovs import find_aovs
from .shading.depth import SIZE, check_radius, check_size
from .shading.fragments import Cones, Fragments, Surfaces
from .shading.ground import Ground
from .shading.lighting import Rig
from .shading.shading_context import ShadingContext
from .suitable_radius import suitable_radius

#: The most samples of a pixel.
MAX_SAMPLES = 1 << 16
#: The samples of a pixel if lines are thinner than one, and if not; and those of a camera with a lens.
THIN_SAMPLES, SAMPLES, LENS_SAMPLES = 4, 16, 64
#: The number of samples from which path tracing takes plain rays: cones take three times as long, and many rays cover
#: pixels as well.
MANY_SAMPLES = 32


class Renderer(Progressive):
    """Renders a picture sample by sample; `picture` returns what is there at any time.

    It can be interrupted at any point, saved, and resumed by another renderer with the same settings. The picture is
    then the same, bit for bit, as without the interruption.

    Parameters
    ----------
    tree : Tree
    camera : Camera
    width, height : int
    radius : float
        Added to the radius of the lines.
    look : Look
    rig : Rig, optional
        The lights; by default those of the look.
    samples : int, optional
        How many samples of a pixel are averaged.

    Examples
    --------
    >>> import fastlines as fl
    >>> from fastlines.rendering.looks import make_look
    >>> scene = fl.scenes.make("spaghetti", 100)
    >>> look = make_look("fibre", scene.lines)
    >>> renderer = Renderer(fl.build(scene.lines), scene.camera, 32, 32, 0.01, look, samples=2)
    >>> [renderer.picture().samples for _ in renderer.passes()]
    [1, 2]
    """

    def __init__(
        self,
        tree: Tree,
        camera: Camera,
        width: int,
        height: int,
        radius: float,
        look: Look,
        rig: Rig | None = None,
        samples: int | None = None,
    ) -> None:
        check_size(width, height)
        check_samples(samples)
        self.look = look
        context = ShadingContext.of(tree, camera, height, radius, rig or look.rig)
        samples = samples or (LENS_SAMPLES if camera.lens_radius else THIN_SAMPLES if context.thin else SAMPLES)
        super().__init__(context, width, height, samples, {"light": (3,), "alpha": (), "shadow": ()})
        opacity = (radius + tree.geometry.max_radius) / max(context.pixel, 1e-30)
        traces_many = isinstance(look, TracedHair) and samples >= MANY_SAMPLES
        thin = context.thin and not traces_many
        self._finder = Cones(tree, radius, camera.spread(height), opacity) if thin else Surfaces(tree, radius)
        self._ground = Ground(context) if look.has_ground and len(tree.geometry) else None

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
            dark = self._ground.darkness(origins, directions, Sampler(index, hashed(seeds, 3)))
            found["shadow"] = dark * (1 - fragments.opacity)
        return found

    @property
    def _shader(self) -> Look:
        return self.look

    def _own_settings(self) -> dict[str, Any]:
        return {"look": self.look, "lights": self.context.rig, "kind of rays": type(self._finder).__name__}


def render(
    tree: Any,
    camera: Camera | None = None,
    *,
    width: int | None = None,
    height: int | None = None,
    look: str | Look | Measure | None = None,
    radius: float | None = None,
    samples: int | None = None,
    color: str | None = None,
    color_map: str | None = None,
    background: str | None = None,
    rig: Rig | None = None,
    exposure: float = 0.0,
    quality: str = "normal",
    aovs: bool = False,
    legend: bool = False,
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
    color : str, optional
        Of hair: "blond", "brown" and others, or "#rrggbb". Of fibres and tubes: "direction", "strand", the name of an
        attribute, or "#rrggbb"; "attribute:strand" is an attribute of the name of one of these words.
    color_map : str, optional
        For an attribute: "viridis", "magma", "inferno", "coolwarm" or "gray".
    background : str, optional
        One colour, or those at the top and at the bottom: "#fff" or "#fff:#ccc".
    rig : Rig, optional
        The lights.
    exposure : float
        Multiply the light by 2 to this power.
    quality : {"normal", "high"}
        With "high", light in hair is scattered as often as it takes, by path tracing; that takes many samples.
    aovs : bool
        Find depths, positions, normals, tangents and ids too: `Picture.aovs`. They are those of a pinhole.
    legend : bool
        Draw what the colours mean: `Picture.with_legend`.
    progress : bool or callable

    Returns
    -------
    Picture

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
    check_size(SIZE if width is None else width, SIZE if height is None else height)
    check_samples(samples)
    check_exposure(exposure)
    check_progress(progress)
    if color_map is not None:
        check_map(color_map)
    if camera is not None:
        instance("camera", camera, Camera, "a Camera")
    if rig is not None:
        instance("rig", rig, Rig, "a Rig, such as STUDIO")
    backdrop = None if background is None else Backdrop.of(background)
    name = look if isinstance(look, str) else None
    if name is not None:
        check_name(name)
    made = MEASURES.get(look) or look if isinstance(look, str) else look
    if not (made is None or isinstance(made, str | Measure) or hasattr(made, "shade")):
        raise InputError(f"look={look!r}; expected the name of a look, or an object with the members of Look")
    given = {"color": color, "color_map": color_map, "rig": rig, "exposure": exposure, "quality": quality}
    given |= {"legend": legend, "lens_radius": camera.lens_radius if camera is not None else None}
    check_options(given, request_of(name, made))
    if not isinstance(tree, Tree):
        tree = build(tree)
    suitable = (SIZE, SIZE) if camera is not None else default_size(tree.geometry, SIZE)
    width, height = complete_size(width, height, suitable)
    check_size(width, height)
    if camera is None:
        camera = default_camera(tree.geometry, aspect=width / height)
    if radius is None and tree.geometry.needs_radius:
        radius = suitable_radius(tree, camera) if len(tree.geometry) else 0.0
    radius = check_radius(tree, radius)
    if made is None or isinstance(made, str):
        name = made or look_for(tree.geometry)
        check_options(given, PictureRequest(look=name))
        made = make_look(name, tree.geometry, color, color_map, quality)
    check_options(given, request_of(name, made, tree.geometry))
    renderer = renderer_of(tree, camera, width, height, radius, made, backdrop, rig, samples)
    with reporting(progress, "render") as callback:
        for _ in renderer.passes(callback):
            pass
    return finish(renderer, backdrop, exposure, aovs, legend)


def request_of(
    name: str | None, made: str | Look | Measure | None, geometry: AnyGeometry | None = None
) -> PictureRequest:
    """Return what is known of a picture.

    Parameters
    ----------
    name : str or None
        The name of its look, if it has one.
    made : str, Look, Measure or None
        The look, made or not.
    geometry : Lines or another container, optional
        With it, the colours are known too.
    """
    if isinstance(made, Measure):
        return PictureRequest(look=name or NUMBERS[0], color="number")
    if made is None or isinstance(made, str):
        return PictureRequest(look=made)
    look = name or (OWN_LIT if made.is_light else OWN_FLAT)
    if geometry is None:
        return PictureRequest(look=look)
    return PictureRequest(look=look, color=made.color.depends_on(geometry) if isinstance(made, Solid) else "other")


def renderer_of(
    tree: Tree,
    camera: Camera,
    width: int,
    height: int,
    radius: float,
    look: Look | Measure,
    backdrop: Backdrop | None = None,
    rig: Rig | None = None,
    samples: int | None = None,
) -> Renderer | MeasureRenderer:
    """Return the renderer of a look or of a measure; lines that fade do so into the backdrop."""
    if isinstance(look, Measure):
        return MeasureRenderer(tree, camera, width, height, radius, look, samples or 1)
    if backdrop is not None and isinstance(look, Solid):
        look = replace(look, backdrop=backdrop)
    return Renderer(tree, camera, width, height, radius, look, rig, samples)


def check_samples(samples: int | None) -> None:
    """Refuse a number of samples that is not whole, or out of range."""
    if samples is not None:
        count("samples", samples, 1, MAX_SAMPLES)


def check_exposure(exposure: float) -> None:
    """Refuse an exposure that would make the light overflow or vanish."""
    number("exposure", exposure, "a number from -60 to 60", -60.0, 60.0)


def finish(
    renderer: Progressive, backdrop: Backdrop | None, exposure: float = 0.0, aovs: bool = False, legend: bool = False
) -> Picture:
    """Return the picture of all samples so far, and what does not depend on them; the options are those of `render`."""
    picture, size = renderer.picture(), (renderer.width, renderer.height)
    if backdrop is not None:
        picture = replace(picture, backdrop=backdrop.light(*size))
    found = find_aovs(renderer.context, *size) if aovs else {}
    return replace(picture, exposure=exposure, aovs=found | picture.aovs, shows_legend=legend)


def _summed(fragments: Fragments, light: FloatArray, n_rays: int) -> FloatArray:
    """Sum the light of the fragments of each ray."""
    weighted = light * fragments.weight[:, None]
    return np.stack([np.bincount(fragments.ray, weighted[:, axis], minlength=n_rays) for axis in range(3)], axis=1)
