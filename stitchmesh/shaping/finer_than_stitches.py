# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Features of a mesh that are finer than its stitches, as in a scan: small holes are spanned, and debris is left out.

A hole is a border that the surface surrounds. Its turning is -2 pi in a plane, and nearer to 0 where the surface
bulges. The end of a tube has the turning 0, and the outline of a flat piece 2 pi. Fingertips and toes are often
modelled as small holes too, but these are wider: a yarn is drawn through their last loops. Debris is a part without a
connection to others, smaller than the smallest tube, which has two rounds of ``SMALLEST_RING`` stitches.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stitchmesh.errors import MeshError
from stitchmesh.mesh import FloatArray, IntArray, Mesh
from stitchmesh.shaping.borders import length_of, turning
from stitchmesh.shaping.counts import SMALLEST_RING, StitchSize
from stitchmesh.shaping.marks import TimeMark, nearest_border
from stitchmesh.shaping.triangle_surface import TriangleSurface, connected_parts, in_triangles

HOLE_TURNING = -np.pi
"""Largest turning of a hole [rad]: half of the turning of a hole in a plane."""


def knitted_surface(mesh: Mesh, size: StitchSize, marks: Sequence[TimeMark]) -> tuple[TriangleSurface, list[str]]:
    """Return the triangles of a mesh that are knitted, and a sentence for each kind of feature that was changed.

    Args:
        mesh: the mesh.
        size: size of the stitches.
        marks: a hole whose border is marked is not spanned.

    Raises:
        MeshError: no part has room for some stitches.
    """
    whole, holes = with_small_holes_spanned(in_triangles(mesh), size.width, marks)
    kept, debris = without_debris(whole, size)
    notes = []
    if len(holes):
        notes.append(f"{_count(holes, 'hole')} finer than the stitches, and spanned by them; see {_place(holes[0])}")
    if len(debris):
        notes.append(f"{_count(debris, 'part')} smaller than a few stitches, and left out; see {_place(debris[0])}")
    return kept, notes


def with_small_holes_spanned(
    surface: TriangleSurface, stitch_width: float, marks: Sequence[TimeMark] = ()
) -> tuple[TriangleSurface, FloatArray]:
    """Fill each hole that is hardly wider than a stitch by triangles around its centre.

    Args:
        surface: the surface.
        stitch_width: wale spacing [cm].
        marks: a border that is marked is not filled.

    Returns:
        The surface, and the centres of the holes [cm], shape (n, 3).
    """
    borders = surface.borders
    kept = {nearest_border(surface, np.asarray(mark.points[0])) for mark in marks if mark.kind == "border" and borders}
    # Perimeter of the largest hole that is spanned, in stitch widths: it is little wider than a stitch.
    small = [
        border for number, border in enumerate(borders)
        if number not in kept and length_of(surface, border) < 4.0 * stitch_width
        and turning(surface, border) < HOLE_TURNING
    ]  # fmt: skip
    centres = np.array([surface.vertices[border].mean(axis=0) for border in small]).reshape(-1, 3)
    return _filled(surface, small, centres), centres


def without_debris(surface: TriangleSurface, size: StitchSize) -> tuple[TriangleSurface, FloatArray]:
    """Leave out the parts that have no room for the smallest tube.

    Returns:
        The surface, and a vertex of each part that was left out [cm], shape (n, 3).

    Raises:
        MeshError: no part has room.
    """
    parts = connected_parts(surface)
    room = [float(part.area.sum()) / (size.width * size.height) for part, _ in parts]
    fine = [count < 2 * SMALLEST_RING for count in room]
    if all(fine):
        raise MeshError(
            f"the largest connected part has room for {max(room):.1f} stitches of {size.width:g} cm, expected at "
            f"least {2 * SMALLEST_RING}; choose a smaller stitch, and check the unit"
        )
    if not any(fine):
        return surface, np.zeros((0, 3))
    dropped = np.array([part.vertices[0] for (part, _), small in zip(parts, fine, strict=True) if small])
    kept = [part for (part, _), small in zip(parts, fine, strict=True) if not small]
    first = np.concatenate([[0], np.cumsum([len(part.vertices) for part in kept])])
    triangles = [part.triangles + start for part, start in zip(kept, first[:-1], strict=True)]
    return TriangleSurface(np.concatenate([part.vertices for part in kept]), np.concatenate(triangles)), dropped


def _filled(surface: TriangleSurface, holes: Sequence[IntArray], centres: FloatArray) -> TriangleSurface:
    """The surface with triangles around a new vertex at the centre of each hole."""
    if not holes:
        return surface
    count = len(surface.vertices)
    fans = [
        np.stack([np.roll(hole, -1), hole, np.full(len(hole), count + number)], axis=1)
        for number, hole in enumerate(holes)
    ]
    return TriangleSurface(np.concatenate([surface.vertices, centres]), np.concatenate([surface.triangles, *fans]))


def _count(places: FloatArray, word: str) -> str:
    return f"1 {word} of the mesh is" if len(places) == 1 else f"{len(places)} {word}s of the mesh are"


def _place(point: FloatArray) -> str:
    return "(" + ", ".join(f"{value:.3g}" for value in point) + ") cm"
