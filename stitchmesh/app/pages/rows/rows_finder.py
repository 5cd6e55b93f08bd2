# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Finds rows and stitches on a mesh in a worker thread, and keeps what was found last.

Rows without their stitches take a fraction of the time. They are found first on large triangles, then on smaller ones.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from stitchmesh.app.newest_task import NewestTask, Refused, Work
from stitchmesh.app.pages.rows.found_rows import FoundRows, found_rows, rows_of_fabric
from stitchmesh.app.project.shaping import Shaping
from stitchmesh.app.task import TaskControl, TaskRunner
from stitchmesh.errors import StitchMeshError
from stitchmesh.mesh import Mesh
from stitchmesh.shaping.auto_stitches import EDGE_OVER_WIDTH, ShapedFabric, marks_by_part
from stitchmesh.shaping.counts import StitchSize
from stitchmesh.shaping.finer_than_stitches import knitted_surface
from stitchmesh.shaping.marks import marked_ends
from stitchmesh.shaping.time_function import knitting_time
from stitchmesh.shaping.triangle_surface import connected_parts, divided

FINDING_ROWS, FINDING_STITCHES = "finding the rows", "finding the stitches"
"""Names of the tasks."""
COARSE, FINE = 500.0, 1_500.0
"""Area of a surface over the square of the longest edge of its triangles: about 3,000 and 10,000 triangles."""
Stitches = tuple[ShapedFabric, FoundRows]
"""Stitches, and the rows that they were made of."""


class RowsFinder:
    """Rows and stitches of one mesh after another. All methods belong to the event thread."""

    def __init__(self, tasks: TaskRunner, on_found: Callable[[bool], object]) -> None:
        """Find nothing yet.

        Args:
            tasks: runs the work.
            on_found: called when something was found or the search has ended, with whether there are new stitches.
        """
        self._newest, self._on_found = NewestTask(tasks), on_found
        self.mesh: Mesh | None = None
        """The mesh."""
        self._forget()

    @property
    def running(self) -> str | None:
        """Name of the task that runs or waits; None if none does."""
        work = self._newest.work
        return None if work is None else work.name

    @property
    def blocked_by(self) -> str | None:
        """What another page does, which must end first; None if there is nothing."""
        return self._newest.blocked_by

    def take_mesh(self, mesh: Mesh) -> None:
        """Take a mesh; what was found on another one is forgotten."""
        if mesh is not self.mesh:
            self.mesh = mesh
            self._forget()

    def knows(self, shaping: Shaping) -> bool:
        """Whether the rows of a shaping, or the reason why there are none, are known."""
        return self._found_for == shaping

    def shaped(self, shaping: Shaping) -> ShapedFabric | None:
        """Return the stitches of a shaping; None if they have not been found."""
        return self._stitches if self._stitches is not None and self._stitches_for == shaping else None

    def find_rows(self, shaping: Shaping) -> None:
        """Find the rows, unless another page does something."""
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
            ParameterError: another page does something.
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
        """The rows that were found last; None if there are none."""
        self.error = ""
        """Why no rows or stitches could be found; empty if they were."""
        self._found_for: Shaping | None = None
        self._stitches: ShapedFabric | None = None
        self._stitches_for: Shaping | None = None

    def _take_frame(self, mesh: Mesh, found: FoundRows) -> None:
        """Take the first rows, while better ones are found."""
        if mesh is self.mesh:
            self.found, self.error = found, ""
            self._on_found(False)

    def _take_rows(self, mesh: Mesh, shaping: Shaping, found: FoundRows | Refused | None) -> None:
        """Take the rows, or the reason why there are none; nothing where the search was stopped."""
        if self._take(mesh, shaping, found):
            self.found = found if isinstance(found, FoundRows) else None
        self._on_found(False)

    def _take_stitches(self, mesh: Mesh, shaping: Shaping, found: Stitches | Refused | None) -> None:
        """Take the stitches, or the reason why there are none; nothing where the search was stopped."""
        taken = self._take(mesh, shaping, found) and isinstance(found, tuple)
        if taken and isinstance(found, tuple):
            self._stitches, self.found = found
            self._stitches_for = shaping
        self._on_found(taken)

    def _take(self, mesh: Mesh, shaping: Shaping, found: object) -> bool:
        """Keep for what something was found, and the error; return whether it belongs to the mesh."""
        if mesh is not self.mesh or found is None:
            return False
        self._found_for, self.error = shaping, found.reason if isinstance(found, Refused) else ""
        return True


def preview(mesh: Mesh, shaping: Shaping, control: TaskControl) -> FoundRows:
    """Find rows on large triangles, publish them as a frame, and return those on smaller triangles.

    Raises:
        StitchMeshError: the marks contradict each other; on large triangles neighbouring marks may only seem to.
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
    """Find rows on triangles whose edges are at most so long [cm].

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
