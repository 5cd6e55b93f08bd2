# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Captured launches: branches run both of their sides, and loops end where the number on the device is zero."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
import warp as wp

from stitchmesh.compute.captured import Branches, CapturedLaunches, CapturedLoop, GridBuild
from stitchmesh.compute.device import device_named
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import prepare

CPU = device_named("cpu")
PREPARE = partial(prepare, device=CPU)


@kernel
def add_number(number: int, total: wp.array[wp.int32]) -> None:
    total[wp.tid()] = total[wp.tid()] + number


@kernel
def set_number(number: int, total: wp.array[wp.int32]) -> None:
    total[wp.tid()] = number


@kernel
def count_down(active: wp.array[wp.int32], rounds: wp.array[wp.int32]) -> None:
    if active[0] > 0:
        active[0] = active[0] - 1
        rounds[0] = rounds[0] + 1


@kernel
def count_neighbours(grid: wp.uint64, reach: float, places: wp.array[wp.vec3], found: wp.array[wp.int32]) -> None:
    count = int(0)
    for j in wp.hash_grid_query(grid, places[wp.tid()], reach):
        if wp.length(places[j] - places[wp.tid()]) < reach:
            count += 1
    found[wp.tid()] = count


def number() -> wp.array:
    return wp.zeros(1, dtype=wp.int32, device=CPU)


def test_branches_run_both_sides_between_what_is_before_and_after():
    left, right = number(), number()
    inner = Branches([PREPARE(add_number, 1, [2], [left])], [PREPARE(add_number, 1, [3], [right])])
    before = [PREPARE(set_number, 1, [10], [each]) for each in (left, right)]
    after = PREPARE(add_number, 1, [100], [left])
    captured = CapturedLaunches([*before, inner, after], CPU)
    for _ in range(2):
        captured.launch()
        assert (left.numpy()[0], right.numpy()[0]) == (112, 13)


@pytest.mark.parametrize(("rounds", "batch"), [(0, 4), (5, 1), (5, 4)])
def test_a_loop_repeats_as_long_as_the_number_is_not_zero(rounds, batch):
    active, done = number(), number()
    first = [PREPARE(set_number, 1, [rounds], [active]), PREPARE(set_number, 1, [0], [done])]
    loop = CapturedLoop(first, [PREPARE(count_down, 1, [], [active, done])], active, CPU, batch=batch)
    for _ in range(2):
        loop.launch()
        assert (active.numpy()[0], done.numpy()[0]) == (0, rounds)


@pytest.mark.parametrize("device", ["cpu", pytest.param("cuda:0", marks=pytest.mark.gpu)])
def test_a_replay_sorts_into_its_own_grid_after_other_grids_were_built(device):
    there, reaches, searches = device_named(device), (0.1, 0.5), []
    points = np.random.default_rng(1).random((300, 3), dtype=np.float32)
    for reach in reaches:
        places = wp.array(points, dtype=wp.vec3, device=there)
        grid, found = wp.HashGrid(16, 16, 16, device=there), wp.zeros(300, dtype=wp.int32, device=there)
        query = prepare(count_neighbours, 300, [wp.uint64(grid.id), reach, places], [found], there)
        searches.append((CapturedLaunches([GridBuild(grid, places, reach), query], there), found))
    apart = np.linalg.norm(points[:, None] - points, axis=2)
    for (search, found), reach in zip(searches, reaches, strict=True):
        search.launch()
        expected = (apart < reach).sum(axis=1)
        assert np.abs(found.numpy() - expected).max() <= (np.abs(apart - reach) < 1e-6).sum()
