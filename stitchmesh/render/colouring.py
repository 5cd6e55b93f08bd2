# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Colours of yarns: by yarn, row, stitch, strain, stretch, contact force or distance, or one colour.

The colours of rows and of stitches can be blended with the colours of the yarns (Leaf et al. 2018, section 7.2).
"""

from __future__ import annotations

import difflib
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.hand_knitting.words import stitch_name
from stitchmesh.mesh import FloatArray, Mesh, StitchMesh
from stitchmesh.mesh.palette import colours_of, linear_colour, parse_colour, srgb_colour
from stitchmesh.render.colour_scale import ColourScale, diverging_scale, sequential_scale
from stitchmesh.render.lettering import Colour
from stitchmesh.render.palette import stitch_colour
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.colours import row_colours
from stitchmesh.yarn.strand_distance import strand_distance

if TYPE_CHECKING:
    from stitchmesh.yarnrelax import YarnMaterial

COLOUR_BY = ("yarn", "row", "stitch", "strain", "stretch", "contact", "distance", "body-distance")
"""The words that choose what the colours show, besides one colour."""
LEAST_STRAIN = 0.005
"""The last colour stands for at least this strain; with a smaller one, rounding would look like strain."""


@dataclass(frozen=True)
class Coloured:
    """Colours of control points, and their legend."""

    points: NDArray[np.uint8]
    """Colour of each control point (sRGB), shape (N, 3)."""
    key: tuple[tuple[str, Colour], ...] = ()
    """Names and colours of the legend; empty where the colours need none."""
    scale: ColourScale | None = None
    """The scale, where the colours show a number."""


def colour_yarns(
    yarns: YarnSet, colour: str, *, fabric: StitchMesh | None = None, body: Mesh | None = None, blend: float = 1.0,
    material: YarnMaterial | None = None,
) -> Coloured:  # fmt: skip
    """Return the colours of the control points of yarns.

    Args:
        yarns: the yarns.
        colour: a word of ``COLOUR_BY``, or one colour for all yarns (``parse_colour``). ``strain`` shows the strain of
            the yarn, ``stretch`` the stretch of the stitches, ``contact`` the contact force per length
            (``contact_load``), ``distance`` the gap to the nearest other strand (``strand_distance``), and
            ``body-distance`` the gap to the body.
        fabric: the stitch mesh of the yarns, for ``stitch`` and ``stretch``.
        body: the body, for ``body-distance``.
        blend: weight of the colours of rows or stitches, from 0 (the colours of the yarns) to 1.
        material: material of the yarns, for ``contact``; by default the default material, scaled to their radius.

    Raises:
        ParameterError: the colour is unknown, the fabric or the body that it needs is missing, or the weight is not
            from 0 to 1.
    """
    if not 0.0 <= blend <= 1.0:
        raise ParameterError(f"blend: got {blend:g}; expected 0 to 1")
    if colour == "yarn":
        return Coloured(_own_colours(yarns))
    if colour == "row":
        return Coloured(_blended(yarns, row_colours(yarns.row), blend))
    if colour == "stitch":
        knitted = _fabric_of(yarns, fabric, colour)
        codes = np.where(yarns.face >= 0, knitted.stitch[yarns.face], -1)
        return Coloured(_blended(yarns, _code_colours(codes), blend), stitch_key(knitted, codes))
    if colour in COLOUR_BY:
        return _by_number(yarns, colour, fabric, body, material)
    return Coloured(np.tile(one_colour(colour), (len(yarns.points), 1)))


def one_colour(colour: str) -> NDArray[np.uint8]:
    """Return the sRGB colour that a text names, shape (3,).

    Raises:
        ParameterError: the text is no colour and no word of ``COLOUR_BY``.
    """
    try:
        return parse_colour(colour)
    except ParameterError as error:
        near = difflib.get_close_matches(colour.lower(), COLOUR_BY, n=1, cutoff=0.6)
        hint = f" (did you mean {near[0]!r}?)" if near else ""
        raise ParameterError(f"{error}; or colour by {', '.join(COLOUR_BY)}{hint}") from None


def blend_colours(own: NDArray[np.uint8], code: NDArray[np.uint8], weight: float) -> NDArray[np.uint8]:
    """Mix two arrays of sRGB colours in linear light; ``weight`` is the weight of the second array."""
    mixed = (1.0 - weight) * linear_colour(own / 255) + weight * linear_colour(code / 255)
    return np.round(255 * srgb_colour(mixed)).astype(np.uint8)


def stitch_key(fabric: StitchMesh, codes: NDArray[np.int64]) -> tuple[tuple[str, Colour], ...]:
    """Return the legend of stitch types, with one entry for each type; negative codes are left out."""
    return tuple(
        (stitch_name(fabric.stitch_type(code)), stitch_colour(code))
        for code in np.unique(codes[codes >= 0]).tolist()
    )


def _own_colours(yarns: YarnSet) -> NDArray[np.uint8]:
    return colours_of(yarns.colour, yarns.palette)[yarns.point_yarn]


def _blended(yarns: YarnSet, colours: NDArray[np.uint8], weight: float) -> NDArray[np.uint8]:
    """Mix colours with the colours of the yarns, unless the weight of the first is 1."""
    return colours if weight == 1.0 else blend_colours(_own_colours(yarns), colours, weight)


def _by_number(
    yarns: YarnSet, colour: str, fabric: StitchMesh | None, body: Mesh | None, material: YarnMaterial | None
) -> Coloured:
    """Colour each control point by a number on a scale."""
    if colour == "strain":
        values = control_point_means(yarns, yarns.strain)
        return _scaled(diverging_scale(values, LEAST_STRAIN), values, lambda mark: f"{100 * mark:+.1f} % strain")
    if colour == "stretch":
        values = _face_stretch(yarns, fabric)
        return _scaled(diverging_scale(values, LEAST_STRAIN), values, lambda mark: f"{100 * mark:+.1f} % stretch")
    if colour == "contact":
        values = control_point_means(yarns, contact_of_yarns(yarns, material))
        return _scaled(sequential_scale(values, 1.0, 0.0), values, lambda mark: f"{mark:.3g} dyn/cm contact")
    values = control_point_means(yarns, strand_distance(yarns) if colour == "distance" else _from_body(yarns, body))
    least = 0.05 * float(yarns.radius.mean())
    return _scaled(sequential_scale(values, least), values, lambda mark: f"{10 * mark:+.2f} mm distance")


def contact_of_yarns(yarns: YarnSet, material: YarnMaterial | None = None) -> FloatArray:
    """Return the contact force per length on each segment [dyn/cm], shape (S,); ``contact_load`` with defaults."""
    from stitchmesh.yarnrelax.evaluate import contact_load
    from stitchmesh.yarnrelax.model.material import material_of

    given = material or material_of(yarns)
    return contact_load(yarns, given, contact_samples=5)  # The presets of the solver have 3 to 11.


def _from_body(yarns: YarnSet, body: Mesh | None) -> FloatArray:
    from stitchmesh.yarnrelax.evaluate import body_distance

    if body is None:
        raise ParameterError("colour: got 'body-distance' without a body; give the mesh of the body too")
    return body_distance(yarns, body)


def _scaled(scale: ColourScale, values: FloatArray, text: Callable[[float], str]) -> Coloured:
    return Coloured(scale.of(values), scale.key(text), scale)


def _face_stretch(yarns: YarnSet, fabric: StitchMesh | None) -> FloatArray:
    """Return the length over rest length - 1 of the stitch that made each control point; 0 where no stitch did."""
    known = _fabric_of(yarns, fabric, "stretch").face_stretch
    if known is None:
        raise ParameterError("colour: got 'stretch' and a stitch mesh that was not relaxed; relax it (relax-mesh)")
    return np.where(yarns.face >= 0, known[yarns.face] - 1.0, 0.0)


def _fabric_of(yarns: YarnSet, fabric: StitchMesh | None, colour: str) -> StitchMesh:
    """Return the fabric, after a check that the yarns can be its yarns."""
    if fabric is None:
        raise ParameterError(f"colour: got {colour!r} for yarns without their stitch mesh; give the stitch mesh too")
    if yarns.face.max(initial=-1) >= fabric.face_count:
        found = f"yarns of face {yarns.face.max()} and a stitch mesh with {fabric.face_count} faces"
        raise ParameterError(f"colour: got {found}; expected the stitch mesh from which the yarns were generated")
    return fabric


def _code_colours(codes: NDArray[np.int64]) -> NDArray[np.uint8]:
    table = np.array([stitch_colour(code) for code in range(int(codes.max(initial=0)) + 1)], dtype=np.uint8)
    return table[np.maximum(codes, 0)]


def control_point_means(yarns: YarnSet, of_segments: FloatArray) -> FloatArray:
    """Return the mean of the two segments that meet near each control point, shape (N,).

    At the ends of an open yarn a control point has only one segment beside it, and the first and the last control point
    have none: they take the number of their neighbour.

    Args:
        yarns: the yarns.
        of_segments: a number for each segment, shape (S,).
    """
    beside = yarns.segment_points[:, 1:3]
    total = np.bincount(beside.ravel(), weights=np.repeat(of_segments, 2), minlength=len(yarns.points))
    count = np.bincount(beside.ravel(), minlength=len(yarns.points))
    mean = total / np.maximum(count, 1)
    first, last = yarns.start[:-1][~yarns.closed], yarns.start[1:][~yarns.closed] - 1
    mean[first], mean[last] = mean[first + 1], mean[last - 1]
    return mean
