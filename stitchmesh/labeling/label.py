# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Separate a mesh into knitting rows and give each row its wale direction."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stitchmesh.errors import LabelError, ParameterError, check_kind
from stitchmesh.labeling.direction import turned_rows
from stitchmesh.labeling.frame import in_knitting_frame
from stitchmesh.labeling.growth import Conflict, RowGrowth
from stitchmesh.labeling.seeds import candidate_seeds, seed_chain, side_of
from stitchmesh.mesh import Mesh, StitchMesh

EdgeName = int | tuple[int, int]
"""A side number, or the two vertices of an edge. The seeded row is to the left of the side (of the directed edge)."""


def label(mesh: Mesh, *, seeds: Sequence[EdgeName] = (), flip: Sequence[int] = ()) -> StitchMesh:
    """Label every edge as a wale or course edge, so that each face has exactly two wale edges.

    The first row grows from a border: border edges are course edges, the edges that leave the border are wale edges,
    and the other edges of the row are course edges, from which the next rows grow. Without seeds, the longest border
    without corners is the cast-on. If all borders have corners, the first row starts at the lowest border between two
    corners. The wale direction of a seeded row points away from the seed. The direction of every other row follows
    the neighbour with which the row shares the greatest course length, so that mismatched wale directions remain at
    the shortest seams.

    Args:
        mesh: any oriented polygon mesh.
        seeds: course edges to start from, in order; a border edge means its border up to the next corners, an inner
            edge means the edge loop through it.
        flip: faces whose rows are reversed at the end.

    Returns:
        The same surface as a stitch mesh of ``Stitch.PANEL`` faces; ``row`` numbers the rows in the order of their
        growth.

    Raises:
        LabelError: the topology does not allow rows from these seeds; the message names the faces where rows conflict.
        ParameterError: a seed or a face does not exist.

    Source: Yuksel et al. 2012, section 5.1.
    """
    check_kind("label", mesh, Mesh)
    growth, seeded = _grow_rows(mesh, seeds)
    turned = turned_rows(mesh, growth, seeded)
    for face in flip:
        if not 0 <= face < mesh.face_count:
            raise ParameterError(f"flip: face {face} does not exist; the mesh has faces 0 to {mesh.face_count - 1}")
        turned[growth.row[face]] ^= True
    turned_face = turned[growth.row]
    left = np.where(turned_face, growth.right_wale, growth.left_wale)
    right = np.where(turned_face, growth.left_wale, growth.right_wale)
    return in_knitting_frame(mesh, left, right, growth.row)


def _grow_rows(mesh: Mesh, seeds: Sequence[EdgeName]) -> tuple[RowGrowth, list[int]]:
    """Grow all rows; return the growth and the rows whose directions the seeds determine."""
    if seeds:
        return _grow_from(mesh, [seed_chain(mesh, side_of(mesh, seed)) for seed in seeds])
    candidates = candidate_seeds(mesh)
    if not candidates:
        raise LabelError(
            "mesh: has no border to start from; name an edge of the first row, seeds=[(vertex, vertex)]"
        )
    first: Conflict | None = None
    for chain in candidates:
        try:
            return _grow_from(mesh, [chain])
        except Conflict as conflict:
            first = first or conflict
    assert first is not None
    raise LabelError(str(first)) from first


def _grow_from(mesh: Mesh, chains: list[list[int]]) -> tuple[RowGrowth, list[int]]:
    """Grow all rows from chains of course sides, then from further chains in parts that no row has reached."""
    growth = RowGrowth(mesh)
    seeded: list[int] = []
    for chain in chains:
        growth.mark_courses(chain)
        seeded += [row for row in [growth.grow_row(chain[0])] if row is not None]
        growth.queue(chain)
    growth.grow_all()
    while growth.unlabeled_face() is not None:
        chain = _seed_of_component(mesh, growth)
        growth.mark_courses(chain)
        seeded += [row for row in [growth.grow_row(chain[0])] if row is not None]
        growth.grow_all()
    return growth, seeded


def _seed_of_component(mesh: Mesh, growth: RowGrowth) -> list[int]:
    """A chain of course sides in a part of the mesh that no row has reached."""
    for chain in candidate_seeds(mesh):
        if growth.row[mesh.side_face[chain[0]]] < 0:
            return chain
    face = growth.unlabeled_face()
    raise LabelError(
        f"face {face}: its part of the mesh has no border and no seed; name an edge there, seeds=[(vertex, vertex)]"
    )
