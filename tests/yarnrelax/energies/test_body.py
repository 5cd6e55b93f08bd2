# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Collision with a body: distances, forces, and yarns that relax to rest on the body."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
import warp as wp
from scipy.optimize import brentq

from stitchmesh.compute.kernel import kernel
from stitchmesh.errors import ParameterError, SolverError
from stitchmesh.io import read_mesh
from stitchmesh.lattice import Lattice
from stitchmesh.mesh import Mesh
from stitchmesh.quality import Quality, quality_named
from stitchmesh.simulation.bodies.body_surface import gap_to
from stitchmesh.simulation.bodies.mesh_features import mesh_features
from stitchmesh.simulation.dead_load import EARTH, Gravity
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.assembled_hessian import HessianAssembly
from stitchmesh.yarnrelax.energies.body import DEPTH, Body, put_surface
from tests.gallery import shared
from tests.yarnrelax.hessian import scenes as hessian_scenes
from tests.yarnrelax.hessian.scenes import assembled_hessian
from tests.yarnrelax.one_term import OneTerm, on_device

MATTER = YarnMaterial.named("leaf")
BOX = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
SHEET = [[0, 1, 2, 3], [1, 4, 5, 2]]


def box(half: tuple[float, float, float] = (1.0, 1.0, 1.0)) -> Mesh:
    """A box around the origin, with outward normals."""
    ring = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    corners = np.concatenate([np.column_stack([ring, np.full(4, z)]) for z in (-1, 1)])
    return Mesh.from_polygons(corners * np.array(half), BOX)


def divided(mesh: Mesh, times: int) -> Mesh:
    """The same quadrilaterals, each divided into four, repeated a number of times."""
    corners, faces = mesh.vertices, mesh.face_vertex.reshape(-1, 4)
    for _ in range(times):
        sides = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2)
        edges, middle = np.unique(np.sort(sides.reshape(-1, 2), axis=1), axis=0, return_inverse=True)
        middle = middle.reshape(faces.shape) + len(corners)
        centre = len(corners) + len(edges) + np.arange(len(faces))
        corners = np.concatenate([corners, corners[edges].mean(axis=1), corners[faces].mean(axis=1)])
        quads = [np.stack([faces[:, k], middle[:, k], centre, middle[:, k - 1]], axis=1) for k in range(4)]
        faces = np.concatenate(quads)
    return Mesh.from_polygons(corners, faces.tolist())


def sphere(radius: float) -> Mesh:
    """A sphere around the origin: the vertices of a divided box, projected to the sphere."""
    mesh = divided(box(), 3)
    return replace(mesh, vertices=radius * mesh.vertices / np.linalg.norm(mesh.vertices, axis=1, keepdims=True))


@cache
def person() -> Mesh:
    return read_mesh(shared("meshes/makehuman-body.obj"), unit="dm")


def ring(radius: float, height: float, count: int, thick: float, *, at: tuple[float, float] = (0.0, 0.0)) -> YarnSet:
    """A closed yarn around the y axis."""
    angle = 2 * np.pi * np.arange(count) / count
    points = np.stack([at[0] + radius * np.sin(angle), height + 0 * angle, at[1] + radius * np.cos(angle)], axis=1)
    return YarnSet.from_curves([points], closed=[True], radius=thick)


@kernel
def measure(surface: Any, limit: wp.float64, samples: wp.array[wp.vec4d], gap: wp.array[wp.vec4d]) -> None:
    p = wp.tid()
    gap[p] = gap_to(surface, samples[p], limit)


def gaps(mesh: Mesh, places: np.ndarray, limit: float = 1e6) -> tuple[np.ndarray, np.ndarray]:
    """Directions and signed distances of points in float64, shapes (n, 3) and (n,); the unit of length is 1 cm."""
    surface = put_surface(on_device(ring(4.0, 0.0, 8, 1.0)), mesh)
    samples = wp.array(np.column_stack([places, 0 * places[:, 0]]), dtype=wp.vec4d, device="cpu")
    found = wp.zeros_like(samples)
    inputs = [surface.constants, wp.float64(limit), samples]
    wp.launch(measure, len(places), inputs=inputs, outputs=[found], device="cpu")
    return found.numpy()[:, :3], found.numpy()[:, 3]


