# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Conjugate gradients find the step of the dense matrix, within their tolerance and in the limits of the moves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.collision.budget import STRAIN_UNIT
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers import newton
from stitchmesh.yarnrelax.solvers.conjugate_gradients import FACTOR, FORCING, NEGATIVE, PRODUCTS, RATIO, SQUARE, WORK
from tests.yarnrelax.hessian.dense_matrix import DOUBLE, Products, started
from tests.yarnrelax.stockinette import periodic_patch

KALDOR, FREE = YarnMaterial.named("kaldor-simulation"), RelaxCell()
CELLS = {"one stitch": periodic_patch(1, 1), "two rows": periodic_patch(2, 1)}


def nearly_at_rest(yarns: YarnSet) -> YarnSet:
    """Yarns whose next Newton step is much shorter than the limits of the moves."""
    quality = replace(DOUBLE, tolerance=1e-4, largest_change=1e-4)
    return relax_yarns(yarns, material=KALDOR, quality=quality, device="cpu", cell=FREE).yarns


def step_of(simulation: YarnSimulation, share: float) -> dict[str, np.ndarray]:
    """Forces, iterate, step and record of one Newton step, with the shares of both matrices given."""
    assert simulation.newton is not None
    simulation.newton.share[:] = share
    products = simulation.newton_step(np.ones(1, dtype=bool), np.ones(1))
    solve = simulation.newton.solve
    found = {"force": simulation.state.force.numpy(), "x": solve.x.numpy(), "step": solve.step.numpy(),
             "limit": solve.limit.numpy(), "record": solve.record.numpy()[0], "products": products}  # fmt: skip
    return {name: np.array(array) for name, array in found.items()}


@pytest.mark.parametrize("share", [1.0, 0.3])
@pytest.mark.parametrize("yarns", CELLS.values(), ids=CELLS)
def test_the_iterate_solves_the_dense_system(yarns: YarnSet, share: float) -> None:
    rest = nearly_at_rest(yarns)
    unit = np.ones(3 * len(rest.points) + 3)
    unit[-3:] = float(STRAIN_UNIT)
    matrix = Products(started(rest, KALDOR, cell=FREE), 1.0 - share).matrix() / np.outer(unit, unit)
    found = step_of(started(rest, KALDOR, cell=FREE), share)
    assert found["record"][NEGATIVE] == 0.0 and found["record"][RATIO] < 1.0
    force, x = found["force"].ravel(), found["x"].ravel()
    exact = np.linalg.lstsq(matrix, force, rcond=1e-12)[0]  # a motion of the yarns as a whole has no stiffness
    # x is the best in its space: its work is twice the energy that the model saves
    assert force @ x == pytest.approx(x @ matrix @ x, rel=1e-6)
    # the error in the norm of the matrix; the iteration ends at a part FORCING in the norm of the preconditioner
    assert np.sqrt((exact - x) @ matrix @ (exact - x)) < 10 * float(FORCING) * np.sqrt(exact @ matrix @ exact)
    assert found["record"][WORK] == pytest.approx(force @ x, rel=1e-12)
    assert found["record"][SQUARE] == pytest.approx(x @ x, rel=1e-12)
    assert found["products"][0] == found["record"][PRODUCTS] > 0


def test_without_the_coarse_space_the_iterate_is_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    """A preconditioner may change the number of products, and does not change the solution."""
    rest = nearly_at_rest(CELLS["one stitch"])
    one = step_of(started(rest, KALDOR, cell=FREE), 1.0)
    monkeypatch.setattr(newton, "suits_coarse_space", lambda model: False)
    other = step_of(started(rest, KALDOR, cell=FREE), 1.0)
    apart = other["record"][WORK] - one["record"][WORK]
    assert abs(apart) < 10 * float(FORCING) * one["record"][WORK]


@pytest.mark.parametrize("yarns", CELLS.values(), ids=CELLS)
def test_no_move_is_longer_than_its_limit_far_from_rest(yarns: YarnSet) -> None:
    simulation = started(replace(yarns, rest_length=0.9 * yarns.rest_length), KALDOR, cell=FREE)
    before = simulation.state.points.numpy().copy()
    found = step_of(simulation, 1.0)
    assert found["record"][RATIO] > 1.0 > found["record"][FACTOR]
    moved = np.linalg.norm(found["step"], axis=1)
    assert (moved <= found["limit"] * (1.0 + 1e-12)).all() and moved.max() > 0.1 * found["limit"].max()
    assert (found["limit"] <= simulation.step_fraction).all()
    assert np.abs(simulation.state.points.numpy() - before).max() > 0.0
