# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The search for rows and stitches of a mesh in a worker thread: the time of each place, and where knitting begins.

Rows without their stitches take a fraction of the time. The search first finds them on large triangles, then on smaller
ones.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from stitchmesh.app.project.shaping import Shaping
from stitchmesh.app.task import NewestTask, Refused, TaskControl, TaskRunner, Work
from stitchmesh.errors import StitchMeshError
from stitchmesh.mesh import FloatArray, IntArray, Mesh
from stitchmesh.shaping.auto_stitches import EDGE_OVER_WIDTH, ShapedFabric, marks_by_part
from stitchmesh.shaping.counts import StitchSize
from stitchmesh.shaping.ends import Ends
from stitchmesh.shaping.finer_than_stitches import knitted_surface
from stitchmesh.shaping.marks import marked_ends
from stitchmesh.shaping.time_function import knitting_time
from stitchmesh.shaping.triangle_surface import TriangleSurface, connected_parts, divided

LIFT = 0.06
"""Distance of lines from the surface, over the mean length of sides; it keeps the lines visible."""


@dataclass(frozen=True, eq=False)
class EndPlace:
    """A border, a line or a tip that has one time."""

    vertices: IntArray
    """Vertices of the surface along the place, shape (n,); a closed line repeats its first vertex, a tip is one
    vertex."""
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
    """Distance of each vertex along the fabric from where knitting begins [cm], shape (V,)."""
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
        """Positions a little outside the vertices, where lines are visible above the surface [cm], shape (V, 3)."""
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
    """Return the rows from which stitches were made."""
    return found_rows(shaped.surface, shaped.time, shaped.ends, shaping)


