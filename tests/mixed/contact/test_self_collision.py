# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Contact of a cloth with itself: derivatives, pressure between layers, neighbours, and layers that never pass."""

from __future__ import annotations

import numpy as np
import pytest
import warp as wp

from stitchmesh.compute.precision import scalar_named
from stitchmesh.errors import ParameterError, SolverError
from stitchmesh.mixed.contact.contact_points import join_points, points_at_nodes
from stitchmesh.mixed.contact.self_collision import STOP, SelfCollision
from tests.mixed.contact.sheets import (
    Sheets,
    blocks_of,
    cpu,
    derivative_errors,
    forces_of,
    moved,
    products_of,
    random_direction,
    sheet,
    state_of,
    together,
)
from tests.shaking import shaken

THICKNESS = 0.1


def collision(cloth: Sheets, precision: str = "float64", **options: float) -> SelfCollision:
    points, links = cloth.points(THICKNESS)
    return SelfCollision(points, links, scalar=scalar_named(precision), device=cpu(), **options)


def layers(gap: float, count: int = 12, size: float = 1.0) -> Sheets:
    """Two parallel sheets, the second one shifted so that its points lie over holes of the first one."""
    return together(sheet(count, size), sheet(count, size, height=gap, shift=0.03))


def rough(cloth: Sheets, seed: int = 0) -> np.ndarray:
    return cloth.vertices + 0.01 * np.random.default_rng(seed).normal(size=cloth.vertices.shape)


@pytest.fixture(scope="module")
def pressed() -> tuple[SelfCollision, Sheets]:
    cloth = layers(0.06)
    return collision(cloth), cloth


def test_forces_and_products_are_derivatives_of_the_energy(pressed):
    term, cloth = pressed
    state = state_of(rough(cloth))
    term.begin_step(state, 0.0, 1e-3)
    # The steps of 1e-6 cm leave h^2 f''' / f' = 1e-10 of truncation and 1e-16 / 1e-6 / 1e-3 of rounding; pairs at the
    # border of contact, where the curvature jumps from 8 to 0, are rare and have a share of about 1e-5.
    of_force, of_product = derivative_errors(term, state, 1e-6)
    assert of_force < 1e-7
    assert of_product < 1e-5


def test_the_matrix_without_its_negative_part_is_never_negative_and_bounds_the_exact_one(pressed):
    term, cloth = pressed
    state = state_of(rough(cloth))
    term.begin_step(state, 0.0, 1e-3)
    for seed in range(5):
        direction = random_direction(state, seed)
        along = direction.numpy()[0]
        never_negative = (along * products_of(term, state, direction, exact=0.0)).sum()
        exact = (along * products_of(term, state, direction, exact=1.0)).sum()
        between = (along * products_of(term, state, direction, exact=0.25)).sum()
        assert never_negative > 0.0 and never_negative > exact
        assert between == pytest.approx(0.75 * never_negative + 0.25 * exact)


def test_blocks_are_the_diagonal_of_the_hessian(pressed):
    term, cloth = pressed
    state = state_of(rough(cloth))
    term.begin_step(state, 0.0, 1e-3)
    blocks = blocks_of(term, state, exact=0.5)
    vertex = int(np.abs(blocks).max(axis=(1, 2)).argmax())
    for axis in range(3):
        unit = np.zeros_like(cloth.vertices)
        unit[vertex, axis] = 1.0
        column = products_of(term, state, state_of(unit), exact=0.5)[vertex]
        assert column == pytest.approx(blocks[vertex, :, axis], rel=1e-9, abs=1e-9 * np.abs(blocks[vertex]).max())


def test_forces_of_two_layers_are_opposite_and_have_no_moment(pressed):
    term, cloth = pressed
    vertices = rough(cloth)
    term.begin_step(state_of(vertices), 0.0, 1e-3)
    force = forces_of(term, state_of(vertices))
    size = np.abs(force).sum()
    assert np.abs(force.sum(axis=0)).max() < 1e-12 * size  # rounding of sums of equal and opposite forces
    assert np.abs(np.cross(vertices, force).sum(axis=0)).max() < 1e-12 * size


