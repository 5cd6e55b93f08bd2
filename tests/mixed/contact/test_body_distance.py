# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Contact with a body: derivatives, pressure, bodies that move, and what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from stitchmesh.compute.precision import scalar_named
from stitchmesh.errors import ParameterError, SolverError
from stitchmesh.mesh import Mesh
from stitchmesh.mesh.vertex_motion import VertexMotion
from stitchmesh.mixed.contact.body import SolidBody
from stitchmesh.mixed.contact.body_distance import BodyContact
from stitchmesh.mixed.contact.contact_points import ContactPoints, points_at_nodes
from stitchmesh.mixed.contact.motion import RigidMotion
from tests.mixed.contact.bodies import ball, box
from tests.mixed.contact.sheets import (
    blocks_of,
    cpu,
    derivative_errors,
    forces_of,
    products_of,
    random_direction,
    sheet,
    state_of,
)

REACH = 0.2
AREA = 0.01
TURN = Rotation.from_rotvec([0.4, -0.8, 0.3]).as_matrix()


def nodes_in(count: int) -> ContactPoints:
    """Contact points at nodes, without a cloth."""
    return points_at_nodes(
        0, panel=np.zeros(count), rest=np.zeros((count, 2)), area=AREA, weight=1.0, thickness=2 * REACH
    )


def contact(count: int, body: SolidBody, precision: str = "float64", **options: Any) -> BodyContact:
    return BodyContact(nodes_in(count), body, scalar=scalar_named(precision), device=cpu(), **options)


def nodes_at(places: np.ndarray, precision: str = "float64"):
    return state_of(np.zeros((0, 3)), places, precision)


def around(mesh: Mesh, seed: int = 0, count: int = 400) -> np.ndarray:
    """Places at distances of up to 0.95 reaches from places of the faces, on both sides, none at a kink."""
    rng = np.random.default_rng(seed)
    faces = mesh.face_vertex.reshape(len(mesh.face_start) - 1, -1)[:, :3]
    corners = mesh.vertices[faces[rng.integers(len(faces), size=count)]]
    weight = rng.dirichlet(np.ones(3), size=count)
    on = np.einsum("nk,nkd->nd", weight, corners)
    return on + rng.uniform(-0.3, 0.95, size=(count, 1)) * REACH * rng.normal(size=(count, 3)) / 2


@pytest.mark.parametrize("mesh", [box((1.0, 0.8, 0.6)), ball(1.0, 2)], ids=["box", "ball"])
def test_forces_and_products_are_derivatives_of_the_energy(mesh):
    motion = RigidMotion(np.zeros(1), np.array([[0.3, 0.1, 0.0]]), TURN[None])
    places = motion.places_at(around(mesh), 0.0)
    # Points beside a kink (the surface, the reach, where the nearest feature changes inside) are left out: there the
    # differences of both sides do not agree.
    term = contact(len(places), SolidBody(mesh, motion))
    state = nodes_at(places)
    term.begin_step(state, 0.0, 1e-3)
    smooth = [each for each in range(len(places)) if smooth_at(term, state, each)]
    assert len(smooth) > 300
    term = contact(len(smooth), SolidBody(mesh, motion))
    of_force, of_product = derivative_errors(term, nodes_at(places[smooth]), 1e-6)
    assert of_force < 1e-7 and of_product < 1e-6  # h^2 times the third derivative over the first, and rounding / h


def smooth_at(term: BodyContact, state, node: int) -> bool:
    """Whether the Hessian of a node is the same a little to all sides."""
    if not hasattr(term, "ahead"):
        term.ahead = [node_blocks(term, nodes_at(state.numpy()[1] + shift)) for shift in np.eye(3) * 1e-5]
        term.back = [node_blocks(term, nodes_at(state.numpy()[1] - shift)) for shift in np.eye(3) * 1e-5]
    size = max(np.abs(np.array(term.ahead)[:, node]).max(), 1e-12)
    return np.abs(np.array(term.ahead)[:, node] - np.array(term.back)[:, node]).max() < 0.02 * size


def node_blocks(term: BodyContact, state) -> np.ndarray:
    columns = []
    for axis in range(3):
        direction = np.zeros((state.node_count, 3))
        direction[:, axis] = 1.0
        columns.append(products_of(term, state, nodes_at(direction)))
    return np.stack(columns, axis=2)


def test_the_matrix_without_its_negative_part_is_never_negative():
    mesh = ball(1.0, 2)
    places = around(mesh)
    term = contact(len(places), SolidBody(mesh))
    state = nodes_at(places)
    blocks = {exact: [] for exact in (0.0, 0.4, 1.0)}
    for exact, columns in blocks.items():
        for axis in range(3):
            direction = np.zeros_like(places)
            direction[:, axis] = 1.0
            columns.append(products_of(term, state, nodes_at(direction), exact))
    never, between, exact = (np.stack(columns, axis=2) for columns in blocks.values())
    size = np.abs(exact).max()
    assert np.linalg.eigvalsh(never).min() > -1e-12 * size  # rounding of products of eigenvectors
    assert np.linalg.eigvalsh(exact).min() < -1e-3 * size
    assert between == pytest.approx(0.6 * never + 0.4 * exact, abs=1e-12 * size)
    values, vectors = np.linalg.eigh(0.5 * (exact + exact.transpose(0, 2, 1)))
    expected = np.einsum("nij,nj,nkj->nik", vectors, np.maximum(values, 0.0), vectors)
    assert never == pytest.approx(expected, abs=1e-10 * size)


