# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A sewn cloth put on bodies that it cuts at the start.

Panels that are placed round a body cut it, in armpits for example, and a garment may be narrower than what it is put
on. Rounds that spread the strain over the cloth (``cloth.starting_shape``) and rounds that move its vertices out of the
bodies (``start_outside``) follow one another, so that the cloth goes round the body with little strain. At the end all
contact points are moved out. Weight and bending have no part in it: a static equilibrium finds the rest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import warp as wp

from stitchmesh.compute.device import alone
from stitchmesh.mesh import FloatArray
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.cloth.starting_shape import RestEdges
from stitchmesh.mixed.contact.body import PlacedBody, SolidBody
from stitchmesh.mixed.contact.start_outside import ENOUGH, moved_outside, outward_move
from stitchmesh.mixed.contact.triangle_points import points_on_triangles

ROUNDS = 300
"""Rounds of spreading strain; an edge of 2 cm hears from places 50 cm away after about as many."""


@dataclass(frozen=True, eq=False)
class WornBody:
    """A body that a cloth is put on."""

    body: SolidBody
    clearance: float
    """Wanted distance of the cloth from its surface [cm]."""


@alone()
def dressed_vertices(
    cloth: Cloth, vertices: FloatArray, bodies: Sequence[WornBody], *, thickness: float, device: wp.Device,
    rounds: int = ROUNDS,
) -> FloatArray:  # fmt: skip
    """Return positions of a cloth outside of bodies at time 0 [cm], shape (V, 3); a cloth that is outside stays.

    Args:
        cloth: the cloth.
        vertices: positions of its vertices [cm], shape (V, 3).
        bodies: the bodies.
        thickness: thickness of the cloth in contact [cm].
        device: where distances are found.
        rounds: number of rounds.

    Raises:
        ParameterError: a clearance is not positive, or a part of the cloth finds no way out.
    """
    fine, coarse = (
        points_on_triangles(
            cloth.triangles, cloth.rest, cloth.panel, vertex_count=len(cloth.vertices), thickness=thickness,
            spacing=spacing,
        )[0]
        for spacing in (thickness, np.inf)
    )  # fmt: skip
    placed = [(PlacedBody(one.body, wp.float64, device), one.clearance) for one in bodies]
    distances = [outward_move(fine, vertices, body, clearance, device)[1] for body, clearance in placed]
    if all(found.min() >= ENOUGH * one.clearance for one, found in zip(bodies, distances, strict=True)):
        return vertices
    edges, moved = RestEdges.of(cloth), np.array(vertices, dtype=np.float64)
    for _ in range(rounds):
        moved += edges.evening_move(moved)
        for body, clearance in placed:
            moved += outward_move(coarse, moved, body, clearance, device)[0]
    for one in bodies:
        moved, _depth = moved_outside(fine, moved, one.body, one.clearance, device)
    return moved
