# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Directions of faces: neighbours agree, and components point outwards."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import MeshError
from stitchmesh.mesh import connectivity
from stitchmesh.mesh.connectivity import find_twins
from stitchmesh.mesh.orientation import is_inside_out
from stitchmesh.mesh.polygon_mesh import FloatArray, IntArray, Mesh
from stitchmesh.mesh.repair.action import ActionLog
from stitchmesh.mesh.repair.components import closed_components, component_of_faces, first_faces
from stitchmesh.mesh.repair.soup import Soup, numbers_in


def patches_and_flips(soup: Soup, pairs: IntArray) -> tuple[IntArray, NDArray[np.bool_]]:
    """Find the faces to reverse so that faces which share an edge pass it in opposite directions.

    Args:
        soup: the faces.
        pairs: sides that share an edge, shape (n, 2).

    Returns:
        Number of the patch of each face, and whether to reverse each face, for the smaller part of each patch; both of
        shape (F,).

    Raises:
        MeshError: the surface has one side only; the message names an edge and a face of the input.
    """
    count, faces = soup.face_count, soup.side_face[pairs]
    same = soup.vertex[pairs[:, 0]] == soup.vertex[pairs[:, 1]]
    patch, other = connectivity.patches_and_flips(faces[:, 0], faces[:, 1], same, count)
    one_sided = np.flatnonzero(patch[faces[:, 0]] < 0)
    if len(one_sided):
        side = int(pairs[one_sided[0], 0])
        ends = f"{soup.source[side]}-{soup.source[soup.side_next[side]]}"
        raise MeshError(connectivity.one_sided_surface(ends, int(soup.origin[soup.side_face[side]])))
    most = np.bincount(patch, minlength=2 * count)
    turned = np.bincount(patch[other], minlength=2 * count)
    return patch, other ^ (2 * turned > most)[patch]



def turn_outwards(soup: Soup, log: ActionLog) -> Soup:
    """Reverse the components whose faces point inwards.

    A closed component has a signed volume. An open one is judged by its mean winding number.

    Args:
        soup: faces that form an oriented manifold surface.
        log: takes the action.
    """
    component = component_of_faces(soup)
    area = np.bincount(component, soup.area)
    closed = closed_components(soup, component)
    # A volume counts as rounding up to this multiple of the area of the surface to the power 3/2.
    inwards = closed & (_volumes(soup, component) < -1e-12 * area**1.5)
    net = np.stack([np.bincount(component, axis) for axis in soup.vector_area.T], axis=1)
    # A component has no inside if the length of the sum of all vector areas is above this multiple of the area.
    # The ratio is 0.955 for a part of a tube that goes round by 60 degrees, whose mean winding number is far
    # above ``INSIDE_OUT``.
    for number in np.flatnonzero(~closed & (np.linalg.norm(net, axis=1) < 0.95 * area)):
        inwards[number] = is_inside_out(mesh_of(soup.kept(np.flatnonzero(component == number))))
    if not inwards.any():
        return soup
    log.add("turned components", soup.origin[first_faces(component)][inwards].tolist())
    return soup.reversed(inwards[component])


def _volumes(soup: Soup, component: IntArray) -> FloatArray:
    """Signed volume of each component [cm^3], positive with outward faces, shape (n,)."""
    corner = soup.points[soup.vertex[soup.start[:-1]]]
    around = corner[first_faces(component)][component]
    cones = np.einsum("fi,fi->f", corner - around, soup.vector_area) / 3.0
    return np.bincount(component, cones).astype(np.float64)


def mesh_of(soup: Soup) -> Mesh:
    """Return the mesh of faces that form an oriented manifold surface; vertices keep their order.

    Raises:
        MeshError: as for ``Mesh.from_polygons``.
    """
    used = numbers_in(soup.vertex, len(soup.points))
    number = np.empty(len(soup.points), dtype=np.int64)
    number[used] = np.arange(len(used))
    vertex = number[soup.vertex]
    return Mesh(soup.points[used], soup.start, vertex, find_twins(soup.start, vertex, len(used)))
