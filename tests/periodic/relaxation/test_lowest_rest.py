# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The lowest of several states, and the smooth random displacements from which the search for it begins."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest

from stitchmesh.linking.certificate import refuse_pull_through
from stitchmesh.periodic.relaxation import lowest_rest as search
from stitchmesh.periodic.relaxation.continuation import size_of
from stitchmesh.periodic.relaxation.lowest_rest import (
    SAME_ENERGY,
    STARTS,
    STEEPEST,
    STRAIN,
    lowest_rest,
    perturb,
    perturbed_start,
    waves,
)
from stitchmesh.periodic.relaxation.prepared_swatch import PreparedSwatch, prepare_swatch
from stitchmesh.periodic.relaxation.way_to_rest import relax_along
from stitchmesh.periodic.swatch import swatch
from stitchmesh.run import QUIET
from stitchmesh.time_limit import TimeLimit, limited_to
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import relax_yarns
from stitchmesh.yarnrelax.relaxation_result import Relaxation
from tests.nightly import at_night
from tests.periodic.free_cells import FREE, drawn

DRAFT: dict[str, Any] = {"quality": "draft", "device": "cpu"} | FREE
EVERY = np.ones(3, dtype=bool)
"""Both strains and the lean may change."""


def prepared(pattern: str, **options: Any) -> PreparedSwatch:
    return prepare_swatch(pattern, material=None, **(DRAFT | options))


def minimum(start: PreparedSwatch, yarns: YarnSet, done: int = 0) -> Relaxation:
    return relax_yarns(
        yarns, material=start.similar, quality=start.quality, device="cpu", cell=start.cell, terms=start.terms
    )


@pytest.mark.parametrize(("pattern", "starts"), [("rib1x1", 1), *at_night(("rib2x2", STARTS))])
def test_noise_on_the_yarns_does_not_change_the_state(
    pattern: str, starts: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """From the generated yarns alone, noise takes both ribs to sizes that differ by a tenth."""
    monkeypatch.setattr(search, "STARTS", starts)
    start = prepared(pattern)
    noise = 0.01 * 0.125 * np.random.default_rng(4).normal(size=start.yarns.points.shape)
    shaken = replace(start.yarns, points=start.yarns.points + noise)
    one, other = (relax_along(start, yarns, QUIET) for yarns in (start.yarns, shaken))
    assert one.report["starts"] == other.report["starts"] == 1 + starts
    sizes = [size_of(each.yarns.lattice) for each in (one, other) if each.yarns.lattice is not None]
    # a tenth of what draft promises, for energies that count as equal
    np.testing.assert_allclose(*sizes, rtol=5e-3)


@pytest.mark.nightly
def test_no_start_is_lower_than_the_state_that_is_kept() -> None:
    start = prepared("rib1x1")
    kept = lowest_rest(start, start.yarns, partial(minimum, start))
    starts = [perturbed_start(start, start.yarns, np.random.default_rng(number)) for number in range(STARTS)]
    energies = [minimum(start, yarns).report["energy"] for yarns in (start.yarns, *starts)]
    assert kept.report["energy"] in energies
    assert kept.report["energy"] <= min(energies) * (1.0 + SAME_ENERGY)
    assert kept.report["energy"] < energies[0] * (1.0 - 10 * SAME_ENERGY)  # the yarns themselves end in a higher state


def test_equal_energies_keep_the_state_of_the_yarns_themselves() -> None:
    """Plain stitches have one state; rounding must not decide among its copies."""
    start = prepared("stockinette")
    kept, own = lowest_rest(start, start.yarns, partial(minimum, start)), minimum(start, start.yarns)
    assert np.array_equal(kept.yarns.points, own.yarns.points)
    assert kept.report["iterations"] > own.report["iterations"] == kept.history[-1]["iteration"]


def test_what_is_given_stays_as_it_is_in_every_start() -> None:
    start = prepared("garter", period=(1.2, None))
    assert start.yarns.lattice is not None
    for number in range(STARTS):
        moved = perturbed_start(start, start.yarns, np.random.default_rng(number))
        assert moved.lattice is not None
        own, other = size_of(start.yarns.lattice), size_of(moved.lattice)
        assert other[0] == pytest.approx(own[0], rel=1e-6)  # single precision
        assert other[1] != pytest.approx(own[1], rel=1e-3)
        assert moved.lattice.periods[1, 0] == pytest.approx(start.yarns.lattice.periods[1, 0], abs=1e-6)


@pytest.mark.parametrize(
    ("pattern", "options"),
    [
        ("garter", {"relax_cell": False}),
        ("garter", {"columns": 2}),
        ("garter", {"unsupported": True}),
        ("garter", {"smallest": False}),
        ("plain", {}),
    ],
)
def test_one_start_where_states_are_not_searched_for(pattern: str, options: dict[str, Any]) -> None:
    assert not prepared(pattern, **options).has_states


def test_a_limit_on_time_or_iterations_ends_the_search() -> None:
    start = prepared("rib1x1")
    with limited_to(TimeLimit(0.0)):
        assert lowest_rest(start, start.yarns, partial(minimum, start)).report["starts"] == 1
    short = swatch("rib1x1", **(DRAFT | {"quality": replace(start.quality, max_iterations=40)}), progress=False)
    assert not short.report["converged"]
    assert short.report["starts"] == 1


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
