"""The progressive renderer: samples of all pixels, one after another, each in bands of rows."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from ..arrays import AnyArray, FloatArray, count, instance, number
from ..builder import build
from ..camera import Camera
from ..errors import InputError
from ..geometry import count_text, largest_radius, needs_radius
from ..progress import ProgressOption, reporting
from ..tree import Tree
from .aovs import find_aovs
from .depth import MAX_RAYS, SIZE, bands, check_radius, check_size
from .fragments import Cones, Fragments, Surfaces
from .ground import Ground
from .lighting import STUDIO, Rig
from .looks import Backdrop, Look, make_look
from .looks.solid import Solid
from .looks.traced_hair import TracedHair
from .measures import MEASURES, Measure, measured_picture
from .palette import GOLDEN
from .picture import Picture
from .radius import suitable_radius
from .sampler import Sampler
from .sampling import hashed, points_in_pixels
from .stage import Stage
from .state import describe, digest, read_state, write_state
from .view import default_camera, default_size

#: The most samples of a pixel.
MAX_SAMPLES = 1 << 16
#: The samples of a pixel if lines are thinner than one, and if not.
THIN_SAMPLES, SAMPLES = 4, 16
#: From so many samples on, path tracing takes plain rays: cones take three times as long, and many rays cover as well.
MANY_SAMPLES = 32


class Renderer:
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
        self.width, self.height, self.look = width, height, look
        self.stage = Stage.of(tree, camera, height, radius, rig or look.rig)
        self.samples = samples or (THIN_SAMPLES if self.stage.thin else SAMPLES)
        opacity = (radius + largest_radius(tree.geometry)) / max(self.stage.pixel, 1e-30)
        traces_many = isinstance(look, TracedHair) and self.samples >= MANY_SAMPLES
        thin = self.stage.thin and not traces_many
        self._finder = Cones(tree, radius, camera.spread(height), opacity) if thin else Surfaces(tree, radius)
        self._light = np.zeros((height * width, 3), np.float64)
        self._alpha = np.zeros(height * width, np.float64)
        self._shadow = np.zeros(height * width, np.float64)
        self._counts = np.zeros(height, np.int64)
        #: The pixels and rows of a band, and their new sums, while they are being stored.
        self._stored: tuple[slice, slice, AnyArray, AnyArray, AnyArray, int] | None = None
        self._ground = Ground(self.stage) if look.has_ground and len(tree.geometry) else None

    def passes(self, progress: Callable[[float], object] | None = None) -> Iterator[int]:
        """Add one sample to each pixel at a time, and yield how many there are."""
        for index in range(int(self._counts.min()), self.samples):
            for rows in bands(self.width, self.height, MAX_RAYS):
                if self._counts[rows.start] <= index:
                    self._add(index, rows)
                if progress is not None:
                    progress((index + rows.stop / self.height) / self.samples)
            yield index + 1

    def picture(self) -> Picture:
        """Return the picture of all samples so far."""
        self._store()
        shape = self.height, self.width
        counts = np.maximum(self._counts, 1)[:, None]
        light = self._light.reshape(*shape, 3) / counts[..., None]
        alpha = self._alpha.reshape(shape) / counts
        backdrop = self.look.backdrop.light(self.width, self.height)
        samples = int(self._counts.min())
        legend = self.look.color.legend(self.stage) if isinstance(self.look, Solid) else None
        return Picture(
            light.astype(np.float32),
            alpha.astype(np.float32),
            backdrop,
            samples,
            shadow=(self._shadow.reshape(shape) / counts).astype(np.float32),
            is_light=self.look.is_light,
            legend=legend,
        )

    def _add(self, index: int, rows: slice) -> None:
        """Add a sample to each pixel of some rows."""
        pixels = np.arange(rows.start * self.width, rows.stop * self.width)
        seeds = hashed(pixels.astype(np.uint32))
        x, y = points_in_pixels(index, pixels, self.width)
        origins, directions, _ = self.stage.camera.ray(x, y, self.width, self.height)
        offsets = (seeds * 2.0**-32 + index * GOLDEN) % 1
        fragments = self._finder.find(origins, directions, offsets)
        own = slice(pixels[0], pixels[-1] + 1)
        light: AnyArray = self._light[own]
        alpha: AnyArray = self._alpha[own]
        shadow: AnyArray = self._shadow[own]
        if len(fragments):
            shaded = self.look.shade(fragments, self.stage, Sampler.of_fragments(index, seeds, fragments.ray))
            light, alpha = light + _summed(fragments, shaded, len(pixels)), alpha + fragments.opacity
        if self._ground is not None:
            dark = self._ground.darkness(origins, directions, Sampler(index, hashed(seeds, 3)))
            shadow = shadow + dark * (1 - fragments.opacity)
        self._stored = own, rows, light, alpha, shadow, index + 1
        self._store()

    def _store(self) -> None:
        """Store the sums of a band; where that was interrupted, it is done anew."""
        if self._stored is not None:
            own, rows, light, alpha, shadow, n_samples = self._stored
            self._light[own], self._alpha[own], self._shadow[own] = light, alpha, shadow
            self._counts[rows] = n_samples
            self._stored = None

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the samples so far to a .npz file, from which `resume` goes on; it appears whole or not at all."""
        self._store()
        write_state(path, self._settings, self._state)

    def resume(self, path: str | os.PathLike[str]) -> int:
        """Take over the samples that `save` has written; return how many of them each pixel has.

        The total number of samples may be another one, unless other rays are traced for it.

        Raises
        ------
        InputError
            If the file is no state of a picture, or of one with other settings or lines.
        OSError
            If it cannot be read.
        """
        found = read_state(path, self._settings, self._state)
        self._light, self._alpha, self._shadow = found["light"], found["alpha"], found["shadow"]
        self._counts = found["counts"]
        return int(self._counts.min())

    @property
    def _state(self) -> dict[str, AnyArray]:
        return {"light": self._light, "alpha": self._alpha, "shadow": self._shadow, "counts": self._counts}

    @cached_property
    def _settings(self) -> dict[str, str]:
        """All that the samples depend on, but for the version of fastlines."""
        stage = self.stage
        settings = {
            "size": f"{self.width} × {self.height}",
            "radius": stage.radius,
            "camera": stage.camera,
            "look": self.look,
            "lights": stage.rig,
            "lines": count_text(stage.tree.geometry),
            "checksum": digest(stage.tree.geometry),
            "rays at a time": MAX_RAYS,
            "kind of rays": type(self._finder).__name__,
        }
        return {name: value if isinstance(value, str) else describe(value) for name, value in settings.items()}


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
    color_map: str = "viridis",
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
        By default one that frames the geometry.
    width, height : int, optional
        By default 1024, the longer side of a format that suits the lines; 1024 × 1024 if you give a camera.
    look : str, Look or Measure, optional
        One of `LOOKS`; by default the one that suits the geometry. Or one of `MEASURES`, a number of each ray.
    radius : float, optional
        Half the thickness of the lines, which is added to their own. By default one that suits if they have none.
    samples : int, optional
        How many samples of a pixel are averaged. By default there are 16, or 4 if lines are thinner than a pixel; of a
        measure there is one, through the pixel's centre.
    color : str, optional
        Of hair: "blond", "brown" and others, or "#rrggbb". Of fibres and tubes: "direction", "strand", the name of an
        attribute, or "#rrggbb".
    color_map : str
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
        Find depths, positions, normals, tangents and ids too: `Picture.aovs`.
    legend : bool
        Draw what the colours mean: `Picture.with_legend`.
    progress : bool or callable

    Returns
    -------
    Picture

    Examples
    --------
    >>> import fastlines as fl
    >>> picture = fl.render(fl.scenes.make("spaghetti", 100).lines, width=32, height=32)
    >>> picture
    <Picture: 32 × 32 pixels, 4 samples>
    """
    chooses_size = width is None and height is None and camera is None
    width, height = SIZE if width is None else width, SIZE if height is None else height
    check_size(width, height)
    check_samples(samples)
    check_exposure(exposure)
    if camera is not None:
        instance("camera", camera, Camera, "a Camera")
    if rig is not None:
        instance("rig", rig, Rig, "a Rig, such as STUDIO")
    if background is not None:
        Backdrop.of(background)
    if not isinstance(tree, Tree):
        tree = build(tree)
    if chooses_size:
        width, height = default_size(tree.geometry, SIZE)
    if camera is None:
        camera = default_camera(tree.geometry, aspect=width / height)
    if radius is None and needs_radius(tree.geometry):
        radius = suitable_radius(tree, camera) if len(tree.geometry) else 0.0
    radius = check_radius(tree, radius)
    look = MEASURES.get(look, look) if isinstance(look, str) else look
    if isinstance(look, Measure):
        if color is not None or rig is not None or quality != "normal":
            text = "shows a number by its own colours; leave out color=, rig= and quality="
            raise InputError(f"the look {look.name!r} {text}")
        picture = measured_picture(tree, camera, width, height, radius, look, samples or 1, progress)
        stage = Stage.of(tree, camera, height, radius, STUDIO)
    else:
        if look is None or isinstance(look, str):
            look = make_look(look, tree.geometry, color, color_map, quality)
        elif not hasattr(look, "shade"):
            raise InputError(f"look={look!r}; expected the name of a look, or an object with the members of Look")
        elif quality != "normal":
            raise InputError(f"quality={quality!r} is for looks by name; a look that you make has its own")
        look = with_backdrop(look, background)
        renderer = Renderer(tree, camera, width, height, radius, look, rig, samples)
        with reporting(progress, "render") as callback:
            for _ in renderer.passes(callback):
                pass
        picture, stage = renderer.picture(), renderer.stage
    return finish(picture, stage, background, exposure, aovs, legend)


def check_samples(samples: int | None) -> None:
    """Refuse a number of samples that is not whole, or out of range."""
    if samples is not None:
        count("samples", samples, 1, MAX_SAMPLES)


def check_exposure(exposure: float) -> None:
    """Refuse an exposure that would make the light overflow or vanish."""
    number("exposure", exposure, "a number from -60 to 60", -60.0, 60.0)


def with_backdrop(look: Look, background: str | None) -> Look:
    """Return the look before another background, into which it fades."""
    return replace(look, backdrop=Backdrop.of(background)) if background and isinstance(look, Solid) else look


def finish(
    picture: Picture, stage: Stage, background: str | None, exposure: float, aovs: bool, legend: bool
) -> Picture:
    """Give a picture what does not depend on its samples; the options are those of `render`."""
    height, width = picture.alpha.shape
    if background is not None:
        picture = replace(picture, backdrop=Backdrop.of(background).light(width, height))
    found = find_aovs(stage, width, height) if aovs else {}
    return replace(picture, exposure=exposure, aovs=found | picture.aovs, shows_legend=legend)


def _summed(fragments: Fragments, light: FloatArray, n_rays: int) -> FloatArray:
    """Sum the light of the fragments of each ray."""
    weighted = light * fragments.weight[:, None]
    return np.stack([np.bincount(fragments.ray, weighted[:, axis], minlength=n_rays) for axis in range(3)], axis=1)
