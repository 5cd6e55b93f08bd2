# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What kernels store in the memory of stars they read again, each node and each number at a place of its own."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.device import device_named
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.launch import launch
from stitchmesh.mixed.crossings.star.star_memory import (
    BLOCK_NUMBERS,
    LEG_NUMBERS,
    load_block,
    load_leg,
    numbers_of,
    store_block,
    store_leg,
)

CPU = device_named("cpu")
COUNT = 70
"""Nodes: two groups and a part of one."""


@kernel
def store_all(blocks: wp.array2d[Any], legs: wp.array2d[Any], of_blocks: wp.array[Any], of_legs: wp.array[Any]) -> None:
    i = wp.tid()
    for pair in range(10):
        store_block(of_blocks, i, pair, blocks[i, pair])
    for k in range(4):
        store_leg(of_legs, i, k, legs[i, k])


@kernel
def load_all(of_blocks: wp.array[Any], of_legs: wp.array[Any], blocks: wp.array2d[Any], legs: wp.array2d[Any]) -> None:
    i = wp.tid()
    for pair in range(10):
        blocks[i, pair] = load_block(of_blocks, i, pair)
    for k in range(4):
        legs[i, k] = load_leg(of_legs, 4 * i + k, legs[i, k][0])


def test_stored_blocks_and_legs_are_read_again():
    random = np.random.default_rng(0)
    blocks, legs = random.normal(size=(COUNT, 10, 4, 4)), random.normal(size=(COUNT, 4, 4))
    memory = [wp.zeros(numbers_of(COUNT, each), dtype=wp.float64, device=CPU) for each in (BLOCK_NUMBERS, LEG_NUMBERS)]
    given = [wp.array(blocks, dtype=wp.mat44d, device=CPU), wp.array(legs, dtype=wp.vec4d, device=CPU)]
    run = partial(launch, device=CPU)
    run(store_all, COUNT, given, memory)
    found = [wp.zeros_like(each) for each in given]
    run(load_all, COUNT, memory, found)
    assert np.array_equal(found[0].numpy(), blocks)
    assert np.array_equal(found[1].numpy(), legs)
    assert [np.count_nonzero(each.numpy()) for each in memory] == [blocks.size, legs.size]
