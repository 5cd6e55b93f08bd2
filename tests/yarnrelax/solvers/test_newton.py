# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Newton's method: its steps lower the energy, converge fast, keep constraints, and predict the change that is left."""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import Any

import numpy as np
import pytest

from stitchmesh.compute.device import device_named
from stitchmesh.periodic.relaxation.continuation import size_of
from stitchmesh.periodic.repeat.drawn_swatch import draw_swatch
from stitchmesh.periodic.resolve_pattern import resolve_pattern
from stitchmesh.periodic.swatch_options import SwatchOptions
from stitchmesh.quality import PRESETS, Quality
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.constraints.borders import KeepBorders
from stitchmesh.yarnrelax.constraints.pins import Pins, pinned_points
from stitchmesh.yarnrelax.energies.shape import KeepShape
from stitchmesh.yarnrelax.friction.friction import Friction
from stitchmesh.yarnrelax.relaxation_loop import SMALLEST_NEWTON_SCALE, RelaxationLoop
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.newton import Newton, RemainingChange
from stitchmesh.yarnrelax.together.relax_cells import relax_cells
from tests.yarnrelax.stockinette import fabric_of, periodic_patch, tube, woven_cell

KALDOR, LEAF, FREE = YarnMaterial.named("kaldor-simulation"), YarnMaterial.named("leaf"), RelaxCell()
DRAFT = PRESETS["draft"]
DOUBLE = replace(DRAFT, precision="float64")
FINE = replace(DOUBLE, tolerance=1e-7, largest_change=1e-6)
FABRIC = fabric_of(4, 6, closed=True)


def started(yarns: YarnSet, quality: Quality = DOUBLE, **options: Any) -> RelaxationLoop:
    """A relaxation that is assessed and has not begun."""
    simulation = YarnSimulation.start(yarns, KALDOR, quality, device_named("cpu"), **options)
    loop = RelaxationLoop(simulation, quality.tolerance, quality.largest_change)
    loop.start()
    return loop


def until_the_end(loop: RelaxationLoop) -> RelaxationLoop:
    """Descend until Newton's method takes over."""
    while not loop.ending[0]:
        loop.advance()
    return loop


SCENES: dict[str, tuple[YarnSet, dict[str, Any]]] = {
    "free cell": (periodic_patch(1, 1), {"cell": FREE}),
    "cell with its periods": (periodic_patch(2, 1), {}),
    "weave": (woven_cell(), {"cell": FREE}),
    "garment": (tube(4, 6), {"terms": [KeepShape(FABRIC)], "constraints": [KeepBorders(FABRIC)]}),
}


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_no_accepted_step_raises_the_energy(scene: tuple[YarnSet, dict[str, Any]], precision: str) -> None:
    loop = until_the_end(started(scene[0], replace(DRAFT, precision=precision), **scene[1]))
    energies = [loop.last[0].energy]
    for _ in range(6):
        loop.advance()
        energies.append(loop.last[0].energy)
    rounding = 32 * loop.simulation.precision * loop.last[0].size  # of the sum of all energies
    assert (np.diff(energies) <= rounding).all()
    assert min(energies[1:]) < energies[0] + rounding


def test_near_rest_three_steps_reduce_the_residual_a_thousandfold() -> None:
    _fabric, drawn = draw_swatch(resolve_pattern("rib1x1"), SwatchOptions(), DOUBLE)
    loop = until_the_end(started(drawn, FINE, cell=FREE))
    residuals = [loop.last[0].residual]
    while not loop.at_rest[0]:
        loop.advance()
        residuals.append(loop.last[0].residual)
        assert len(residuals) < 100
    # the least share of the matrix of Gauss and Newton and the end of the conjugate gradients leave some hundredths of
    # a residual, and once a seventh, so that a single step says little
    assert residuals[-1] < 1e-3 * residuals[-4]


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


