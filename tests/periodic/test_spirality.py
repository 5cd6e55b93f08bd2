# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Spirality: the torque of yarn with residual twist shears single jersey, by its sign, and fabrics of two sides not."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import pytest

import stitchmesh as sm
from stitchmesh.errors import ParameterError
from stitchmesh.periodic.relaxation.spirality import PER_METRE, torque
from stitchmesh.periodic.swatch_options import SwatchOptions
from stitchmesh.yarnrelax.cell_stress import cell_stress
from tests.periodic.free_cells import drawn

DIAMETER = 2.0 * SwatchOptions.yarn_radius
MATERIAL = sm.YarnMaterial.named()
LIVELY = 4.0
"""Residual twist [turns/m]: a sixth of a turn in the yarn of a stitch."""


@cache
def jersey(loop: float, turns: float | None) -> sm.Swatch:
    """Dry stockinette that lies on nothing; ``loop`` is the loop length over the diameter."""
    return sm.swatch(
        "stockinette", quality="draft", device="cpu", relax_cell=True, unsupported=True, loop_length=loop * DIAMETER,
        residual_twist=turns, progress=False,
    )  # fmt: skip


def torque_shear(pattern: str, turns: float) -> float:
    """Shear stress of a fabric as it is drawn, from the torque of its yarn alone [dyn/cm]."""
    yarns = drawn(pattern)
    (twist,) = torque(SwatchOptions(residual_twist=turns), MATERIAL, 1.0)
    stresses = [cell_stress(yarns, MATERIAL, device="cpu", **given) for given in ({"twist": twist}, {})]
    return stresses[0].shear - stresses[1].shear


def test_wales_lean_to_the_right_with_z_twist_and_to_the_left_with_s_twist() -> None:
    right, left = (jersey(18.0, turns).report["spirality"] for turns in (LIVELY, -LIVELY))
    assert 2.0 < right < 10.0
    assert left == pytest.approx(-right, rel=0.01)  # float32, and a residual of 2e-4


def test_spirality_rises_with_loop_length_and_with_twist() -> None:
    """Kothari et al. 2011 found the first; Tao et al. 1997 found the second."""
    angles = [jersey(loop, LIVELY).report["spirality"] for loop in (15.0, 18.0, 22.0)]
    assert angles == sorted(angles)
    assert jersey(18.0, 2.0 * LIVELY).report["spirality"] > 1.5 * angles[1]


def test_yarn_without_torque_has_no_spirality_and_no_further_term() -> None:
    report = jersey(18.0, None).report
    assert report["spirality"] == 0.0
    assert "twist" not in report["energies"] and "torque" not in report
    assert not torque(SwatchOptions(residual_twist=0.0), MATERIAL, 1.0)


@pytest.mark.parametrize("pattern", ["rib1x1", "garter"])
def test_the_torque_of_fabrics_with_two_like_sides_cancels(pattern: str) -> None:
    """Half a turn about an axis in the plane exchanges the sides and reverses the lean, but not the twist."""
    plain = torque_shear("stockinette", LIVELY)
    assert plain < -0.1
    assert torque_shear(pattern, LIVELY) == pytest.approx(0.0, abs=1e-6 * abs(plain))  # drawn in float64, by symmetry


def test_the_report_states_the_torque() -> None:
    """M = 2 pi GJ tau, and the share of sqrt(3) EI / R for the ring of the yarn of a stitch."""
    report = jersey(18.0, LIVELY).report
    assert report["torque"] == pytest.approx(2.0 * math.pi * MATERIAL.torsional_rigidity * LIVELY / 100.0, rel=1e-12)
    ring = report["loop_length"] / (2.0 * math.pi)
    limit = math.sqrt(3.0) * MATERIAL.flexural_rigidity / ring
    assert report["snarling"] == pytest.approx(report["torque"] / limit, rel=1e-9)
    assert report["spirality"] == pytest.approx(math.degrees(math.atan(report["shear"])), rel=1e-12)


def test_gamma_keeps_the_turns_of_the_yarn() -> None:
    """The cell of a tighter fabric relaxes larger than the fabric; its yarn has the same turns and the same energy."""
    options = SwatchOptions(residual_twist=LIVELY)
    (fabric,), (larger,) = (torque(options, MATERIAL, gamma) for gamma in (1.0, 1.25))
    assert fabric.residual == pytest.approx(LIVELY * PER_METRE)
    assert larger.residual * 1.25 == pytest.approx(fabric.residual, rel=1e-12)
    assert larger.k_twist == pytest.approx(1.25 * fabric.k_twist, rel=1e-12)


@pytest.mark.parametrize("turns", [math.inf, math.nan, 1e9])
def test_an_impossible_twist_is_refused(turns: float) -> None:
    given: dict[str, Any] = {"residual_twist": turns}
    with pytest.raises(ParameterError, match=r"residual.twist: got"):
        SwatchOptions(**given)
