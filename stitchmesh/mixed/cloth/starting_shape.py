# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A starting shape in which the strain of a sewn cloth is spread over its panels.

Panels that are placed in space apart from one another, such as the front and the back of a shirt, are sewn together at
the mean of their borders. All strain is then in the triangles at the seams, which may be stretched tenfold. In each
round every edge asks both of its ends to move by half of the length that it has too much or too little, and each vertex
moves by the mean of what its edges ask for (position-based dynamics without velocities, Mueller et al. 2007, with the
averages of Macklin et al. 2014). Weight, bending and bodies have no part in it: a static equilibrium finds the rest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import BORDER, FloatArray, IntArray
from stitchmesh.mixed.cloth.cloth import Cloth


@dataclass(frozen=True, eq=False)
class RestEdges:
    """The edges of a cloth and their lengths at rest."""

    ends: IntArray
    """Vertices of each edge, shape (E, 2)."""
    length: FloatArray
    """Length at rest [cm], shape (E,); on a seam the mean of the lengths in both panels."""
    share: FloatArray
    """Factor of the sum of what the edges of a vertex ask for, by which the vertex moves, shape (V, 1)."""

    @staticmethod
    def of(cloth: Cloth) -> RestEdges:
        """Return the edges of a cloth."""
        ends, length = _edges(cloth)
        count = np.bincount(ends.ravel(), minlength=len(cloth.vertices))
        # over-relaxation by 1.5; below 2 the rounds converge (Macklin et al. 2014)
        return RestEdges(ends, length, 1.5 / np.maximum(count, 1)[:, None])

    def evening_move(self, vertices: FloatArray) -> FloatArray:
        """Return how the vertices move in one round [cm], shape (V, 3).

        Args:
            vertices: positions of the vertices [cm], shape (V, 3).
        """
        span = vertices[self.ends[:, 1]] - vertices[self.ends[:, 0]]
        now = np.maximum(np.linalg.norm(span, axis=1), 1e-12)  # a shorter edge has no direction
        pull = span * (0.5 * (1.0 - self.length / now))[:, None]
        asked, index = np.concatenate([pull, -pull]), self.ends.T.ravel()
        total = [np.bincount(index, weights=asked[:, axis], minlength=len(vertices)) for axis in range(3)]
        move: FloatArray = self.share * np.stack(total, axis=1)
        return move


def evened_vertices(cloth: Cloth, *, rounds: int = 500) -> FloatArray:
    """Return positions of the vertices with the strain spread over the panels [cm], shape (V, 3).

    Args:
        cloth: the cloth, which stays as it is.
        rounds: number of rounds.

    Raises:
        ParameterError: the number of rounds is negative.
    """
    checked_rounds(rounds)
    edges, vertices = RestEdges.of(cloth), cloth.vertices.copy()
    for _ in range(rounds):
        vertices += edges.evening_move(vertices)
    return vertices


def checked_rounds(rounds: int) -> int:
    """Return a number of rounds.

    Raises:
        ParameterError: the number is negative.
    """
    if rounds < 0:
        raise ParameterError(f"rounds of evening out: got {rounds}; expected a number of at least 0")
    return rounds


def _edges(cloth: Cloth) -> tuple[IntArray, FloatArray]:
    """Vertices of all edges, and their length at rest [cm]: on a seam the mean of the lengths in both panels."""
    rest = np.linalg.norm(cloth.side_rest[:, 1] - cloth.side_rest[:, 0], axis=1)
    first = np.flatnonzero((cloth.twin == BORDER) | (cloth.twin > np.arange(len(cloth.twin))))
    across = np.where(cloth.twin[first] == BORDER, first, cloth.twin[first])
    return cloth.side_vertices[first], (rest[first] + rest[across]) / 2
