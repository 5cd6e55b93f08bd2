# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The branches of a cell that is drawn: those of a spring with two shapes, whose energies are known."""

from __future__ import annotations

from typing import Any

import pytest

from stitchmesh.periodic.relaxation import drawn_cell
from stitchmesh.periodic.relaxation.drawn_cell import draw_without_friction
from stitchmesh.yarnrelax.relaxation_result import Relaxation

ENERGY = {"low": lambda strain: 1.0 + strain**2, "high": lambda strain: 1.02 + (strain - 0.15) ** 2}
"""Energies of the two shapes by the strain."""


def spring(drawn: Any, shape: Any, strain: float) -> Relaxation:
    """The spring at rest at a strain: it snaps above 0.25, and back below 0.05."""
    shape = "high" if strain > 0.25 else "low" if strain < 0.05 else shape
    report = {"energy": ENERGY[shape](strain), "residual": 0.0, "converged": True, "out_of_time": False}
    return Relaxation(shape, report, [])


@pytest.mark.parametrize(
    ("strains", "branches"),
    [
        ([0.0, 0.1, 0.2], [1, 1, 1]),
        ([0.0, 0.1, 0.2, 0.1, 0.0], [1, 1, 1, 1, 1]),
        ([0.0, 0.1, 0.2, 0.3, 0.4], [1, 1, 1, 2, 2]),
        ([0.0, 0.1, 0.2, 0.3, 0.2, 0.1, 0.0], [1, 1, 1, 2, 2, 2, 1]),
    ],
)
def test_a_shape_that_does_not_come_back_is_another_branch(
    strains: list[float], branches: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(drawn_cell, "_relaxed_at", spring)
    monkeypatch.setattr(drawn_cell, "_tension", lambda drawn, yarns: (0.0, 0.0))
    cell: Any = type("Cell", (), {"free": "low"})()
    assert [state.branch for state in draw_without_friction(cell, strains)] == branches
