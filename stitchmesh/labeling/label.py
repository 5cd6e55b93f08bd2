# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Separate a mesh into knitting rows and give each row its wale direction."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stitchmesh.errors import LabelError, ParameterError
from stitchmesh.labeling.direction import turned_rows
from stitchmesh.labeling.frame import in_knitting_frame
from stitchmesh.labeling.growth import Conflict, RowGrowth
from stitchmesh.labeling.seeds import candidate_seeds, seed_chain, side_of
from stitchmesh.mesh import Mesh, StitchMesh

EdgeName = int | tuple[int, int]
"""A side number, or the two vertices of an edge; the row grows to the left of the side, or of first-to-second."""


def label(mesh: Mesh, *, seeds: Sequence[EdgeName] = (), flip: Sequence[int] = ()) -> StitchMesh:
    """Label every edge as wale or course, so that each face has exactly two wale edges.

    From a border the first row grows: border edges are course edges, edges that leave the border are wale edges,
    the rest of the row are course edges, from which the next rows grow. Without seeds the longest smooth border
    is the cast-on; a mesh whose borders all have corners starts at its lowest side. Rows point away from their
    seed; all others follow the neighbour that they share most course length with, so that mismatched wale
    directions fall on the shortest seams.

    Args:
        mesh: any oriented polygon mesh.
        seeds: course edges to start from, in order; a border edge stands for its whole border up to corners,
            an inner edge for the edge loop through it.
        flip: faces whose rows are turned over afterwards.

    Returns:
        The same surface as a stitch mesh of ``Stitch.PANEL`` faces; ``row`` counts rows in knitting order.

    Raises:
        LabelError: the topology admits no rows from these seeds; names the faces where rows collide.
        ParameterError: a seed or face does not exist.

    Source: Yuksel et al. 2012, section 5.1.
    """
    growth, seeded = _grown(mesh, seeds)
    turned = turned_rows(mesh, growth, seeded)
    for face in flip:
        if not 0 <= face < mesh.face_count:
            raise ParameterError(f"flip: face {face} does not exist; the mesh has faces 0 to {mesh.face_count - 1}")
        turned[growth.row[face]] ^= True
    turned_face = turned[growth.row]
    left = np.where(turned_face, growth.right_wale, growth.left_wale)
    right = np.where(turned_face, growth.left_wale, growth.right_wale)
    return in_knitting_frame(mesh, left, right, growth.row)


def _grown(mesh: Mesh, seeds: Sequence[EdgeName]) -> tuple[RowGrowth, list[int]]:
    """Grow all rows; returns the growth and the rows whose direction the seeds fix."""
    if seeds:
        return _grow_from(mesh, [seed_chain(mesh, side_of(mesh, seed)) for seed in seeds])
    candidates = candidate_seeds(mesh)
    if not candidates:
        raise LabelError(
            "mesh: it has no border to start from; name an edge of the first row, seeds=[(vertex, vertex)]"
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
    """A starting chain in a part of the mesh that no row has reached."""
    for chain in candidate_seeds(mesh):
        if growth.row[mesh.side_face[chain[0]]] < 0:
            return chain
    face = growth.unlabeled_face()
    raise LabelError(
        f"face {face}: no border and no seed in its part of the mesh; name an edge there, seeds=[(vertex, vertex)]"
    )
