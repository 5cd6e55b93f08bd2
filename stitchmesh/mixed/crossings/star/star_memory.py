# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Where the numbers of each star lie in memory, and how kernels read and write them.

On a GPU nodes form groups of 32. A group stores the first number of all its nodes, then the second number of all its
nodes, and so on. The 32 threads that work together then read and write each number of their nodes in one transaction;
with one structure for each node a product takes three times as long. On a CPU the numbers of a node follow one another
and are read at once.
"""

# no postponed annotations: Warp evaluates the types of native functions directly
# ruff: noqa: F811
# mypy: disable-error-code="no-redef,valid-type,no-untyped-def,empty-body"

import warp as wp

GROUP = 32
"""Nodes of a group on a GPU."""
LEG_NUMBERS, BLOCK_NUMBERS = 16, 160
"""Count of numbers of a node: 16 for the vectors of four legs, and 160 for ten blocks of 4 x 4."""


def numbers_of(count: int, each: int) -> int:
    """Length of an array of ``each`` numbers for ``count`` nodes."""
    return -(-count // GROUP) * GROUP * each


def _place(node: str, each: int) -> str:
    """Declare in C++ the place ``first`` of the first number of a node and the distance ``next`` of its numbers."""
    return f"""
#if defined(__CUDA_ARCH__)
    const size_t first = size_t({node} / {GROUP}) * {each * GROUP} + {node} % {GROUP}, next = {GROUP};
#else
    const size_t first = size_t({node}) * {each}, next = 1;
#endif
"""


_LOAD_BLOCK = f"""{_place("i", BLOCK_NUMBERS)}
    wp::mat_t<4, 4, wp::TYPE> block;
    for (int r = 0; r < 4; ++r)
        for (int c = 0; c < 4; ++c) block.data[r][c] = blocks.data[first + (16 * pair + 4 * r + c) * next];
    return block;
"""
_STORE_BLOCK = f"""{_place("i", BLOCK_NUMBERS)}
    for (int r = 0; r < 4; ++r)
        for (int c = 0; c < 4; ++c)
            blocks.data[first + (16 * pair + 4 * r + c) * next] = wp::TYPE(block.data[r][c]);
"""
_LOAD_LEG = f"""{_place("(slot / 4)", LEG_NUMBERS)}
    wp::vec_t<4, wp::TYPE> leg;
    for (int c = 0; c < 4; ++c) leg.c[c] = wp::TYPE(legs.data[first + (4 * (slot % 4) + c) * next]);
    return leg;
"""
_STORE_LEG = f"""{_place("i", LEG_NUMBERS)}
    for (int c = 0; c < 4; ++c) legs.data[first + (4 * k + c) * next] = leg.c[c];
"""


@wp.func_native(_LOAD_BLOCK.replace("TYPE", "float32"))
def load_block(blocks: wp.array(dtype=wp.float32), i: int, pair: int) -> wp.mat44f:
    """A block of 4 x 4 of node i."""
    ...


@wp.func_native(_LOAD_BLOCK.replace("TYPE", "float64"))
def load_block(blocks: wp.array(dtype=wp.float64), i: int, pair: int) -> wp.mat44d:
    """A block of 4 x 4 of node i."""
    ...


@wp.func_native(_STORE_BLOCK.replace("TYPE", "float32"))
def store_block(blocks: wp.array(dtype=wp.float32), i: int, pair: int, block: wp.mat44f):
    """Store a block of 4 x 4 of node i."""
    ...


@wp.func_native(_STORE_BLOCK.replace("TYPE", "float32"))
def store_block(blocks: wp.array(dtype=wp.float32), i: int, pair: int, block: wp.mat44d):
    """Store a block of 4 x 4 of node i, rounded to single precision."""
    ...


@wp.func_native(_STORE_BLOCK.replace("TYPE", "float64"))
def store_block(blocks: wp.array(dtype=wp.float64), i: int, pair: int, block: wp.mat44d):
    """Store a block of 4 x 4 of node i."""
    ...


@wp.func_native(_LOAD_LEG.replace("TYPE", "float32"))
def load_leg(legs: wp.array(dtype=wp.float32), slot: int, zero: wp.float32) -> wp.vec4f:
    """The vector of slot 4 i + k."""
    ...


@wp.func_native(_LOAD_LEG.replace("TYPE", "float64"))
def load_leg(legs: wp.array(dtype=wp.float32), slot: int, zero: wp.float64) -> wp.vec4d:
    """The vector of slot 4 i + k, in the precision of ``zero``."""
    ...


@wp.func_native(_LOAD_LEG.replace("TYPE", "float64"))
def load_leg(legs: wp.array(dtype=wp.float64), slot: int, zero: wp.float64) -> wp.vec4d:
    """The vector of slot 4 i + k."""
    ...


@wp.func_native(_STORE_LEG)
def store_leg(legs: wp.array(dtype=wp.float32), i: int, k: int, leg: wp.vec4f):
    """Store the vector of leg k of node i."""
    ...


@wp.func_native(_STORE_LEG)
def store_leg(legs: wp.array(dtype=wp.float64), i: int, k: int, leg: wp.vec4d):
    """Store the vector of leg k of node i."""
    ...
