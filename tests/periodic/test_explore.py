# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The distance of two states of rest, their groups, and explorations."""

from __future__ import annotations

import logging
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.lattice import Lattice
from stitchmesh.periodic.explore import SAME, distance, distinct_rests, explore
from stitchmesh.periodic.relaxation.continuation import stretch_cell
from stitchmesh.periodic.swatch import Swatch
from stitchmesh.yarn import YarnSet
from tests.periodic.free_cells import free_swatch

pytestmark = pytest.mark.usefixtures("first_state")
DRAFT: dict[str, Any] = {"quality": "draft", "device": "cpu", "progress": False}


@pytest.fixture(scope="module")
def rib() -> Swatch:
    return free_swatch("rib2x2")


def changed(yarns: YarnSet, matrix: list[list[float]]) -> YarnSet:
    """The yarns and their lattice after a linear map."""
    assert yarns.lattice is not None
    turn = np.array(matrix).T
    return replace(yarns, points=yarns.points @ turn, lattice=Lattice(yarns.lattice.periods @ turn))


def same_states(yarns: YarnSet) -> dict[str, YarnSet]:
    """The same state of rest: moved, in another image, turned, seen from the back, and along the yarn."""
    assert yarns.lattice is not None
    first = slice(yarns.start[0], yarns.start[1])
    image = yarns.points.copy()
    image[first] += yarns.lattice.shift([2, -1])
    turn = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    return {
        "moved": replace(yarns, points=yarns.points + np.array([0.3, -0.2, 1.0])),
        "image": replace(yarns, points=image),
        "turned": changed(yarns, (turn * np.sign(np.linalg.det(turn))).tolist()),
        "from the back": changed(yarns, [[-1, 0, 0], [0, 1, 0], [0, 0, -1]]),
        "mirrored": changed(yarns, [[-1, 0, 0], [0, 1, 0], [0, 0, 1]]),
    }


def test_equal_states_have_no_distance(rib: Swatch) -> None:
    for name, other in same_states(rib.yarns).items():
        # rounding, and quantiles of the mirrored heights, which have another order
        assert distance(rib.yarns, other) < 1e-3, name


def test_distances_are_relative_sizes_leans_and_reliefs(rib: Swatch) -> None:
    yarns = rib.yarns
    assert distance(yarns, stretch_cell(yarns, 1.1, 1.0)) == pytest.approx(np.log(1.1), rel=1e-9)
    assert distance(yarns, stretch_cell(yarns, 1.0, 0.9)) == pytest.approx(-np.log(0.9), rel=1e-9)
    assert distance(yarns, changed(yarns, [[1, 0.3, 0], [0, 1, 0], [0, 0, 1]])) == pytest.approx(0.3, rel=1e-6)
    assert distance(yarns, changed(yarns, [[1, 0, 0], [0, 1, 0], [0, 0, 0.5]])) > SAME
    assert distance(stretch_cell(yarns, 1.1, 1.0), yarns) == pytest.approx(np.log(1.1), rel=1e-9)  # symmetric


def test_leans_to_either_side_are_one_state(rib: Swatch) -> None:
    left, right = (changed(rib.yarns, [[1, lean, 0], [0, 1, 0], [0, 0, 1]]) for lean in (-0.3, 0.3))
    assert distance(left, right) < 1e-9


def test_groups_do_not_depend_on_the_order(rib: Swatch) -> None:
    wide = [replace(rib, yarns=stretch_cell(rib.yarns, factor, 1.0)) for factor in (1.0, 1.01, 1.3, 1.31, 1.6)]
    made = [
        replace(each, report=each.report | {"energy_per_stitch": energy})
        for each, energy in zip(wide, (5.0, 4.0, 2.0, 3.0, 1.0), strict=True)
    ]
    for order in ([0, 1, 2, 3, 4], [3, 0, 4, 2, 1]):
        rests = distinct_rests([made[k] for k in order])
        assert [(rest.energy, rest.count) for rest in rests] == [(1.0, 1), (2.0, 2), (4.0, 2)]


def test_stockinette_has_one_state_of_rest() -> None:
    found = explore("stockinette", 2, **DRAFT)
    assert (len(found.rests), found.starts, found.not_at_rest) == (1, 3, 0)
    (row,) = found.table()
    assert (row["shape"], row["posture"], row["count"], row["usual"]) == ("flat", "upright", 3, True)


@pytest.mark.nightly
def test_dry_starts_take_one_path_and_their_sizes_have_a_spread() -> None:
    """Noise moves knits that friction holds too."""
    found = explore("stockinette", 2, relaxation="dry", **DRAFT)
    assert (len(found.rests), found.not_at_rest) == (1, 0)
    (rest,) = found.rests
    assert rest.swatch.report["relaxation"] == "dry" and rest.usual and rest.count == 3
    assert 0.0 < min(found.spread) and max(found.spread) < SAME


@pytest.mark.nightly
def test_equal_seeds_find_equal_states_and_a_plain_swatch_is_among_the_starts(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.ERROR):
        one, same = (explore("moss", 1, seed=2, **DRAFT) for _ in range(2))
    assert one.table() == same.table()
    assert sum(rest.count for rest in one.rests) + one.not_at_rest == 2
    assert len(one.rests) > 1  # its courses stand alike in a swatch, and fold where they may lie differently
    (usual,) = (rest for rest in one.rests if rest.usual)
    np.testing.assert_array_equal(usual.swatch.yarns.points, free_swatch("moss").yarns.points)
    energies = [rest.energy for rest in one.rests]
    assert energies == sorted(energies)


def test_fewer_than_one_start_is_refused() -> None:
    with pytest.raises(ParameterError, match="explore: got 0 starts; expected at least 1"):
        explore("stockinette", 0, **DRAFT)
