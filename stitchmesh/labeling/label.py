# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Separate a mesh into knitting rows and give each row its wale direction."""

from __future__ import annotations

import logging
from collections.abc import Sequence

from stitchmesh.io.library_meshes import MeshLike, as_mesh
from stitchmesh.labeling.partial_labeling import start_labeling
from stitchmesh.labeling.seeds import EdgeName
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.mesh.orientation import INSIDE_OUT, mean_winding_number

logger = logging.getLogger(__name__)


def label(
    mesh: MeshLike, *, borders: Sequence[EdgeName] = (), seeds: Sequence[EdgeName] = (), flip: Sequence[int] = ()
) -> StitchMesh:
    """Label every edge as a wale or course edge, so that each face has exactly two wale edges.

    The first row grows from a border: border edges are course edges, the edges that leave the border are wale edges,
    and the other edges of the row are course edges, from which the next rows grow. Without seeds, the longest border
    without corners is the cast-on. If all borders have corners, the first row starts at the lowest border between two
    corners. The wale direction of a seeded row points away from the seed. The direction of every other row follows
    the neighbour with which the row shares the greatest course length, so that mismatched wale directions remain at
    the shortest seams.

    Args:
        mesh: any oriented polygon mesh, or a mesh of trimesh, meshio or pyvista in centimetres (``as_mesh``).
        borders: edges of borders to start from first; each stands for its whole border, even if this has corners.
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
    mesh = as_mesh(mesh, place="label")
    warn_if_inside_out(mesh)
    labeling = start_labeling(mesh)
    for border in borders:
        labeling = labeling.start_at_border(border)
    for seed in seeds:
        labeling = labeling.start_at_edge(seed)
    labeling = labeling.label_all()
    for face in flip if labeling.labeled.all() else ():
        labeling = labeling.flip_row(face)
    return labeling.finish()


def warn_if_inside_out(mesh: Mesh) -> None:
    """Log a warning if the faces of a mesh point to its inside, because its purl side would be outside."""
    number = mean_winding_number(mesh)
    if number < INSIDE_OUT:
        logger.warning(
            "mesh: is inside out, so its purl side will be outside (mean winding number %.2f; -0.5 is a closed surface "
            "inside out, 0 a flat piece); turn it with turn_inside_out (--turn-inside-out)",
            number,
        )
