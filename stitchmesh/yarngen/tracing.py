# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Join yarn parts into yarns: each end of a part meets exactly one other end, or it is the end of a yarn.

Part p has two ends: number 2p is its start and number 2p + 1 is its end. Two faces that share a wale side have one
crossing there, and these two crossings meet. Two faces that share a course side run along it in opposite directions, so
crossing 0 of one face meets crossing 1 of the other. This rule also covers mismatched wale directions (Yuksel et al.
2012, section 4.4). A bridge replaces the crossing across the side by another crossing.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.errors import YarnError
from stitchmesh.mesh import BORDER, IntArray, StitchMesh
from stitchmesh.yarngen.bridges import SLOTS, Bridges
from stitchmesh.yarngen.embedding import PlacedParts

TIED = -1
"""Marks a part end without a partner: the yarn ends there and is tied off."""


def link_ends(fabric: StitchMesh, parts: PlacedParts, bridges: Bridges) -> IntArray:
    """The partner of each part end, ``TIED`` where the yarn ends, shape (2 P,).

    Args:
        fabric: the stitch mesh, including the bind-off row.
        parts: the yarn parts of the stitch mesh.
        bridges: bridges and tails, where yarn does not continue across a side.

    Raises:
        YarnError: two parts use the same crossing, or a loop is not held by the face across the side.
    """
    crossing = end_crossings(parts)
    repeated = np.flatnonzero(np.bincount(crossing) > 1)
    if len(repeated):
        repeated_side = repeated[0] // SLOTS
        raise YarnError(
            f"face {fabric.side_face[repeated_side]}: two yarn parts cross side {repeated_side} in one place",
            face=int(fabric.side_face[repeated_side]),
        )
    end_at = np.full(fabric.side_count * SLOTS, TIED)
    end_at[crossing] = np.arange(len(crossing))
    across = _opposite_crossings(fabric, bridges)[crossing]
    partner = np.where(across == TIED, TIED, end_at[across])
    unconnected = np.flatnonzero((partner == TIED) & ((across != TIED) | ~fabric.is_wale[crossing // SLOTS]))
    if len(unconnected):
        side = int(crossing[unconnected[0]] // SLOTS)
        raise YarnError(
            f"face {fabric.side_face[side]}: the yarn that crosses {fabric.side_name(side)} meets no other yarn; put a "
            "stitch there that holds the loop, or bind off",
            face=int(fabric.side_face[side]),
        )
    return partner


def end_crossings(parts: PlacedParts) -> IntArray:
    """The crossing at which each part end lies, shape (2 P,)."""
    crossings: IntArray = (parts.end_side * SLOTS + parts.end_slot).ravel()
    return crossings


def _opposite_crossings(fabric: StitchMesh, bridges: Bridges) -> IntArray:
    """The crossing that meets each crossing of a side, ``TIED`` where none does, shape (C * SLOTS,)."""
    sides = np.repeat(np.arange(fabric.side_count), SLOTS)
    slots = np.tile(np.arange(SLOTS), fabric.side_count)
    twin = fabric.twin[sides]
    slots_across = np.where(fabric.is_wale[sides], slots, 1 - slots)
    across = np.where(twin == BORDER, TIED, twin * SLOTS + slots_across)
    # a head above a bottom border is closed by itself: its two crossings meet
    closed_by_itself = (twin == BORDER) & ~fabric.is_wale[sides]
    across[closed_by_itself] = sides[closed_by_itself] * SLOTS + 1 - slots[closed_by_itself]
    across[list(bridges.paths)] = [path.to for path in bridges.paths.values()]
    across[list(bridges.tails)] = TIED
    return across


def trace(partner: IntArray) -> list[tuple[list[int], bool]]:
    """Follow the partners from part to part and return the yarns, open yarns first.

    Args:
        partner: partner of each part end, shape (2 P,), from ``link_ends``.

    Returns:
        For each yarn the list of the part ends at which the yarn enters its parts, and whether the yarn is closed. Each
        part belongs to exactly one yarn.
    """
    partners, used = partner.tolist(), bytearray(len(partner) // 2)  # Python reads single bytes of an array slowly
    yarns = []
    for first in [*np.flatnonzero(partner == TIED).tolist(), *range(0, len(partners), 2)]:
        if used[first // 2]:
            continue
        entries, end = [], first
        while end != TIED and not used[end // 2]:
            used[end // 2] = True
            entries.append(end)
            end = partners[end ^ 1]
        yarns.append((entries, end != TIED))
    return yarns
