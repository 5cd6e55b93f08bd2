# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Colours of yarns in a picture: by yarn, row, stitch or strain, or one colour.

The colours of rows and of stitches can be blended with those of the yarns (Leaf et al. 2018, section 7.2).
"""

from __future__ import annotations

import difflib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray, StitchMesh
from stitchmesh.mesh.palette import colours_of, linear_colour, parse_colour, srgb_colour
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.render.lettering import Colour
from stitchmesh.render.palette import stitch_colour
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.colours import row_colours

COLOUR_BY = ("yarn", "row", "stitch", "strain")
"""What can decide the colours, besides one colour."""
STRAIN_SCALE = np.array([[49, 92, 146], [146, 176, 202], [236, 232, 222], [222, 150, 120], [164, 48, 42]])
"""Colours of strains from the most negative to the most positive one, evenly spaced, sRGB."""
STRAIN_QUANTILE = 0.99
"""Quantile of the absolute strain that has the last colour of the scale."""
LEAST_STRAIN = 0.005
"""Smallest strain of the last colour; with a smaller one, rounding would look like strain."""


@dataclass(frozen=True)
class Coloured:
    """Colours of control points, and their legend."""

    points: NDArray[np.uint8]
    """Colour of each control point (sRGB), shape (N, 3)."""
    key: tuple[tuple[str, Colour], ...] = ()
    """Names and colours of the legend; empty where the colours need none."""


def colour_yarns(yarns: YarnSet, colour: str, *, fabric: StitchMesh | None = None, blend: float = 1.0) -> Coloured:
    """Return the colours of the control points of yarns.

    Args:
        yarns: the yarns.
        colour: a word of ``COLOUR_BY``, or one colour for all yarns (``parse_colour``).
        fabric: the stitch mesh of the yarns, for ``stitch``.
        blend: weight of the colours of rows or stitches, from 0 (the colours of the yarns) to 1.

    Raises:
        ParameterError: the colour is unknown, ``stitch`` is asked for without the stitch mesh of the yarns, or the
            weight is not from 0 to 1.
    """
    if not 0.0 <= blend <= 1.0:
        raise ParameterError(f"blend: got {blend:g}; expected 0 to 1")
    own = colours_of(yarns.colour, yarns.palette)[yarns.point_yarn]
    if colour == "yarn":
        return Coloured(own)
    if colour == "row":
        return Coloured(blend_colours(own, row_colours(yarns.row), blend))
    if colour == "stitch":
        codes = _stitches(yarns, fabric)
        return Coloured(blend_colours(own, _code_colours(codes), blend), stitch_key(codes))
    if colour == "strain":
        return _by_strain(yarns)
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
    """Mix two arrays of sRGB colours in linear light; ``weight`` is that of the second one."""
    mixed = (1.0 - weight) * linear_colour(own / 255) + weight * linear_colour(code / 255)
    return np.round(255 * srgb_colour(mixed)).astype(np.uint8)


def stitch_key(codes: NDArray[np.int64]) -> tuple[tuple[str, Colour], ...]:
    """Return the legend of stitch types, with one entry for each type; negative codes are left out."""
    return tuple(
        (Stitch(code).name.lower().replace("_", " "), stitch_colour(code)) for code in np.unique(codes[codes >= 0])
    )


def _stitches(yarns: YarnSet, fabric: StitchMesh | None) -> NDArray[np.int64]:
    """Return the stitch type of each control point, -1 where no stitch made the point."""
    if fabric is None:
        raise ParameterError("colour: got 'stitch' for yarns without their stitch mesh; give the stitch mesh too")
    if yarns.face.max(initial=-1) >= fabric.face_count:
        found = f"yarns of face {yarns.face.max()} and a stitch mesh with {fabric.face_count} faces"
        raise ParameterError(f"colour: got {found}; expected the stitch mesh from which the yarns were generated")
    return np.where(yarns.face >= 0, fabric.stitch[yarns.face], -1)


def _code_colours(codes: NDArray[np.int64]) -> NDArray[np.uint8]:
    table = {code: stitch_colour(max(code, 0)) for code in np.unique(codes).tolist()}
    return np.array([table[code] for code in codes.tolist()], dtype=np.uint8)


def _by_strain(yarns: YarnSet) -> Coloured:
    """Colour each control point by the mean strain of the segments beside it."""
    total, count = np.zeros(len(yarns.points)), np.zeros(len(yarns.points))
    for place in (1, 2):
        np.add.at(total, yarns.segment_points[:, place], yarns.strain)
        np.add.at(count, yarns.segment_points[:, place], 1.0)
    strain = total / np.maximum(count, 1.0)
    most = max(float(np.quantile(np.abs(strain), STRAIN_QUANTILE)), LEAST_STRAIN)
    marks = np.linspace(most, -most, len(STRAIN_SCALE))
    key = tuple((f"{100 * mark:+.1f} % strain", _rgb(_scale(mark / most))) for mark in marks)
    return Coloured(_scale(strain / most), key)


def _scale(value: FloatArray | float) -> NDArray[np.uint8]:
    """Return the colours of values from -1 to 1 on ``STRAIN_SCALE``, shape (n,) to (n, 3)."""
    places = np.linspace(-1.0, 1.0, len(STRAIN_SCALE))
    return np.stack([np.interp(value, places, channel) for channel in STRAIN_SCALE.T], axis=-1).round().astype(np.uint8)


def _rgb(colour: NDArray[np.uint8]) -> Colour:
    red, green, blue = colour.tolist()
    return red, green, blue
