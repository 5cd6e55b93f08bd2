# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The preconditioner is the inverse of P = S M + I - S on filtered vectors."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
import warp as wp

from stitchmesh.compute.device import device_named
from stitchmesh.compute.launch import launch
from stitchmesh.mixed.enrichment import preconditioner as preconditioner_file
from stitchmesh.mixed.enrichment.preconditioner import SHARE, Preconditioner
from stitchmesh.mixed.enrichment.region import Embedding, FreeUnknowns, Region, embed, region_around
from stitchmesh.mixed.mixed_vector import MixedBlocks, MixedVector
from tests.mixed.patch import enriched_everywhere, square_patch

CPU = device_named("cpu")
RUN = partial(launch, device=CPU)
PATCH = square_patch(5, 3)
REGIONS = {
    "square": region_around(*PATCH.layout, PATCH.near((0.5, 0.5), 0.25)),
    "one triangle": region_around(*PATCH.layout, [20]),
    "everywhere": enriched_everywhere(*PATCH.layout),
}


def masses(region: Region, ratio: float) -> tuple[np.ndarray, np.ndarray]:
    """Masses of vertices and nodes, with the largest ratio between a vertex and a node."""
    random = np.random.default_rng(6)
    vertices = np.exp(random.uniform(-0.5, 0.5, len(region.vertex_alpha)))
    return vertices, np.exp(random.uniform(-0.5, 0.5, len(region.nodes))) / ratio


def blocks_of(vertices: np.ndarray, nodes: np.ndarray, scalar) -> MixedBlocks:
    blocks = MixedBlocks.of_numbers(vertices, nodes, scalar, CPU)
    blocks.sliding.assign(nodes[:, None, None] * np.eye(2))
    return blocks


def forces_on(region: Region, scalar) -> MixedVector:
    random = np.random.default_rng(7)
    count = len(region.nodes)
    parts = [random.normal(size=shape) for shape in ((len(region.vertex_alpha), 3), (count, 3), (count, 2))]
    return MixedVector.from_numpy(*parts, scalar, CPU)


def solved(region: Region, free: FreeUnknowns, mass: tuple, force: MixedVector) -> tuple[Embedding, MixedVector]:
    embedding = embed(region)
    preconditioner = Preconditioner(embedding, free, mass, force.scalar, CPU, by_masses=True)
    preconditioner.set_metric(blocks_of(*mass, force.scalar))
    motion = force.like()
    preconditioner.launches(force, motion, RUN)
    return embedding, motion


def dense_system(embedding: Embedding, mass: tuple) -> tuple[np.ndarray, np.ndarray]:
    """S and M of equations 7 and 8 for the vertices and the hybrid nodes."""
    basis = embedding.basis.toarray()
    of_vertices, of_nodes = np.diag(mass[0]), np.diag(mass[1][embedding.nodes])
    full = np.block([[of_vertices + basis.T @ of_nodes @ basis, basis.T @ of_nodes], [of_nodes @ basis, of_nodes]])
    s = np.eye(len(full))
    s[len(mass[0]) :, len(mass[0]) :] -= basis @ np.linalg.pinv(basis)
    return s, full


@pytest.mark.parametrize(
    ("name", "ratio"), [("square", 1e-3), ("square", 1e6), ("one triangle", 1e3), ("everywhere", 1e3)]
)
def test_p_times_its_inverse_is_the_identity(name, ratio):
    region = REGIONS[name]
    mass, force = masses(region, ratio), forces_on(region, wp.float64)
    given = force.copy()
    embedding, motion = solved(region, FreeUnknowns.of(region), mass, force)
    basis, hybrid, unknown = embedding.basis.toarray(), embedding.nodes, region.unknown_vertices
    s, m = dense_system(embedding, mass)
    p = s @ m + np.eye(len(s)) - s
    (f_v, f_p, f_s), (v, nodes, sliding) = given.numpy(), motion.numpy()
    f_v = np.where(unknown[:, None], f_v, 0.0)
    r = s @ np.concatenate([f_v + basis.T @ f_p[hybrid], f_p[hybrid]])
    z = np.concatenate([v, nodes[hybrid] - basis @ v])
    # Rounding of float64, times the ratio of masses by which P enlarges differences of velocities.
    tolerance = 1e-12 * max(ratio, 1 / ratio) * np.abs(r).max()
    np.testing.assert_allclose((p @ z)[: len(v)][unknown], r[: len(v)][unknown], atol=tolerance)
    np.testing.assert_allclose((p @ z)[len(v) :], r[len(v) :], atol=tolerance)
    free = np.setdiff1d(np.arange(len(nodes)), hybrid)
    np.testing.assert_allclose(nodes[free], f_p[free] / mass[1][free, None], rtol=1e-13)
    slides = region.sliding_nodes
    np.testing.assert_allclose(sliding[slides], f_s[slides] / mass[1][slides, None], rtol=1e-13)
    assert not sliding[~slides].any()


