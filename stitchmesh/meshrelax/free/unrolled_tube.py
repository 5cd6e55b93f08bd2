# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Turns a round tube into a flat strip whose ends are joined, and the strip into a tube again.

All rows of the strip have the same girth, so that the tube stays a cylinder. A pattern is the same in all its repeats,
and a cylinder can be unrolled without any stretch.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stitchmesh.errors import MeshError
from stitchmesh.lattice import Lattice
from stitchmesh.mesh import StitchMesh

TURN = 2.0 * np.pi
"""A full turn [radians]."""


def unroll_tube(tube: StitchMesh) -> StitchMesh:
    """Return a round tube around the y axis as a strip in the plane z = 0, whose ends a lattice joins.

    Args:
        tube: stitch mesh in which each face takes less than half a turn.

    Raises:
        MeshError: the tube is on a lattice already.
    """
    if tube.lattice is not None:
        raise MeshError("tube: got a fabric on a lattice; expected one around the y axis")
    radius = float(np.hypot(tube.vertices[:, 0], tube.vertices[:, 2]).mean())
    angle = np.arctan2(tube.vertices[:, 0], tube.vertices[:, 2])
    corner = angle[tube.face_vertex]
    around = np.rint((corner[tube.face_start[:-1]][tube.side_face] - corner) / TURN).astype(np.int64)
    height = tube.vertices[:, 1]
    return replace(
        tube,
        vertices=np.stack([radius * angle, height, np.zeros_like(height)], axis=1),
        lattice=Lattice(np.array([[TURN * radius, 0.0, 0.0], [0.0, float(np.ptp(height)), 0.0]])),
        corner_image=np.stack([around, np.zeros_like(around)], axis=1),
    )


def roll_up(strip: StitchMesh) -> StitchMesh:
    """Return the round tube around the y axis of a strip (``unroll_tube``) whose first period lies along x."""
    assert strip.lattice is not None
    radius = float(strip.lattice.periods[0, 0]) / TURN
    angle = strip.vertices[:, 0] / radius
    points = np.stack([radius * np.sin(angle), strip.vertices[:, 1], radius * np.cos(angle)], axis=1)
    return replace(strip, vertices=points, lattice=None, corner_image=None)
