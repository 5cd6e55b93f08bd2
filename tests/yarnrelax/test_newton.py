# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Newton's method: its steps lower the energy, converge fast, keep constraints, and predict the change that is left."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from stitchmesh.compute.device import device_named
from stitchmesh.mesh import Mesh
from stitchmesh.periodic.repeat.drawn_swatch import draw_swatch
from stitchmesh.periodic.resolve_pattern import resolve_pattern
from stitchmesh.periodic.swatch_options import SwatchOptions
from stitchmesh.quality import PRESETS, Quality
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.collision.step_limit import STRAIN_UNIT
from stitchmesh.yarnrelax.constraints.borders import KeepBorders
from stitchmesh.yarnrelax.constraints.pins import Pins, pinned_points
from stitchmesh.yarnrelax.energies.body import Body
from stitchmesh.yarnrelax.energies.shape import KeepShape
from stitchmesh.yarnrelax.friction.friction import Friction
from stitchmesh.yarnrelax.hessian.cell_matrices import REFINED
from stitchmesh.yarnrelax.newton import DESCENT, LARGE, LATE, NEWTON_RISE, SMALLEST_NEWTON_SCALE, Newton, newton_of
from stitchmesh.yarnrelax.newton_interval import STEP_COST
from stitchmesh.yarnrelax.newton_moves import deformations
from stitchmesh.yarnrelax.relaxation_loop import RelaxationLoop
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.solver import ASSESSMENT_INTERVAL
from stitchmesh.yarnrelax.together.carried_cells import put_into, taken_out
from stitchmesh.yarnrelax.together.relax_cells import relax_cells
from tests.yarnrelax.stockinette import fabric_of, flat_patch, periodic_patch, tube, woven_cell

KALDOR, FREE = YarnMaterial.named("kaldor-simulation"), RelaxCell()
DRAFT = PRESETS["draft"]
DOUBLE = replace(DRAFT, precision="float64")
FINE = replace(DOUBLE, tolerance=1e-10, largest_change=1e-9)
FABRIC = fabric_of(4, 6, closed=True)


def started(yarns: YarnSet, quality: Quality = DOUBLE, **options: Any) -> RelaxationLoop:
    """A relaxation that is assessed and has not begun."""
    simulation = YarnSimulation.start(yarns, KALDOR, quality, device_named("cpu"), **options)
    loop = RelaxationLoop(simulation, quality.tolerance, quality.largest_change)
    loop.start()
    return loop


def drawn(pattern: str) -> YarnSet:
    """The yarns of a repeat before they relax."""
    return draw_swatch(resolve_pattern(pattern), SwatchOptions(), DOUBLE)[1]


def until_the_end(loop: RelaxationLoop) -> RelaxationLoop:
    """Descend until Newton's method takes over."""
    while not loop.ending[0]:
        loop.advance()
    return loop


SCENES: dict[str, tuple[YarnSet, dict[str, Any]]] = {
    "weave": (woven_cell(), {"cell": FREE}),
    "garment": (tube(4, 6), {"terms": [KeepShape(FABRIC)], "constraints": [KeepBorders(FABRIC)]}),
    "cell with friction": (periodic_patch(2, 1), {"cell": FREE, "terms": [Friction(0.3)]}),
}


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_no_accepted_step_raises_the_energy(scene: tuple[YarnSet, dict[str, Any]]) -> None:
    loop = until_the_end(started(scene[0], DRAFT, **scene[1]))
    energies, steps = [loop.last[0].energy], [False]
    for _ in range(12):
        steps.append(bool(loop.takes_newton_step[0]))
        loop.advance()
        energies.append(loop.last[0].energy)
    rounding = NEWTON_RISE * loop.simulation.precision * loop.last[0].size  # of the sum of all energies
    assert sum(steps) > 1
    assert (np.diff(energies)[steps[1:]] <= rounding).all()
    assert min(energies[1:]) < energies[0] + rounding


