# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Launches in parts: every element once, one launch after the other, the same bits for any number of threads."""

from __future__ import annotations

import threading
from typing import Any

import numpy as np
import pytest
import warp as wp

from stitchmesh.compute import launch as launching
from stitchmesh.compute.captured import CapturedLaunches, CopyArray, ZeroArray
from stitchmesh.compute.kernel import RUNS_IN_PARTS, kernel
from stitchmesh.compute.launch import PART, LaunchTable, launch, prepare
from stitchmesh.compute.reduction import row_totals, strand_sums
from stitchmesh.compute.threads import Work
from stitchmesh.linking.crossings import find_crossings
from tests.compute.thread_counts import thread_count

COUNTS = [1, 3]
LENGTHS = [1, PART, 10 * PART + 3]


@kernel
def count_visits(visits: wp.array[wp.int32]) -> None:
    """Add one to each element, and a thousand times its number."""
    i = wp.tid()
    visits[i] = visits[i] + 1 + 1000 * i


@kernel(tile=64)
def count_blocks(visits: wp.array2d[wp.int32]) -> None:
    """The same for blocks of one lane."""
    block, lane = wp.tid()
    visits[block, lane] = visits[block, lane] + 1 + 1000 * block


@kernel
def sum_neighbours(values: wp.array[wp.float64], sums: wp.array[wp.float64]) -> None:
    """Sum of an element and its neighbours on a ring."""
    i, count = wp.tid(), values.shape[0]
    sums[i] = (values[(i + count - 1) % count] + values[i] + values[(i + 1) % count]) * wp.float64(0.3)


def cpu(values: np.ndarray) -> Any:
    return wp.array(values, device="cpu")


def test_this_version_of_warp_runs_launches_in_parts() -> None:
    assert RUNS_IN_PARTS


def test_a_launch_of_a_range_visits_its_elements_only() -> None:
    visits = cpu(np.zeros(20, dtype=np.int32))
    prepared = prepare(count_visits, 20, [visits], [], wp.get_device("cpu"))
    prepared.bounds.shape[0], prepared.bounds.size = 9, 4
    prepared.launch()
    assert visits.numpy().tolist() == [1 + 1000 * k if 5 <= k < 9 else 0 for k in range(20)]


@pytest.mark.parametrize("threads", COUNTS)
@pytest.mark.parametrize("length", LENGTHS)
def test_every_element_and_every_block_is_visited_once(length: int, threads: int) -> None:
    device = wp.get_device("cpu")
    elements, blocks = cpu(np.zeros(length, dtype=np.int32)), cpu(np.zeros((length, 1), dtype=np.int32))
    with thread_count(threads):
        launch(count_visits, length, [elements], [], device)
        launch(count_blocks, length, [blocks], [], device)
    expected = 1 + 1000 * np.arange(length)
    assert np.array_equal(elements.numpy(), expected) and np.array_equal(blocks.numpy()[:, 0], expected)


@pytest.mark.parametrize("threads", COUNTS)
def test_a_launch_begins_after_the_end_of_the_launch_before_it(threads: int) -> None:
    device, length = wp.get_device("cpu"), 40 * PART
    one, two = cpu(np.random.default_rng(3).normal(size=length)), cpu(np.zeros(length))
    expected = one.numpy().copy()
    steps = [
        prepare(sum_neighbours, length, [one], [two], device),
        prepare(sum_neighbours, length, [two], [one], device),
    ]
    with thread_count(threads):
        table = LaunchTable(steps * 10)
        table.launch()
        table.launch()
    for _ in range(40):
        expected = (np.roll(expected, 1) + expected + np.roll(expected, -1)) * 0.3
    assert np.array_equal(one.numpy(), expected)