def found_rows(surface: TriangleSurface, courses: FloatArray, ends: Sequence[Ends], shaping: Shaping) -> FoundRows:
    """Return the rows of a time.

    Args:
        surface: the surface.
        courses: time of each vertex in courses, shape (V,).
        ends: the ends of each connected part.
        shaping: the options that gave the time; if no mark has a time, the smallest time becomes 0.
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
    root, other = ("begin", "end") if ends.begins else ("end", "begin")
    groups = (root, ends.roots), (other, (*ends.others, *ends.grafts)), ("row", ends.lines)
    return [(role, end.vertices) for role, group in groups for end in group]


def _place(surface: TriangleSurface, time: FloatArray, path: IntArray, role: str) -> EndPlace:
    """Return the place of some vertices in order; a whole border is a closed line."""
    closed = any(len(border) == len(path) and np.isin(path, border).all() for border in surface.borders)
    along = np.append(path, path[0]) if closed else path
    return EndPlace(along, role, float(time[path[0]]))


def _tips(surface: TriangleSurface, time: FloatArray, used: np.ndarray) -> list[EndPlace]:
    """Return the tips of closed limbs: vertices earlier or later than all around, outside borders and used places."""
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


FINDING_ROWS, FINDING_STITCHES = "finding the rows", "finding the stitches"
"""Names of the tasks."""
COARSE, FINE = 500.0, 1_500.0
"""Area of a surface over the square of the longest edge of its triangles: about 3,000 and 10,000 triangles."""
Stitches = tuple[ShapedFabric, FoundRows]
"""Stitches, and the rows from which they were made."""


class RowsFinder:
    """Finds rows and stitches of one mesh after another. All methods belong to the event thread."""

    def __init__(self, tasks: TaskRunner, on_found: Callable[[bool], object]) -> None:
        """Find nothing yet; ``on_found`` is called at the end of a search, with whether there are new stitches."""
        self._newest, self._on_found = NewestTask(tasks), on_found
        self.mesh: Mesh | None = None
        """The mesh."""
        self._forget()

    @property
    def running(self) -> str | None:
        """Name of the task that runs or waits; None without one."""
        work = self._newest.work
        return None if work is None else work.name

    @property
    def blocked_by(self) -> str | None:
        """Name of the work of another page that must end first; None if there is none."""
        return self._newest.blocked_by

    def take_mesh(self, mesh: Mesh) -> None:
        """Take a mesh, and forget the results for another one."""
        if mesh is not self.mesh:
            self.mesh = mesh
            self._forget()

    def knows(self, shaping: Shaping) -> bool:
        """Return whether the rows of a shaping, or the reason why there are none, are known."""
        return self._found_for == shaping

    def shaped(self, shaping: Shaping) -> ShapedFabric | None:
        """Return the stitches of a shaping; None before they are found."""
        return self._stitches if self._stitches is not None and self._stitches_for == shaping else None

    def find_rows(self, shaping: Shaping) -> None:
        """Find the rows, unless another page is at work."""
        mesh = self.mesh
        if mesh is None or self.blocked_by is not None:
            return
        self._newest.ask(
            Work(
                FINDING_ROWS, lambda control: preview(mesh, shaping, control),
                partial(self._take_rows, mesh, shaping), partial(self._take_frame, mesh),
            )
        )  # fmt: skip

    def find_stitches(self, shaping: Shaping) -> None:
        """Find the stitches.

        Raises:
            ParameterError: another page is at work.
        """
        mesh = self.mesh
        assert mesh is not None

        def find(control: TaskControl) -> Stitches:
            shaped = shaping.shape(mesh, control.progress)
            return shaped, rows_of_fabric(shaped, shaping)

        self._newest.ask(Work(FINDING_STITCHES, find, partial(self._take_stitches, mesh, shaping)))

    def stop(self) -> None:
        """End the search."""
        self._newest.stop()

    def _forget(self) -> None:
        self.found: FoundRows | None = None
        """The newest rows; None if there are none."""
        self.error = ""
        """Why the search found no rows or stitches; empty if it did."""
        self._found_for: Shaping | None = None
        self._stitches: ShapedFabric | None = None
        self._stitches_for: Shaping | None = None

    def _take_frame(self, mesh: Mesh, found: FoundRows) -> None:
        """Take the first rows, while the search finds better ones."""
        if mesh is self.mesh:
            self.found, self.error = found, ""
            self._on_found(False)

    def _take_rows(self, mesh: Mesh, shaping: Shaping, found: FoundRows | Refused | None) -> None:
        """Take the rows, or the reason why there are none; do nothing after a stopped search."""
        if self._take(mesh, shaping, found):
            self.found = found if isinstance(found, FoundRows) else None
        self._on_found(False)

    def _take_stitches(self, mesh: Mesh, shaping: Shaping, found: Stitches | Refused | None) -> None:
        """Take the stitches, or the reason why there are none; do nothing after a stopped search."""
        taken = self._take(mesh, shaping, found) and isinstance(found, tuple)
        if taken and isinstance(found, tuple):
            self._stitches, self.found = found
            self._stitches_for = shaping
        self._on_found(taken)

    def _take(self, mesh: Mesh, shaping: Shaping, found: object) -> bool:
        """Keep the shaping of a result, and its error; return whether the result belongs to the mesh."""
        if mesh is not self.mesh or found is None:
            return False
        self._found_for, self.error = shaping, found.reason if isinstance(found, Refused) else ""
        return True


def preview(mesh: Mesh, shaping: Shaping, control: TaskControl) -> FoundRows:
    """Find rows on large triangles, publish them as a frame, and return the rows on smaller triangles.

    Raises:
        StitchMeshError: the marks contradict each other. On large triangles, neighbouring marks may only seem to do so.
    """
    area = float(np.linalg.norm(mesh.face_vector_area, axis=1).sum())
    control.progress("shape", 0.0, "large triangles")
    coarse, fine = (max(EDGE_OVER_WIDTH * shaping.stitch_width, (area / count) ** 0.5) for count in (COARSE, FINE))
    if coarse > fine:
        try:
            control.frame(rows_on(mesh, shaping, coarse))
        except StitchMeshError:
            pass
    control.progress("shape", 0.2, "small triangles")
    return rows_on(mesh, shaping, fine)


def rows_on(mesh: Mesh, shaping: Shaping, longest_edge: float) -> FoundRows:
    """Find rows on triangles whose edges have at most a given length [cm].

    Raises:
        StitchMeshError: the marks contradict each other, or are off the surface.
    """
    knitted, _ = knitted_surface(mesh, StitchSize(shaping.stitch_width, shaping.height), shaping.marks)
    surface = divided(knitted, longest_edge)
    courses, ends = np.zeros(len(surface.vertices)), []
    parts = connected_parts(surface)
    for (part, vertices), marks in zip(parts, marks_by_part(parts, shaping.marks), strict=True):
        found = marked_ends(part, marks, np.array(shaping.up))
        courses[vertices], found = knitting_time(part, found, shaping.height)
        ends.append(found)
    return found_rows(surface, courses, ends, shaping)