def test_near_rest_two_steps_reduce_the_residual_a_hundred_thousandfold(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each leaves a multiple of the square of the residual, and what conjugate gradients leave of it (``REFINED``)."""
    monkeypatch.setattr(Newton, "factors_hold", lambda newton, cells, fall: cells & False)  # each with its own factors
    loop = until_the_end(started(drawn("rib1x1"), FINE, cell=FREE))
    residuals = [loop.last[0].residual]
    while not loop.at_rest[0]:
        loop.advance()
        residuals.append(loop.last[0].residual)
        assert len(residuals) < 200
    # the last step judges that the yarns are at rest
    # that of ``REFINED`` is a norm of energies; its ratio to that of forces is a few
    assert residuals[-1] == residuals[-2] < 10.0 * REFINED**2 * residuals[-4]
    assert 1e-7 < residuals[-4] < 0.05


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_a_step_near_rest_is_the_motion_that_is_left(scene: tuple[YarnSet, dict[str, Any]]) -> None:
    """Points are shaken by h, and the cell is strained by h: the step takes both back, up to the square of h."""
    loop = started(scene[0], FINE, **scene[1])
    loop.run(20_000)
    assert loop.at_rest[0]
    simulation, energy = loop.simulation, loop.last[0].energy
    model, strain, count = simulation.model, simulation.strain, simulation.model.point_count
    rest = simulation.state.points.numpy().copy()
    shaken = np.random.default_rng(1).normal(size=(count, 3))
    shaken -= shaken.mean(axis=0)  # no force holds a cell in its plane
    for constraint in simulation.constraints:
        rows = constraint.coupling().rows.toarray()
        shaken -= (np.linalg.pinv(rows) @ (rows @ shaken.ravel())).reshape(-1, 3)
    given = np.array([1.0, -0.5, 0.25])
    periods = None if strain is None else strain.periods.numpy().copy()
    # The square of h has a factor of some hundreds, for contacts that open and close. Conjugate gradients leave a
    # thousandth in the norm of the energy (``REFINED``), and more of soft motions.
    for h, error in ((1e-5, 0.05), (1e-6, 0.01)):
        moved = rest.copy()
        moved[:count] += h * shaken
        if strain is not None and periods is not None:
            deformed = deformations(strain.host_frame, h * given[None])[0]
            moved[:count] = moved[:count] @ deformed
            strain.periods.assign(periods @ deformed)
            simulation.candidates.near.invalidate()
        simulation.state.points.assign(moved)
        simulation.search_contacts()
        now, newton = simulation.assess_cells()[0], Newton(simulation)
        every = np.ones(1, dtype=bool)
        newton.find_steps(every, every, loop.last.size)
        step, left = newton.steps, newton.remaining_changes(every, np.array([now.size]))[0]
        assert step.known[0] and step.exact[0] and left is not None
        missing = step.motion[:count] / h + shaken
        if model.on_lattice:
            missing -= missing.mean(axis=0)
        assert np.abs(missing).max() < error * np.abs(shaken).max()
        assert left.rms_radii == pytest.approx(h * np.sqrt((shaken**2).sum(axis=1).mean()), rel=error)
        assert left.energy == pytest.approx((now.energy - energy) / now.size, rel=error)
        if strain is not None:
            np.testing.assert_allclose(step.motion[-1] / float(STRAIN_UNIT), -h * given, atol=error * h)
            assert left.spacing == pytest.approx(h, rel=error)


def test_pinned_points_keep_their_bits_and_borders_their_middles() -> None:
    yarns = tube(4, 6)
    pins = Pins(faces=[0, 8, 16])
    loop = until_the_end(started(yarns, DRAFT, constraints=[pins], terms=[KeepShape(FABRIC)]))
    held, points = pinned_points(yarns, pins), loop.simulation.state.points
    before = points.numpy().copy()
    loop.advance()
    assert np.array_equal(points.numpy()[held], before[held])
    assert np.abs(points.numpy() - before).max() > 1e-4

    loop = until_the_end(started(yarns, DRAFT, constraints=[KeepBorders(FABRIC)], terms=[KeepShape(FABRIC)]))
    points = loop.simulation.state.points
    before = points.numpy().copy()
    loop.advance()
    moved = (points.numpy() - before)[: len(yarns.points)].reshape(24, 12, 3)
    middles = np.abs(moved.mean(axis=1)).max(axis=1)
    border = np.arange(24) // 6 % 3 == 0  # the first and the last of four rows
    assert middles[border].max() < 1e-5 < middles[~border].max()  # rounding of coordinates of some tens of radii


@pytest.mark.parametrize("free", [None, FREE])
def test_moves_are_no_longer_than_the_scaled_limit(free: RelaxCell | None) -> None:
    yarns, scale = periodic_patch(1, 1), 0.125
    simulation = started(replace(yarns, rest_length=0.9 * yarns.rest_length), cell=free).simulation
    newton, every = Newton(simulation), np.ones(1, dtype=bool)
    periods, points = periods_and_points(simulation)
    newton.find_steps(every, every, np.ones(len(every)))
    room = simulation.state.budget.numpy()
    assert newton.move(every, np.array([scale])).all()
    deformed, moved = periods_and_points(simulation)
    # the move comes before the deformation of the cell, which acts in its plane
    deformation = np.eye(3)
    deformation[:2, :2] = np.linalg.solve(periods[:, :2], deformed[:, :2])
    length = np.linalg.norm(moved @ np.linalg.inv(deformation) - points, axis=1)
    limit = min(simulation.step_fraction * scale, float(room.max()))
    assert 0.1 * limit < length.max() <= limit * (1.0 + 1e-12)


def periods_and_points(simulation: YarnSimulation) -> tuple[np.ndarray, np.ndarray]:
    periods = simulation.model.constants.images.periods.numpy()
    return np.array(periods), np.array(simulation.state.points.numpy()[: simulation.model.point_count])


def test_it_ends_pieces_whose_ends_are_held_and_whose_factors_are_affordable(monkeypatch: pytest.MonkeyPatch) -> None:
    """The ends of open yarns are held where stitches keep their places; friction moves the rest of large pieces."""
    floor = Body(Mesh.from_polygons([[-9, -9, -9], [-9, -9, 9], [9, -9, 9]], [[0, 1, 2]]))
    flat, shape = flat_patch(3, 4), KeepShape(fabric_of(3, 4, closed=False))

    def newton(yarns: YarnSet, *terms: Any) -> Newton | None:
        return newton_of(YarnSimulation.start(yarns, KALDOR, DOUBLE, device_named("cpu"), terms))

    assert newton(flat) is None
    assert newton(flat, shape) is not None
    small = newton(tube(4, 6), floor)
    assert small is not None and small.descent == DESCENT
    large = tube(5, 20)
    late = newton(large, floor)
    assert len(large.points) > LARGE and late is not None and late.descent == LATE
    assert newton(large, Friction(0.3)) is None
    monkeypatch.setattr("stitchmesh.yarnrelax.newton.LARGEST_ON_HOST", len(large.points) - 1)
    assert newton(large, floor) is None


def test_yarns_are_at_rest_only_where_the_remaining_change_is_small() -> None:
    coarse, fine = (replace(DOUBLE, tolerance=0.9, largest_change=change) for change in (0.5, 1e-9))
    ends = [relax_yarns(periodic_patch(1, 1), quality=quality, device="cpu", cell=FREE) for quality in (coarse, fine)]
    for end, quality in zip(ends, (coarse, fine), strict=True):
        assert end.report["converged"]
        assert end.report["remaining_change"]["spacing"] < quality.largest_change
    assert ends[0].report["iterations"] < ends[1].report["iterations"]


def test_nothing_is_known_of_the_change_left_where_iterations_end_after_a_step(
    caplog: pytest.LogCaptureFixture,
) -> None:
    """Only the next step would say it; here the iterations end."""
    quality = replace(DOUBLE, tolerance=1e-12, largest_change=1e-12)
    whole = [entry["iteration"] for entry in relax_yarns(periodic_patch(1, 1), quality=quality, device="cpu").history]
    caplog.clear()
    quality = replace(quality, max_iterations=whole[-2])
    report = relax_yarns(periodic_patch(1, 1), quality=quality, device="cpu").report
    assert not report["converged"] and report["remaining_change"] is None
    (record,) = (entry for entry in caplog.records if entry.levelname == "WARNING")
    assert "spacing to change by an amount that is not known yet (expected 1e-12 of itself)" in record.getMessage()


def test_a_step_that_cannot_lower_the_energy_ends_the_relaxation_with_a_warning(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """No step is accepted: each is tried again at a quarter of its length, until it is too short to matter."""
    monkeypatch.setattr(RelaxationLoop, "is_acceptable", lambda loop, *_assessed: ~loop.ending)
    tried, move = [], Newton.move

    def note_scale(newton: Newton, cells: np.ndarray, scale: np.ndarray) -> Any:
        tried.append(float(scale[0]))
        return move(newton, cells, scale)

    monkeypatch.setattr(Newton, "move", note_scale)
    result = relax_yarns(periodic_patch(1, 1), quality=FINE, device="cpu", cell=FREE)
    assert not result.report["converged"] and result.report["iterations"] < DRAFT.max_iterations
    assert tried == [0.25**count for count in range(len(tried))]
    assert tried[-1] < SMALLEST_NEWTON_SCALE < tried[-2]
    assert "no step lowers the energy" in caplog.records[-1].getMessage()


def test_steps_count_as_iterations_of_each_cell_which_has_its_own_remaining_change() -> None:
    cells = [periodic_patch(1, 1), woven_cell()]
    batch = relax_cells(cells, free=[FREE, FREE], quality=FINE, device="cpu")
    assert batch.report["converged"] == 2
    assert batch.report["launched"] == max(cell.report["iterations"] for cell in batch.cells)
    for cell in batch.cells:
        counts = np.diff([entry["iteration"] for entry in cell.history])
        assert set(counts.tolist()) == {int(ASSESSMENT_INTERVAL), STEP_COST["cpu"]}
    left = [cell.report["remaining_change"] for cell in batch.cells]
    assert left[0] != left[1] and max(change["spacing"] for change in left) < FINE.largest_change


def test_a_cell_goes_on_in_another_batch_with_what_is_known_of_it() -> None:
    given = [(periodic_patch(1, 1), KALDOR), (woven_cell(), KALDOR)]

    def batch(cells: slice) -> RelaxationLoop:
        simulation = YarnSimulation(given[cells], DOUBLE, device_named("cpu"), cells=[FREE, FREE][cells])
        return RelaxationLoop(simulation, 1e-3)

    both, alone = batch(slice(0, 2)), batch(slice(1, 2))
    assert both.newton is not None and alone.newton is not None
    both.newton.memory = np.array([[1.0, 1.0, 0.05, 0.0], [0.3, 0.5, 0.0125, 2.0]])
    both.iterations[:] = [140, 260]
    both.ending[:] = [False, True]
    both.alternation.descent[:] = [0, 40]
    both.alternation.newton_fall[:] = [0.0, 1e-5]
    both.start()
    alone.start()
    put_into(alone, np.array([True]), taken_out(both, np.array([False, True])))
    assert np.array_equal(alone.newton.memory, both.newton.memory[1:])
    for name in ("iterations", "ending"):
        assert getattr(alone, name).tolist() == getattr(both, name)[1:].tolist()
    for name in ("descent", "newton_fall"):
        assert getattr(alone.alternation, name).tolist() == getattr(both.alternation, name)[1:].tolist()


def test_each_cell_of_a_batch_steps_as_it_does_alone() -> None:
    given = [(periodic_patch(1, 1), KALDOR), (woven_cell(), KALDOR)]
    ends = []
    for numbers in ([0, 1], [0], [1]):
        own = [given[number] for number in numbers]
        simulation = YarnSimulation(own, DOUBLE, device_named("cpu"), cells=[FREE] * len(own))
        newton, every = Newton(simulation), np.ones(len(numbers), dtype=bool)
        newton.find_steps(every, every, np.ones(len(every)))
        ends.append([newton.steps.motion[newton.moves.entries_of(cell).number] for cell in np.diag(every)])
    for together, alone in zip(ends[0], ends[1] + ends[2], strict=True):
        # The table of images of a batch is another one, and with it the order of sums; the softest motions amplify it.
        np.testing.assert_allclose(together, alone, atol=1e-6 * np.abs(alone).max())
