# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Squeeze tests: virtual work, the table, the command and bad requests."""

from __future__ import annotations

import csv
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stitchmesh.cli.main import main
from stitchmesh.errors import ParameterError
from stitchmesh.periodic.squeeze import SqueezeCurve, squeeze_test
from stitchmesh.yarnrelax import YarnMaterial

pytestmark = pytest.mark.usefixtures("first_state")
PARTS = (0.9, 0.8, 0.75, 0.7, 0.65, 0.6, 0.55, 0.5)


@cache
def curve() -> SqueezeCurve:
    """Stockinette of soft yarn."""
    material = YarnMaterial.named("kaldor-simulation").compressed_by("van-wyk")
    return squeeze_test("stockinette", PARTS, material=material, quality="draft", device="cpu")


def test_the_pressure_is_the_slope_of_the_energy() -> None:
    found = curve()
    thickness, pressure, energy = (found.column(name) for name in ("thickness", "pressure", "energy"))
    np.testing.assert_allclose(thickness / thickness[0], [1.0, *PARTS], rtol=1e-9)  # rounding
    assert pressure[0] < 0.01 * pressure[1] and (np.diff(pressure) > 0.0).all()
    assert (np.diff(found.column("flattening")) < 0.0).all()
    work = (pressure[1:] + pressure[:-1]) / 2.0 * -np.diff(thickness)
    # the trapezoid rule over a pressure that rises by up to a half in a step
    np.testing.assert_allclose(np.diff(energy)[2:], work[2:], rtol=0.05)


def test_thickness_is_read_between_the_states() -> None:
    found = curve()
    third = found.points[3]
    assert found.thickness_at(third.pressure) == pytest.approx(third.thickness)
    with pytest.raises(ParameterError, match="thickness: got a pressure of 1e"):
        found.thickness_at(1e9)


def test_the_thickness_says_that_it_was_compared_with_no_measurement() -> None:
    assert str(curve().ranges) == (
        "Not validated: the thickness of stockinette under pressure was compared with no measurement."
    )


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"parts": []}, "squeeze, parts"), ({"parts": [0.8, 0.9]}, "expected falling parts"),
        ({"parts": [0.9, 0.1]}, "parts: got 0.1; expected at least 0.2"),
        ({"parts": [0.9], "period": (1.0, None)}, "period: got one for a squeeze test"),
    ],
)  # fmt: skip
def test_bad_requests_are_refused(given: dict[str, Any], message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        squeeze_test("stockinette", device="cpu", **given)


def test_the_command_writes_a_table_and_a_plot(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["squeeze", "stockinette", "--to", "0.9", "--steps", "1", "--quality", "draft", "--device", "cpu"]
    assert main([*words, "-o", str(tmp_path / "new")]) == 0
    with open(tmp_path / "new" / "squeeze.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert float(rows[1]["pressure_kilopascal"]) == pytest.approx(1e-4 * float(rows[1]["pressure_dyn_per_cm2"]))
    assert (tmp_path / "new" / "squeeze.png").stat().st_size > 1000
    *states, verdict = capsys.readouterr().out.splitlines()
    assert len(states) == 2 and verdict.startswith("Not validated: the thickness")
    assert main([*words, "--to", "1.5", "-o", str(tmp_path / "other")]) == 2
    assert "expected a part of the thickness below 1" in capsys.readouterr().err
