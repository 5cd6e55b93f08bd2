# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The shape term of garments: patches and their energy, and borders that are held."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.compute.device import device_named
from stitchmesh.compute.precision import scalar_named
from stitchmesh.errors import ParameterError
from stitchmesh.quality import PRESETS
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.collision.narrow_phase import Candidates, make_candidates
from stitchmesh.yarnrelax.constraints.borders import KeepBorders
from stitchmesh.yarnrelax.energies.shape import KeepShape, Shape
from stitchmesh.yarnrelax.energies.shape_patches import RINGS, choose_patches, loops_of
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.state import State, make_state
from stitchmesh.yarnrelax.model.upload import put_model
from tests.yarnrelax.stockinette import fabric_of, flat_patch, tube

ROWS, STITCHES = 7, 8
MATERIAL = YarnMaterial.named("kaldor-simulation")
ShapeScene = tuple[Model, Shape, State, Candidates]


def shape_scene(yarns: YarnSet) -> ShapeScene:
    model = put_model(
        yarns,
        MATERIAL,
        quadrature_points=3,
        contact_samples=3,
        scalar=scalar_named("float64"),
        device=device_named("cpu"),
    )
    shape = KeepShape(fabric_of(ROWS, STITCHES, closed=False)).on(model)
    return model, shape, make_state(model, external=True), make_candidates(model, 0.1)


def energy_and_force(scene: ShapeScene, points: np.ndarray) -> tuple[float, np.ndarray]:
    """Energy [erg] and forces [dyn] with control points at ``points`` [cm]."""
    model, shape, state, candidates = scene
    state.points.assign(model.to_device(points))
    state.external_force.zero_()
    shape.forces(state, candidates, model.launch)
    return shape.energy(state, candidates), state.external_force.numpy() / model.unit


def test_shape_force_is_minus_the_gradient_on_both_sides_of_the_threshold() -> None:
    yarns = flat_patch(ROWS, STITCHES)
    scene = shape_scene(yarns)
    random = np.random.default_rng(9)
    direction = random.normal(size=yarns.points.shape)
    for lift in (0.05, 0.4):  # below and above the threshold of one radius, 0.125 cm
        points = yarns.points + random.normal(scale=0.02, size=yarns.points.shape) + [0.0, 0.1, lift]
        force = energy_and_force(scene, points)[1]
        step = 1e-6  # the energy is piecewise quadratic, so only rounding is left
        ends = [energy_and_force(scene, points + side * step * direction)[0] for side in (1, -1)]
        slope = (ends[0] - ends[1]) / (2 * step)
        assert slope == pytest.approx(-(force * direction).sum(), rel=1e-6)


def test_the_force_on_stitches_displaced_by_a_radius_equals_the_formula() -> None:
    yarns = flat_patch(ROWS, STITCHES)
    force = energy_and_force(shape_scene(yarns), yarns.points + np.array([0.0, 0.0, 0.125]))[1]
    expected = 0.02 * MATERIAL.k_len / yarns.rest_length.mean() + 2 * MATERIAL.k_bend / 0.5**2
    # the mean over the stitches is exact by construction, because the formula divides by the mean weight
    assert -force[:, 2].sum() / (ROWS * STITCHES) == pytest.approx(expected, rel=1e-9)
    assert np.abs(force[:, :2]).max() < 1e-9 * expected


def test_row_sums_bound_the_stiffness_of_the_patches() -> None:
    yarns = flat_patch(ROWS, STITCHES)
    scene = shape_scene(yarns)
    rows = scene[1].stiffness() / scene[0].unit ** 2
    start = yarns.points + np.array([0.0, 0.0, 0.4])
    direction = np.random.default_rng(1).normal(size=yarns.points.shape)
    change = 1e-4
    ends = [energy_and_force(scene, start + side * change * direction)[1] for side in (1, -1)]
    curvature = -((ends[0] - ends[1]) * direction).sum() / (2 * change)
    assert 0.0 < curvature <= (rows[:, None] * direction**2).sum()


@pytest.mark.parametrize("lift", [0.05, 0.4], ids=["below the threshold", "above the threshold"])
def test_its_coupling_is_the_derivative_of_the_forces(lift: float) -> None:
    """The stiffness is V^T C^-1 V; between the thresholds of all patches the forces are linear."""
    yarns = flat_patch(ROWS, STITCHES)
    scene = shape_scene(yarns)
    model, shape, state, _candidates = scene
    random = np.random.default_rng(9)
    # the mean displacement of a patch of many loops stays within a tenth of these from the lift
    points = yarns.points + random.normal(scale=0.02, size=yarns.points.shape) + [0.0, 0.1, lift]
    direction = random.normal(size=yarns.points.shape)
    step = 1e-3
    ends = [energy_and_force(scene, points + side * step * direction)[1] for side in (1, -1)]
    energy_and_force(scene, points)
    coupling = shape.coupling(state)
    assert coupling.compliance is not None
    rows, compliance = coupling.rows.toarray(), coupling.compliance.toarray()
    np.testing.assert_allclose(compliance, compliance.T, atol=1e-15 * np.abs(compliance).max())  # rounding
    found = rows.T @ np.linalg.solve(compliance, rows @ direction.ravel()) / model.unit**2
    expected = (ends[1] - ends[0]).ravel() / (2 * step)
    np.testing.assert_allclose(found, expected, atol=1e-10 * np.abs(expected).max())  # rounding over the step


def test_rows_of_borders_sum_the_motions_of_their_loops() -> None:
    """Constraints hold what their rows sum: forces less the reactions have no sum, steps leave none."""
    yarns, fabric = flat_patch(ROWS, STITCHES), fabric_of(ROWS, STITCHES, closed=False)
    model = shape_scene(yarns)[0]
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
