# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Cells that are relaxed in one batch give the same results as cells that are relaxed alone."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from stitchmesh.compute.device import device_named
from stitchmesh.errors import ParameterError, SolverError
from stitchmesh.lattice import Lattice
from stitchmesh.quality import PRESETS
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial, relax_yarns, yarn_energies, yarn_forces
from stitchmesh.yarnrelax.energies import evaluation as all_terms
from stitchmesh.yarnrelax.energies.confinement import Confinement
from stitchmesh.yarnrelax.model.image_table import has_room, renew_images
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers import lbfgs_steps
from stitchmesh.yarnrelax.solvers.lbfgs_fused import FusedLBFGS
from stitchmesh.yarnrelax.together.cell_batch import BegunCell, CellBatch, RelaxedCell, relax_batch
from stitchmesh.yarnrelax.together.relax_cells import relax_cells
from tests.yarnrelax.loops import iterate
from tests.yarnrelax.stockinette import flat_patch, periodic_patch, woven_cell

KALDOR, LEAF = YarnMaterial.named("kaldor-simulation"), YarnMaterial.named("leaf")
EXACT = replace(PRESETS["draft"], precision="float64", tolerance=1e-5, largest_change=1e-5)
FREE = RelaxCell(shear=False)


def same_bits(one: Any, other: Any) -> bool:
    """Whether two results have the same control points, periods, energies and iterations to the last bit."""
    both = (one, other)
    points, periods = ([get(each) for each in both] for get in (lambda own: own.yarns.points,
                                                                 lambda own: own.yarns.lattice.periods))  # fmt: skip
    return (
        np.array_equal(*points) and np.array_equal(*periods)
        and all(one.report[name] == other.report[name] for name in ("iterations", "energy", "residual"))
    )  # fmt: skip


def larger(yarns: YarnSet, factor: float) -> YarnSet:
    """The same cell with every length multiplied by ``factor``."""
    assert yarns.lattice is not None
    return replace(
        yarns, points=yarns.points * factor, radius=yarns.radius * factor, rest_length=yarns.rest_length * factor,
        lattice=Lattice(yarns.lattice.periods * factor), natural_curvature=yarns.natural_curvature / factor,
    )  # fmt: skip


def crimped(yarns: YarnSet) -> YarnSet:
    """The same cell with a natural curvature of the yarns."""
    return replace(yarns, natural_curvature=np.full(len(yarns.points), 0.5))


CELLS = [periodic_patch(1, 1), crimped(woven_cell()), periodic_patch(2, 3), larger(periodic_patch(1, 2), 0.3)]
MATERIALS = [KALDOR, LEAF, LEAF, KALDOR.scaled(0.3)]


def test_forces_and_energies_of_each_cell_equal_those_of_the_cell_alone() -> None:
    simulation = YarnSimulation(list(zip(CELLS, MATERIALS, strict=True)), EXACT, device_named("cpu"))
    found = simulation.assess_cells()
    all_terms.force_launches(
        simulation.model,
        simulation.state,
        simulation.candidates,
        (),
        simulation.point_stiffness,
        simulation.model.launch,
    )
    force, start = simulation.state.force.numpy(), simulation.model.point_start
    counts = {"quadrature_points": EXACT.quadrature_points, "contact_samples": EXACT.contact_samples}
    for cell, (yarns, material) in enumerate(zip(CELLS, MATERIALS, strict=True)):
        energies = yarn_energies(yarns, material, **counts)
        # rounding: float64 sums in different orders
        assert found[cell].energies == pytest.approx(energies, rel=1e-11, abs=1e-12 * sum(energies.values()))
        alone = yarn_forces(yarns, material, **counts) * simulation.model.cells[cell].unit
        own = force[start[cell] : start[cell + 1]]
        np.testing.assert_allclose(own, alone, atol=1e-11 * np.abs(alone).max())


def test_each_cell_relaxes_to_the_same_state_as_alone() -> None:
    batch = relax_cells(CELLS, materials=MATERIALS, free=[FREE] * 4, quality=EXACT, device="cpu")
    assert batch.report["converged"] == 4
    for yarns, material, cell in zip(CELLS, MATERIALS, batch.cells, strict=True):
        # The crimped weave has several states of rest, and rounding decides which one it comes to; alone it begins at
        # that of the batch, where it has to stay.
        begins = cell.yarns if yarns is CELLS[1] else yarns
        alone = relax_yarns(begins, material=material, quality=EXACT, device="cpu", cell=FREE)
        assert cell.yarns.lattice is not None and alone.yarns.lattice is not None
        # Candidate lists are made at different iterations, so the paths differ. At rest, the energies differ by the
        # square of the tolerance, and the periods by the tolerance times the ratio of the stretch stiffness of yarn to
        # the stiffness of the fabric (see test_cell_strain).
        assert cell.report["energy"] == pytest.approx(alone.report["energy"], rel=1e-6)
        np.testing.assert_allclose(
            cell.yarns.lattice.periods, alone.yarns.lattice.periods, atol=2e-3 * alone.yarns.lattice.periods.max()
        )
        assert cell.report["max_strain"] == pytest.approx(np.abs(cell.yarns.strain).max(), rel=1e-6)  # two roundings
        assert 0 < cell.report["tenth_iterations"] <= cell.report["iterations"] and cell.report["gradient"] < 0.1
        assert cell.report["min_distance_over_radius"] == pytest.approx(
            alone.report["min_distance_over_radius"], abs=1e-2
        )