def winding_number(mesh: Mesh, places: np.ndarray) -> np.ndarray:
    """Winding number of the surface around each point: its solid angle over 4 pi (van Oosterom, Strackee 1983)."""
    triangles = mesh_features(mesh).corners
    number = []
    for place in places:
        a, b, c = (triangles - place).transpose(1, 0, 2)
        la, lb, lc = (np.linalg.norm(side, axis=1) for side in (a, b, c))
        volume = np.einsum("td,td->t", a, np.cross(b, c))
        below = la * lb * lc + (a * b).sum(axis=1) * lc + (b * c).sum(axis=1) * la + (c * a).sum(axis=1) * lb
        number.append(np.arctan2(volume, below).sum() / (2 * np.pi))
    return np.array(number)


def box_distance(places: np.ndarray) -> np.ndarray:
    """Signed distance from the surface of the box of half size 1, in closed form."""
    over = np.abs(places) - 1.0
    return np.linalg.norm(np.maximum(over, 0.0), axis=1) + np.minimum(over.max(axis=1), 0.0)


def test_distance_from_a_box_is_exact_at_faces_edges_and_corners() -> None:
    places = np.random.default_rng(1).uniform(-2.0, 2.0, size=(2000, 3))
    direction, distance = gaps(box(), places)
    # float32 chooses among features whose distances agree within 1e-7, which changes the distance by as much
    np.testing.assert_allclose(distance, box_distance(places), atol=1e-6)
    assert np.median(np.abs(distance - box_distance(places))) < 1e-15  # the distance itself is computed in float64
    ahead = gaps(box(), places + 1e-4 * direction)[1]
    outside = distance > 0.0
    np.testing.assert_allclose((ahead - distance)[outside], 1e-4, rtol=1e-6)  # d is smooth outside a convex body


def test_the_sign_is_that_of_the_winding_number_on_the_body() -> None:
    mesh, noise = person(), np.random.default_rng(2)
    triangles = mesh_features(mesh).corners
    chosen = triangles[noise.integers(0, len(triangles), 300)]
    places = np.einsum("nk,nkd->nd", noise.dirichlet([1, 1, 1], 300), chosen) + noise.normal(size=(300, 3))
    distance = gaps(mesh, places)[1]
    assert 100 < (distance < 0.0).sum() < 200
    assert np.array_equal(distance < 0.0, winding_number(mesh, places) > 0.5)


def test_points_beyond_the_border_of_an_open_surface_are_outside() -> None:
    floor = Mesh.from_polygons([[-1, 0, -1], [-1, 0, 1], [1, 0, 1], [1, 0, -1]], [[0, 1, 2, 3]])
    direction, distance = gaps(floor, np.array([[0.2, -0.3, 0.1], [0.2, 0.3, 0.1], [1.3, -0.4, 0.0], [1.3, 0.4, 0.0]]))
    np.testing.assert_allclose(distance, [-0.3, 0.3, 0.5, 0.5], rtol=1e-12)
    expected = [[0, 1, 0], [0, 1, 0], [0.6, -0.8, 0], [0.6, 0.8, 0]]
    np.testing.assert_allclose(direction, expected, atol=1e-12)


def test_degenerate_triangles_and_duplicate_vertices_do_not_matter() -> None:
    whole = mesh_features(box())
    # Each face has its own vertices, one of them twice; vertices at the same position must be merged.
    corners = box().vertices[np.array(BOX)[:, [0, 1, 2, 3, 3]]].reshape(-1, 3)
    found = mesh_features(Mesh.from_polygons(corners, np.arange(30).reshape(6, 5).tolist()))
    assert len(found.corners) == 12
    assert found.shares.sum() == whole.shares.sum()
    for features in (whole, found):  # The diagonals of a cube around 0 lie between the normals of three faces.
        np.testing.assert_allclose(features.outward[:, 4:], features.corners / np.sqrt(3), atol=1e-12)


