# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Runs of a region with new faces, made in one change of the mesh.

A run keeps the loops below it and above it, and the wale edges at its two ends. All its faces are new, and so are its
increases and decreases. A course line between two rebuilt runs may be divided into another number of loops.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import BORDER, FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.change import UNKNOWN_STRETCH, Patch, stretch_at, vertices_left
from stitchmesh.mesh.courses import Course, bottom_sides, top_sides
from stitchmesh.mesh.renumbering import Renumbering
from stitchmesh.mesh.shaping_stitches import closing_half_turns
from stitchmesh.mesh.stitch import Stitch


@dataclass(frozen=True, eq=False)
class CourseLine:
    """The loops of a course line along a run, from left to right."""

    loops: IntArray
    """Side of each loop as the run sees it, shape (n,); the numbers of new loops follow those of the sides."""
    vertices: IntArray
    """Ends of the loops; the numbers of new vertices follow those of the vertices, shape (n + 1,)."""


@dataclass(frozen=True, eq=False)
class RunPlan:
    """A run, and its new faces."""

    run: Course
    """The run; a closed run may start with any of its faces."""
    below: CourseLine
    """The loops below the run."""
    above: CourseLine
    """The loops above the run."""
    loops: IntArray
    """Numbers of loops below and above each new face, left to right, shape (n, 2)."""
    stitch: IntArray
    """Type of each new face, shape (n,); a plain face keeps the type of the plain face that was in its place."""


@dataclass(frozen=True, eq=False)
class Rebuilt:
    """A patch that makes the faces of runs anew, with their numbers."""

    patch: Patch
    """The patch."""
    faces: Renumbering
    """Numbers of all faces before and after the patch."""


def line_below(fabric: StitchMesh, run: Course) -> CourseLine:
    """Return the course line below a run."""
    sides = np.array(bottom_sides(fabric, run.faces), dtype=np.int64)
    last = fabric.face_vertex[fabric.right_wale[run.faces[-1]]]
    return CourseLine(sides, np.append(fabric.face_vertex[sides], last))


def line_above(fabric: StitchMesh, run: Course) -> CourseLine:
    """Return the course line above a run."""
    sides = np.array(top_sides(fabric, run.faces), dtype=np.int64)
    first = fabric.face_vertex[fabric.left_wale[run.faces[0]]]
    return CourseLine(sides, np.concatenate([[first], fabric.face_vertex[sides]]))


def rebuild_runs(fabric: StitchMesh, plans: Sequence[RunPlan], positions: FloatArray) -> Rebuilt:
    """Return the patch that makes the faces of runs anew, and the numbers of all faces before and after it.

    Args:
        fabric: stitch mesh.
        plans: the runs.
        positions: positions of the new vertices [cm], shape (m, 3).
    """
    removed = np.sort(np.concatenate([plan.run.faces for plan in plans])).astype(np.int64)
    face = Renumbering.filling(fabric.face_count, removed, sum(len(plan.loops) for plan in plans))
    sides = _Sides(fabric, plans)
    corners = np.concatenate([_corners(plan) for plan in plans])
    count = len(fabric.vertices)
    gone = vertices_left(fabric, removed, corners[corners < count])
    vertex = Renumbering.filling(count, gone, len(positions))
    loops = np.concatenate([plan.loops for plan in plans])
    old = np.concatenate([_old_faces(fabric, plan) for plan in plans])
    stitch = np.concatenate([plan.stitch for plan in plans])
    patch = Patch(
        removed_faces=removed,
        removed_vertices=gone,
        added_faces=face.added,
        added_vertices=vertex.added,
        positions=positions,
        face_size=loops.sum(axis=1) + 2,
        corners=np.concatenate([vertex.after, vertex.added])[corners],
        twin=sides.twins(face),
        faces={
            "n_bottom": loops[:, 0],
            "n_top": loops[:, 1],
            "stitch": np.where(_stays_plain(fabric, loops, old), fabric.stitch[old], stitch),
            "row": fabric.row[old],
            "yarn": fabric.yarn[old],
        },
        sides={
            "twist": sides.half_turns(loops, stitch),
            **{name: sides.marks(name) for name in ("cable_shift", "cable_layer")},
        },
        stretch=sides.stretch(),
    )
    return Rebuilt(patch, face)


def _stays_plain(fabric: StitchMesh, loops: IntArray, old: IntArray) -> NDArray[np.bool_]:
    """Return whether each new face and the nearest old face both have one loop below and one above, shape (n,)."""
    plain: NDArray[np.bool_] = (loops == 1).all(axis=1) & (fabric.n_bottom[old] == 1) & (fabric.n_top[old] == 1)
    return plain


def _places(loops: IntArray) -> tuple[IntArray, IntArray, IntArray, IntArray]:
    """Return for each side its face, its place there, and the loops left of the face below and above, shape (c,)."""
    size = loops.sum(axis=1) + 2
    face = np.repeat(np.arange(len(loops)), size)
    place = np.arange(size.sum()) - np.repeat(np.cumsum(size) - size, size)
    first = np.cumsum(loops, axis=0) - loops
    return face, place, first[face, 0], first[face, 1]


def _corners(plan: RunPlan) -> IntArray:
    face, place, below, above = _places(plan.loops)
    bottom, top = plan.loops[face].T
    low = plan.below.vertices[np.where(place <= bottom, below + place, 0)]
    high = plan.above.vertices[np.where(place > bottom, above + top + bottom + 1 - place, 0)]
    return np.where(place <= bottom, low, high)


