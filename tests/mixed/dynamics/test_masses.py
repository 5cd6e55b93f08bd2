# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Masses of triangles, seams and yarns are kept by blending, and the mass matrix is that of crossing yarns."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
import warp as wp

from stitchmesh.compute.device import device_named
from stitchmesh.compute.launch import launch
from stitchmesh.errors import ParameterError
from stitchmesh.mixed.assembly import rod_masses, triangle_masses
from stitchmesh.mixed.dynamics.mass_matrix import BlendedMasses, MassMatrix, blend_masses
from stitchmesh.mixed.enrichment.region import HYBRID, YARNS, region_around
from stitchmesh.mixed.mixed_vector import MixedBlocks, MixedVector
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial
from stitchmesh.mixed.triangles.seam_rod import SeamMaterial
from tests.mixed.dynamics.scene import crossing_masses
from tests.mixed.patch import square_patch
from tests.mixed.triangles.flat_cloths import rectangle, with_seam

CPU = device_named("cpu")
RUN = partial(launch, device=CPU)
PATCH = square_patch(6, 4)
CHOSEN = PATCH.near((0.5, 0.5), 0.2)


def test_mass_of_the_enriched_region_is_that_of_its_yarns_and_the_centre_nearly():
    region = region_around(*PATCH.layout, CHOSEN, rings=2)
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


def test_products_and_blocks_belong_to_the_kinetic_energy_of_sliding_yarns():
    random = np.random.default_rng(9)
    mass = BlendedMasses(random.uniform(1, 2, 5), random.uniform(0.1, 1, (7, 2)))
    along = random.normal(size=(7, 2, 3))
    matrix = MassMatrix(mass, wp.float64, CPU, crossing_masses(mass.yarns, wp.float64, along))
    parts = [random.normal(size=shape) for shape in ((5, 3), (7, 3), (7, 2))]
    motion = MixedVector.from_numpy(*parts, wp.float64, CPU)
    product = motion.copy()
    factors = wp.array([[2.0, 3.0]], dtype=wp.vec2d, device=CPU)
    matrix.combine_products(factors, motion, product, RUN)
    own = motion.values.numpy()
    work = own @ product.values.numpy() - 3.0 * own @ own
    rounding = 1e-13  # sums of 50 numbers of size 1
    assert work == pytest.approx(4.0 * kinetic_energy(mass, along, motion), rel=rounding)
    blocks = MixedBlocks.zeros(5, 7, wp.float64, CPU)
    matrix.combine_blocks(wp.array([[1.0, 0.0]], dtype=wp.vec2d, device=CPU), blocks, RUN)
    for number, size in ((0, 3), (1, 3), (2, 2)):
        for k in range(size):
            alone = [np.zeros_like(part) for part in parts]
            alone[number][:, k] = 1.0
            energy = kinetic_energy(mass, along, MixedVector.from_numpy(*alone, wp.float64, CPU))
            block = (blocks.vertices, blocks.nodes, blocks.sliding)[number].numpy()
            assert 0.5 * block[:, k, k].sum() == pytest.approx(energy, rel=rounding)


KNIT = ClothMaterial("knit", 1000.0, 3000.0, 400.0, 0.4, 5.0, 2.0, 0.02)


def test_the_mass_of_a_cloth_is_that_of_its_area():
    mass = triangle_masses(rectangle("irregular", 6, 5, 3.0, 2.0), KNIT)
    assert mass.sum() == pytest.approx(0.02 * 6.0) and mass.min() > 0.0


def test_a_rod_has_half_of_the_mass_of_each_edge_at_its_ends():
    cloth = with_seam(rectangle("diagonals", 2, 2, 1.0, 3.0), [[1, 4], [4, 7]])
    rod = SeamMaterial(1.0, 1.0, density=0.2)
    np.testing.assert_allclose(rod_masses(cloth, rod)[[1, 4, 7, 0]], [0.15, 0.3, 0.15, 0.0])
    np.testing.assert_allclose(rod_masses(cloth, rod, [0.0, 0.5])[[1, 4, 7]], [0.0, 0.075, 0.075])
