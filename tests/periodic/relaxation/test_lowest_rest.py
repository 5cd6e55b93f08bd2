# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The lowest of several states: noise does not change it, it is never above the state of the yarns themselves."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest

from stitchmesh.periodic.relaxation.continuation import size_of
from stitchmesh.periodic.relaxation.lowest_rest import SAME_ENERGY, STARTS, lowest_rest, perturbed_start
from stitchmesh.periodic.relaxation.prepared_swatch import PreparedSwatch, prepare_swatch
from stitchmesh.periodic.relaxation.way_to_rest import relax_along
from stitchmesh.periodic.swatch import swatch
from stitchmesh.run import QUIET
from stitchmesh.time_limit import TimeLimit, limited_to
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import relax_yarns
from stitchmesh.yarnrelax.relaxation_result import Relaxation
from tests.nightly import at_night
from tests.periodic.free_cells import FREE

DRAFT: dict[str, Any] = {"quality": "draft", "device": "cpu"} | FREE


def prepared(pattern: str, **options: Any) -> PreparedSwatch:
    return prepare_swatch(pattern, material=None, **(DRAFT | options))


def minimum(start: PreparedSwatch, yarns: YarnSet, done: int = 0) -> Relaxation:
    return relax_yarns(
        yarns, material=start.similar, quality=start.quality, device="cpu", cell=start.cell, terms=start.terms
    )


@pytest.mark.parametrize("pattern", ["rib1x1", *at_night("rib2x2")])
def test_noise_on_the_yarns_does_not_change_the_state(pattern: str) -> None:
    """From the generated yarns alone, noise takes both ribs to sizes that differ by a tenth."""
    start = prepared(pattern)
    noise = 0.01 * 0.125 * np.random.default_rng(4).normal(size=start.yarns.points.shape)
    shaken = replace(start.yarns, points=start.yarns.points + noise)
    one, other = (relax_along(start, yarns, QUIET) for yarns in (start.yarns, shaken))
    assert one.report["starts"] == other.report["starts"] == 1 + STARTS
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