@pytest.mark.parametrize("x", [0.5, 0.9])
def test_dense_parallel_layers_press_as_in_the_closed_form(x):
    """p = P (1/x + x^3 - 2x) in the middle of large layers."""
    cloth = together(sheet(24, 0.8), sheet(24, 0.8, height=x * THICKNESS, shift=0.013))
    points, links = cloth.points(THICKNESS, spacing=THICKNESS / 4)
    term = SelfCollision(points, links, pressure=1000.0, scalar=wp.float64, device=cpu())
    state = state_of(cloth.vertices)
    term.begin_step(state, 0.0, 0.0)
    force = forces_of(term, state)[: len(cloth.vertices) // 2]
    inside = (np.abs(cloth.vertices[: len(force), :2]) < 0.8 / 2 - 1.5 * THICKNESS).all(axis=1)
    pressure = -force[inside, 2].sum() / (inside.sum() * (0.8 / 24) ** 2)
    # Sums over points a quarter of the thickness apart replace an integral over a disc whose rim has a kink.
    assert pressure == pytest.approx(1000.0 * (1 / x + x**3 - 2 * x), rel=0.02)


def test_a_flat_cloth_has_no_contact_and_neither_has_a_cylinder_with_a_seam():
    flat = sheet(20, 1.0)
    term = collision(flat)
    term.begin_step(state_of(flat.vertices), 0.0, 1e-3)
    assert term.energy(state_of(flat.vertices)) == 0.0
    tube, vertices = tube_of(flat, 1.0)  # a circumference of ten thicknesses
    with_seam = collision(tube)
    with_seam.begin_step(state_of(vertices), 0.0, 1e-3)
    assert with_seam.energy(state_of(vertices)) == 0.0
    points, _links = tube.points(THICKNESS)
    without = SelfCollision(points, None, scalar=wp.float64, device=cpu())
    without.begin_step(state_of(vertices), 0.0, 1e-3)
    assert without.energy(state_of(vertices)) > 0.0  # neighbours across the seam would collide


def tube_of(flat: Sheets, size: float) -> tuple[Sheets, np.ndarray]:
    """A panel whose two borders x = -size / 2 and x = size / 2 are sewn together, and its vertices as a cylinder."""
    count = int(np.sqrt(len(flat.vertices)))
    last = len(flat.vertices) - count
    triangles = np.where(flat.triangles >= last, flat.triangles - last, flat.triangles)
    angle, radius = 2 * np.pi * flat.vertices[:last, 0] / size, size / (2 * np.pi)
    vertices = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), flat.vertices[:last, 1]])
    return Sheets(vertices, triangles, flat.rest, flat.panel), vertices


def test_a_hybrid_region_counts_once():
    """Points on triangles of weight 1 - alpha and nodes of weight alpha at the same places: the energy of one sheet."""
    cloth = layers(0.07)
    points, links = cloth.points(THICKNESS)
    whole = SelfCollision(points, links, scalar=wp.float64, device=cpu())
    state = state_of(cloth.vertices)
    whole.begin_step(state, 0.0, 1e-3)
    part, _ = cloth.points(THICKNESS, weight=0.3, node_count=len(points))
    nodes = points_at_nodes(
        len(cloth.vertices), panel=points.panel, rest=points.rest, area=points.area, weight=0.7, thickness=THICKNESS
    )
    hybrid = SelfCollision(join_points([part, nodes]), links, scalar=wp.float64, device=cpu())
    mixed = state_of(cloth.vertices, points.places(cloth.vertices, np.zeros((0, 3))))
    hybrid.begin_step(mixed, 0.0, 1e-3)
    assert hybrid.energy(mixed) == pytest.approx(whole.energy(state), rel=1e-12)  # sums in another order
    assert derivative_errors(hybrid, state_of(rough(cloth), mixed.numpy()[1]), 1e-6)[0] < 1e-7


@pytest.mark.decides
def test_noise_changes_forces_by_rounding_only(pressed):
    """Lists are in the order of the points, and pairs that come and go at their margin add nothing."""
    _term, cloth = pressed
    forces = []
    for seed in range(3):
        term = collision(cloth)
        state = state_of(shaken(rough(cloth), seed) if seed else rough(cloth))
        term.begin_step(state, 0.0, 1e-3)
        forces.append(forces_of(term, state))
        lists, count = term.pairs.lists.numpy(), term.pairs.count.numpy()
        assert all((np.diff(row[:n]) > 0).all() for row, n in zip(lists, count, strict=True))
    # one unit in the last place of a place, 1e-16 cm, times the stiffness, about 10 forces / thickness
    assert np.abs(np.array(forces[1:]) - forces[0]).max() < 1e-13 * np.abs(forces[0]).max()


