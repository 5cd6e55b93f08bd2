# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The residual equals its formula, is independent of units, and excludes the forces that constraints carry."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.compute.device import device_named
from stitchmesh.quality import PRESETS
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial, yarn_energies, yarn_forces
from stitchmesh.yarnrelax.assessment import Assessment
from stitchmesh.yarnrelax.constraints.borders import KeepBorders
from stitchmesh.yarnrelax.simulation import YarnSimulation
from tests.yarnrelax.loops import assessed
from tests.yarnrelax.stockinette import fabric_of, flat_patch, periodic_patch, shaken, tube

pytestmark = pytest.mark.decides

LEAF = YarnMaterial.named("leaf")
STIFFNESSES = ("k_len", "k_length", "k_bend", "k_contact")
COARSE = {"quadrature_points": 3, "contact_samples": 3}


def rms(vectors: np.ndarray) -> float:
    return float(np.sqrt((vectors**2).sum() / len(vectors)))


def forces_by_term(yarns: YarnSet) -> list[np.ndarray]:
    parts = [replace(LEAF, **{other: 0.0 for other in STIFFNESSES if other != own}) for own in STIFFNESSES]
    return [yarn_forces(yarns, part, **COARSE) for part in parts]


@pytest.mark.parametrize("yarns", [shaken(flat_patch(3, 2)), shaken(periodic_patch(2, 1))], ids=["swatch", "cell"])
def test_the_residual_is_the_net_force_over_the_sum_of_magnitudes(yarns: YarnSet) -> None:
    found = assessed(yarns, LEAF)
    parts = forces_by_term(yarns)
    magnitudes = sum(np.linalg.norm(part, axis=1) for part in parts)
    # float64 rounding
    assert found.residual == pytest.approx(rms(np.sum(parts, axis=0)) / rms(magnitudes[:, None]), rel=1e-9)
    assert 0.0 < found.residual < 1.0
    assert found.energies == pytest.approx(yarn_energies(yarns, LEAF, **COARSE), rel=1e-9)
    assert found.energy == pytest.approx(sum(found.energies.values()), rel=1e-12)


def test_a_force_slightly_above_rounding_counts() -> None:
    line = np.arange(12)[:, None] * [0.21, 0.13, 0.07]
    rest = YarnSet.from_curves([line], closed=[False], radius=0.125)
    # float32 rounds coordinates of ten units to 1e-6 and cannot represent a strain of 1e-7; float64 can
    tight = replace(rest, rest_length=rest.rest_length * (1 - 1e-7))
    assert assessed(tight, LEAF).residual > 0.1
    assert assessed(tight, LEAF, "float32").residual == 0.0


def test_the_residual_excludes_the_forces_that_constraints_carry() -> None:
    yarns, fabric = tube(2, 4), fabric_of(2, 4, closed=True)
    pulled = replace(yarns, rest_length=0.9 * yarns.rest_length)
    free, held = assessed(pulled, LEAF), assessed(pulled, LEAF, constraints=[KeepBorders(fabric)])
    parts = forces_by_term(pulled)
    net = np.sum(parts, axis=0).reshape(8, 12, 3)  # both rows are border rows, so each stitch is held
    magnitudes = sum(np.linalg.norm(part, axis=1) for part in parts)
    left = (net - net.mean(axis=1, keepdims=True)).reshape(-1, 3)
    assert held.residual == pytest.approx(rms(left) / rms(magnitudes[:, None]), rel=1e-9)
    assert held.residual < free.residual


def test_a_state_that_is_not_finite_is_detected() -> None:
    assert not Assessment(0.1, {"bend": np.inf, "stretch": 1.0}).finite
    assert not Assessment(np.nan, {"bend": 1.0}).finite
    assert Assessment(0.1, {"bend": 1.0}).finite


def test_an_assessment_keeps_its_energies_when_the_yarns_move():
    simulation = YarnSimulation.start(flat_patch(2, 2), YarnMaterial.named(), PRESETS["draft"], device_named("cpu"))
    before = simulation.assess_cells()
    energies = dict(before[0].energies)
    simulation.state.points.assign(1.1 * simulation.state.points.numpy())
    assert simulation.assess_cells()[0].energies != energies and before[0].energies == energies