@pytest.mark.parametrize("x", [0.3, 0.7])
def test_pressure_on_a_flat_body_is_the_closed_form(x):
    cloth = sheet(6, 1.0, height=x * REACH)
    points, _links = cloth.points(2 * REACH, spacing=np.inf)
    term = BodyContact(
        points, SolidBody(box((2, 2, 1), (0, 0, -1))), pressure=500.0, scalar=scalar_named("float64"), device=cpu()
    )
    state = state_of(cloth.vertices)
    force = forces_of(term, state)
    slope = 7.5 + 49 * (0.5 - x) if x < 0.5 else 1 / x**3 - x
    assert force[:, 2].sum() == pytest.approx(500.0 * slope * 1.0)  # an area of 1 cm^2
    assert np.abs(force[:, :2]).max() < 1e-9 * force[:, 2].max()  # the rounding of the normal


def test_forces_are_continuous_in_a_concave_part():
    """Across the middle of a groove between two faces, where the nearest face changes."""
    corners = np.array([[-2, 1], [-2, -1], [2, -1], [2, 1], [0, 0]], dtype=float)  # a notch in the upper side
    low, high = (np.column_stack([corners[:, 0], np.full(5, y), corners[:, 1]]) for y in (-1, 1))
    sides = [[k, (k + 1) % 5, (k + 1) % 5 + 5, k + 5] for k in range(5)]
    caps = [[4, 3, 2], [4, 2, 1], [4, 1, 0]]
    faces = [*sides, *caps, *[[f + 5 for f in face[::-1]] for face in caps]]
    body = SolidBody(reversed_mesh(Mesh.from_polygons(np.concatenate([low, high]), faces)))
    at = np.array([[-1e-7, 0.0, 0.1], [1e-7, 0.0, 0.1]])
    force = forces_of(contact(2, body), nodes_at(at))
    assert np.abs(force[1] - force[0]).max() < 1e-4 * np.abs(force).max()  # 2e-7 cm times the stiffness
    assert force[0, 2] > 0.0


def reversed_mesh(mesh: Mesh) -> Mesh:
    faces = [mesh.face_vertex[a:b][::-1].tolist() for a, b in zip(mesh.face_start, mesh.face_start[1:], strict=False)]
    return Mesh.from_polygons(mesh.vertices, faces)


def test_forces_do_not_depend_on_the_place_of_the_world():
    """A body and points moved together: forces turn with them."""
    mesh = box((1.0, 0.8, 0.6))
    places = around(mesh)
    here = forces_of(contact(len(places), SolidBody(mesh)), nodes_at(places))
    motion = RigidMotion(np.zeros(1), np.array([[3.0, -2.0, 5.0]]), TURN[None], np.array([0.5, 0.0, 0.0]))
    there = forces_of(contact(len(places), SolidBody(mesh, motion)), nodes_at(motion.places_at(places, 0.0)))
    assert there == pytest.approx(here @ TURN.T, abs=1e-9 * np.abs(here).max())


def test_a_deformed_body_is_the_body_made_in_that_place():
    mesh = ball(1.0, 2)
    wide = mesh.vertices * [1.5, 1.0, 0.7]
    deforming = SolidBody(mesh, VertexMotion(np.array([0.0, 2.0]), np.stack([mesh.vertices, wide])))
    middle = Mesh.from_polygons(0.5 * (mesh.vertices + wide), mesh.face_vertex.reshape(-1, 3).tolist())
    places = around(middle)
    term = contact(len(places), deforming)
    state = nodes_at(places)
    term.begin_step(state, 0.5, 0.5)
    expected = forces_of(contact(len(places), SolidBody(middle)), state)
    assert forces_of(term, state) == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())


def test_a_body_in_motion_is_where_it_will_be_at_the_end_of_the_step():
    motion = RigidMotion(np.array([0.0, 1.0]), np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 4.0]]))
    term = contact(1, SolidBody(box((1, 1, 1)), motion))
    state = nodes_at(np.array([[0.0, 0.0, 3.1]]))
    term.begin_step(state, 0.4, 0.1)
    assert term.distances(state)[0] == pytest.approx(0.1)
    term.begin_step(state, 0.0, 0.0)
    assert term.distances(state)[0] == pytest.approx(2.1)