def test_the_result_is_symmetric_and_satisfies_the_constraint_and_the_rest_of_the_force_is_mass_times_motion():
    """In single precision."""
    region = REGIONS["square"]
    mass = masses(region, 1e2)
    first, second = forces_on(region, wp.float32), forces_on(region, wp.float32)
    second.values.assign(second.values.numpy()[::-1].copy())
    given = [first.copy(), second.copy()]
    embedding, one = solved(region, FreeUnknowns.of(region), mass, first)
    _, two = solved(region, FreeUnknowns.of(region), mass, second)
    rounding = 1e-5  # sums of some 100 numbers
    v, nodes, _ = one.numpy()
    assert np.abs(embedding.constraint(v, nodes)).max() < 30 * rounding * np.abs(nodes).max()
    left, right = (a.values.numpy().astype(float) @ b.values.numpy() for a, b in ((two, given[0]), (one, given[1])))
    assert abs(left - right) < 10 * rounding * abs(left)
    f_v, f_p, _ = first.numpy()
    f_v[~region.unknown_vertices] = 0.0
    np.testing.assert_allclose(f_v, mass[0][:, None] * v, atol=10 * rounding * np.abs(f_v).max())
    np.testing.assert_allclose(f_p, mass[1][:, None] * nodes, atol=10 * rounding * np.abs(f_p).max())


def test_fixed_vertices_and_nodes_do_not_move_and_the_rest_still_satisfies_the_constraint():
    region = REGIONS["everywhere"]
    fixed_vertices, fixed_nodes = [0, 1, 5], [3, 4, 60]
    free = FreeUnknowns.of(region, fixed_vertices=fixed_vertices, fixed_nodes=fixed_nodes)
    force = forces_on(region, wp.float64)
    embedding, motion = solved(region, free, masses(region, 1e2), force)
    v, nodes, _ = motion.numpy()
    assert not v[fixed_vertices].any()
    assert not nodes[fixed_nodes].any()
    assert np.abs(embedding.constraint(v, nodes)).max() < 1e-11 * np.abs(nodes).max()  # rounding of float64


def test_where_all_is_fixed_nothing_moves_and_all_is_finite():
    region = REGIONS["square"]
    free = FreeUnknowns.of(region, fixed_vertices=np.arange(36), fixed_nodes=np.arange(225))
    _, motion = solved(region, free, masses(region, 1.0), forces_on(region, wp.float64))
    assert not motion.values.numpy().any()


def test_the_metric_of_the_masses_scales_with_its_factor_and_keeps_its_projection():
    region = REGIONS["square"]
    mass, embedding = masses(region, 1e2), embed(region)
    preconditioner = Preconditioner(embedding, FreeUnknowns.of(region), mass, wp.float64, CPU, by_masses=True)
    results = []
    for factor in (1.0, 1e6, 1.0):
        preconditioner.set_metric(blocks_of(factor * mass[0], factor * mass[1], wp.float64), of_mass=factor)
        force = forces_on(region, wp.float64)
        motion = force.like()
        preconditioner.launches(force, motion, RUN)
        results.append((factor * motion.values.numpy(), force.values.numpy().copy()))
    for motion, filtered in results[1:]:
        np.testing.assert_allclose(motion, results[0][0], rtol=1e-9)  # rounding times the ratio of masses
        np.testing.assert_allclose(filtered, results[0][1], atol=1e-11)


def random_blocks(region: Region, scalar) -> tuple[tuple[np.ndarray, np.ndarray], MixedBlocks]:
    """Positive blocks with condition numbers of some tens, and their masses, which are smaller."""
    random = np.random.default_rng(17)
    mass = masses(region, 1e2)
    blocks = blocks_of(*mass, scalar)
    for array, numbers in ((blocks.vertices, mass[0]), (blocks.nodes, mass[1])):
        root = random.normal(size=(len(numbers), 3, 3))
        array.assign(numbers[:, None, None] * (root @ root.swapaxes(1, 2) + 0.3 * np.eye(3)))
    return mass, blocks


