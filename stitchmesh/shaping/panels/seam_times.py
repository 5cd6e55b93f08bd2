# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Equal times at the two sides of a seam, so that rows go on from panel to panel.

Where the times of two panels along a seam differ by nearly the same number of courses everywhere, both take the mean of
the two, and the difference becomes a whole number.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.shaping.panels.outline_pieces import SIDE, OutlinePiece
from stitchmesh.shaping.panels.panel_time import PanelTime, refined_line

LARGEST_CHANGE = 2.0
"""Deviation of the difference of two times from a whole number, in courses, up to which they are made equal."""


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
        """The time minus that of the other side, which runs the other way, at each vertex."""
        difference: FloatArray = self.courses - np.interp(1.0 - self.place, other.place, other.courses)
        return difference

    def differs_evenly(self, other: _Side) -> bool:
        """Whether the times of the two sides differ by nearly one whole number."""
        difference = self.differences(other)
        return bool(np.abs(difference - np.rint(np.median(difference))).max() <= LARGEST_CHANGE)

    def mean_with(self, other: _Side) -> dict[int, float]:
        """Return the mean time of both sides at each vertex, up to a whole number."""
        difference = self.differences(other)
        mean = self.courses - 0.5 * (difference - np.rint(np.median(difference)))
        return dict(zip(self.vertices.tolist(), mean.tolist(), strict=True))
