# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Blended masses keep mass and first moment; the mass matrix is that of the kinetic energy of crossing yarns."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
import warp as wp

from stitchmesh.compute.device import device_named
from stitchmesh.compute.launch import launch
from stitchmesh.compute.precision import vector
from stitchmesh.errors import ParameterError
from stitchmesh.mixed.dynamics.mass_matrix import BlendedMasses, MassMatrix, blend_masses
from stitchmesh.mixed.enrichment.region import HYBRID, YARNS, region_around
from stitchmesh.mixed.mixed_vector import MixedBlocks, MixedVector
from tests.mixed.dynamics.scene import MASS, crossing_masses, masses_of
from tests.mixed.patch import enriched_everywhere, square_patch

CPU = device_named("cpu")
RUN = partial(launch, device=CPU)
PATCH = square_patch(6, 4)
CHOSEN = PATCH.near((0.5, 0.5), 0.2)


@pytest.mark.parametrize("rings", [1, 2])
def test_mass_of_the_enriched_region_is_that_of_its_yarns_and_the_centre_nearly(rings):
    region = region_around(*PATCH.layout, CHOSEN, rings=rings)
    segments = PATCH.segments()
    mass = np.random.default_rng(8).uniform(0.5, 1.0, len(segments))
    blended = blend_masses(region, segments, mass, np.zeros((len(segments), 2)), np.zeros(len(region.triangles)))
    within = np.isin(region.node_kind[segments], (HYBRID, YARNS))
    half = np.repeat(mass / 2, 2)[within.ravel()]
    points = PATCH.nodes[segments.ravel()[within.ravel()]]
    # Sums of some 500 numbers of size 1.
    np.testing.assert_allclose(blended.total, half.sum(), rtol=1e-13)
    moment = blended.vertices @ PATCH.vertices + blended.nodes @ PATCH.nodes[region.nodes]
    # Segments between full-yarn and hybrid triangles give the part 1 - alpha to their hybrid end, half a spacing away.
    np.testing.assert_allclose(moment / half.sum(), half @ points / half.sum(), atol=0.1 / PATCH.nodes_a_side)


def test_without_a_region_the_triangles_have_the_mass_and_with_yarns_everywhere_the_yarns():
    none = masses_of(PATCH, region_around(*PATCH.layout, []))
    np.testing.assert_allclose(none.vertices.sum(), MASS, rtol=1e-14)
    for region in (enriched_everywhere(*PATCH.layout), region_around(*PATCH.layout, np.arange(72))):
        full = masses_of(PATCH, region)
        assert not full.vertices.any()
        np.testing.assert_allclose(full.nodes.sum(), MASS, rtol=1e-13)


def test_a_hybrid_triangle_without_nodes_has_the_mass_of_its_cloth():
    coarse = square_patch(2, 1)
    region = region_around(*coarse.layout, [0], rings=2)
    empty = np.setdiff1d(np.flatnonzero(region.triangle_kind == HYBRID), coarse.node_triangle)
    assert len(empty) > 0
    segments = coarse.segments()
    blended = blend_masses(region, segments, np.zeros(4), np.zeros((4, 2)), np.ones(8))
    np.testing.assert_allclose(blended.vertices.sum(), (1 - region.triangle_alpha[empty]).sum(), rtol=1e-14)


def test_wrong_masses_are_refused():
    region = region_around(*PATCH.layout, CHOSEN)
    segments = PATCH.segments()
    with pytest.raises(ParameterError, match="masses: got segments and triangles of shapes"):
        blend_masses(region, segments, np.ones(3), np.zeros_like(segments), np.ones(72))
    with pytest.raises(ParameterError, match="a mass that is negative or not finite"):
        BlendedMasses(np.array([-1.0]), np.zeros((0, 2)))


def kinetic_energy(mass: BlendedMasses, along: np.ndarray, motion: MixedVector) -> float:
    v, p, s = motion.numpy()
    by_yarn = p[:, None] - along * s[:, :, None]
    return 0.5 * float(mass.vertices @ (v**2).sum(axis=1) + np.sum(mass.yarns * (by_yarn**2).sum(axis=2)))


@pytest.mark.parametrize("scalar", [wp.float32, wp.float64])
def test_products_and_blocks_belong_to_the_kinetic_energy_of_sliding_yarns(scalar):
    random = np.random.default_rng(9)
    mass = BlendedMasses(random.uniform(1, 2, 5), random.uniform(0.1, 1, (7, 2)))
    along = random.normal(size=(7, 2, 3))
    matrix = MassMatrix(mass, scalar, CPU, crossing_masses(mass.yarns, scalar, along))
    parts = [random.normal(size=shape) for shape in ((5, 3), (7, 3), (7, 2))]
    motion = MixedVector.from_numpy(*parts, scalar, CPU)
    product = motion.copy()
    factors = wp.array([[2.0, 3.0]], dtype=vector(2, scalar), device=CPU)
    matrix.combine_products(factors, motion, product, RUN)
    own = motion.values.numpy().astype(float)
    work = own @ product.values.numpy() - 3.0 * own @ own
    rounding = 1e-5 if scalar is wp.float32 else 1e-13  # sums of 50 numbers of size 1
    assert work == pytest.approx(4.0 * kinetic_energy(mass, along, motion), rel=rounding)
    blocks = MixedBlocks.zeros(5, 7, scalar, CPU)
    matrix.combine_blocks(wp.array([[1.0, 0.0]], dtype=vector(2, scalar), device=CPU), blocks, RUN)
    for number, size in ((0, 3), (1, 3), (2, 2)):
        for k in range(size):
            alone = [np.zeros_like(part) for part in parts]
            alone[number][:, k] = 1.0
            energy = kinetic_energy(mass, along, MixedVector.from_numpy(*alone, scalar, CPU))
            block = (blocks.vertices, blocks.nodes, blocks.sliding)[number].numpy()
            assert 0.5 * block[:, k, k].sum() == pytest.approx(energy, rel=rounding)


def test_yarn_that_slides_as_fast_as_its_node_moves_has_no_kinetic_energy():
    mass = BlendedMasses(np.zeros(0), np.array([[0.5, 0.0]]))
    crossing = crossing_masses(mass.yarns, wp.float64, np.array([[[0.0, 2.0, 0.0], [0.0, 0.0, 0.0]]]))
    matrix = MassMatrix(mass, wp.float64, CPU, crossing)
    motion = MixedVector.from_numpy(np.zeros((0, 3)), [[0.0, 6.0, 0.0]], [[3.0, 0.0]], wp.float64, CPU)
    product = motion.like()
    unit = wp.array([[1.0, 0.0]], dtype=wp.vec2d, device=CPU)
    matrix.combine_products(unit, motion, product, RUN)
    assert not product.values.numpy().any()
