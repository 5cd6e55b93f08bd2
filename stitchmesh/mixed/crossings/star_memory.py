# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Where the numbers of each star lie in memory: groups of 32 nodes, and within a group one number of all its nodes.

The 32 threads of a GPU that work together then read and write each number of their nodes in one transaction, which
takes a third of the time of one structure for each node. Within a group, all numbers of a node are near one another,
which suits the cache of a CPU.
"""

from __future__ import annotations

from typing import Any

import warp as wp

GROUP = wp.constant(32)
"""Nodes of a group."""
LEG_NUMBERS, BLOCK_NUMBERS = wp.constant(16), wp.constant(160)
"""Numbers of a node: vectors of four legs, and ten blocks of 4 x 4."""


def numbers_of(count: int, each: int) -> int:
    """Length of an array of ``each`` numbers for ``count`` nodes."""
    group = int(GROUP)
    return -(-count // group) * group * each


@wp.func
def first_number(i: int, each: int) -> int:
    """Place of the first number of node i; the others follow at distances of ``GROUP``."""
    return (i // GROUP) * each * GROUP + i % GROUP


@wp.func
def store_leg(legs: wp.array[Any], i: int, k: int, value: Any):  # type: ignore[no-untyped-def]
    """Store the vector of leg k of node i, in the precision of the array."""
    first = first_number(i, LEG_NUMBERS) + 4 * k * GROUP
    for c in range(4):
        legs[first + c * GROUP] = type(legs[0])(value[c])


@wp.func
def load_leg(legs: wp.array[Any], slot: int, zero: Any) -> Any:
    """The vector of slot 4 i + k, in the precision of ``zero``."""
    at = first_number(slot // 4, LEG_NUMBERS) + 4 * (slot % 4) * GROUP
    return wp.vector(
        type(zero)(legs[at]),
        type(zero)(legs[at + GROUP]),
        type(zero)(legs[at + 2 * GROUP]),
        type(zero)(legs[at + 3 * GROUP]),
    )


@wp.func
def store_block(blocks: wp.array[Any], i: int, pair: int, value: Any):  # type: ignore[no-untyped-def]
    """Store a block of 4 x 4 of node i, in the precision of the array."""
    first = first_number(i, BLOCK_NUMBERS) + 16 * pair * GROUP
    for r in range(4):
        for c in range(4):
            blocks[first + (4 * r + c) * GROUP] = type(blocks[0])(value[r, c])


@wp.func
def load_block(blocks: wp.array[Any], i: int, pair: int) -> Any:
    """A block of 4 x 4 of node i."""
    a = first_number(i, BLOCK_NUMBERS) + 16 * pair * GROUP
    b, c, d = a + 4 * GROUP, a + 8 * GROUP, a + 12 * GROUP
    return wp.matrix(
        blocks[a], blocks[a + GROUP], blocks[a + 2 * GROUP], blocks[a + 3 * GROUP],
        blocks[b], blocks[b + GROUP], blocks[b + 2 * GROUP], blocks[b + 3 * GROUP],
        blocks[c], blocks[c + GROUP], blocks[c + 2 * GROUP], blocks[c + 3 * GROUP],
        blocks[d], blocks[d + GROUP], blocks[d + 2 * GROUP], blocks[d + 3 * GROUP],
        shape=(4, 4),
    )  # fmt: skip
