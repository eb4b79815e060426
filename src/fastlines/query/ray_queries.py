"""Queries about rays: the methods of what rays can be traced through."""

from __future__ import annotations

from typing import Unpack

import numpy as np
import numpy.typing as npt

from ..arrays import IntArray
from ..errors import InputError
from .gather import GatherArguments, Gathered
from .hit_runs import HitRunQueries
from .hits import AllHits, FirstHits
from .ray_arguments import RayArguments, RayOptions, shows_ray_options


class RayQueries(HitRunQueries):
    """The queries of a tree about rays."""

    @shows_ray_options
    def first_hit(
        self,
        origins: npt.ArrayLike,
        directions: npt.ArrayLike,
        radius: npt.ArrayLike | None = None,
        *,
        at: str = "closest",
        kernel: str = "auto",
        **options: Unpack[RayOptions],
    ) -> FirstHits:
        """Find the nearest hit of each ray o + t·d.

        A ray hits a segment if it comes within the radius of it, for t in [t_min, t_max]: the radius of the query, plus
        that of the lines if they have one. Of hits with equal t the lowest id comes first. All queries take these
        parameters.

        Parameters
        ----------
        origins, directions : (…, 3) array
            Converted to float32. t is in units of the direction's length, which need not be 1.
        radius : number or (…) array, optional
            The largest distance of a hit, in units of the coordinates: one for all rays or one for each. The radius of
            the lines is added to it. The default is 0 if they have one or there is a spread, else it is required.
        spread : number or (…) array
            By how much the radius grows for each unit of length along the ray, from its origin on: one for all rays or
            one for each. `Camera.spread` is that of half a pixel. Needs ``at="closest"``.
        ignore, ignore_strands : int array or hits, optional
            Primitives and strands to leave out, as if they were not there: (k,) for all rays, or (…, m) with m numbers
            for each ray, of which -1 is none. First hits stand for what each of them has hit. Both broadcast to the
            shape of the rays.
            In a `Geometry`, primitives have their ``hits.prim_number``, and strands count on from part to part.
        parts : int or sequence of ints, optional
            The parts of a `Geometry` that rays see, as if it had no others; by default all. Hits name parts and
            primitives as without it.
        t_min, t_max : number or (…) array
            Bounds on t: one for all rays or one for each.
        at : {"closest", "surface", "entry"}
            Take t at the closest approach (the thesis), or where the ray enters the capsule or round cone of this
            radius around the segment (t_min if it starts inside); ``t_out`` is then where it leaves. With ``"entry"``,
            only rays that enter hit, at t > t_min: what a ray starts in is left out, and so is a surface that it starts
            on. Triangles have no inside: each crossing is an entry.
        invalid : {"error", "skip"}
            Refuse invalid rays (NaN, a direction of length zero, …), or let them miss and list them in ``skipped``.
        progress : bool or callable
            Show a bar, or call back with the fraction that is done.
        kernel : {"auto", "single", "wave", "bundle", "binary"}
            Choose the kernel for each group of rays by their coherence, or force one: one ray at a time, incoherent
            rays together, coherent rays as one beam, or a search of the tree as it was built. The answer is the same.
            Rays with a spread are never bundled.

        Returns
        -------
        FirstHits
            Arrays of the shape of the rays.

        Raises
        ------
        InputError
            If a ray is invalid, and the message lists the rows; if there is no radius; or if there is a spread, and
            `at` is not ``"closest"``.

        Examples
        --------
        >>> import fastlines as fl
        >>> tree = fl.build([[[-1, -1, -1], [1, 1, 1]]])
        >>> tree.first_hit([0, 0, -5], [0, 0, 1], 0.5).t
        array(5., dtype=float32)
        """
        return self._query(kernel, RayArguments(origins, directions, radius, **options)).first_hit(at)

    @shows_ray_options
    def first_surface(
        self,
        origins: npt.ArrayLike,
        directions: npt.ArrayLike,
        radius: npt.ArrayLike | None = None,
        *,
        kernel: str = "auto",
        **options: Unpack[RayOptions],
    ) -> FirstHits:
        """Find the nearest surface of each ray, for pictures; `first_hit` explains the parameters.

        It is ``first_hit(…, at="surface")`` for those who need neither ``distance`` nor ``t_out``. Of a curve, these
        are here those of the piece that the ray hits first, and not of the whole crossing, which takes as long again.

        Examples
        --------
        >>> import fastlines as fl
        >>> arch = fl.Curves.from_bezier([[[0, 0, 0], [0, 0, 4], [3, 0, 4], [3, 0, 0]]], radius=0.05)
        >>> hits = fl.build(arch).first_surface([-5, 0, 1], [1, 0, 0])
        >>> print(hits.t.round(2), hits.prim, hits.u.round(2))
        5.02 0 0.09
        """
        return self._query(kernel, RayArguments(origins, directions, radius, **options)).first_surface()

    @shows_ray_options
    def all_hits(
        self,
        origins: npt.ArrayLike,
        directions: npt.ArrayLike,
        radius: npt.ArrayLike | None = None,
        *,
        at: str = "closest",
        merge: str | None = None,
        kernel: str = "auto",
        **options: Unpack[RayOptions],
    ) -> AllHits:
        """Find every hit of each ray, each once, sorted by t; `first_hit` explains the other parameters.

        Parameters
        ----------
        merge : {None, "strand"}
            Make one hit of those of a strand whose intervals from t to ``t_out`` overlap, so that a strand that the ray
            crosses counts once per crossing; needs ``at="surface"``. See `AllHits.merged_by_strand`.

        Notes
        -----
        A hit takes 20 bytes (24 unless ``at="closest"``), and 20 more during the query; `count_hits` counts them.

        Raises
        ------
        MemoryError
            If the hits do not fit into memory. A sample of the rays often shows this soon after the start.

        Examples
        --------
        >>> import fastlines as fl
        >>> tree = fl.build([[[-1, 0, 0], [1, 0, 0]], [[0, -1, 1], [0, 1, 1]]])
        >>> hits = tree.all_hits([[0, 0, -5], [9, 9, 9]], [0, 0, 1], 0.5)
        >>> print(hits.offsets, hits.prim, hits.t)
        [0 2 2] [0 1] [5. 6.]
        """
        return self._query(kernel, RayArguments(origins, directions, radius, **options)).all_hits(at, merge)

    @shows_ray_options
    def any_hit(
        self,
        origins: npt.ArrayLike,
        directions: npt.ArrayLike,
        radius: npt.ArrayLike | None = None,
        *,
        at: str = "closest",
        kernel: str = "auto",
        **options: Unpack[RayOptions],
    ) -> npt.NDArray[np.bool_]:
        """Return whether each ray hits anything, as bool of the shape of the rays; see `first_hit`.

        Parameters
        ----------
        at : {"closest", "surface", "entry"}
            Which rays hit: with ``"entry"``, those that enter. The others are the same here.

        Examples
        --------
        >>> import fastlines as fl
        >>> fl.build([[[-1, 0, 0], [1, 0, 0]]]).any_hit([[0, 0, -5], [9, 9, 9]], [0, 0, 1], 0.5)
        array([ True, False])
        """
        return self._query(kernel, RayArguments(origins, directions, radius, **options)).any_hit(at)

    @shows_ray_options
    def count_hits(
        self,
        origins: npt.ArrayLike,
        directions: npt.ArrayLike,
        radius: npt.ArrayLike | None = None,
        *,
        at: str = "closest",
        kernel: str = "auto",
        **options: Unpack[RayOptions],
    ) -> IntArray:
        """Count the segments that each ray hits, as int64 of the shape of the rays; see `first_hit`.

        Parameters
        ----------
        at : {"closest", "surface", "entry"}
            As in `any_hit`.

        Examples
        --------
        >>> import fastlines as fl
        >>> tree = fl.build([[[-1, 0, 0], [1, 0, 0]], [[0, -1, 1], [0, 1, 1]]])
        >>> tree.count_hits([[0, 0, -5], [9, 9, 9]], [0, 0, 1], 0.5)
        array([2, 0])
        """
        return self._query(kernel, RayArguments(origins, directions, radius, **options)).count_hits(at)

    @shows_ray_options
    def next_hits(
        self,
        origins: npt.ArrayLike,
        directions: npt.ArrayLike,
        radius: npt.ArrayLike | None = None,
        k: int | None = None,
        *,
        rank: str = "t",
        at: str = "closest",
        kernel: str = "auto",
        **options: Unpack[RayOptions],
    ) -> AllHits:
        """Find the k best hits of each ray, each once, by t or by distance; `first_hit` explains the other parameters.

        Parameters
        ----------
        k : int
        rank : {"t", "distance"}
            Which hits come first, and the order of the answer: those with the least t, or those with the least
            ``distance`` from the ray (of thick lines: of their axes). Ties go by t, then by id.

        Notes
        -----
        For later hits ask for a larger k. With t_min at the last t, the ray would start there and find again segments
        that are still within the radius.

        Examples
        --------
        >>> import fastlines as fl
        >>> tree = fl.build([[[-1, 0.4, 0], [1, 0.4, 0]], [[-1, 0.1, 1], [1, 0.1, 1]]])
        >>> ray = [0, 0, -5], [0, 0, 1], 0.5
        >>> print(tree.next_hits(*ray, k=1).prim, tree.next_hits(*ray, k=1, rank="distance").prim)
        [0] [1]
        """
        if k is None:
            raise InputError("next_hits needs k=, the number of hits of each ray; radius= comes before it")
        return self._query(kernel, RayArguments(origins, directions, radius, **options)).next_hits(k, at, rank)

    @shows_ray_options
    def gather(
        self,
        origins: npt.ArrayLike,
        directions: npt.ArrayLike,
        radius: npt.ArrayLike | None = None,
        values: npt.ArrayLike | None = None,
        *,
        blur: str = "box",
        sigma: npt.ArrayLike = 0.0,
        line_sigma: npt.ArrayLike = 0.0,
        optical_depth: npt.ArrayLike | None = None,
        phase: float | None = None,
        inner: bool = True,
        squares: bool = False,
        kernel: str = "auto",
        **options: Unpack[RayOptions],
    ) -> Gathered:
        """Sum over all hits of each ray, without listing them; `first_hit` explains the other parameters.

        A hit adds ``values[prim] · K / sin θ · exp(-sigma·t·|d|) · exp(-line_sigma·u·length) · p``. K is the blur, θ
        the angle between ray and line, ``t·|d|`` the length along the ray, u·length that along the line, and p the
        phase function. The sum is exact in its order: every tree, kernel and number of threads gives the same bits.

        Parameters
        ----------
        values : (n_prims,) or (n_prims, C) array, optional
            What each primitive adds, in up to 8 channels; finite, converted to float32. The default is 1. Those of a
            `Geometry` follow its parts, as ``hits.prim_number`` counts.
        blur : {"box", "epanechnikov", "none"}
            K, with the reach R of the ray at the hit: 1/(2R), or 3/(4R)·(1 - (distance/R)²). R is the radius of the
            query, plus that of the line, plus the spread times the depth. With ``"none"``, K / sin θ is 1.
        sigma, line_sigma : number or (C,) array
            Extinction per unit of length along the ray from its origin, and along the line from its first point.
        optical_depth : (…, K) or (…, K, C) array, optional
            In place of `sigma`, for media that are not the same everywhere: the optical depth of each ray at K equal
            steps from t_min to t_max, linear in between.
        phase : number, optional
            Weigh with the Henyey-Greenstein phase function of this mean cosine g, of light that flies from the first
            point of a line to its last and leaves towards the origin of the ray. By default p is 1.
        inner : bool
            Leave out hits whose t is t_min or t_max, or that are at an end of their line: so what a line adds does not
            depend on how it is cut into pieces.
        squares : bool
            Return the sums of squares, too.

        Returns
        -------
        Gathered
            ``sum``, ``squares`` and ``count``, in the shape of the rays; sums have the channels as last dimension.

        Notes
        -----
        With a blur, sums leave out hits on lines that are parallel to the ray, to within 2⁻²⁰, and those whose reach
        times sin θ is below 2⁻¹²⁶, the least normal float32. Curves, primitives of your own, parts of a `Geometry`,
        forests, GPUs and `ignore` list hits, in parts, which the CPU sums.

        Raises
        ------
        InputError
            As `first_hit`; if values, extinctions or depths cannot be used; if a blur has a radius of 0; or if rays are
            in the memory of a GPU.

        Examples
        --------
        >>> import fastlines as fl
        >>> tree = fl.build([[[-1, 0, 0], [1, 0, 0]], [[0, -1, 1], [0, 1, 1]]])
        >>> rays = [[0, 0, -5], [0.5, 0, -5]], [0, 0, 1]
        >>> gathered = tree.gather(*rays, 0.25)
        >>> print(gathered.sum, gathered.count)
        [4. 2.] [2 1]
        >>> print(tree.gather(*rays, 0.25, values=[1, 3], blur="none").sum)
        [4. 1.]
        """
        what = GatherArguments(values, blur, sigma, line_sigma, optical_depth, phase, inner, squares)
        return self._query(kernel, RayArguments(origins, directions, radius, **options)).gather(what)
