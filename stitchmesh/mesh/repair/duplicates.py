# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Faces that have the same vertices as another face."""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh.polygon_mesh import IntArray
from stitchmesh.mesh.repair.action import ActionLog
from stitchmesh.mesh.repair.soup import Soup


def remove_duplicates(soup: Soup, log: ActionLog) -> Soup:
    """Keep the first of the faces that have the same vertices, in whatever order and direction.

    Args:
        soup: faces that visit each of their vertices once.
        log: takes the action.
    """
    sorted_vertex = soup.vertex[np.lexsort((soup.vertex, soup.side_face))]
    again = np.zeros(soup.face_count, dtype=bool)
    for size in np.unique(soup.size):
        faces = np.flatnonzero(soup.size == size)
        again[faces[_repeated_rows(sorted_vertex[soup.start[faces][:, None] + np.arange(size)])]] = True
    if not again.any():
        return soup
    log.add("duplicate faces", soup.origin[again].tolist())
    return soup.kept(np.flatnonzero(~again))


def _repeated_rows(rows: IntArray) -> IntArray:
    """Numbers of the rows that occur earlier too."""
    order = np.lexsort(rows.T[::-1])  # Equal rows keep their order.
    same = (np.diff(rows[order], axis=0) == 0).all(axis=1)
    return order[1:][same]
