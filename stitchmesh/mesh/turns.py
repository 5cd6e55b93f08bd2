# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Turns within a fabric, where a short row turns back and the next one begins.

The ends of the two rows, two left or two right wale sides, form a slit: a border of two sides. Its *base* is the vertex
at which the rows above and below the short rows meet. Its *tip* is the end of the course edge between the two rows.
The two sides lie on each other, so that the slit is closed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh.polygon_mesh import FloatArray, IntArray
from stitchmesh.mesh.stitch_mesh import LEFT, RIGHT, StitchMesh

SLIT_SIDES = 2
"""Sides of the border of a turn."""
TIP = 0.1
"""Distance of the tip from the base of a turn, over the distance of the base from the other end of the course edge that
ends at the tip. At 0.1 the yarns of the two rows start 0.66 to 0.71 radii apart, at 0.3 and at 0.0 about 0.6, beyond
the base at -0.1 only 0.4 (six pairs of short rows on a bent tube)."""


@dataclass(frozen=True, eq=False)
class Turns:
    """Vertices of the turns of a fabric, one of each kind for each turn."""

    tip: IntArray
    """The tips, shape (n,)."""
    base: IntArray
    """The bases, shape (n,)."""
    inner: IntArray
    """The other ends of the course edges that end at the tips, shape (n,)."""


def turn_slits(fabric: StitchMesh) -> list[tuple[int, int]]:
    """Return the two border sides of each turn."""
    role = fabric.side_role
    slits = [loop.tolist() for loop in fabric.boundary_loops if len(loop) == SLIT_SIDES]
    return [(one, other) for one, other in slits if role[one] == role[other] and role[one] in (LEFT, RIGHT)]


def turn_edges(fabric: StitchMesh) -> NDArray[np.bool_]:
    """Return whether each edge is one of the two row ends at a turn, shape (E,)."""
    found = np.zeros(len(fabric.edge_side), dtype=bool)
    found[fabric.side_edge[np.array(turn_slits(fabric), dtype=np.int64).ravel()]] = True
    return found


def find_turns(fabric: StitchMesh) -> Turns:
    """Find the turns of a fabric."""
    found = [_turn(fabric, side, other) for slit in turn_slits(fabric) for side, other in (slit, slit[::-1])]
    tip, base, inner = np.array([turn for turn in found if turn is not None], dtype=np.int64).reshape(-1, 3).T
    return Turns(tip, base, inner)


def _turn(fabric: StitchMesh, lower: int, upper: int) -> tuple[int, int, int] | None:
    """The tip, the base and the inner vertex of a turn; None if the row of the second side is not above the first."""
    after, before = fabric.side_next, fabric.side_previous
    vertex = fabric.face_vertex
    if fabric.side_role[lower] == RIGHT:
        if fabric.twin[after[lower]] != before[upper]:
            return None
        return int(vertex[after[lower]]), int(vertex[lower]), int(vertex[after[after[lower]]])
    if fabric.twin[before[lower]] != after[upper]:
        return None
    return int(vertex[lower]), int(vertex[after[lower]]), int(vertex[before[lower]])


def tip_beside(base: FloatArray, inner: FloatArray) -> FloatArray:
    """Return the position of a tip [cm], from the positions of the base and the inner vertex, shape (3,) or (n, 3)."""
    tip: FloatArray = base + TIP * (inner - base)
    return tip


def with_tips_placed(fabric: StitchMesh, moving: NDArray[np.bool_] | None = None) -> StitchMesh:
    """Return a fabric without a lattice whose turns have their tips where the yarns have the most room.

    Args:
        fabric: stitch mesh.
        moving: whether each vertex may be moved, shape (V,); None if all may.
    """
    turns = find_turns(fabric)
    chosen = np.ones(len(turns.tip), dtype=bool) if moving is None else moving[turns.tip]
    if not chosen.any():
        return fabric
    vertices = fabric.vertices.copy()
    base, inner = vertices[turns.base[chosen]], vertices[turns.inner[chosen]]
    vertices[turns.tip[chosen]] = tip_beside(base, inner)
    return replace(fabric, vertices=vertices)
