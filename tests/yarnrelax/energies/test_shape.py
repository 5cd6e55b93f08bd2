# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The shape term of garments: patches and their energy, and borders that are held."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.quality import PRESETS
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.constraints.borders import KeepBorders
from stitchmesh.yarnrelax.energies.shape import KeepShape
from stitchmesh.yarnrelax.energies.shape_patches import RINGS, choose_patches, loops_of
from stitchmesh.yarnrelax.model.state import make_state
from tests.yarnrelax.one_term import OneTerm, on_device
from tests.yarnrelax.stockinette import fabric_of, flat_patch, tube

ROWS, STITCHES = 7, 8
MATERIAL = YarnMaterial.named("kaldor-simulation")


def shape_scene(yarns: YarnSet) -> OneTerm:
    return OneTerm.of(on_device(yarns, MATERIAL), KeepShape(fabric_of(ROWS, STITCHES, closed=False)))


def test_shape_force_is_minus_the_gradient_on_both_sides_of_the_threshold() -> None:
    yarns = flat_patch(ROWS, STITCHES)
    scene = shape_scene(yarns)
    random = np.random.default_rng(9)
    direction = random.normal(size=yarns.points.shape)
    for lift in (0.05, 0.4):  # below and above the threshold of one radius, 0.125 cm
        points = yarns.points + random.normal(scale=0.02, size=yarns.points.shape) + [0.0, 0.1, lift]
        expected = -(scene.forces(points) * direction).sum()
        # the energy is piecewise quadratic, so only rounding is left
        assert scene.slope(points, direction, 1e-6) == pytest.approx(expected, rel=1e-6)


def test_the_force_on_stitches_displaced_by_a_radius_equals_the_formula() -> None:
    yarns = flat_patch(ROWS, STITCHES)
    force = shape_scene(yarns).forces(yarns.points + np.array([0.0, 0.0, 0.125]))
    expected = 0.02 * MATERIAL.k_len / MATERIAL.segment_length + 2 * MATERIAL.k_bend / 0.5**2
    # the mean over the stitches is exact by construction, because the formula divides by the mean weight
    assert -force[:, 2].sum() / (ROWS * STITCHES) == pytest.approx(expected, rel=1e-9)
    assert np.abs(force[:, :2]).max() < 1e-9 * expected


@pytest.mark.parametrize("lift", [0.05, 0.4], ids=["below the threshold", "above the threshold"])
def test_its_coupling_is_the_derivative_of_the_forces(lift: float) -> None:
    """The stiffness is V^T C^-1 V; between the thresholds of all patches the forces are linear."""
    yarns = flat_patch(ROWS, STITCHES)
    scene = shape_scene(yarns)
    random = np.random.default_rng(9)
    # the mean displacement of a patch of many loops stays within a tenth of these from the lift
    points = yarns.points + random.normal(scale=0.02, size=yarns.points.shape) + [0.0, 0.1, lift]
    direction = random.normal(size=yarns.points.shape)
    step = 1e-3
    ends = [scene.forces(points + side * step * direction) for side in (1, -1)]
    scene.forces(points)
    coupling = scene.term.coupling(scene.state)
    assert coupling.compliance is not None
    rows, compliance = coupling.rows.toarray(), coupling.compliance.toarray()
    np.testing.assert_allclose(compliance, compliance.T, atol=1e-15 * np.abs(compliance).max())  # rounding
    found = rows.T @ np.linalg.solve(compliance, rows @ direction.ravel()) / scene.model.unit**2
    expected = (ends[1] - ends[0]).ravel() / (2 * step)
    np.testing.assert_allclose(found, expected, atol=1e-10 * np.abs(expected).max())  # rounding over the step


def test_rows_of_borders_sum_the_motions_of_their_loops() -> None:
    """Constraints hold what their rows sum: forces less the reactions have no sum, steps leave none."""
    yarns, fabric = flat_patch(ROWS, STITCHES), fabric_of(ROWS, STITCHES, closed=False)
    model = on_device(yarns, MATERIAL)
    borders = KeepBorders(fabric).on(model)
    coupling, state = borders.coupling(), make_state(model, external=True)
    motion = np.random.default_rng(4).normal(size=yarns.points.shape)
    loops = loops_of(yarns, fabric)
    expected = np.add.reduceat(motion[loops.points.entry], loops.points.start[:-1])[loops.held]
    assert coupling.compliance is None
    np.testing.assert_allclose(coupling.rows @ motion.ravel(), expected.ravel(), atol=1e-14)  # rounding of sums
    force, step = model.upload(motion, 3), model.upload(motion, 3)
    state.stiffness.fill_(1.0)
    borders.filter_forces(force, model.launch)
    limit = model.empty(model.point_count)
    limit.fill_(10.0)
    borders.filter_steps(state, step, limit, model.launch)
    for vectors in (force, step):
        np.testing.assert_allclose(coupling.rows @ vectors.numpy().ravel(), 0.0, atol=1e-12)  # places of some tens


def test_patches_overlap_and_cover_every_loop() -> None:
    yarns, fabric = flat_patch(ROWS, STITCHES), fabric_of(ROWS, STITCHES, closed=False)
    loops = loops_of(yarns, fabric)
    patches, centres = choose_patches(fabric, loops)
    assert set(patches.entry) == set(range(ROWS * STITCHES))
    assert len(centres) < ROWS * STITCHES
    for patch, centre in enumerate(centres):
        inside = slice(patches.start[patch], patches.start[patch + 1])
        faces = loops.face[patches.entry[inside]]
        sides = np.abs(faces // STITCHES - centre // STITCHES) + np.abs(faces % STITCHES - centre % STITCHES)
        # on a grid of quadrilaterals, the distance between faces in steps across edges is |row| + |column| difference
        np.testing.assert_allclose(patches.weight[inside], 1 - sides / (RINGS + 1))
    assert len(loops.held) == 2 * ROWS + 2 * STITCHES - 4


def test_border_loops_keep_their_mean_position_while_the_others_relax() -> None:
    yarns, fabric = tube(5, 8), fabric_of(5, 8, closed=True)
    quality = replace(PRESETS["draft"], tolerance=1e-3, max_iterations=200)
    relaxed = relax_yarns(yarns, quality=quality, device="cpu", keep_shape=fabric).yarns
    before = yarns.points.reshape(5, 8, 12, 3)
    after = relaxed.points.reshape(5, 8, 12, 3)
    moved = np.linalg.norm((after - before).mean(axis=2), axis=2)
    # float32 rounds coordinates of 2 cm to 1e-7 cm, and the rounding errors do not accumulate
    assert moved[[0, 4]].max() < 5e-7
    assert np.linalg.norm(after - before, axis=-1).max() > 0.1 * 0.125


def test_a_fabric_that_does_not_match_the_yarns_is_refused() -> None:
    with pytest.raises(ParameterError, match="keep_shape"):
        relax_yarns(tube(5, 8), device="cpu", keep_shape=fabric_of(2, 3, closed=True))