@pytest.mark.parametrize("speed", [10.0, 1e4])
def test_no_move_passes_through_the_surface(speed):
    """Points that are thrown at a ball stop above half the depth, wherever they come from."""
    mesh = ball(2.0, 3)
    rng = np.random.default_rng(1)
    places = rng.normal(size=(50, 3))
    places *= 3.0 / np.linalg.norm(places, axis=1)[:, None]
    term = contact(len(places), SolidBody(mesh), depth=0.5)
    for _ in range(10):
        direction = nodes_at(-speed * places)
        part = term.step_limit(nodes_at(places), direction)
        assert 0.0 < part <= 1.0
        moved = places - part * speed * places
        term.begin_step(nodes_at(moved), 0.0, 0.0)
        assert term.distances(nodes_at(moved)).min() > -0.26
        if term.energy(nodes_at(moved)) > 0.0:
            return
        places = moved
    raise AssertionError("no point has come to the surface")


def test_measured_distances_change_no_bit():
    """Points that have moved since the beginning of a step, and points of a term that has measured nothing."""
    mesh = ball(1.0, 2)
    rng = np.random.default_rng(2)
    start = rng.normal(size=(300, 3)) * [0.8, 0.8, 0.8]
    start = start[np.linalg.norm(start, axis=1) > 0.9]
    moved = start + 0.1 * rng.normal(size=start.shape)
    term, fresh = (contact(len(start), SolidBody(mesh)) for _ in range(2))
    term.begin_step(nodes_at(start), 0.0, 1e-3)
    state, direction = nodes_at(moved), random_direction(nodes_at(moved))
    assert np.abs(forces_of(term, state)).any(axis=1).sum() > 20
    assert (forces_of(term, state) == forces_of(fresh, state)).all()
    assert (products_of(term, state, direction) == products_of(fresh, state, direction)).all()
    assert term.energy(state) == fresh.energy(state)
    for k in range(5):  # small moves, most of which need no new measurement
        moved = moved + 0.004 * rng.normal(size=start.shape)
        term.begin_step(nodes_at(moved), 0.0, 1e-3)
        fresh.forget_distances()
        assert (forces_of(term, nodes_at(moved)) == forces_of(fresh, nodes_at(moved))).all(), k
    assert term.step_limit(state, nodes_at(0.1 * start)) <= fresh.step_limit(state, nodes_at(0.1 * start)) == 1.0


@pytest.mark.nightly
def test_single_precision_agrees():
    mesh = ball(1.0, 2)
    places = around(mesh)
    expected = forces_of(contact(len(places), SolidBody(mesh)), nodes_at(places))
    single = forces_of(contact(len(places), SolidBody(mesh), "float32"), nodes_at(places, "float32"))
    # places are rounded by 6e-8 cm; the stiffness is below 100 forces / reach
    assert np.abs(single - expected).max() < 1e-4 * np.abs(expected).max()
    far = np.linalg.norm(expected, axis=1) < 0.1 * np.abs(expected).max()
    assert np.abs(single - expected)[far].max() < 1e-4 * np.abs(expected).max()


def test_weights_and_vertices():
    """Points on triangles of half weight have half of the forces, and blocks are the diagonal."""
    cloth = sheet(4, 1.0, height=0.1)
    body = SolidBody(box((2, 2, 1), (0, 0, -1)))
    terms = [
        BodyContact(cloth.points(2 * REACH, weight=w)[0], body, scalar=scalar_named("float64"), device=cpu())
        for w in (1.0, 0.5)
    ]
    state = state_of(cloth.vertices)
    assert forces_of(terms[1], state) == pytest.approx(0.5 * forces_of(terms[0], state))
    blocks = blocks_of(terms[0], state)
    up = np.zeros_like(cloth.vertices)
    up[12, 2] = 1.0
    assert products_of(terms[0], state, state_of(up))[12] == pytest.approx(blocks[12, :, 2])


def test_refuses():
    mesh = box((1, 1, 1))
    with pytest.raises(
        ParameterError, match=r"^arm: got an open mesh, with 4 sides on a border; expected a closed one"
    ):
        SolidBody(Mesh.from_polygons(mesh.vertices, mesh.face_vertex.reshape(-1, 4)[1:].tolist()), name="arm")
    with pytest.raises(ParameterError, match=r"^body: got a mesh that is inside out \(volume -8 cm\^3\)"):
        SolidBody(reversed_mesh(mesh))
    with pytest.raises(ParameterError, match=r"got a motion of 7 vertices; expected 8"):
        SolidBody(mesh, VertexMotion(np.zeros(1), np.zeros((1, 7, 3))))
    for options in ({"thickness": -0.1}, {"pressure": 0.0}, {"depth": np.inf}):
        with pytest.raises(ParameterError, match=r"^body: got a"):
            contact(1, SolidBody(mesh), **options)
    term = contact(3, SolidBody(box((3, 3, 3))))
    with pytest.raises(SolverError) as raised:
        term.begin_step(nodes_at(np.array([[0.0, 0.0, 0.0], [9.0, 0.0, 0.0], [0.0, 1.0, 0.0]])), 0.0, 1e-3)
    expected = "body: 2 contact points, the deepest at node 0, are up to 3 cm inside; expected at most 1"
    assert str(raised.value) == f"{expected}; move the cloth out, or take shorter steps"
