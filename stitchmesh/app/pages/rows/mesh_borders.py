# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The borders of a mesh, and the marks that name them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stitchmesh.app.project.shaping import Point
from stitchmesh.mesh import IntArray, Mesh
from stitchmesh.shaping.marks import TimeMark

AUTOMATIC = "automatic"
"""Role of a border without a mark."""
CYCLE = (AUTOMATIC, "begin", "end", "side")
"""Roles that clicks at a border give it, one after another."""


class MeshBorders:
    """The borders of one mesh, by number."""

    def __init__(self, mesh: Mesh) -> None:
        """Find the borders."""
        self.mesh = mesh
        self.loops: tuple[IntArray, ...] = mesh.boundary_loops
        """The sides along each border, in order."""

    @property
    def sides(self) -> IntArray:
        """The sides along all borders."""
        return np.concatenate([np.zeros(0, dtype=np.int64), *self.loops])

    def of_side(self, side: int) -> int:
        """Return the border to which a side belongs."""
        return next(number for number, loop in enumerate(self.loops) if side in loop)

    def point(self, number: int) -> Point:
        """Return the point by which a mark names a border [cm]: the first vertex along it."""
        x, y, z = self.mesh.corner_position[self.loops[number][0]].tolist()
        return x, y, z

    def nearest(self, point: Sequence[float]) -> int | None:
        """Return the border nearest to a point [cm], as a mark of a border means it; None if there is no border."""
        position, place = self.mesh.corner_position, np.asarray(point, dtype=np.float64)
        away = [float(np.linalg.norm(position[loop] - place, axis=1).min()) for loop in self.loops]
        return int(np.argmin(away)) if away else None

    def mark_of(self, marks: Sequence[TimeMark], number: int) -> int | None:
        """Return the number of the mark that names a border; None if no mark does."""
        for place, mark in enumerate(marks):
            if mark.kind == "border" and self.nearest(mark.points[0]) == number:
                return place
        return None

    def role_of(self, marks: Sequence[TimeMark], number: int) -> str:
        """Return the role that a mark gives a border."""
        mark = self.mark_of(marks, number)
        return AUTOMATIC if mark is None else marks[mark].role

    def words(self, number: int) -> str:
        """Say which border it is, by its length and its height above the lowest point of the mesh."""
        loop = self.loops[number]
        length = float(self.mesh.side_length[loop].sum())
        height = float(self.mesh.corner_position[loop, 1].mean() - self.mesh.vertices[:, 1].min())
        return f"border of {length:.0f} cm at height {height:.0f} cm"


def role_after(role: str) -> str:
    """Return the role that the next click at a border gives it."""
    return CYCLE[(CYCLE.index(role) + 1) % len(CYCLE)] if role in CYCLE else AUTOMATIC
