# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Smooth random displacements: they are periodic, gentle and repeatable, and no yarn passes through another one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.periodic.relaxation.lowest_rest import STEEPEST, STRAIN, perturb, waves
from stitchmesh.periodic.repeat.drawn_swatch import draw_swatch
from stitchmesh.periodic.resolve_pattern import resolve_pattern
from stitchmesh.periodic.swatch_options import SwatchOptions
from stitchmesh.quality import quality_named
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.linking.certificate import refuse_pull_through

EVERY = np.ones(3, dtype=bool)
"""Both strains and the lean may change."""


def drawn(pattern: str) -> YarnSet:
    return draw_swatch(resolve_pattern(pattern), SwatchOptions(), quality_named("draft"))[1]


def random(seed: int = 5) -> np.random.Generator:
    return np.random.default_rng(seed)


def test_waves_have_the_periods_of_the_lattice() -> None:
    yarns = drawn("eyelet-lace")
    assert yarns.lattice is not None
    moved = replace(yarns, points=yarns.points + yarns.lattice.shift((-2, 3)))
    # phases of some turns, rounded
    assert waves(moved, random()) == pytest.approx(waves(yarns, random()), abs=1e-12)


def test_points_approach_each_other_by_a_quarter_of_their_distance_at_most() -> None:
    yarns = drawn("rib2x2")
    displacement = waves(yarns, random())
    first, second = np.triu_indices(len(yarns.points), 1)
    apart = np.linalg.norm(yarns.points[first, :2] - yarns.points[second, :2], axis=1)
    change = np.linalg.norm(displacement[first] - displacement[second], axis=1)
    near = apart < 0.3  # the gradient is bounded at the control points, and changes by a tenth over this distance
    assert (change[near] <= 1.2 * STEEPEST * apart[near] + 1e-12).all()
    assert change[near].max() > 0.0


@pytest.mark.parametrize("pattern", ["rope-cable", "eyelet-lace", "double-plain-stitched"])
def test_no_yarn_passes_through_another_one(pattern: str) -> None:
    yarns = drawn(pattern)
    moved = perturb(yarns, random(), EVERY)
    refuse_pull_through(yarns, moved, "cpu")
    assert not np.array_equal(moved.points, yarns.points)


def test_the_cell_is_strained_within_bounds() -> None:
    yarns = drawn("garter")
    assert yarns.lattice is not None
    for seed in range(20):
        moved = perturb(yarns, random(seed), EVERY)
        assert moved.lattice is not None
        strain = np.linalg.solve(yarns.lattice.periods[:, :2], moved.lattice.periods[:, :2]) - np.eye(2)
        assert 0.0 < np.abs(strain).max() <= STRAIN * (1 + 1e-12)  # rounding
        assert strain[0, 1] == pytest.approx(0.0, abs=1e-12)  # courses keep their direction