def test_lists_made_for_a_move_give_the_same_forces_as_new_ones(pressed):
    _term, cloth = pressed
    start = layers(0.5).vertices
    term = collision(cloth)
    state, direction = state_of(start), state_of(cloth.vertices - start)
    term.begin_step(state, 0.0, 1e-3)
    part = term.step_limit(state, direction)
    assert 0.9 < part <= 1.0  # the layers are at 0.06 / 0.1 of contact, but over holes, so no pair is as near as that
    end = moved(state, direction, part)
    late = forces_of(term, end)
    fresh = collision(cloth)
    fresh.begin_step(end, 0.0, 1e-3)
    assert np.abs(late).max() > 0.0
    assert (late == forces_of(fresh, end)).all()


@pytest.mark.parametrize("speed", [1.0, 10_000.0])
def test_no_move_jumps_through_a_layer(speed):
    """A sheet that falls on another one by far more than their distance in one move stops in contact, above it."""
    cloth = together(sheet(8, 0.6), sheet(8, 0.6, height=0.3, shift=0.02))
    half = len(cloth.vertices) // 2
    points, links = cloth.points(THICKNESS)
    term = SelfCollision(points, links, scalar=wp.float64, device=cpu())
    down = np.zeros_like(cloth.vertices)
    down[half:, 2] = -speed
    state = state_of(cloth.vertices)
    term.begin_step(state, 0.0, 1e-3)
    for _ in range(100):
        part = term.step_limit(state, state_of(down))
        state = moved(state, state_of(down), part)
        if term.energy(state) > 0.0:
            break
    places = points.places(state.numpy()[0], np.zeros((0, 3)))
    below, above = places[points.panel == 0], places[points.panel == 1]
    apart = np.linalg.norm(below[:, None] - above[None], axis=2)
    assert term.energy(state) > 0.0
    assert apart.min() == pytest.approx(float(STOP) * THICKNESS, rel=1e-9)
    assert (above[:, 2] > 0.0).all()


def test_a_layer_that_slides_is_not_limited():
    cloth = layers(0.2)
    term = collision(cloth)
    along = np.zeros_like(cloth.vertices)
    along[len(along) // 2 :, 0] = 5.0
    state = state_of(cloth.vertices)
    term.begin_step(state, 0.0, 1e-3)
    assert term.step_limit(state, state_of(along)) == pytest.approx(min(1.0, 16 * 0.15 / 5.0))  # the longest sweep
    assert term.step_limit(state, state_of(0.1 * along)) == 1.0
    everything = state_of(np.full_like(cloth.vertices, 1e3))
    assert term.step_limit(state, everything) == 1.0  # motion of the whole cloth brings nothing nearer


@pytest.mark.nightly
def test_single_precision_agrees(pressed):
    term, cloth = pressed
    single = collision(cloth, "float32")
    state = state_of(rough(cloth))
    for each, precision in ((term, "float64"), (single, "float32")):
        each.begin_step(state_of(rough(cloth), precision=precision), 0.0, 1e-3)
    expected = forces_of(term, state)
    found = forces_of(single, state_of(rough(cloth), precision="float32"))
    # a place is rounded by 6e-8 of 1 cm, 1e-6 of a distance, and f' changes by six times that part
    assert np.abs(found - expected).max() < 3e-5 * np.abs(expected).max()


def test_coincident_points_are_finite(pressed):
    term, cloth = pressed
    vertices = np.zeros_like(cloth.vertices)
    term.begin_step(state_of(vertices), 0.0, 1e-3)
    assert np.isfinite(term.energy(state_of(vertices)))
    assert np.isfinite(forces_of(term, state_of(vertices))).all()
    term.pairs.invalidate()


def test_refuses():
    cloth = sheet(2, 1.0)
    with pytest.raises(ParameterError, match=r"^contact: got a thickness of nan cm; expected a positive number$"):
        cloth.points(np.nan)
    with pytest.raises(ParameterError, match=r"spacing of 0\.0 cm"):
        cloth.points(0.1, spacing=0.0)
    with pytest.raises(ParameterError, match="got 3 parts of a side; expected a power of two"):
        cloth.points(0.1, most_parts=3)
    points, links = cloth.points(0.1)
    with pytest.raises(ParameterError, match=r"pressure of 0\.0"):
        SelfCollision(points, links, pressure=0.0, scalar=wp.float64, device=cpu())
    term = SelfCollision(points, links, scalar=wp.float64, device=cpu())
    with pytest.raises(SolverError, match="places that are not finite"):
        term.begin_step(state_of(np.full_like(cloth.vertices, np.nan)), 0.0, 1e-3)
    with pytest.raises(ParameterError, match=r"got \(4, 0\) vertices and nodes in float64; expected \(9, 0\)"):
        term.begin_step(state_of(np.zeros((4, 3))), 0.0, 1e-3)
