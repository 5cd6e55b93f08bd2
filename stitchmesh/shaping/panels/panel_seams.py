# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The two sides of a seam: equal times, so that rows go on from panel to panel, and a gap between their yarns.

Where the times of two panels along a seam differ by nearly the same number of courses everywhere, both take the mean of
the two, and the difference becomes a whole number.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import BORDER, FloatArray, IntArray, Mesh
from stitchmesh.shaping.level_lines import LevelLine
from stitchmesh.shaping.panels.outline_pieces import ENDS, SIDE, OutlinePiece
from stitchmesh.shaping.panels.panel_time import PanelTime, refined_line

SIDE_GAP = 0.5
"""Distance by which a border is drawn back from a seam, in stitch widths."""
TOP_GAP = 0.7
"""The same distance for a border at which rows end and loops are bound off."""


def gap_at(piece: OutlinePiece, width: float) -> float:
    """Return the distance by which a border is drawn back from a piece of an outline, if it is sewn [cm]."""
    return width * (TOP_GAP if piece.kind == ENDS else SIDE_GAP)


def drawn_back(mesh: Mesh, sides: IntArray, distance: FloatArray) -> FloatArray:
    """Return the vertices of a mesh after parts of its borders were moved inwards along the surface [cm], shape (V, 3).

    Args:
        mesh: the mesh.
        sides: border sides to move, shape (n,).
        distance: length of the motion of each side [cm], shape (n,).
    """
    ends = mesh.face_vertex[sides], mesh.face_vertex[mesh.side_next[sides]]
    step = mesh.vertices[ends[1]] - mesh.vertices[ends[0]]
    inwards = np.cross(mesh.face_vector_area[mesh.side_face[sides]], step)
    length = np.maximum(np.linalg.norm(inwards, axis=1), np.finfo(np.float64).tiny)
    motion, count = np.zeros_like(mesh.vertices), np.zeros(len(mesh.vertices))
    for vertices in ends:
        np.add.at(motion, vertices, (distance / length)[:, None] * inwards)
        np.add.at(count, vertices, 1)
    return mesh.vertices + motion / np.maximum(count, 1)[:, None]


def sides_on_seams(
    fabric: Mesh, face_panel: IntArray, pieces: list[OutlinePiece], lines: list[LevelLine], reach: float
) -> tuple[IntArray, IntArray]:
    """Find the border sides of stitches that lie on a piece of an outline that is sewn to another one.

    Args:
        fabric: the stitches.
        face_panel: panel of each stitch, shape (F,).
        pieces: pieces of the outlines of the panels.
        lines: the same pieces as lines.
        reach: distance from an outline up to which a side lies on it [cm].

    Returns:
        The sides, and the number of the piece of each, both of shape (n,).
    """
    border = np.flatnonzero(fabric.twin == BORDER)
    ends = fabric.face_vertex[np.stack([border, fabric.side_next[border]])]
    own: dict[int, list[int]] = {}
    for number, piece in enumerate(pieces):
        own.setdefault(piece.panel, []).append(number)
    found = []
    for side, middle in zip(border.tolist(), fabric.vertices[ends].mean(axis=0), strict=True):
        near = own[int(face_panel[fabric.side_face[side]])]
        apart, nearest = min((lines[number].nearest(middle)[1], number) for number in near)
        if apart <= reach and pieces[nearest].partner >= 0:
            found.append((side, nearest))
    sides, on_piece = np.array(found, dtype=np.int64).reshape(-1, 2).T
    return sides, on_piece


def with_equal_seams(times: list[PanelTime], pieces: list[OutlinePiece]) -> list[PanelTime]:
    """Make the times of panels at their seams equal, up to whole numbers of courses.

    Args:
        times: time of each panel.
        pieces: pieces of the outlines of the panels.
    """
    known: list[dict[int, float]] = [{} for _ in times]
    for number, piece in enumerate(pieces):
        if piece.partner <= number or piece.kind != SIDE or pieces[piece.partner].kind != SIDE:
            continue
        sides = [_Side.of(times[one.panel], one) for one in (piece, pieces[piece.partner])]
        if sides[0].differs_evenly(sides[1]):
            for one, other in (sides, sides[::-1]):
                known[one.panel].update(one.mean_with(other))
    return [time.with_times(values) for time, values in zip(times, known, strict=True)]


class _Side:
    """The time along one side of a seam."""

    def __init__(self, panel: int, vertices: IntArray, place: FloatArray, courses: FloatArray) -> None:
        self.panel, self.vertices, self.place, self.courses = panel, vertices, place, courses

    @classmethod
    def of(cls, time: PanelTime, piece: OutlinePiece) -> _Side:
        """Return the time along a piece of an outline."""
        vertices = refined_line(time.refined, [piece])
        points = time.refined.surface.vertices[vertices]
        place = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
        return cls(piece.panel, vertices, place / place[-1], time.courses[vertices])

    def differences(self, other: _Side) -> FloatArray:
        """The time of this side minus the time of the other side, which runs the other way, at each vertex."""
        difference: FloatArray = self.courses - np.interp(1.0 - self.place, other.place, other.courses)
        return difference

    def differs_evenly(self, other: _Side) -> bool:
        """Whether the times of the two sides differ by nearly one whole number."""
        difference = self.differences(other)
        # Two times become equal if their difference deviates from a whole number by at most this, in courses.
        return bool(np.abs(difference - np.rint(np.median(difference))).max() <= 2.0)

    def mean_with(self, other: _Side) -> dict[int, float]:
        """Return the mean time of both sides at each vertex, up to a whole number."""
        difference = self.differences(other)
        mean = self.courses - 0.5 * (difference - np.rint(np.median(difference)))
        return dict(zip(self.vertices.tolist(), mean.tolist(), strict=True))