@pytest.mark.parametrize("scale", [1.0, 0.125])
def test_moves_are_no_longer_than_the_scaled_limit(scale: float) -> None:
    loop = started(replace(periodic_patch(1, 1), rest_length=0.9 * periodic_patch(1, 1).rest_length), cell=FREE)
    simulation = loop.simulation
    simulation.newton_step(np.ones(1, dtype=bool), np.array([scale]))
    assert simulation.newton is not None
    length = np.linalg.norm(simulation.newton.solve.step.numpy(), axis=1)
    assert 0.0 < length.max() <= simulation.step_fraction * scale * (1.0 + 1e-12)


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_the_same_steps_have_the_same_bits_twice(scene: tuple[YarnSet, dict[str, Any]]) -> None:
    ends = []
    for _ in range(2):
        loop = until_the_end(started(scene[0], DRAFT, **scene[1]))
        for _step in range(3):
            loop.advance()
        ends.append((loop.simulation.state.points.numpy().copy(), list(loop.last), loop.remaining, loop.iteration))
    assert np.array_equal(ends[0][0], ends[1][0])
    assert ends[0][1:] == ends[1][1:]


@pytest.mark.parametrize("pattern", ["garter", "seed", "rib1x1", "rib2x2", "moss", "half-cardigan"])
def test_the_true_remaining_change_is_below_three_times_its_estimate(pattern: str) -> None:
    """Patterns that come to rest without passing a symmetric state, which Newton's method can take for rest."""
    quality = PRESETS["standard"]
    _fabric, drawn = draw_swatch(resolve_pattern(pattern), SwatchOptions(), quality)
    options: dict[str, Any] = {"material": YarnMaterial.named(), "device": "cpu", "cell": FREE}
    found = relax_yarns(drawn, quality=quality, **options)
    exact = replace(quality, precision="float64", tolerance=1e-6, largest_change=1e-6, max_iterations=50_000)
    rest = relax_yarns(found.yarns, quality=exact, **options)
    assert found.report["converged"] and rest.report["converged"]
    left = found.report["remaining_change"]["spacing"]
    assert left < quality.largest_change
    assert found.yarns.lattice is not None and rest.yarns.lattice is not None
    sizes = [np.array(size_of(yarns.lattice)) for yarns in (found.yarns, rest.yarns)]
    assert np.abs(sizes[0] / sizes[1] - 1.0).max() < 3.0 * left


def test_yarns_are_at_rest_only_where_the_remaining_change_is_small() -> None:
    coarse, fine = (replace(DOUBLE, tolerance=0.9, largest_change=change) for change in (0.5, 1e-9))
    ends = [relax_yarns(periodic_patch(1, 1), quality=quality, device="cpu", cell=FREE) for quality in (coarse, fine)]
    for end, quality in zip(ends, (coarse, fine), strict=True):
        assert end.report["converged"]
        assert end.report["remaining_change"]["spacing"] < quality.largest_change
    assert ends[0].report["iterations"] < ends[1].report["iterations"]


@pytest.mark.parametrize("given", [{"terms": [Friction(0.3)]},
                                   {"quality": replace(DRAFT, solver="dynamics", max_iterations=60)}])  # fmt: skip
def test_where_rest_moves_or_yarns_have_speed_nothing_is_known_of_the_remaining_change(given: dict[str, Any]) -> None:
    options = {"quality": replace(DRAFT, max_iterations=400), "device": "cpu", "material": LEAF} | given
    result = relax_yarns(tube(3, 6), keep_shape=fabric_of(3, 6, closed=True), **options)
    assert result.report["remaining_change"] is None
    assert all(entry["iteration"] % 20 == 0 for entry in result.history)  # whole intervals