def test_a_batch_of_one_cell_has_the_same_bits_as_a_single_relaxation() -> None:
    alone = relax_yarns(CELLS[2], material=LEAF, quality="draft", device="cpu", cell=FREE)
    batch = relax_cells([CELLS[2]], materials=[LEAF], free=[FREE], quality="draft", device="cpu")
    np.testing.assert_array_equal(batch.cells[0].yarns.points, alone.yarns.points)
    assert batch.cells[0].report["iterations"] == alone.report["iterations"]


def launch_apart(simulation: YarnSimulation, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let each step of an iteration have a launch of its own."""
    monkeypatch.setattr(simulation.solver, "fused_launch", lambda *_arguments: None)
    simulation.search.generation += 1


def test_separate_launches_take_the_same_steps_as_the_fused_launch(monkeypatch: pytest.MonkeyPatch) -> None:
    ends = []
    for in_one_launch in (True, False):
        given = list(zip(CELLS, MATERIALS, strict=True))
        simulation = YarnSimulation(given, EXACT, device_named("cpu"), cells=[FREE] * 4)
        assert isinstance(simulation.solver, FusedLBFGS)
        if not in_one_launch:
            launch_apart(simulation, monkeypatch)
        simulation.state.budget.fill_(1e6)  # with small budgets, cells would wait for each other
        iterate(simulation, 20)
        ends.append((simulation.state.points.numpy(), simulation.model.constants.images.periods.numpy()))
    # on a CPU, both add in the same order
    np.testing.assert_array_equal(ends[0][0], ends[1][0])
    np.testing.assert_array_equal(ends[0][1], ends[1][1])


def test_a_cell_in_many_blocks_takes_the_same_steps_as_in_one_block(monkeypatch: pytest.MonkeyPatch) -> None:
    ends = []
    for chunk in (1024, 10):
        monkeypatch.setitem(lbfgs_steps.CHUNK, "cpu", chunk)
        simulation = YarnSimulation.start(CELLS[2], LEAF, EXACT, device_named("cpu"), cell=FREE)
        assert isinstance(simulation.solver, FusedLBFGS)
        launch_apart(simulation, monkeypatch)
        iterate(simulation, 10)
        ends.append(simulation.state.points.numpy()[:-1])
    # rounding of float64 sums in different orders, amplified by ten steps
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-9)


def test_a_cell_that_fails_does_not_affect_the_others() -> None:
    crossed = replace(CELLS[1], points=CELLS[1].points * [1.0, 1.0, 0.0])
    cells = [CELLS[0], crossed, CELLS[2]]
    batch = relax_cells(cells, materials=[KALDOR, LEAF, LEAF], quality="draft", device="cpu")
    assert [cell.report["error"] is None for cell in batch.cells] == [True, False, True]
    assert "too close" in batch.cells[1].report["error"]
    assert [cell.report["converged"] for cell in batch.cells] == [True, False, True]
    assert all(np.isfinite(cell.yarns.points).all() for cell in batch.cells)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"cells": []}, "cells: got none"),
        ({"cells": [periodic_patch(1, 1), flat_patch(2, 2)]}, "cell 1: repeats on no lattice"),
        ({"cells": CELLS[:2], "materials": [KALDOR]}, "materials: got 1 for 2 cells"),
        ({"cells": CELLS[:2], "free": [FREE] * 3}, "free: got 3 for 2 cells"),
        ({"cells": CELLS[:2], "quality": replace(EXACT, solver="dynamics")}, "only quasistatic"),
    ],
)
def test_input_that_cannot_be_relaxed_in_one_batch_is_refused(arguments: dict, message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        relax_cells(device="cpu", **arguments)


def test_the_table_of_images_has_room_for_a_cell_until_its_yarns_spread() -> None:
    simulation = YarnSimulation(list(zip(CELLS, MATERIALS, strict=True)), EXACT, device_named("cpu"))
    every, points = np.ones(4, dtype=bool), simulation.state.points
    assert has_room(simulation.model, points, every)
    spread = points.numpy()
    spread[simulation.model.point_start[2] : simulation.model.point_start[3]] *= 20.0
    points.assign(spread)
    assert not has_room(simulation.model, points, every)
    assert has_room(simulation.model, points, np.array([True, True, False, True]))


def test_a_cell_that_has_left_the_numbers_leaves_the_images_of_the_others() -> None:
    simulation = YarnSimulation(list(zip(CELLS, MATERIALS, strict=True)), EXACT, device_named("cpu"))
    model, state = simulation.model, simulation.state
    points = state.points.numpy()
    points[: model.point_start[1]] *= [1.0, 8.0, 1.0]
    state.points.assign(points)
    simulation.search_contacts(cells=np.array([True, False, False, False]))
    expected = model.constants.images.image.numpy()
    points[model.point_start[2] : model.point_start[3]] = np.nan
    state.points.assign(points)
    renew_images(model, state.points)
    assert np.array_equal(model.constants.images.image.numpy(), expected)
    state.points.assign(np.full_like(points, np.nan))
    with pytest.raises(SolverError, match="a place of the yarns is not finite"):
        renew_images(model, state.points)


def test_a_new_table_of_images_leaves_the_lists_of_other_cells_as_they_are() -> None:
    simulation = YarnSimulation(list(zip(CELLS, MATERIALS, strict=True)), EXACT, device_named("cpu"))
    model, candidates = simulation.model, simulation.candidates
    first, last = model.sample_start[model.segment_start[[1, 2]]]

    def pairs_of_second_cell() -> list[list[tuple[int, int, int]]]:
        table, counts, lists = model.constants.images.image.numpy(), candidates.count.numpy(), candidates.lists.numpy()
        return [
            [(entry % model.sample_count, *table[entry // model.sample_count].tolist())
             for entry in lists[p, : counts[p]].tolist()]
            for p in range(first, last)
        ]  # fmt: skip

    before, images = pairs_of_second_cell(), len(model.constants.images.image)
    points = simulation.state.points.numpy()
    points[: model.point_start[1]] *= [1.0, 8.0, 1.0]
    simulation.state.points.assign(points)
    simulation.search_contacts(cells=np.array([True, False, False, False]))
    assert len(model.constants.images.image) > images
    assert pairs_of_second_cell() == before and any(before)


def test_the_last_cell_of_a_batch_goes_on_with_other_cells() -> None:
    """Ten cells at rest leave the eleventh, which goes on beside a cell that begins, to the state of a single run."""
    (rested,) = relax_cells(CELLS[:1], materials=[KALDOR], free=[FREE], quality=EXACT, device="cpu").cells
    given = [(rested.yarns, KALDOR)] * 10 + [(CELLS[2], LEAF)]
    batch = CellBatch(given, [FREE] * 11, None, EXACT, device_named("cpu"), np.full(11, EXACT.max_iterations))
    ended, _launched = relax_batch(batch, None, others_follow=True)
    assert all(isinstance(cell, RelaxedCell) for cell in ended[:10])
    left = ended[10]
    assert isinstance(left, BegunCell)
    done = left.carried.iterations
    both = replace(batch, given=[(CELLS[0], KALDOR), (CELLS[2], LEAF)], free=[FREE] * 2, most=batch.most[:2],
                   begun=[None, left])  # fmt: skip
    first, second = relax_batch(both, None)[0]
    assert isinstance(first, RelaxedCell) and isinstance(second, RelaxedCell)
    assert first.report["converged"] and second.report["converged"] and second.report["iterations"] > done
    counts = [entry["iteration"] for entry in second.history]
    assert counts == sorted(counts) and counts[0] == 0 and done in counts and first.history[0]["iteration"] == 0
    alone = relax_yarns(CELLS[2], material=LEAF, quality=EXACT, device="cpu", cell=FREE)
    assert same_bits(second, alone)


def test_the_bits_of_a_cell_depend_on_no_other_cell_of_its_batch() -> None:
    """Also if cells need new lists and leave the batch at other times, and stand in another order."""
    longer = [replace(yarns, rest_length=(1.1 + 0.1 * k) * yarns.rest_length) for k, yarns in enumerate(CELLS)]
    planes = [Confinement(1.5 * float(yarns.radius.mean())) for yarns in CELLS]
    for quality, between in ((PRESETS["draft"], planes), (EXACT, None)):
        given = list(zip(longer, MATERIALS, strict=True))
        batch = CellBatch(given, [FREE] * 4, between, quality, device_named("cpu"), np.full(4, 3000))
        whole, _launched = relax_batch(batch, None)
        for chosen in ([2], [3, 2], [1, 0]):
            part = replace(
                batch, given=[given[k] for k in chosen], free=[FREE] * len(chosen), most=batch.most[chosen],
                planes=None if between is None else [planes[k] for k in chosen],
            )  # fmt: skip
            for number, cell in zip(chosen, relax_batch(part, None)[0], strict=True):
                assert same_bits(cell, whole[number])