def test_the_shares_of_features_count_every_point_once() -> None:
    """The sum of all shares is the Euler characteristic of the surface: 2 for a sphere, 1 for a disc."""
    sheet = Mesh.from_polygons([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0], [2, 1, 0]], SHEET)
    for mesh, characteristic in ((sphere(1.0), 2.0), (sheet, 1.0)):
        features = mesh_features(mesh)
        assert len(features.corners) + features.shares.sum() == characteristic


def test_force_is_minus_the_gradient() -> None:
    """A part of the ring is inside the sphere and a part outside, so that both pieces of the penalty occur."""
    body, yarns = Body(sphere(2.0), thickness=0.05), ring(1.9, 0.3, 24, 0.4)
    noise = np.random.default_rng(4)
    points = yarns.points + noise.normal(scale=0.1, size=yarns.points.shape)
    scene = OneTerm.of(on_device(yarns), body)
    force = scene.forces(points)
    direction = noise.normal(size=points.shape)
    # truncation error: step^2 over the smallest radius^2, and the distance is not smooth across edges of the mesh
    assert scene.slope(points, direction, 1e-5) == pytest.approx(-(force * direction).sum(), rel=1e-5)
    assert np.count_nonzero(np.linalg.norm(force, axis=1)) > len(points) / 4


@pytest.mark.parametrize("side", [1.0, 0.6])
def test_the_stiffness_is_minus_the_derivative_of_the_force(side: float) -> None:
    """Beside faces, edges and corners of a box, outside and inside; the yarn itself adds what it has without a box."""
    yarns = ring(side * 1.5, 0.9, 24, 0.25)
    alone, beside = (hessian_scenes.started(yarns, MATTER, terms) for terms in ([], [Body(box())]))
    matrix = assembled_hessian(beside) - assembled_hessian(alone)
    assert abs(matrix).max() > 0.1 * abs(assembled_hessian(alone)).max()
    motion = np.random.default_rng(3).normal(size=yarns.points.shape)
    expected = hessian_scenes.derivative_of_forces(beside, motion) - hessian_scenes.derivative_of_forces(alone, motion)
    hessian_scenes.assert_close((matrix @ motion.ravel()).reshape(-1, 3), expected)


def test_without_its_exact_share_the_stiffness_is_never_negative() -> None:
    yarns = ring(1.5, 0.9, 24, 0.25)
    alone, beside = (hessian_scenes.started(yarns, MATTER, terms) for terms in ([], [Body(box())]))
    whole, none = np.ones(24), np.zeros(24)
    exact, kept = (
        (HessianAssembly(beside).matrix(share) - HessianAssembly(alone).matrix(share)).toarray()
        for share in (whole, none)
    )
    largest = np.linalg.eigvalsh(exact)[-1]
    assert np.linalg.eigvalsh(exact)[0] < -1e-3 * largest
    assert np.linalg.eigvalsh(kept)[0] > -1e-12 * largest  # rounding


def test_the_energy_around_a_box_does_not_depend_on_its_subdivision() -> None:
    """The energy is that of the closed-form distance: faces, edges and corners of a convex body each count once."""
    noise = np.random.default_rng(8)
    middles = noise.normal(size=(200, 1, 3))
    middles *= noise.uniform(1.1, 1.7, size=(200, 1, 1)) / np.abs(middles).max(axis=2, keepdims=True)
    curves = middles + noise.normal(scale=0.05, size=(200, 4, 3))  # short yarns on all sides of the box
    yarns = YarnSet.from_curves(list(curves), closed=[False] * 200, radius=0.8)
    scenes = [OneTerm.of(on_device(yarns), Body(mesh)) for mesh in (box(), divided(box(), 2))]
    found = [scene.energy() for scene in scenes]
    model, samples = scenes[0].model, scenes[0].state.samples.numpy()[:, :3]
    distance = box_distance(model.from_device(model.upload(samples, 3)))
    assert distance.min() > 0.0
    counts = np.diff(model.sample_start)
    weights = np.repeat(yarns.rest_length / counts, counts)
    energies = [w * penalty(d / 0.8) if d < 0.8 else 0.0 for w, d in zip(weights, distance, strict=True)]
    expected = 2 * 0.8 * MATTER.k_contact * sum(energies)
    # float32 decides whether a feature at the limit of the range is found; there f is 1e-12
    assert found == pytest.approx([expected] * 2, rel=1e-9)


