# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Puts a sewn cloth on bodies that it cuts at the start.

Panels that are placed round a body cut it, in the armpits for example, and a garment may be narrower than the body that
wears it. Two kinds of rounds follow one another: one spreads the strain over the cloth (``cloth.starting_shape``), the
other moves its vertices out of the bodies. The cloth then goes round the body with little strain. At the end all
contact points are moved out. Weight and bending have no part in it: a static equilibrium finds the rest.

A contact point that is inside, or nearer to the surface than a clearance, asks for a move along the direction to the
nearest place of the surface,

    m = (clearance - d) n,       d the signed distance, n its gradient

Each vertex moves by the mean of what its points ask for, weighted by their shares, until no point is left inside.
Triangles that this stretches contract in the first steps of the simulation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.device import alone
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import launch
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import FloatArray
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.cloth.starting_shape import RestEdges
from stitchmesh.mixed.contact.body import PlacedBody, SolidBody, to_body
from stitchmesh.mixed.contact.contact_points import ContactPoints, points_on_triangles
from stitchmesh.simulation.bodies.body_surface import ExactSurface, gap_to

OUTWARD_ROUNDS = 100
"""Largest number of moves."""
ENOUGH = 0.25
"""Part of the clearance at which a point may stay; reaching the full clearance would take many small moves."""
FAR = 1e15
"""A distance beyond the distance of any point [cm]."""
ROUNDS = 300
"""Rounds of spreading strain. In about as many rounds, strain spreads over 50 cm of edges that are 2 cm long."""


@kernel
def move_out(
    # model
    surface: ExactSurface,
    clearance: wp.float64,
    limit: wp.float64,
    # state in
    frame: wp.array[wp.mat33d],
    origin: wp.array[wp.vec3d],
    # state in and out
    place: wp.array[wp.vec3d],
    # state out
    distance: wp.array[wp.float64],
) -> None:
    """Move each place that is nearer than the clearance; its signed distance before."""
    i = wp.tid()
    here = to_body(frame[0], origin[0], place[i])
    gap = gap_to(surface, wp.vec4d(here[0], here[1], here[2], limit), limit)
    distance[i] = gap[3]
    if gap[3] < clearance:
        place[i] += frame[0] * wp.vec3d(gap[0], gap[1], gap[2]) * (clearance - gap[3])


@alone()
def moved_outside(
    points: ContactPoints, vertices: FloatArray, body: SolidBody, clearance: float, device: wp.Device
) -> tuple[FloatArray, float]:
    """Vertices of a cloth moved out of a body at time 0.

    Args:
        points: contact points on all triangles of the cloth (``points_on_triangles`` without weights).
        vertices: positions [cm], shape (V, 3).
        body: the body.
        clearance: wanted distance of the points from its surface [cm].
        device: where the distances are found.

    Returns:
        The positions [cm], shape (V, 3), and how deep the deepest point was inside [cm]; zero if no point was inside.

    Raises:
        ParameterError: the clearance is not positive, or a point finds no way out.
    """
    if not (np.isfinite(clearance) and clearance > 0.0):
        raise ParameterError(f"{body.name}: got a clearance of {clearance} cm; expected a positive number")
    placed = PlacedBody(body, wp.float64, device)
    moved, depth = np.array(vertices, dtype=np.float64), 0.0
    for round_number in range(OUTWARD_ROUNDS):
        move, distance = outward_move(points, moved, placed, clearance, device)
        least = float(distance.min(initial=clearance))
        depth = max(-least, 0.0) if round_number == 0 else depth
        if least >= ENOUGH * clearance:
            return moved, depth
        moved += move
    deep = int((distance < 0.0).sum())
    found = f"{deep} of {len(points)} points, up to {max(-least, 0.0):.3g} cm deep, find no way out"
    raise ParameterError(f"{body.name}: {found}; expected a cloth around it; place the cloth farther out")


def outward_move(
    points: ContactPoints, vertices: FloatArray, placed: PlacedBody, clearance: float, device: wp.Device
) -> tuple[FloatArray, FloatArray]:
    """Return the moves of the vertices out of a body in one round [cm], (V, 3), and the point distances now [cm], (M,).

    Args:
        points: contact points on triangles.
        vertices: positions [cm], shape (V, 3).
        placed: the body.
        clearance: wanted distance of the points from its surface [cm].
        device: where the distances are found.
    """
    before = points.places(vertices, np.zeros((points.node_count, 3)))
    place = wp.array(before, dtype=wp.vec3d, device=device)
    distance = wp.zeros(len(points), dtype=wp.float64, device=device)
    inputs = [placed.surface, wp.float64(clearance), wp.float64(FAR), placed.frame, placed.origin]
    launch(move_out, len(points), inputs, [place, distance], device)
    found = distance.numpy()
    return _mean_at_vertices(points, place.numpy() - before, found < clearance), found


def _mean_at_vertices(points: ContactPoints, wanted: FloatArray, near: NDArray[np.bool_]) -> FloatArray:
    """Mean of the wanted moves of the near points of each vertex, weighted by their shares, shape (V, 3)."""
    share = (points.share * near[:, None]).ravel()
    index = points.index.ravel()
    total = np.bincount(index, weights=share, minlength=points.vertex_count)
    sums = [
        np.bincount(index, weights=share * np.repeat(wanted[:, axis], 3), minlength=points.vertex_count)
        for axis in range(3)
    ]
    moves: FloatArray = np.stack(sums, axis=1) / np.maximum(total, 1e-12)[:, None]
    return moves


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
        points_on_triangles(cloth, thickness=thickness, spacing=spacing)[0] for spacing in (thickness, np.inf)
    )
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
