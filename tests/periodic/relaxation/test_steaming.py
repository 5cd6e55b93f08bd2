# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Steamed swatches, and swatches of yarn that yields: energy, moments of curling, size after release."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.errors import ParameterError
from stitchmesh.periodic.relaxation.steaming import UNCHANGED
from stitchmesh.periodic.swatch_options import SwatchOptions
from stitchmesh.quality import PRESETS
from stitchmesh.yarn.lasting_bend import bend_at_knots
from tests.periodic.free_cells import FREE

MATERIAL = sm.YarnMaterial.named()
BLOCKED: dict[str, Any] = {"blocked": 50.0}


@cache
def jersey(**options: Any) -> sm.Swatch:
    """Stockinette at draft."""
    return sm.swatch("stockinette", quality="draft", device="cpu", progress=False, **options)


@pytest.mark.parametrize("share", [0.5, 1.0])
def test_steam_leaves_a_share_of_the_curl_and_its_square_of_the_energy(share: float) -> None:
    """Bending carries nearly all of both. Yarn that is set in place hardly moves, so that k is s kappa everywhere."""
    before, after = jersey(**FREE).report, jersey(**FREE, steamed=share).report
    assert after["converged"]
    for moment in ("course_moment", "wale_moment"):  # contacts move a little: 5 % of the moment
        assert after[moment] == pytest.approx((1.0 - share) * before[moment], abs=0.05 * abs(before[moment]))
    assert after["energies"]["bend"] / before["energies"]["bend"] == pytest.approx((1.0 - share) ** 2, abs=0.03)
    assert after["before_steam"]["energy"] == pytest.approx(before["energy"], rel=1e-6)
    assert after["width"] == pytest.approx(before["width"], rel=0.03)


def test_a_swatch_that_was_blocked_and_steamed_keeps_a_part_of_its_stretch() -> None:
    free, pinned = jersey(**FREE).report["width"], jersey(**BLOCKED).report["width"]
    half, most = (jersey(**BLOCKED, steamed=share).report["width"] for share in (0.5, 0.9))
    assert free < half < most < pinned
    assert "tension" not in jersey(**BLOCKED, steamed=0.5).report["energies"] or (
        jersey(**BLOCKED, steamed=0.5).report["energies"]["tension"] == 0.0
    )


def test_jersey_that_was_steamed_upright_leans_less() -> None:
    """Steam sets the twist too; pins hold the wales upright meanwhile."""
    turns = 4.0
    plain = jersey(**FREE, residual_twist=turns).report
    steamed = jersey(**BLOCKED, residual_twist=turns, steamed=0.8).report
    assert 0.0 < steamed["spirality"] < 0.5 * plain["spirality"]
    assert steamed["torque"] == pytest.approx(0.2 * plain["torque"], rel=1e-12)


def test_a_knit_off_the_needles_comes_to_rest_again_with_its_friction() -> None:
    dry: dict[str, Any] = {"relaxation": "dry", "relax_cell": True}
    before, after = jersey(**dry).report, jersey(**dry, steamed=0.5).report
    assert after["converged"] and "friction" in after["energies"]
    assert after["steps"] == before["steps"] + 1 and after["iterations"] > before["iterations"]
    assert after["energies"]["bend"] < 0.3 * before["energies"]["bend"]


def test_the_whole_repeat_has_the_natural_curvature_of_its_smallest_cell() -> None:
    made = jersey(**FREE, steamed=0.5)
    assert made.at_rest is not None and made.yarns.yarn_count > made.at_rest.yarns.yarn_count
    draft = PRESETS["draft"]
    found = sm.yarn_energies(
        made.yarns, MATERIAL, quadrature_points=draft.quadrature_points, contact_samples=draft.contact_samples,
        device="cpu",
    )  # fmt: skip
    assert found["bend"] == pytest.approx(made.report["energies"]["bend"], rel=1e-4)  # float32


def test_yarn_yields_until_its_moment_is_at_most_that_of_its_limit() -> None:
    limit = 1.0
    made = jersey(**FREE, yield_curvature=limit)
    yarns = made.yarns
    elastic = np.abs(np.abs(bend_at_knots(yarns)) - np.abs(yarns.natural_curvature))
    assert elastic.max() < limit + 2.0 * UNCHANGED / yarns.radius.min()
    assert made.report["energy"] < jersey(**FREE).report["energy"]


def test_elastic_yarn_keeps_no_bends() -> None:
    assert not jersey(**FREE).yarns.natural_curvature.any()
    assert not jersey(**FREE, yield_curvature=100.0).yarns.natural_curvature.any()


@pytest.mark.parametrize(
    ("options", "message"),
    [({"steamed": 1.5}, "steamed: got 1.5.*a share from 0 to 1"), ({"yield_curvature": -1.0}, "yield.curvature")],
)
def test_values_out_of_bounds_are_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        SwatchOptions(**options)


def test_a_live_swatch_is_not_steamed() -> None:
    with pytest.raises(ParameterError, match="steamed: got one for a live swatch"):
        sm.SwatchSession("stockinette", steamed=0.5, quality="draft", device="cpu")


def test_a_stretch_test_has_no_torque() -> None:
    with pytest.raises(ParameterError, match="residual_twist: got one for a stretch test"):
        sm.stretch_test("stockinette", sm.StretchPath(course=(0.0, 0.1)), residual_twist=5.0, device="cpu")
