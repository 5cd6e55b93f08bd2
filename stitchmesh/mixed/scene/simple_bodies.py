# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Balls, boxes and bending arms as closed meshes.

An arm that bends at its elbow is a tube with round ends around a line that is straight, then an arc, then straight. At
rest the elbow is the origin, the upper arm points along y, and the forearm along -y; a bend turns the forearm towards
z. With the length L of the elbow and the angle phi of the bend, the tangent of the line at the distance s from the
middle of the elbow, towards the hand, is

    (0, -cos psi, sin psi),     psi = phi (s / L + 1/2), between 0 and phi

The arc is as long as the straight elbow was: the skin on its outside is stretched and the skin on its inside is
compressed, without a fold up to the angle L / R of a tube of radius R.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray, Mesh
from stitchmesh.mixed.output.loop_subdivision import loop_subdivision

BALL_ROUNDS = 4
"""How often the faces of an octahedron are divided into four; a quarter of a circle has 16 edges."""
OCTAHEDRON = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], dtype=np.float64)
OCTANTS = [[x, y, z] if (x + y + z) % 2 == 0 else [x, z, y] for x in (0, 1) for y in (2, 3) for z in (4, 5)]
"""Faces of the octahedron, outwards."""
QUADS = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
"""Faces of a box, outwards; corners 0 to 3 are the lower ring."""
SIDES = 24
"""Number of sides of the tube; its rings are as far apart as its edges are long."""
ELBOW = 2.6
"""Length of the elbow, over the radius."""
LONGEST = 300.0
"""Largest length of a part, over the radius."""
LARGEST_BEND = 140.0
"""Largest bend [degrees]; as an angle in radians it is somewhat below ``ELBOW``."""


def ball(radius: float, centre: ArrayLike) -> Mesh:
    """Return a ball of triangles whose corners lie on the sphere."""
    divided = loop_subdivision(OCTANTS, len(OCTAHEDRON), BALL_ROUNDS)
    points = divided.linear @ OCTAHEDRON
    directions = points / np.linalg.norm(points, axis=1, keepdims=True)
    return Mesh.from_polygons(radius * directions + np.asarray(centre), divided.triangles.tolist())


def box(size: ArrayLike, centre: ArrayLike) -> Mesh:
    """Return a box of six faces."""
    ring = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
    corners = np.concatenate([np.column_stack([ring, np.full(4, z)]) for z in (-0.5, 0.5)])
    return Mesh.from_polygons(corners * np.asarray(size) + np.asarray(centre), QUADS)


def check_bend(bend: float) -> None:
    """Check the bend of an arm [degrees].

    Raises:
        ParameterError: the bend is negative or too large.
    """
    if not 0.0 <= bend <= LARGEST_BEND:
        raise ParameterError(f"arm: got a bend of {bend} degrees; expected 0 to {LARGEST_BEND:g}")


@dataclass(frozen=True)
class Arm:
    """The measures of an arm.

    Raises:
        ParameterError: a part is shorter than half of the elbow, or longer than ``LONGEST`` radii.
    """

    radius: float
    """Radius R of both parts [cm]."""
    upper: float
    """Length of the upper arm from the middle of the elbow [cm]."""
    forearm: float
    """Length of the forearm from the middle of the elbow [cm]."""

    def __post_init__(self) -> None:
        least = 0.5 * ELBOW * self.radius
        if min(self.upper, self.forearm) < least:
            found = f"got parts of {self.upper:g} and {self.forearm:g} cm"
            raise ParameterError(f"arm: {found}; expected at least {least:.3g} cm, half of the elbow of this radius")
        most = LONGEST * self.radius
        if max(self.upper, self.forearm) > most:
            found = f"got parts of {self.upper:g} and {self.forearm:g} cm"
            raise ParameterError(f"arm: {found}; expected at most {most:.3g} cm, {LONGEST:g} times the radius")

    def mesh(self) -> Mesh:
        """Return the straight arm as a closed mesh."""
        return Mesh.from_polygons(self.vertices(0.0), list(self._faces()))

    def vertices(self, bend: float) -> FloatArray:
        """Return the vertices of the arm with a bend [degrees], the elbow at the origin [cm], shape (V, 3).

        Raises:
            ParameterError: the bend is negative or too large.
        """
        check_bend(bend)
        along, radius = self._rings()
        middle, outwards = self._line(along, np.radians(bend))
        turn = 2.0 * np.pi * np.arange(SIDES) / SIDES
        ring = np.cos(turn)[:, None] * [1.0, 0.0, 0.0] + np.sin(turn)[:, None] * outwards[:, None, :]
        tube = (middle[:, None, :] + radius[:, None, None] * ring).reshape(-1, 3)
        ends, _ = self._line(np.array([-self.upper - self.radius, self.forearm + self.radius]), np.radians(bend))
        vertices: FloatArray = np.concatenate([tube, ends])
        return vertices

    def _rings(self) -> tuple[FloatArray, FloatArray]:
        """Distances of the rings from the middle of the elbow towards the hand, and their radii [cm]."""
        edge = 2.0 * np.pi * self.radius / SIDES
        count = int(np.ceil((self.upper + self.forearm) / edge))
        angle = np.linspace(0.0, 0.5 * np.pi, SIDES // 4 + 1)[1:-1]
        cap, shrunk = self.radius * np.sin(angle), self.radius * np.cos(angle)
        straight = np.linspace(-self.upper, self.forearm, count + 1)
        along = np.concatenate([-self.upper - cap[::-1], straight, self.forearm + cap])
        return along, np.concatenate([shrunk[::-1], np.full(len(straight), self.radius), shrunk])

    def _line(self, along: FloatArray, bend: float) -> tuple[FloatArray, FloatArray]:
        """Points of the line, and the directions across it towards z, for distances along it; both (n, 3)."""
        length = ELBOW * self.radius
        inside = np.clip(along, -0.5 * length, 0.5 * length) + 0.5 * length
        psi = bend * inside / length
        # sin(psi) / psi and (1 - cos(psi)) / psi without a division by zero
        forward = np.sinc(psi / np.pi)
        sideways = 0.5 * psi * np.sinc(0.5 * psi / np.pi) ** 2
        beyond = along + 0.5 * length - inside
        down = inside * forward + beyond * np.cos(psi)
        across = inside * sideways + beyond * np.sin(psi)
        nothing = np.zeros_like(along)
        points = np.stack([nothing, 0.5 * length - down, across], axis=1)
        return points, np.stack([nothing, np.sin(psi), np.cos(psi)], axis=1)

    def _faces(self) -> Iterator[list[int]]:
        count = len(self._rings()[0])
        first, last = count * SIDES, count * SIDES + 1
        following = [(side, (side + 1) % SIDES) for side in range(SIDES)]
        for ring, other in pairwise(range(0, count * SIDES, SIDES)):
            yield from ([ring + a, ring + b, other + b, other + a] for a, b in following)
        end = (count - 1) * SIDES
        for a, b in following:
            yield [first, b, a]
            yield [last, end + a, end + b]
