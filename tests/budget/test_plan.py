# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Plans on devices that have a table and on devices that have none."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.budget import plan
from stitchmesh.budget.budget import Budget
from stitchmesh.budget.calibration import calibrate, stockinette_cell
from stitchmesh.budget.plan import make_plan
from stitchmesh.budget.tables import BudgetScene, read_tables

SCENE = BudgetScene(kind="free cell", stitches=2, name="Stockinette")


def test_a_device_without_a_table_is_compared_with_the_nearest_one(monkeypatch):
    monkeypatch.setattr(plan, "device_title", lambda device: "another machine")
    table = next(table for table in read_tables() if table.processor == "cpu")

    def slow(device: str | None, processor: str) -> tuple[float, float]:
        assert processor == table.processor
        return 3.0 * table.pace[0], 7.0 * table.pace[1]

    known = make_plan(Budget(error=0.4), SCENE, device="cpu", measure=lambda device, processor: table.pace)
    made = make_plan(Budget(error=0.4), SCENE, device="cpu", measure=slow)
    assert known.choice is not None and made.choice is not None
    expected = 3.0 * known.choice.expected.seconds  # the scene is small
    assert made.choice.expected.seconds == pytest.approx(expected, rel=1e-12)
    assert "calibrated: another machine takes 3 times as long" in made.line and "\n" not in made.line


def test_a_device_with_a_table_is_not_calibrated(monkeypatch):
    table = next(table for table in read_tables() if table.processor == "cpu")
    monkeypatch.setattr(plan, "device_title", lambda device: table.device)
    made = make_plan(Budget(within=60.0), SCENE, device="cpu", measure=lambda device, processor: (np.nan, np.nan))
    assert table.title in made.line and "calibrated" not in made.line and "limited to 60 s" in made.line


def test_a_calibration_reads_the_clock_around_each_scene():
    times = iter([0.0, 10.0, 11.0, 100.0, 200.0, 203.0])
    assert calibrate("cpu", clock=lambda: next(times)) == (1.0, 3.0)


def test_the_scene_of_the_calibration_is_a_cell_of_plain_stitches():
    yarns = stockinette_cell(3)
    assert yarns.lattice is not None and yarns.yarn_count == 3
    np.testing.assert_allclose(yarns.lengths, yarns.rest_length, rtol=1e-12)
    assert len(np.unique(yarns.face)) == 9