def test_several_threads_share_a_large_launch_and_one_runs_a_small_one(monkeypatch: pytest.MonkeyPatch) -> None:
    wanted: list[int] = []
    monkeypatch.setattr(launching, "thread_count", lambda: 8)
    monkeypatch.setattr(launching, "share", lambda work, threads: (wanted.append(threads), work(0)))
    enough = 2 * launching.PARTS_PER_THREAD * PART
    for length in (PART, enough - PART, enough, 5 * enough):
        visits = cpu(np.zeros(length, dtype=np.int32))
        launch(count_visits, length, [visits], [], wp.get_device("cpu"))
        assert visits.numpy()[-1] == 1 + 1000 * (length - 1)
    assert wanted == [2, 8]


def test_kernels_with_tiles_run_on_one_thread() -> None:
    parts, totals = cpu(np.ones((40, 256))), cpu(np.zeros(40))
    prepared = prepare(row_totals, 40, [parts], [totals], wp.get_device("cpu"))
    assert launching._part_size(prepared) == 40
    assert not launching._uses_one_memory(find_crossings.func)  # its slots are atomic on a CPU too


def test_tiles_in_functions_that_a_kernel_calls_are_found() -> None:
    @wp.func
    def total_of(parts: wp.array2d[wp.float64]) -> wp.float64:
        return wp.tile_sum(wp.tile_load(parts, shape=(1, 256), offset=(0, 0)))[0]

    def calls(parts: Any, totals: Any) -> None:
        totals[wp.tid()] = total_of(parts)

    assert launching._uses_one_memory(calls)
    assert not launching._uses_one_memory(strand_sums.func)


@pytest.mark.parametrize("threads", COUNTS)
def test_copies_and_zeros_are_parts_of_a_table(threads: int) -> None:
    device, length = wp.get_device("cpu"), 5001
    source, target, cleared = (cpu(np.arange(3.0 * length).reshape(-1, 3)) for _ in range(3))
    strided = cpu(np.ones((length, 2)))
    target.zero_()
    visits = cpu(np.zeros(length, dtype=np.int32))
    steps = [ZeroArray(cleared), CopyArray(source, target), ZeroArray(strided[:, 1])]
    with thread_count(threads):
        captured = CapturedLaunches([*steps, prepare(count_visits, length, [visits], [], device)], device, times=2)
        captured.launch()
    assert not cleared.numpy().any() and np.array_equal(target.numpy(), source.numpy())
    assert strided.numpy().sum(axis=0).tolist() == [length, 0.0]
    assert np.array_equal(visits.numpy(), 2 + 2000 * np.arange(length))
    assert [type(table) for table in captured.parts].count(LaunchTable) == 3  # a copy with gaps stays by itself


def test_a_table_whose_work_was_interrupted_is_done_and_can_be_launched_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """An interrupt before the calling thread begins leaves the table open to threads that come late."""
    visits = cpu(np.zeros(20 * PART, dtype=np.int32))

    def interrupted(work: Work, _threads: int) -> None:
        work(1)
        raise KeyboardInterrupt

    with thread_count(2):
        table = LaunchTable([prepare(count_visits, len(visits), [visits], [], wp.get_device("cpu"))])
        with monkeypatch.context() as patch:
            patch.setattr(launching, "share", interrupted)
            with pytest.raises(KeyboardInterrupt):
                table.launch()
        table._work(1)  # a thread that comes after the end takes nothing
        table.launch()
    assert np.array_equal(visits.numpy(), 2 * (1 + 1000 * np.arange(len(visits))))


def run_often(table: LaunchTable) -> None:
    for _ in range(200):
        table.launch()


def test_two_threads_may_run_tables_at_the_same_time() -> None:
    device, length = wp.get_device("cpu"), 20 * PART
    arrays = [cpu(np.zeros(length, dtype=np.int32)) for _ in range(2)]
    with thread_count(3):
        tables = [LaunchTable([prepare(count_visits, length, [array], [], device)]) for array in arrays]
        callers = [threading.Thread(target=run_often, args=[table]) for table in tables]
        for caller in callers:
            caller.start()
        for caller in callers:
            caller.join()
    for array in arrays:
        assert np.array_equal(array.numpy(), 200 * (1 + 1000 * np.arange(length)))
