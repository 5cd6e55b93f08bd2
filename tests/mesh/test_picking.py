# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A ray picks the face, the side and the corner at which it points."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.io import read_mesh
from stitchmesh.mesh import BORDER, Mesh
from stitchmesh.mesh.picking import PickingTable, pick, picking_table, side_near_ray
from tests.gallery import ROOT, grid, pentagon_row, torus, tube

MESHES = {"torus": torus(9, 12), "pentagons": pentagon_row()}


def outside(table: PickingTable, face: int, distance: float = 0.1) -> tuple[np.ndarray, np.ndarray]:
    """A ray that begins a little outside a face and points at its centre."""
    area = table.mesh.face_vector_area[face]
    normal = area / np.linalg.norm(area)
    return table.centre[face] + distance * normal, -normal


@pytest.mark.parametrize("name", MESHES)
def test_a_ray_at_the_centre_of_a_face_picks_the_face(name):
    table = picking_table(MESHES[name])
    for face in range(table.mesh.face_count):
        origin, direction = outside(table, face)
        place = pick(table, origin, direction)
        assert place is not None
        assert place.face == face
        assert place.point == pytest.approx(table.centre[face], abs=1e-9)
        assert place.depth == pytest.approx(0.1)


def test_the_first_face_on_a_ray_is_the_one_that_brute_force_finds():
    """Rays from outside through random points, compared with the nearest of all triangles that contain the point."""
    table = picking_table(read_mesh(ROOT / "assets" / "meshes" / "sweater.obj"))
    position = table.mesh.corner_position
    random = np.random.default_rng(3)
    for _ in range(40):
        origin = 200.0 * random.normal(size=3)
        aim = position[random.integers(len(position))] + 0.3 * random.normal(size=3)
        place = pick(table, origin, aim - origin)
        assert (None if place is None else place.face) == nearest_by_solving(table, origin, aim - origin)


def nearest_by_solving(table: PickingTable, origin: np.ndarray, direction: np.ndarray) -> int | None:
    """The face of the nearest triangle on a ray, by one linear system for each triangle."""
    mesh = table.mesh
    tail, head = mesh.corner_position, mesh.corner_position[mesh.side_next]
    centre = table.centre[mesh.side_face]
    columns = np.stack([tail - centre, head - centre, np.broadcast_to(-direction, tail.shape)], axis=2)
    solution = np.linalg.solve(columns, (origin - centre)[..., None])[..., 0]
    inside = (solution[:, 0] >= 0) & (solution[:, 1] >= 0) & (solution[:, :2].sum(axis=1) <= 1) & (solution[:, 2] > 0)
    hits = np.flatnonzero(inside)
    return int(mesh.side_face[hits[solution[hits, 2].argmin()]]) if len(hits) else None


@pytest.mark.parametrize("name", MESHES)
def test_near_the_middle_of_a_side_the_side_is_picked(name):
    table = picking_table(MESHES[name])
    mesh = table.mesh
    middle = (mesh.corner_position + mesh.corner_position[mesh.side_next]) / 2
    for side in range(mesh.side_count):
        face = int(mesh.side_face[side])
        direction = outside(table, face)[1]
        aim = 0.9 * middle[side] + 0.1 * table.centre[face]
        place = pick(table, aim - 0.1 * direction, direction)
        assert place is not None
        assert (place.face, place.side) == (face, side)


def test_near_a_corner_the_corner_and_its_vertex_are_picked():
    table = picking_table(grid(4, 3))
    mesh = table.mesh
    for corner in range(mesh.side_count):
        aim = 0.8 * mesh.corner_position[corner] + 0.2 * table.centre[mesh.side_face[corner]]
        place = pick(table, aim + np.array([0.0, 0.0, 5.0]), [0.0, 0.0, -2.0])
        assert place is not None
        assert (place.corner, place.vertex) == (corner, mesh.face_vertex[corner])


def test_a_face_is_picked_from_its_inside_too():
    table = picking_table(tube(12, 3))
    place = pick(table, [0.0, 1.5, 0.0], [0.0, 0.0, 1.0])
    assert place is not None
    assert place.point[2] > 0


def test_a_ray_that_points_away_or_passes_by_picks_nothing():
    table = picking_table(grid(3, 3))
    assert pick(table, [1.5, 1.5, 5.0], [0.0, 0.0, 1.0]) is None
    assert pick(table, [9.0, 1.5, 5.0], [0.0, 0.0, -1.0]) is None
    assert pick(table, [1.5, 1.5, 5.0], [1.0, 0.0, 0.0]) is None


def test_the_bay_of_a_concave_face_does_not_belong_to_the_face():
    """An L whose centre lies in its own corner: the square that is missing is not part of the face."""
    points = [(0, 0), (9, 0), (9, 1), (1, 1), (1, 9), (0, 9)]
    table = picking_table(Mesh.from_polygons([(x, y, 0.0) for x, y in points], [list(range(6))]))
    for x, y in ((0.5, 0.5), (8.5, 0.5), (0.5, 8.5), (3.0, 0.9)):
        assert pick(table, [x, y, 4.0], [0.0, 0.0, -1.0]) is not None
    for x, y in ((3.0, 3.0), (2.0, 1.5), (1.5, 5.0)):
        assert pick(table, [x, y, 4.0], [0.0, 0.0, -1.0]) is None


@pytest.mark.parametrize("beside", [-0.05, 0.05])
def test_a_click_beside_a_border_finds_the_border(beside):
    table = picking_table(grid(4, 3))
    mesh = table.mesh
    borders = np.flatnonzero(mesh.twin == BORDER)
    side = side_near_ray(table, borders, [1.5, beside, 10.0], [0.0, 0.0, -1.0], 0.01)
    assert side is not None
    ends = mesh.corner_position[[side, mesh.side_next[side]]]
    assert ends[:, 0].tolist() == [1.0, 2.0]
    assert (ends[:, 1] == 0.0).all()
    assert side_near_ray(table, borders, [1.5, -0.3, 10.0], [0.0, 0.0, -1.0], 0.01) is None
    assert side_near_ray(table, borders[:0], [1.5, 0.0, 10.0], [0.0, 0.0, -1.0], 0.01) is None


def test_a_border_behind_the_mesh_is_not_found():
    """The lower border of the back of a tube lies behind the front when seen from slightly above."""
    table = picking_table(tube(12, 3))
    borders = np.flatnonzero(table.mesh.twin == BORDER)
    origin = np.array([0.0, 10.0, 40.0])
    aim = np.array([0.0, 0.0, -3.0])
    assert side_near_ray(table, borders, origin, aim - origin, 0.01) is None
    front = np.array([0.0, 0.0, 3.0])
    assert side_near_ray(table, borders, origin, front - origin, 0.01) is not None


@pytest.mark.parametrize(
    ("origin", "direction"),
    [((0, 0, np.nan), (0, 0, 1)), ((0, 0, 0), (0, 0, 0)), ((0, 0), (0, 1)), ((0, 0, 0), (np.inf, 0, 0))],
)
def test_a_ray_without_a_direction_is_refused(origin, direction):
    with pytest.raises(ParameterError, match="ray: got origin"):
        pick(picking_table(grid(2, 2)), origin, direction)
