# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The map of the sizes of stitches: a surface in colours, outlines of rows, and a legend."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stitchmesh.app.controls.html_pieces import colour_bar
from stitchmesh.app.scene.drawing import Colour, Colours, Lines, Surface
from stitchmesh.app.scene.scene import DrawingScene
from stitchmesh.markup import Markup
from stitchmesh.mesh import BORDER, FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.face_triangles import FaceTriangles, face_triangles
from stitchmesh.meshrelax.evenness import Measure, relative_sizes
from stitchmesh.render.colour_scale import DIVERGING, ColourScale

LARGEST_RATIO = 1.5
"""Size of a stitch over the average at the upper end of the scale; the lower end is the inverse."""
PLAIN: Colour = (206, 198, 184)
"""Colour of stitches of unknown size."""
LIFT = 0.05
"""Distance of lines from the surface, over the mean length of sides; it keeps the lines visible."""
OUTLINE: Colour = (0, 158, 115)
"""Colour of outlines; no scale contains it, and it is visible on light and dark backgrounds."""
SCALE = ColourScale(DIVERGING, -float(np.log(LARGEST_RATIO)), float(np.log(LARGEST_RATIO)))
"""Colours of the logarithms of relative sizes, so that twice and half the size are equally far from the average."""


class SizeMap:
    """A fabric that moves and changes its colours while it keeps its faces."""

    def __init__(self, fabric: StitchMesh) -> None:
        """Prepare the faces of a fabric."""
        self._found: FaceTriangles = face_triangles(fabric)
        self._triangles: IntArray = fabric.face_vertex[self._found.corners]
        self._palette = np.concatenate([SCALE.table(255), [PLAIN]]).astype(np.uint8)

    def surface(self, fabric: StitchMesh, measure: Measure) -> Surface:
        """Return the surface of a fabric with the same faces as the first one.

        Args:
            fabric: the fabric; without stretch it has one colour.
            measure: which size the colours show.
        """
        if fabric.stretch is None:
            return Surface(fabric.vertices, self._triangles, PLAIN)
        size = relative_sizes(fabric, measure)
        known = np.isfinite(size)
        place = np.rint(254 * SCALE.share(np.log(np.where(known, size, 1.0))))
        index = np.where(known, place, 255).astype(np.uint8)[self._found.face]
        return Surface(fabric.vertices, self._triangles, Colours(index, self._palette))


class SizeMapDrawing:
    """Draws the maps of fabrics and their sides; a fabric with the same number of faces moves in place."""

    def __init__(self, scene: DrawingScene) -> None:
        """Draw nothing yet."""
        self._scene = scene
        self._map: SizeMap | None = None
        self.shown: StitchMesh | None = None
        """The visible fabric."""

    def show(self, fabric: StitchMesh, measure: Measure) -> bool:
        """Draw a fabric, and return whether its number of faces differs from that of the one before."""
        other = self.shown is None or self.shown.face_count != fabric.face_count
        if self._map is None or other:
            self._map = SizeMap(fabric)
        self.shown = fabric
        self._scene.show("fabric", self._map.surface(fabric, measure))
        self._scene.show("sides", edges(fabric))
        return other


def outline(fabric: StitchMesh, faces: NDArray[np.bool_]) -> Lines:
    """Return the lines around some faces of a fabric.

    Args:
        fabric: the fabric.
        faces: whether each face of the fabric is one of these faces, shape (F,).
    """
    across = np.where(fabric.twin == BORDER, -1, fabric.side_face[fabric.twin])
    sides = np.flatnonzero(faces[fabric.side_face] & ((across < 0) | ~faces[across]))
    return Lines(_lifted(fabric, sides, 1.0), OUTLINE, 4.0)


def edges(fabric: StitchMesh) -> Lines:
    """Return the sides of all stitches as thin lines."""
    return Lines(_lifted(fabric, fabric.edge_side, 0.3), (90, 84, 78), 1.0)


def legend_html(small: str = "too many", large: str = "too few") -> Markup:
    """Return the scale with its numbers, and the meaning of both ends in words."""
    marks = (f"{1.0 / LARGEST_RATIO:.2f} {small}", "1 average", f"{LARGEST_RATIO:.2f} {large}")
    spoken = "Colours from blue, stitches that are smaller than the average, to red, stitches that are larger"
    return colour_bar(DIVERGING, marks, "Size of a stitch over the average of the fabric", spoken)


def _lifted(fabric: StitchMesh, sides: IntArray, share: float) -> FloatArray:
    """Return the ends of some sides, shifted along the normals of their faces by a share of ``LIFT``, (n, 2, 3)."""
    area = fabric.face_vector_area
    normal = area / np.maximum(np.linalg.norm(area, axis=1, keepdims=True), np.finfo(float).tiny)
    lift = LIFT * float(fabric.side_length.mean()) * normal
    ends: FloatArray = fabric.corner_position[np.stack([sides, fabric.side_next[sides]], axis=1)]
    return ends + (share * lift)[fabric.side_face[sides], None]