def valley() -> Mesh:
    """Two planes that descend towards the x axis at 45 degrees."""
    ends = [[-9.0, 9.0], [0.0, 0.0], [9.0, 9.0]]
    corners = [[x, y, z] for x in (-20.0, 20.0) for z, y in ends]
    return Mesh.from_polygons(corners, [[0, 1, 4, 3], [1, 2, 5, 4]])


def test_a_loaded_yarn_relaxes_to_rest_in_a_valley() -> None:
    """Both planes carry the load: q = k_body (2 g(h / sqrt 2) / sqrt 2 - g(h)) / R at the height h above the edge.

    Here g = -f'. The second term is the share of the edge between the planes. If only the nearest plane
    exerted a force, there would be no equilibrium.
    """
    radius, weight = 0.25, 5e4
    matter = replace(MATTER, mass_per_length=weight / -EARTH[1])
    yarns = straight(12, 0.0)
    yarns = replace(yarns, points=yarns.points + np.array([0.0, 0.5, 0.2]))
    quality = Quality("float64", 3, 3, 12, 0.2, 1e-5, 5000)
    result = relax_yarns(yarns, material=matter, quality=quality, device="cpu", terms=[Gravity(), Body(valley())])
    assert result.report["converged"]

    def g(x: float) -> float:
        return 2 / x**3 - 2 * x if 0.5 < x < 1 else 0.0

    whole, root = 2 * radius * MATTER.k_contact / radius, np.sqrt(2)
    height = brentq(lambda h: whole * (2 * g(h / root) / root - g(h)) - weight, 0.501 * root, root)
    assert height < 1.0  # the edge is in range
    middle = result.yarns.sampled(4)[0][len(result.yarns.rest_length) * 2]
    assert middle[1] / radius == pytest.approx(height, rel=1e-4)  # ten times the residual
    assert abs(middle[2]) < 1e-4 * radius


def straight(length: int, height: float, radius: float = 0.25) -> YarnSet:
    points = np.zeros((4 * length + 3, 3))
    points[:, 0], points[:, 1] = (np.arange(len(points)) - (len(points) - 1) / 2) / 4, height
    return YarnSet.from_curves([points], closed=[False], radius=radius)


def lifted(yarns: YarnSet, height: float) -> np.ndarray:
    """Control points of a yarn, moved up by ``height``."""
    return yarns.points + np.array([0.0, height, 0.0])


def penalty(x: float) -> float:
    """The function f in the documentation of the module ``body_penalty``."""
    return 1 / x**2 + x**2 - 2 if x > 0.5 else 2.25 - 15 * (x - 0.5) + 49 * (x - 0.5) ** 2


@pytest.mark.parametrize("x", [0.9, 0.3, -2.0])
def test_a_straight_yarn_over_a_flat_body_has_the_energy_of_the_formula(x: float) -> None:
    thickness, stiffness, radius = 0.05, 0.7, 0.25
    yarns = straight(6, 0.0)
    body = Body(box((8.0, 3.0, 8.0)), thickness=thickness, stiffness=stiffness)
    scene = OneTerm.of(on_device(yarns), body)
    place = lifted(yarns, 3.0 + x * (radius + thickness))
    energy, force = scene.energy(place), scene.forces(place)
    whole = 2 * radius * MATTER.k_contact * stiffness * 6.0  # k_body times the length
    assert energy == pytest.approx(whole * penalty(x), rel=1e-9)  # rounding of coordinates near 3
    slope = (penalty(x + 1e-5) - penalty(x - 1e-5)) / 2e-5  # truncation: 1e-10 times f''', at most 200
    assert force[:, 1].sum() == pytest.approx(-whole * slope / (radius + thickness), rel=1e-7)
    np.testing.assert_allclose(force[:, [0, 2]], 0.0, atol=1e-9 * force[:, 1].max())