def test_the_report_names_the_remaining_change_where_iterations_end_first(caplog: pytest.LogCaptureFixture) -> None:
    quality = replace(DOUBLE, tolerance=1e-12, largest_change=1e-12)
    whole = [entry["iteration"] for entry in relax_yarns(periodic_patch(1, 1), quality=quality, device="cpu").history]
    caplog.clear()
    quality = replace(quality, max_iterations=whole[-2])
    report = relax_yarns(periodic_patch(1, 1), quality=quality, device="cpu").report
    assert not report["converged"]
    left = RemainingChange(**report["remaining_change"])
    (record,) = (entry for entry in caplog.records if entry.levelname == "WARNING")
    assert f"spacing to change by about {left.spacing:.2g} of itself (expected 1e-12)" in record.getMessage()
    assert asdict(left) == report["remaining_change"]


def test_a_step_that_cannot_lower_the_energy_ends_the_relaxation_with_a_warning(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """No step is accepted: each is tried again at a quarter of its length, until it is too short to matter."""
    monkeypatch.setattr(RelaxationLoop, "_is_acceptable", lambda loop, *_assessed: ~loop.ending)
    tried = []
    step = Newton.step

    def note_scale(newton: Newton, *arguments: Any) -> Any:
        tried.append(float(arguments[3][0]))
        return step(newton, *arguments)

    monkeypatch.setattr(Newton, "step", note_scale)
    result = relax_yarns(periodic_patch(1, 1), quality=DRAFT, device="cpu", cell=FREE)
    assert not result.report["converged"] and result.report["iterations"] < DRAFT.max_iterations
    assert tried == [0.25**count for count in range(len(tried))]
    assert tried[-1] < SMALLEST_NEWTON_SCALE < tried[-2]
    assert "no step lowers the energy" in caplog.records[-1].getMessage()


def test_products_count_as_iterations_of_each_cell() -> None:
    """The limit holds for each cell, and cuts its last step short."""
    cells, quality = [periodic_patch(1, 1), woven_cell()], replace(DOUBLE, tolerance=1e-9, largest_change=1e-9)
    batch = relax_cells(cells, free=[FREE, FREE], quality=quality, device="cpu")
    done = [cell.report["iterations"] for cell in batch.cells]
    assert batch.report["launched"] == max(done) > min(done)
    few = relax_cells(cells, free=[FREE, FREE], quality=replace(quality, max_iterations=min(done) // 2), device="cpu")
    for cell in few.cells:
        assert not cell.report["converged"]
        assert cell.report["iterations"] == min(done) // 2


@pytest.mark.parametrize("free", [[FREE, FREE], None])
def test_some_cells_of_a_batch_continue_alone_with_their_damping_and_estimate(free: list[RelaxCell] | None) -> None:
    cells, cpu = [periodic_patch(1, 1), woven_cell()], device_named("cpu")
    given = [(yarns, KALDOR) for yarns in cells]
    both = YarnSimulation(given, DOUBLE, cpu, cells=free)
    alone = YarnSimulation(given[1:], DOUBLE, cpu, cells=None if free is None else free[1:])
    assert both.newton is not None and alone.newton is not None
    both.newton_step(np.ones(2, dtype=bool), np.ones(2))
    damping, first = np.random.default_rng(5).random(len(both.newton.solve.damping)), len(cells[0].points)
    both.newton.solve.damping.assign(damping)
    alone.newton.teach(np.array([0]), both.newton.learned()[1:])
    expected = np.concatenate([damping[first : both.model.point_count], damping[both.model.point_count + 1 :]])
    assert np.array_equal(alone.newton.solve.damping.numpy(), expected)
    assert np.array_equal(alone.newton.record, both.newton.record[1:])


def test_each_cell_of_a_batch_has_its_own_remaining_change() -> None:
    cells = [periodic_patch(1, 1), woven_cell()]
    for free in ([FREE, FREE], None):
        batch = relax_cells(cells, free=free, quality=DOUBLE, device="cpu")
        left = [cell.report["remaining_change"] for cell in batch.cells]
        assert left[0] is not None and left[1] is not None and left[0] != left[1]
        assert max(change["spacing"] for change in left) < DOUBLE.largest_change
