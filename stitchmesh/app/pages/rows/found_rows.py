# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Rows that were found on a surface: the time of each place, and where knitting begins and ends."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stitchmesh.app.project.shaping import Shaping
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.shaping.auto_stitches import ShapedFabric
from stitchmesh.shaping.ends import Ends
from stitchmesh.shaping.triangle_surface import TriangleSurface, connected_parts

LIFT = 0.06
"""Distance of lines from the surface, divided by the mean length of sides; it keeps them visible."""


@dataclass(frozen=True, eq=False)
class EndPlace:
    """A border, a line or a tip that is knitted at one time."""

    vertices: IntArray
    """Vertices of the surface along it, shape (n,); a closed line repeats its first vertex, a tip is one vertex."""
    role: str
    """``begin``, ``end`` or ``row``."""
    time: float
    """Its time [cm]."""


@dataclass(frozen=True, eq=False)
class FoundRows:
    """A surface with its time."""

    surface: TriangleSurface
    """The surface."""
    time: FloatArray
    """Distance along the fabric from where knitting begins [cm], shape (V,)."""
    course_height: float
    """Height of a row [cm]."""
    places: tuple[EndPlace, ...]
    """Where knitting begins and ends, and the lines along which rows run."""

    @cached_property
    def side_edges(self) -> IntArray:
        """The two vertices of each border edge at which rows end, shape (n, 2)."""
        at_ends = [np.sort(np.stack([place.vertices[:-1], place.vertices[1:]], axis=1)) for place in self.places]
        borders = [np.sort(np.stack([border, np.roll(border, -1)], axis=1)) for border in self.surface.borders]
        edges = np.concatenate([np.zeros((0, 2), dtype=np.int64), *borders])
        count = len(self.time)
        others = np.concatenate([np.zeros((0, 2), dtype=np.int64), *at_ends]) @ np.array([count, 1])
        return edges[~np.isin(edges @ np.array([count, 1]), others)]

    @property
    def rows(self) -> int:
        """Number of rows, one above the other, from the first time to the last one."""
        return round(float(np.ptp(self.time)) / self.course_height)

    @cached_property
    def in_front(self) -> FloatArray:
        """Positions a little outside of the vertices, where lines on the surface can be seen [cm], shape (V, 3)."""
        mesh = self.surface.mesh
        return self.surface.vertices + LIFT * float(mesh.side_length.mean()) * mesh.vertex_normal

    @cached_property
    def area(self) -> float:
        """Area of the surface [cm^2]."""
        return float(self.surface.area.sum())

    def time_at(self, point: Sequence[float]) -> float:
        """Return the time of the vertex nearest to a point [cm]."""
        away = self.surface.vertices - np.asarray(point, dtype=np.float64)
        return float(self.time[np.einsum("vi,vi->v", away, away).argmin()])


def rows_of_fabric(shaped: ShapedFabric, shaping: Shaping) -> FoundRows:
    """Return the rows that stitches were made of."""
    return found_rows(shaped.surface, shaped.time, shaped.ends, shaping)


def found_rows(surface: TriangleSurface, courses: FloatArray, ends: Sequence[Ends], shaping: Shaping) -> FoundRows:
    """Return the rows of a time.

    Args:
        surface: the surface.
        courses: time of each vertex in courses, shape (V,).
        ends: the ends of each connected part.
        shaping: how the time was found; if no mark has a time, the smallest time becomes 0.
    """
    time = courses * shaping.height
    if all(mark.time is None for mark in shaping.marks):
        time = time - time.min()
    places: list[EndPlace] = []
    used = np.zeros(len(time), dtype=bool)
    for (_, vertices), its in zip(connected_parts(surface), ends, strict=True):
        for role, end in _roles(its):
            path = vertices[end]
            used[path] = True
            places.append(_place(surface, time, path, role))
    return FoundRows(surface, time, shaping.height, (*places, *_tips(surface, time, used)))


def _roles(ends: Ends) -> list[tuple[str, IntArray]]:
    """The role and the vertices of each end."""
    root, other = ("begin", "end") if ends.begins else ("end", "begin")
    groups = (root, ends.roots), (other, (*ends.others, *ends.grafts)), ("row", ends.lines)
    return [(role, end.vertices) for role, group in groups for end in group]


def _place(surface: TriangleSurface, time: FloatArray, path: IntArray, role: str) -> EndPlace:
    """The place of some vertices in order; a whole border is a closed line."""
    closed = any(len(border) == len(path) and np.isin(path, border).all() for border in surface.borders)
    along = np.append(path, path[0]) if closed else path
    return EndPlace(along, role, float(time[path[0]]))


def _tips(surface: TriangleSurface, time: FloatArray, used: np.ndarray) -> list[EndPlace]:
    """The tips of closed limbs: vertices, neither at a border nor in an end, that are earlier or later than all around.

    Args:
        surface: the surface.
        time: time of each vertex [cm], shape (V,).
        used: whether each vertex belongs to an end, shape (V,).
    """
    inner = ~used
    inner[np.concatenate([np.zeros(0, dtype=np.int64), *surface.borders])] = False
    both = np.concatenate([surface.edges, surface.edges[:, ::-1]])
    found = []
    for role, sign in (("begin", -1.0), ("end", 1.0)):
        passed = both[sign * time[both[:, 1]] >= sign * time[both[:, 0]], 0]
        is_tip = inner.copy()
        is_tip[passed] = False
        found += [EndPlace(np.array([tip]), role, float(time[tip])) for tip in np.flatnonzero(is_tip)]
    return found