def sample_forces(scene: OneTerm, points: np.ndarray) -> np.ndarray:
    """Force and stiffness of each sample, shape (S, 4) [units]."""
    scene.forces(points)
    return scene.state.sample_force.numpy().copy()


def test_skipping_searches_out_of_range_changes_no_bit() -> None:
    """A yarn moves into a box and out again: one term is used for all positions, and a new term for each position."""
    yarns = straight(4, 0.0)
    model = on_device(yarns, precision="float32")
    body, noise = Body(box()), np.random.default_rng(6)
    reused = OneTerm.of(model, body)
    turn = np.linalg.qr(noise.normal(size=(3, 3)))[0]
    for height in np.concatenate([np.arange(2.5, 0.6, -0.07), np.arange(0.6, 2.5, 0.11)]):
        points = lifted(yarns, height) @ turn
        fresh = OneTerm.of(model, body)
        assert np.array_equal(sample_forces(reused, points), sample_forces(fresh, points))
        assert reused.energy(points) == fresh.energy(points)


@pytest.mark.nightly
def test_a_ring_tightened_around_the_waist_lies_on_the_body() -> None:
    thick = 0.4
    yarns = ring(15.0, 22.0, 120, thick, at=(0.0, 6.0))
    yarns = replace(yarns, rest_length=0.7 * yarns.rest_length)
    body = person()
    matter = MATTER.scaled(thick / 0.125)
    quality = replace(quality_named("draft"), tolerance=1e-3)
    result = relax_yarns(yarns, material=matter, quality=quality, device="cpu", terms=[Body(body)])
    assert result.report["converged"]
    curve = result.yarns.sampled(4)[0]
    assert (np.abs(winding_number(body, curve)) < 0.5).all()  # all outside
    distance = gaps(body, curve)[1] / thick
    assert 0.5 < distance.min() < 1.0  # the ring touches the body, and the penetration is less than half a radius
    assert (distance < 1.0).mean() > 0.3  # elsewhere the ring spans concave regions


OUTSIDE = ring(2.0, 0.0, 12, 0.1)


def line_on_lattice() -> YarnSet:
    """A straight yarn that runs through a lattice."""
    lattice = Lattice(np.array([[4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]))
    return YarnSet(
        points=straight(1, 0.0).points[:4], start=[0, 4], closed=[True], radius=[0.1], rest_length=np.ones(4),
        row=np.zeros(4), face=np.zeros(4), part=np.zeros(4), lattice=lattice, lattice_step=[[1, 0]],
    )  # fmt: skip


def test_yarns_too_deep_in_a_closed_body_are_refused() -> None:
    yarns = replace(ring(0.4, 0.0, 12, 0.05), face=np.full(12, 7))
    with pytest.raises(SolverError, match=r"yarn 0 \(control point \d+, stitch face 7\): 0.7\d* cm inside the body"):
        relax_yarns(yarns, material=MATTER, quality="draft", device="cpu", terms=[Body(box())])
    assert DEPTH * 0.05 < 0.7


@pytest.mark.parametrize(
    ("mesh", "options", "yarns", "message"),
    [
        (box(), {}, line_on_lattice(), "body: got yarns on a lattice"),
        (Mesh.from_polygons(box().vertices, [face[::-1] for face in BOX]), {}, OUTSIDE, "look inwards"),
        (box(), {"thickness": -0.1}, OUTSIDE, "thickness"),
        (box(), {"thickness": np.nan}, OUTSIDE, "thickness"),
        (box(), {"stiffness": 0.0}, OUTSIDE, "stiffness"),
        (box(), {"material": replace(MATTER, k_contact=0.0)}, OUTSIDE, "k_contact"),
    ],
)
def test_what_cannot_collide_is_refused(mesh: Mesh, options: dict[str, Any], yarns: YarnSet, message: str) -> None:
    material = options.pop("material", MATTER)
    with pytest.raises(ParameterError, match=message):
        relax_yarns(yarns, material=material, quality="draft", device="cpu", terms=[Body(mesh, **options)])
