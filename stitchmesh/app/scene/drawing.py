# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The drawings of a scene, as data: surfaces with colours, lines, arrows, texts, yarns and marks of points.

Positions are in cm, colours in sRGB.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.render.yarn_blocks import YarnBlocks

Colour: TypeAlias = tuple[int, int, int]
"""A colour, red, green and blue from 0 to 255, sRGB."""
LARGEST_PALETTE = 256
"""Largest number of colours of one surface; the browser gets one byte for each triangle or point."""


IN_PLACE = np.zeros((1, 3))
"""Displacement of the only copy of yarns that are drawn once."""


@dataclass(frozen=True, eq=False)
class Colours:
    """Colours of the triangles or of the points of a surface, as places in a palette.

    Raises:
        ParameterError: the palette is empty or too large, or an index is outside it.
    """

    index: NDArray[np.uint8]
    """Place in the palette of each triangle, shape (T,), or of each point, shape (V,)."""
    palette: NDArray[np.uint8]
    """Colours, sRGB, shape (P, 3), P from 1 to 256."""

    def __post_init__(self) -> None:
        if not 1 <= len(self.palette) <= LARGEST_PALETTE:
            raise ParameterError(f"colours: got a palette of {len(self.palette)}; expected 1 to {LARGEST_PALETTE}")
        if self.index.max(initial=0) >= len(self.palette):
            raise ParameterError(f"colours: got index {self.index.max()} in a palette of {len(self.palette)}")

    @classmethod
    def of(cls, colours: NDArray[np.uint8]) -> Colours:
        """Return the colours of an array of sRGB colours, shape (n, 3), as a palette of at most 256 colours.

        If there are more colours, the palette holds 6 x 7 x 6 evenly spaced colours, and each colour becomes the
        nearest of them.
        """
        code = colours.astype(np.int64) @ np.array([1 << 16, 1 << 8, 1])
        different, index = np.unique(code, return_inverse=True)
        if len(different) > LARGEST_PALETTE:
            return _nearest_of_cube(colours)
        palette = np.stack([different >> 16, different >> 8 & 255, different & 255], axis=1)
        return cls(index.astype(np.uint8), palette.astype(np.uint8))


@dataclass(frozen=True, eq=False)
class Surface:
    """Triangles with colours.

    Raises:
        ParameterError: the number of colours is not the number of triangles or of points.
    """

    points: FloatArray
    """Positions, shape (V, 3)."""
    triangles: IntArray
    """Corners of the triangles, anticlockwise seen from outside, shape (T, 3)."""
    colours: Colours | Colour
    """Colours of the triangles if ``flat`` is True, otherwise of the points; or one colour."""
    flat: bool = True
    """Whether each triangle has its own normal and colour; otherwise normals and colours change smoothly."""
    opacity: float = 1.0
    """From 0, invisible, to 1."""
    takes_strokes: bool = False
    """Whether a drag that begins on the surface is a stroke (``Page.stroked``) instead of a turn of the camera."""

    def __post_init__(self) -> None:
        expected = len(self.triangles) if self.flat else len(self.points)
        if isinstance(self.colours, Colours) and len(self.colours.index) != expected:
            what = "triangles" if self.flat else "points"
            raise ParameterError(f"surface: got {len(self.colours.index)} colours for {expected} {what}")


@dataclass(frozen=True, eq=False)
class Lines:
    """Straight lines."""

    segments: FloatArray
    """Ends of the lines, shape (n, 2, 3)."""
    colour: Colour | NDArray[np.uint8]
    """One colour, or a colour for each end, shape (n, 2, 3)."""
    width: float = 2.0
    """Width on the screen [pixels]."""


@dataclass(frozen=True, eq=False)
class Arrows:
    """Arrows."""

    segments: FloatArray
    """Start and tip of each arrow, shape (n, 2, 3)."""
    colour: Colour | NDArray[np.uint8]
    """One colour, or a colour for each arrow, shape (n, 3)."""
    radius: float
    """Radius of the shafts [cm]."""


@dataclass(frozen=True, eq=False)
class Labels:
    """Short texts at points."""

    points: FloatArray
    """Positions, shape (n, 3)."""
    texts: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Copies:
    """A surface with smooth normals and one colour, drawn at several places; the browser gets it only once."""

    points: FloatArray | NDArray[np.float32]
    """Positions, shape (V, 3)."""
    triangles: IntArray | NDArray[np.uint32]
    """Corners of the triangles, anticlockwise seen from outside, shape (T, 3)."""
    colour: Colour
    """Colour of all copies."""
    offsets: FloatArray | NDArray[np.float32]
    """Displacement of each copy, shape (n, 3)."""


@dataclass(frozen=True, eq=False)
class YarnTubes:
    """Yarns as tubes; their detail follows the distance from the camera of each browser (``levels_of_detail``).

    Raises:
        ParameterError: the number of colours is not the number of control points, or a copy is no vector.
    """

    blocks: YarnBlocks
    """Runs of the yarns in blocks of space (``make_blocks``); the same object for all frames of one fabric."""
    points: FloatArray
    """Positions of the control points of the yarns, shape (N, 3)."""
    colours: NDArray[np.uint8]
    """Colour of each control point, shape (N, 3)."""
    copies: FloatArray = field(default_factory=lambda: IN_PLACE)
    """Displacement of each drawn copy, shape (n, 3); one copy in place by default."""

    def __post_init__(self) -> None:
        if self.colours.shape != self.points.shape:
            raise ParameterError(f"tubes: got colours {self.colours.shape} for points {self.points.shape}")
        if self.copies.ndim != 2 or self.copies.shape[1:] != (3,):
            raise ParameterError(f"tubes: got copies of shape {self.copies.shape}; expected (n, 3)")


Drawing: TypeAlias = Surface | Lines | Arrows | Labels | Copies | YarnTubes
"""Any drawing that a scene shows under one name."""


def shows_nothing(drawing: Drawing) -> bool:
    """Whether a drawing has no triangle, no line and no text."""
    if isinstance(drawing, Surface):
        return not len(drawing.triangles)
    if isinstance(drawing, Lines):
        return not len(drawing.segments)
    return isinstance(drawing, Labels) and not drawing.texts


def _nearest_of_cube(colours: NDArray[np.uint8]) -> Colours:
    """Return colours rounded to a cube of 6 x 7 x 6 colours."""
    steps = np.array([6, 7, 6])
    place = np.rint(colours / 255.0 * (steps - 1)).astype(np.int64)
    grid = np.stack(np.meshgrid(*[np.linspace(0, 255, n) for n in steps], indexing="ij"), axis=-1).reshape(-1, 3)
    return Colours(np.ravel_multi_index(place.T, steps).astype(np.uint8), np.rint(grid).astype(np.uint8))


OCTAHEDRON = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], dtype=np.float64)
OCTAHEDRON_FACES = np.array([[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]])


def point_marks(centres: FloatArray, size: float, colour: Colour) -> Surface:
    """Return marks of points.

    Args:
        centres: the points [cm], shape (n, 3).
        size: distance of the corners of each octahedron from its point [cm].
        colour: their colour, sRGB.
    """
    points = (centres[:, None] + size * OCTAHEDRON).reshape(-1, 3)
    triangles = (len(OCTAHEDRON) * np.arange(len(centres))[:, None, None] + OCTAHEDRON_FACES).reshape(-1, 3)
    return Surface(points, triangles, colour)