@pytest.mark.parametrize("most_rows", [0, 400])
def test_the_result_in_a_metric_of_blocks_minimizes_the_work_under_the_constraint(monkeypatch, most_rows):
    monkeypatch.setattr(preconditioner_file, "MOST_BLOCK_ROWS", most_rows)
    region = REGIONS["square"]
    mass, blocks = random_blocks(region, wp.float64)
    embedding, free = embed(region), FreeUnknowns.of(region)
    preconditioner = Preconditioner(embedding, free, mass, wp.float64, CPU, by_masses=False)
    preconditioner.set_metric(blocks)
    force = forces_on(region, wp.float64)
    (f_v, f_p, _), motion = force.numpy(), force.like()
    preconditioner.launches(force, motion, RUN)
    v, p, _ = motion.numpy()
    moved = region.unknown_vertices & embedding.coupled[0]
    metric = []
    for block, taken in ((blocks.vertices.numpy(), moved), (blocks.nodes.numpy(), embedding.coupled[1])):
        mean = np.trace(block, axis1=1, axis2=2)[taken, None, None] / 3 * np.eye(3)
        metric.append(block[taken] + SHARE * mean if most_rows else mean)
    # D z is the force but for a combination E' mu of the constraints: it is orthogonal to all p = B w + F x
    left = np.zeros_like(v)
    left[moved] = f_v[moved] - np.einsum("nij,nj->ni", metric[0], v[moved])
    rest = f_p[embedding.nodes] - np.einsum("nij,nj->ni", metric[1], p[embedding.nodes])
    mu = np.linalg.lstsq(embedding.independent.toarray(), rest, rcond=None)[0]
    # bounds of the vertices that have hardly any mass are 1e-5 of the masses of their nodes
    np.testing.assert_allclose(embedding.independent @ mu, rest, atol=1e-11)
    np.testing.assert_allclose((embedding.gram.T @ mu + left)[moved], 0.0, atol=1e-4 * np.abs(f_v).max())
    assert np.abs(embedding.constraint(v, p)).max() < 1e-11 * np.abs(p).max()  # rounding times the ratio of masses


def test_the_projection_in_a_metric_of_blocks_is_idempotent():
    region = REGIONS["everywhere"]
    mass, blocks = random_blocks(region, wp.float64)
    free = FreeUnknowns.of(region, fixed_vertices=[0, 1], fixed_nodes=[7])
    preconditioner = Preconditioner(embed(region), free, mass, wp.float64, CPU, by_masses=False)
    preconditioner.set_metric(blocks)
    motion = forces_on(region, wp.float64)
    preconditioner.project_launches(motion, RUN)
    once = motion.values.numpy().copy()
    preconditioner.project_launches(motion, RUN)
    # rounding times the condition number of Sigma, some 1,000
    np.testing.assert_allclose(motion.values.numpy(), once, atol=1e-12 * np.abs(once).max())


def test_positions_and_eulerian_coordinates_of_free_nodes_are_solved_together():
    region = region_around(*PATCH.layout, np.arange(50))
    vertices, yarns = masses(region, 1.0)
    random = np.random.default_rng(13)
    along = random.normal(size=(2, len(yarns), 3))
    blocks = blocks_of(vertices, 2 * yarns, wp.float64)
    sliding = yarns[:, None] * (along**2).sum(axis=2).T * 1.01
    blocks.sliding.assign(sliding[:, :, None] * np.eye(2))
    for array, w in ((blocks.coupling_u, along[0]), (blocks.coupling_v, along[1])):
        array.assign(-w * yarns[:, None])
    free = FreeUnknowns.of(region)
    preconditioner = Preconditioner(embed(region), free, (vertices, yarns), wp.float64, CPU, by_masses=False)
    preconditioner.set_metric(blocks)
    force = forces_on(region, wp.float64)
    (_, f_p, f_s), motion = force.numpy(), force.like()
    preconditioner.launches(force, motion, RUN)
    _, p, s = motion.numpy()
    rounding = 1e-11  # times the condition number of a block, at most some 1,000
    by_yarn = -np.einsum("kni,nk->ni", along, s * yarns[:, None])
    np.testing.assert_allclose(2 * yarns[:, None] * p + by_yarn, f_p, atol=rounding)
    np.testing.assert_allclose(sliding * s - np.einsum("kni,ni->nk", along, p) * yarns[:, None], f_s, atol=rounding)
