# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Forces that rounding hides are not taken for rest, and yarns without load are at rest whatever their stiffness."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.compute.device import device_named
from stitchmesh.errors import SolverError
from stitchmesh.quality import PRESETS
from stitchmesh.reporting.verdict import relaxation_verdict
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import Relaxation, YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.assessment import Assessment
from stitchmesh.yarnrelax.simulation import YarnSimulation
from tests.yarnrelax.stockinette import periodic_patch

pytestmark = pytest.mark.decides

DRAFT = replace(PRESETS["draft"], max_iterations=2000)
RADIUS = 0.125
STIFF = {"k_length": (1e6, 1e8, 1e10), "k_len": (1e6, 2e8, 1e12), "k_bend": (1e-3, 1e3), "k_contact": (1e6, 1e9, 1e12)}
CASES = [(field, value) for field, values in STIFF.items() for value in values]


def material(**stiffness: float) -> YarnMaterial:
    """Return the default material with other stiffnesses, also with larger ones than a user may choose."""
    return replace(YarnMaterial.named(), **stiffness)


def assessed(yarns: YarnSet, precision: str = "float32", **stiffness: float) -> Assessment:
    quality = replace(DRAFT, precision=precision)
    return YarnSimulation.start(yarns, material(**stiffness), quality, device_named("cpu")).assess_cells()[0]


def relaxed(yarns: YarnSet, **stiffness: float) -> Relaxation:
    return relax_yarns(yarns, material=material(**stiffness), quality=DRAFT, device="cpu")


def arc(over_radius: float) -> YarnSet:
    """Half of a circle of a number of yarn radii."""
    angle = np.arange(0.0, np.pi, 1.3 / over_radius)
    points = RADIUS * over_radius * np.stack([np.cos(angle), np.sin(angle), np.zeros(len(angle))], axis=1)
    return YarnSet.from_curves([points], closed=[False], radius=RADIUS)


@pytest.mark.parametrize(("field", "value"), CASES)
def test_what_is_called_at_rest_has_a_residual_below_the_tolerance_in_exact_arithmetic(field, value):
    """The verdict promises no more of the forces, and float64 is exact beside float32."""
    try:
        made = relaxed(periodic_patch(2, 2), **{field: value})
    except SolverError as error:
        assert "\n" not in str(error)
        return
    if made.report["converged"]:
        assert assessed(made.yarns, "float64", **{field: value}).residual < DRAFT.tolerance


@pytest.mark.parametrize("stiffness", [{"k_length": 1e10}, {"k_len": 1e10}])
def test_stiff_yarn_hides_the_bending_of_its_loops_in_float32_and_not_in_float64(stiffness):
    made = relaxed(periodic_patch(2, 2), **stiffness).yarns
    coarse, fine = (assessed(made, precision, **stiffness) for precision in ("float32", "float64"))
    assert coarse.hidden and coarse.residual >= coarse.rounding > DRAFT.tolerance
    assert not fine.hidden and "float64" in coarse.remedy(DRAFT.tolerance)


def test_the_report_and_the_verdict_say_that_rounding_hides_the_answer():
    made = relaxed(periodic_patch(2, 2), k_length=1e10).report
    assert made["hidden_by_rounding"] and not made["converged"]
    assert made["iterations"] < DRAFT.max_iterations  # further iterations would change nothing
    text = str(relaxation_verdict(made))
    assert "rounding hides whether the yarns are at rest" in text and "reference (float64), or smaller stiff" in text


def test_a_gentle_arc_is_not_at_rest_although_rounding_hides_what_straightens_it():
    made = relaxed(arc(50.0))
    end = np.linalg.norm(made.yarns.points[-1] - made.yarns.points[0])
    assert end < 0.9 * made.yarns.rest_length.sum() and not made.report["converged"]


def test_an_arc_that_has_straightened_is_at_rest():
    assert relaxed(arc(10.0)).report["converged"]


@pytest.mark.parametrize("stiffness", [{}, {"k_length": 1e10}, {"k_len": 1e10}, {"k_bend": 1e10}, {"k_bend": 0.0}])
def test_a_straight_yarn_is_at_rest_at_any_stiffness(stiffness):
    line = np.arange(30)[:, None] * [0.21, 0.13, 0.07]  # lengths that no precision represents exactly
    found = assessed(YarnSet.from_curves([line], closed=[False], radius=RADIUS), **stiffness)
    assert found.residual == 0.0 and not found.hidden
