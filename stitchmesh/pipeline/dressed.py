# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Puts a knitted garment on bodies that its yarns cut, before the yarns are relaxed.

The stitches go round the bodies as the cloth of a scene does (``mixed.contact.dressing``): their triangles are moved
out, and the strain spreads over the garment. The given shape of the garment is its shape at rest. The yarns are carried
along: each control point keeps its foot on its stitch and its height above it (``mixed.layout.spline_yarns``).
The stitches keep away from a body by the reach of its contact and by the height of the yarns, so that the yarns begin
outside.

A map that carries points with a surface takes no yarn through another one as long as the surface does not fold. The
linking of the yarns is compared nevertheless. Where a limb of a body goes through the garment, as the arms of a
standing body go through a poncho, no small move takes the stitches round the limb. They would be drawn out, so the
garment is refused.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stitchmesh.compute.device import device_named
from stitchmesh.errors import ParameterError
from stitchmesh.linking.certificate import refuse_pull_through
from stitchmesh.mesh import FloatArray, StitchMesh
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.cloth.from_stitches import stitch_triangles
from stitchmesh.mixed.contact.body import SolidBody
from stitchmesh.mixed.contact.dressing import WornBody, dressed_vertices
from stitchmesh.mixed.layout.spline_yarns import lay_splines
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.energies.body import Body
from stitchmesh.yarnrelax.evaluate import body_distance

MOST_HEIGHTS = 0.95
"""The heights above the stitches of this part of the control points count; the other points are tails and floats."""
MOST_STRETCH = 2.0
"""Largest stretch of the side of a stitch: a loop of twice its width is nearly a straight yarn."""


@dataclass(frozen=True, eq=False)
class Dressed:
    """A garment outside of the bodies that it is put on."""

    yarns: YarnSet
    """The yarns, with their rest lengths unchanged."""
    fabric: StitchMesh
    """The stitches from which the yarns were made."""
    depth: float
    """How deep the yarns were in a body [cm]; 0 if no yarn was in a body."""
    farthest: float
    """Farthest move of a control point [cm]."""


def dressed(yarns: YarnSet, fabric: StitchMesh, bodies: Sequence[Body], *, device: str | None = None) -> Dressed:
    """Move a garment out of the bodies that its yarns are in; yarns outside of all bodies keep all their bits.

    Args:
        yarns: the yarns, as generated or as relaxed without the bodies.
        fabric: the stitches from which the yarns were made.
        bodies: the bodies; no yarn counts as inside an open body.
        device: "cpu", "cuda:0" ...; by default the first GPU, or the CPU without a GPU.

    Raises:
        ParameterError: the yarns do not belong to the fabric, a part of the garment finds no way out, or a body goes
            through the garment.
        SolverError: the moved yarns are linked in another way.
    """
    solid = [body for body in bodies if body.closed]
    depth = max((_depth(yarns, body, device) for body in solid), default=0.0)
    if depth <= 0.0:
        return Dressed(yarns, fabric, 0.0, 0.0)
    cloth = _cloth_at_rest(fabric)
    laid = lay_splines(cloth, fabric, yarns)
    reach = float(np.quantile(np.abs(laid.height), MOST_HEIGHTS)) + float(yarns.radius.max())
    worn = [WornBody(SolidBody(body.mesh), reach + body.thickness) for body in solid]
    vertices = dressed_vertices(cloth, cloth.vertices, worn, thickness=2.0 * reach, device=device_named(device))
    _refuse_drawn_out(fabric, vertices)
    moved = replace(yarns, points=yarns.points + laid.world(cloth, vertices) - laid.world(cloth))
    refuse_pull_through(yarns, moved, device)
    farthest = float(np.linalg.norm(moved.points - yarns.points, axis=1).max())
    return Dressed(moved, replace(fabric, vertices=vertices), depth, farthest)


def _depth(yarns: YarnSet, body: Body, device: str | None) -> float:
    """How deep the middle of a yarn is in a body [cm], negative if none is in it."""
    distance = body_distance(yarns, body.mesh, device=device) + yarns.radius[yarns.segment_yarn]
    return -float(distance.min())


def _refuse_drawn_out(fabric: StitchMesh, vertices: FloatArray) -> None:
    """Refuse positions of the vertices if they stretch the side of a stitch too far; the message names the place."""
    stretch = replace(fabric, vertices=vertices).side_length / fabric.side_length
    side = int(stretch.argmax())
    if stretch[side] > MOST_STRETCH:
        x, y, z = fabric.vertices[fabric.face_vertex[side]]
        found = f"goes through the garment near {x:.0f}, {y:.0f}, {z:.0f} cm (stitch face {fabric.side_face[side]})"
        raise ParameterError(
            f"body: {found}, where stitches would be stretched {stretch[side]:.2g} times; expected at most "
            f"{MOST_STRETCH:g}; pose its limbs within the garment or through its openings, or take a wider garment"
        )


def _cloth_at_rest(fabric: StitchMesh) -> Cloth:
    """The stitches as triangles that are at rest at their present positions."""
    triangles = fabric.face_vertex[stitch_triangles(fabric)]
    return Cloth(
        vertices=fabric.vertices, triangles=triangles, rest=_flat(fabric.vertices[triangles]),
        panel=np.zeros(len(triangles), dtype=np.int64), panel_names=("fabric",),
    )  # fmt: skip


def _flat(corners: FloatArray) -> FloatArray:
    """Each triangle in its own plane, with its first side along x [cm], shape (T, 3, 2)."""
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    length = np.linalg.norm(first, axis=1)
    along = (first * second).sum(axis=1) / length
    across = np.linalg.norm(np.cross(first, second), axis=1) / length
    zero = np.zeros(len(corners))
    return np.stack([zero, zero, length, zero, along, across], axis=1).reshape(-1, 3, 2)
