# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The separate components of a surface."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh.connectivity import linked_groups
from stitchmesh.mesh.polygon_mesh import BORDER, IntArray, Mesh, ranges
from stitchmesh.mesh.repair.action import ActionLog
from stitchmesh.mesh.repair.soup import Soup, edges_of


def component_of_faces(soup: Soup) -> IntArray:
    """Return the component of each face of a manifold surface, shape (F,); components are numbered by first face."""
    first, second = soup.side_face[edges_of(soup).with_count(2)].T
    return linked_groups(soup.face_count, first, second)


def first_faces(component: IntArray) -> IntArray:
    """Return the first face of each component, shape (n,)."""
    return np.unique(component, return_index=True)[1]


def closed_components(soup: Soup, component: IntArray) -> NDArray[np.bool_]:
    """Return whether each component has no border, shape (n,)."""
    closed = np.ones(component.max() + 1, dtype=bool)
    closed[component[soup.side_face[edges_of(soup).with_count(1)[:, 0]]]] = False
    return closed


def remove_small_components(soup: Soup, log: ActionLog) -> Soup:
    """Remove the components whose area is very small beside the largest one.

    Args:
        soup: faces that form a manifold surface.
        log: takes the action.
    """
    component = component_of_faces(soup)
    area = np.bincount(component, soup.area)
    # A component is a speck if it is smaller than a ten-thousandth of the largest one.
    small = area < 1e-4 * area.max()
    if not small.any():
        return soup
    log.add("small components", soup.origin[first_faces(component)][small].tolist())
    return soup.kept(np.flatnonzero(~small[component]))


def components_of(mesh: Mesh) -> tuple[Mesh, ...]:
    """Return the components of a mesh as meshes of their own, the largest area first.

    Args:
        mesh: a mesh without a lattice. Vertices and faces of a component keep their order.
    """
    sides = np.flatnonzero(mesh.twin != BORDER)
    component = linked_groups(mesh.face_count, mesh.side_face[sides], mesh.side_face[mesh.twin[sides]])
    if not component.any():
        return (mesh,)
    area = np.bincount(component, np.linalg.norm(mesh.face_vector_area, axis=1))
    order = np.argsort(component, kind="stable")
    groups = np.split(order, np.cumsum(np.bincount(component))[:-1])
    return tuple(_part(mesh, groups[number]) for number in np.argsort(-area, kind="stable"))


def _part(mesh: Mesh, faces: IntArray) -> Mesh:
    """A component alone."""
    sides = ranges(mesh.face_start, faces)
    used, vertex = np.unique(mesh.face_vertex[sides], return_inverse=True)
    twin = mesh.twin[sides]
    start = np.concatenate([[0], np.cumsum(np.diff(mesh.face_start)[faces])])
    return Mesh(mesh.vertices[used], start, vertex, np.where(twin == BORDER, BORDER, np.searchsorted(sides, twin)))
