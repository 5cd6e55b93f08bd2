# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Repair of polygons from modelling programs.

The order of the steps matters. Faces that visit a vertex twice and faces that occur twice are corrected first, so that
the faces of each edge are counted correctly. Vertices are welded next. Welding can crush faces, and a removed sliver
leaves T-junctions, so that faces are corrected again until no T-junction is left. Only then are edges with more than
two faces separated, directions made to agree, small components removed, holes filled and components turned outwards.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from stitchmesh.errors import MeshError, check_kind
from stitchmesh.mesh.polygon_mesh import Mesh
from stitchmesh.mesh.repair.action import ActionLog, RepairAction, RepairOptions
from stitchmesh.mesh.repair.components import components_of, remove_small_components
from stitchmesh.mesh.repair.degenerate_faces import (
    correct_repeated_corners,
    remove_duplicates,
    remove_faces_without_area,
)
from stitchmesh.mesh.repair.holes import fill_holes
from stitchmesh.mesh.repair.junctions import join_junctions
from stitchmesh.mesh.repair.manifold import make_manifold
from stitchmesh.mesh.repair.orientation import mesh_of, turn_outwards
from stitchmesh.mesh.repair.soup import Soup, soup_of
from stitchmesh.mesh.repair.weld import weld, weld_distance

DEFAULT_REPAIR = RepairOptions()
"""What a repair may change by default."""


@dataclass(frozen=True, eq=False)
class Repaired:
    """A valid mesh made of polygons that need not be valid, and what was changed."""

    mesh: Mesh
    """The mesh, with all its components."""
    actions: tuple[RepairAction, ...]
    """What was changed, in a fixed order; empty if the polygons were valid."""

    @cached_property
    def components(self) -> tuple[Mesh, ...]:
        """The separate components of the mesh, the largest area first."""
        return components_of(self.mesh)


def repair_mesh(
    vertices: ArrayLike, faces: Sequence[Sequence[int]], options: RepairOptions = DEFAULT_REPAIR
) -> Repaired:
    """Make a valid mesh of polygons or triangles that modelling programs write.

    Vertices on the border at equal positions are welded. Faces without area, faces that occur twice, vertices without a
    face and very small components are removed. T-junctions are joined, edges with more than two faces and vertices in
    which parts meet are split, faces are turned to agree and to point outwards, and missing triangles are filled.
    Nothing else is changed: a valid mesh keeps its vertices, its faces and their order, and polygons stay polygons.

    Args:
        vertices: positions [cm], shape (V, 3).
        faces: vertices of each polygon, from 0, in either direction.
        options: what may be changed.

    Raises:
        MeshError: the positions have another shape, a coordinate is not finite, a vertex does not exist, no face has an
            area, or the surface has one side only.
        ParameterError: the weld distance is above half the median length of an edge.
    """
    check_kind("repair_mesh: options", options, RepairOptions, "RepairOptions(weld_distance=0.01)")
    log = ActionLog()
    soup = soup_of(vertices, faces)
    log.add("isolated vertices", np.flatnonzero(np.bincount(soup.vertex, minlength=len(soup.points)) == 0).tolist())
    soup = make_manifold(_connected(soup, options, log), log)
    soup = remove_small_components(soup, log)
    soup = fill_holes(soup, options.largest_hole, log)
    soup = turn_outwards(soup, log)
    return Repaired(mesh_of(soup), log.actions())


def _connected(soup: Soup, options: RepairOptions, log: ActionLog) -> Soup:
    """Weld the vertices, and correct the faces and their T-junctions.

    Raises:
        MeshError: no face is left.
        ParameterError: as for ``repair_mesh``.
    """
    count = soup.face_count
    soup = correct_repeated_corners(soup, log)
    _check_faces_left(soup, count)
    soup = remove_duplicates(soup, log)
    distance = weld_distance(soup, options)
    soup = weld(soup, distance)
    # Each search finds T-junctions that the divisions of the search before made.
    for _ in range(20):
        soup = correct_repeated_corners(soup, log)
        _check_faces_left(soup, count)
        soup = remove_faces_without_area(soup, log)
        _check_faces_left(soup, count)
        soup = remove_duplicates(soup, log)
        joined = join_junctions(soup, distance, log)
        if joined is soup:
            break
        soup = joined
    return soup


def _check_faces_left(soup: Soup, count: int) -> None:
    if soup.face_count == 0:
        raise MeshError(f"mesh: none of the {count} faces has an area; expected polygons with three corners apart")
