# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Forces that rounding hides are not taken for rest, and yarns without load are at rest whatever their stiffness."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import SolverError
from stitchmesh.quality import PRESETS
from stitchmesh.reporting.verdict import relaxation_verdict
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import Relaxation, YarnMaterial, relax_yarns
from tests.yarnrelax.loops import assessed
from tests.yarnrelax.stockinette import periodic_patch

pytestmark = pytest.mark.decides

DRAFT = replace(PRESETS["draft"], max_iterations=2000)
RADIUS = 0.125


def material(**stiffness: float) -> YarnMaterial:
    """Return the default material with other stiffnesses, also with larger ones than a user may choose."""
    return replace(YarnMaterial.named(), **stiffness)


def relaxed(yarns: YarnSet, **stiffness: float) -> Relaxation:
    return relax_yarns(yarns, material=material(**stiffness), quality=DRAFT, device="cpu")


def arc(over_radius: float) -> YarnSet:
    """Half of a circle of a number of yarn radii."""
    angle = np.arange(0.0, np.pi, 1.3 / over_radius)
    points = RADIUS * over_radius * np.stack([np.cos(angle), np.sin(angle), np.zeros(len(angle))], axis=1)
    return YarnSet.from_curves([points], closed=[False], radius=RADIUS)


@pytest.mark.parametrize("stiffness", [{"k_length": 1e8}, {"k_len": 2e8}, {"k_bend": 1e3}, {"k_contact": 1e9}], ids=str)
def test_what_is_called_at_rest_has_a_residual_below_the_tolerance_in_exact_arithmetic(stiffness):
    """The verdict promises no more of the forces, and float64 is exact beside float32."""
    try:
        made = relaxed(periodic_patch(2, 1), **stiffness)
    except SolverError as error:
        assert "\n" not in str(error)
        return
    if made.report["converged"]:
        assert assessed(made.yarns, material(**stiffness)).residual < DRAFT.tolerance


def test_stiff_yarn_hides_the_bending_of_its_loops_in_float32_and_not_in_float64():
    stiffness = {"k_length": 1e10}
    made = relaxed(periodic_patch(2, 1), **stiffness)
    coarse, fine = (assessed(made.yarns, material(**stiffness), precision) for precision in ("float32", "float64"))
    assert coarse.hidden and coarse.residual >= coarse.rounding > DRAFT.tolerance
    assert not fine.hidden and "float64" in coarse.remedy(DRAFT.tolerance)
    assert made.report["hidden_by_rounding"] and not made.report["converged"]
    assert made.report["iterations"] < DRAFT.max_iterations  # further iterations would change nothing
    text = str(relaxation_verdict(made.report))
    assert "rounding hides whether the yarns are at rest" in text and "reference (float64), or smaller stiff" in text


def test_a_gentle_arc_is_not_at_rest_although_rounding_hides_what_straightens_it():
    made = relaxed(arc(50.0))
    end = np.linalg.norm(made.yarns.points[-1] - made.yarns.points[0])
    assert end < 0.9 * made.yarns.rest_length.sum() and not made.report["converged"]
    assert relaxed(arc(10.0)).report["converged"]  # which straightens


@pytest.mark.parametrize("stiffness", [{}, {"k_length": 1e10}, {"k_bend": 0.0}])
def test_a_straight_yarn_is_at_rest_at_any_stiffness(stiffness):
    line = np.arange(30)[:, None] * [0.21, 0.13, 0.07]  # lengths that no precision represents exactly
    yarn = YarnSet.from_curves([line], closed=[False], radius=RADIUS)
    found = assessed(yarn, material(**stiffness), "float32")
    assert found.residual == 0.0 and not found.hidden
