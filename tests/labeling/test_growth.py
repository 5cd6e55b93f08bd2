# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Quads that are labeled together get the labels that they get one by one."""

from __future__ import annotations

import re

import numpy as np
import pytest

from stitchmesh.io import read_mesh
from stitchmesh.labeling import PartialLabeling, growth, start_labeling
from stitchmesh.mesh import Mesh
from stitchmesh.tessellate import tessellate
from tests.gallery import FLAT_AND_ROUND, GARMENTS, grid, odd_corner, tube
from tests.labeling.test_label import assert_rows
from tests.labeling.test_partial_labeling import bits

pytestmark = pytest.mark.decides


def wide_odd_corner(size: int = 20) -> Mesh:
    """Three grids around an inner vertex, so that every row is long and crosses another one."""
    coarse = odd_corner()
    vertices: dict[tuple[float, ...], int] = {}
    faces = []
    for a, b, c, d in coarse.vertices[coarse.face_vertex.reshape(-1, 4)]:
        u, v = np.meshgrid(np.linspace(0, 1, size + 1), np.linspace(0, 1, size + 1), indexing="ij")
        u, v = u[..., None], v[..., None]
        points = np.round((1 - u) * (1 - v) * a + u * (1 - v) * b + u * v * c + (1 - u) * v * d, 9) + 0.0
        number = np.array([[vertices.setdefault(tuple(point), len(vertices)) for point in row] for row in points])
        corners = [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]]
        faces += np.stack(corners, axis=-1).reshape(-1, 4).tolist()
    return Mesh.from_polygons(np.array(list(vertices)), faces)


def steps(mesh: Mesh) -> PartialLabeling:
    """Steps with rows that turn at an edge that was set by hand, flips and a start of its own."""
    labeling = start_labeling(mesh).label_rows(2)
    side = int(mesh.side_next[labeling.right_wale[np.flatnonzero(labeling.labeled)[-1]]])
    return labeling.set_edge(side, None).label_rows(1).label_all()


MESHES = {
    **FLAT_AND_ROUND, "long": lambda: grid(40, 3), "wide tube": lambda: tube(50, 4), "odd corner": wide_odd_corner,
    "glove": lambda: read_mesh(next(path for path in GARMENTS if path.stem == "glove")),
}  # fmt: skip


@pytest.mark.parametrize("name", MESHES)
def test_quads_together_are_labeled_as_quads_one_by_one(name, monkeypatch):
    mesh = MESHES[name]()
    monkeypatch.setattr(growth, "SHORTEST_RUN", 10**9)
    one_by_one = bits(start_labeling(mesh).label_all()), bits(steps(mesh))
    monkeypatch.setattr(growth, "SHORTEST_RUN", 1)
    assert (bits(start_labeling(mesh).label_all()), bits(steps(mesh))) == one_by_one


def test_faces_where_rows_meet_become_corners_if_the_user_says_so():
    """Each fault on the diagonal names an edge; setting it to wale makes a row turn there, and the mesh is labeled."""
    labeling = start_labeling(wide_odd_corner(6)).label_all()
    assert labeling.faults and all("both wale and course" in fault.reason for fault in labeling.faults)
    for fault in labeling.faults:
        first, second = re.search(r"or set edge (\d+)-(\d+) to wale so that a row turns here", fault.reason).groups()
        labeling = labeling.set_edge((int(first), int(second)), "wale")
    fabric = labeling.label_all().finish()
    assert_rows(fabric)
    corners = (fabric.n_bottom == 2) | (fabric.n_top == 2)
    assert np.count_nonzero(corners) == 6
    tessellate(fabric, stitch_width=0.05)