def _old_faces(fabric: StitchMesh, plan: RunPlan) -> IntArray:
    """Return the old face of the run that is nearest to each new face, by its share of the run's width."""
    middle = (np.cumsum(plan.loops, axis=0) - plan.loops / 2.0).sum(axis=1) / plan.loops.sum()
    faces = np.array(plan.run.faces)
    wide = fabric.n_bottom[faces] + fabric.n_top[faces]
    return faces[np.minimum(np.searchsorted(np.cumsum(wide) / wide.sum(), middle), len(faces) - 1)]


class _Sides:
    """The sides of all new faces."""

    def __init__(self, fabric: StitchMesh, plans: Sequence[RunPlan]) -> None:
        self.fabric = fabric
        loop: list[IntArray] = []
        is_top, right, left, outer, face_of, place_of, first = [], [], [], [], [], [], 0
        for plan in plans:
            face, place, below, above = _places(plan.loops)
            bottom, top = plan.loops[face].T
            own = np.full(len(face), BORDER)
            low, high = place < bottom, (place > bottom) & (place <= bottom + top)
            own[low] = plan.below.loops[(below + place)[low]]
            own[high] = plan.above.loops[(above + top + bottom - place)[high]]
            ends = np.cumsum(plan.loops.sum(axis=1) + 2)
            rights, lefts = ends - 2 - plan.loops[:, 1], ends - 1
            offset = sum(len(part) for part in loop)
            inner = slice(None) if plan.run.closed else slice(0, len(ends) - 1)
            right.append(offset + rights[inner])
            left.append(offset + np.roll(lefts, -1)[inner])
            if not plan.run.closed:
                faces = plan.run.faces
                outer.append((int(fabric.left_wale[faces[0]]), offset + int(lefts[0])))
                outer.append((int(fabric.right_wale[faces[-1]]), offset + int(rights[-1])))
            loop.append(own)
            is_top.append(high)
            face_of.append(first + face)
            place_of.append(place)
            first += len(plan.loops)
        self.loop, self.is_top = np.concatenate(loop), np.concatenate(is_top)
        self.face, self.place = np.concatenate(face_of), np.concatenate(place_of)
        self.right, self.left = np.concatenate(right), np.concatenate(left)
        self.outer = np.array(outer, dtype=np.int64).reshape(-1, 2)

    def twins(self, face: Renumbering) -> IntArray:
        """Return the twin of each new side, as in ``Patch.twin``."""
        fabric = self.fabric
        new_of = np.full(fabric.side_count, BORDER)  # the new side in the place of each old side
        known = (self.loop != BORDER) & (self.loop < fabric.side_count)
        new_of[self.loop[known]] = np.flatnonzero(known)
        new_of[self.outer[:, 0]] = self.outer[:, 1]
        old = np.where(known, self.loop, BORDER)
        old[self.outer[:, 1]] = self.outer[:, 0]
        across = np.where(old == BORDER, BORDER, fabric.twin[old])
        new = np.where(across == BORDER, BORDER, new_of[across])
        new[self.right], new[self.left] = self.left, self.right
        made = np.flatnonzero(self.loop >= fabric.side_count)
        pairs = made[np.argsort(self.loop[made], kind="stable")].reshape(-1, 2)
        new[pairs] = pairs[:, ::-1]
        stays = np.stack([face.after[fabric.side_face[across]], fabric.side_place[across]], axis=1)
        stays[across == BORDER] = BORDER
        inner = np.stack([face.added[self.face[new]], self.place[new]], axis=1)
        return np.where((new == BORDER)[:, None], stays, inner)

    def marks(self, name: str) -> IntArray:
        """Return a mark of all new sides: the mark of the old loop, and 0 for a new loop."""
        kept = self.is_top & (self.loop < self.fabric.side_count)
        values: IntArray = np.where(kept, getattr(self.fabric, name)[np.where(kept, self.loop, 0)], 0)
        return values

    def half_turns(self, loops: IntArray, stitch: IntArray) -> IntArray:
        """Return the half turn at each new side: of a new increase, or of the old loop if no increase made it.

        Args:
            loops: numbers of loops below and above each new face, shape (n, 2).
            stitch: type of each new face, shape (n,).
        """
        values = self.marks("twist")
        maker = self.fabric.side_face[np.where(self.loop < self.fabric.side_count, self.loop, 0)]
        values[self.fabric.n_top[maker] > 1] = 0
        last_side = np.cumsum(loops.sum(axis=1) + 2) - 1
        for face in np.flatnonzero(loops[:, 1] > 1):
            for loop, turn in enumerate(closing_half_turns(Stitch(stitch[face]))):
                values[last_side[face] - 1 - loop] = turn
        return values

    def stretch(self) -> FloatArray:
        """Return the stretch at all new sides."""
        old = np.where(self.loop < self.fabric.side_count, self.loop, BORDER)
        old[self.outer[:, 1]] = self.outer[:, 0]
        return np.where(old == BORDER, UNKNOWN_STRETCH, stretch_at(self.fabric, np.maximum(old, 0)))


MOST_LOOPS = 3
"""Largest number of loops below or above one stitch."""


def spread_loops(below: int, above: int, at: Sequence[int] | None = None) -> IntArray:
    """Return the numbers of loops below and above each face of a run with as few increases or decreases as possible.

    Args:
        below: number of loops below the run.
        above: number of loops above the run.
        at: places on the narrower side, in loops, where the wider side has one loop more; None for even places.

    Returns:
        The numbers, shape (n, 2).
    """
    narrow, more = min(below, above), abs(below - above)
    places = [int((number + 0.5) * narrow / more) for number in range(more)] if at is None else at
    further = np.zeros(narrow, dtype=np.int64)
    for place in places:
        free = np.flatnonzero(further == further.min())
        further[free[np.argmin(np.abs(free - place))]] += 1
    faces = np.ones((narrow, 2), dtype=np.int64)
    faces[:, int(above > below)] += further
    return faces
