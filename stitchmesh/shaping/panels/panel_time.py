# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The time at which each place of a panel is knitted, along a direction of its texture.

With X the unit vector along the gradient of the texture coordinate in that direction, the time t minimises

    integral of |grad(t) - X|^2,

so that a row is one course high wherever the surface allows it. Hems are the lines at which the rows of a panel begin
or end. Each hem has one time, a whole number of courses, and a number of stitches for each of its parts.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from stitchmesh.errors import TessellationError
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.shaping.ends import End, Ends
from stitchmesh.shaping.panels.outline_pieces import BEGINS, OutlinePiece, hem_runs
from stitchmesh.shaping.panels.refined_panel import RefinedPanel
from stitchmesh.shaping.time_function import knots
from stitchmesh.shaping.triangle_surface import TriangleSurface


@dataclass(frozen=True, eq=False)
class PanelTime:
    """The time on a panel."""

    refined: RefinedPanel
    """The triangles of the panel."""
    field: FloatArray
    """Unit vector in the direction of knitting on each triangle, shape (T, 3)."""
    height: float
    """Height of a course [cm]."""

    courses: FloatArray
    """Time of each vertex of the refined panel in courses, shape (V,)."""
    ends: Ends
    """The hems; the roots are the hems at which rows begin."""
    runs: tuple[tuple[int, ...], ...]
    """Numbers of the pieces of each hem, in the order of ``ends.all`` and along the border."""

    @property
    def angle(self) -> FloatArray:
        """Angle between the time and the direction of knitting on each triangle [rad], shape (T,)."""
        gradient = self.refined.surface.gradient(self.courses)
        along = np.einsum("ti,ti->t", gradient, self.field)
        angle = np.arctan2(np.linalg.norm(np.cross(gradient, self.field), axis=1), along)
        return np.where(self.field.any(axis=1), angle, 0.0)

    def with_times(self, known: dict[int, float]) -> PanelTime:
        """Return the time that has given values [courses] at some vertices, and keeps its values at the hems."""
        if not known:
            return self
        surface, parts = self.refined.surface, knots(self.refined.surface, self.ends)
        held = {int(parts.unknown[vertex]): value for vertex, value in known.items()}
        held.update({number: float(self.courses[end.vertices[0]]) for number, end in enumerate(self.ends.all)})
        right = parts.total(surface.divergence(self.field / self.height))
        return replace(self, courses=parts.solve(surface.stiffness(), right, held))


def panel_time(
    panel: int, refined: RefinedPanel, pieces: list[OutlinePiece], direction: FloatArray, height: float
) -> PanelTime:
    """Find the time of a panel.

    Args:
        panel: number of the panel.
        refined: its triangles.
        pieces: the outlines of all panels.
        direction: direction of knitting in the texture, shape (2,).
        height: height of a stitch [cm].

    Raises:
        TessellationError: the texture does not change along the direction, or rows begin later than they end.
    """
    surface = refined.surface
    runs = sorted(hem_runs(pieces, panel), key=lambda run: pieces[run[0]].kind)
    hems = [End(refined_line(refined, [pieces[number] for number in run])) for run in runs]
    begins = sum(pieces[run[0]].kind == BEGINS for run in runs)
    ends = Ends(tuple(hems[:begins]), tuple(hems[begins:]))
    field = unit_field(surface, refined.texture @ direction)
    if not field.any():
        along = direction.tolist()
        raise TessellationError(f"the texture coordinates do not change along {along}; choose another direction")
    courses = _solved(surface, refined.texture @ direction, field / height, ends)
    levels = [int(round(float(courses[end.vertices[0]]))) for end in ends.all]
    if begins and len(hems) > begins and max(levels[:begins]) >= max(levels[begins:]):
        place = surface.vertices.mean(axis=0).round(1).tolist()
        raise TessellationError(f"near {place} cm: lower than one row of {height:g} cm; choose a smaller stitch")
    return PanelTime(refined, field, height, courses, ends, tuple(tuple(run) for run in runs))


def unit_field(surface: TriangleSurface, values: FloatArray) -> FloatArray:
    """Return the unit vector along the gradient of a function on each triangle, shape (T, 3); 0 where it is flat."""
    gradient = surface.gradient(values)
    slope = np.linalg.norm(gradient, axis=1, keepdims=True)
    flat = slope <= 1e-9 * max(float(slope.max(initial=0.0)), np.finfo(np.float64).tiny)
    return np.where(flat, 0.0, gradient / np.where(flat, 1.0, slope))


def _solved(surface: TriangleSurface, coordinate: FloatArray, field: FloatArray, ends: Ends) -> FloatArray:
    """Return the time in courses, shape (V,): first with free times of the hems, then with whole numbers."""
    held = ends if ends.all else Ends((End(np.array([int(coordinate.argmin())])),))
    parts = knots(surface, held)
    matrix, right = surface.stiffness(), parts.total(surface.divergence(field))
    # Height of the first course above the lowest vertex of a panel without hems, in courses.
    time = parts.solve(matrix, right, {0: 0.0 if ends.all else 0.5})
    if not ends.all:
        return time
    known = {number: float(np.rint(time[end.vertices[0]])) for number, end in enumerate(held.all)}
    return parts.solve(matrix, right, known)


def refined_line(refined: RefinedPanel, run: list[OutlinePiece]) -> IntArray:
    """Vertices of the surface along consecutive pieces of the outline."""
    corner = np.concatenate([run[0].vertices, *(piece.vertices[1:] for piece in run[1:])])
    first, last = refined.place(int(corner[0])), refined.place(int(corner[-1]))
    loop = next(border for border in refined.surface.borders if first in border)
    ring = np.roll(loop, -int(np.flatnonzero(loop == first)[0]))
    end = int(np.flatnonzero(ring == last)[0]) if last != first else len(ring)
    return np.append(ring, ring[0])[: end + 1]


@dataclass(frozen=True)
class HemPart:
    """Stitches along one piece of the outline at which rows begin or end."""

    piece: int
    """Number of the piece."""
    length: float
    """Its length [cm]."""
    count: int
    """Number of its stitches."""


@dataclass(frozen=True, eq=False)
class Hem:
    """A line at which rows begin or end."""

    points: FloatArray
    """Points along the line from left to right [cm], shape (n, 3)."""
    parts: tuple[HemPart, ...]
    """Its parts from left to right."""


def hems_of(found: PanelTime, pieces: list[OutlinePiece], width: float) -> list[Hem]:
    """Return the hems of a panel, with the number of stitches of each of their pieces.

    Args:
        found: the time of the panel.
        pieces: the outlines of all panels.
        width: width of a stitch [cm].
    """
    hems = []
    for run, end in zip(found.runs, found.ends.all, strict=True):
        order = 1 if pieces[run[0]].kind == BEGINS else -1
        parts = [HemPart(piece, pieces[piece].length, _count(pieces, piece, width)) for piece in run]
        hems.append(Hem(found.refined.surface.vertices[end.vertices][::order], tuple(parts[::order])))
    return hems


def _count(pieces: list[OutlinePiece], number: int, width: float) -> int:
    """Number of stitches along a piece; the same for the two pieces at a seam, from their mean length."""
    piece = pieces[number]
    length = piece.length if piece.partner < 0 else 0.5 * (piece.length + pieces[piece.partner].length)
    # Rounding is done on a rounded number, so that equal pieces have equal numbers.
    return max(1, int(np.floor(round(length / width, 6) + 0.5)))
