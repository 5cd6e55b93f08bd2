# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Join yarn parts into yarns: every part end meets exactly one other, or is tied.

Ends are numbered 2p for the start of part p and 2p + 1 for its end. Across a wale side the one crossing meets its
like; across a course side, which the two faces run along in opposite directions, crossing 0 meets crossing 1. That
is all that mismatched wale directions need (Yuksel et al. 2012, section 4.4). Bridges lead elsewhere.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.errors import YarnError
from stitchmesh.mesh import BORDER, IntArray, StitchMesh
from stitchmesh.yarngen.bridges import SLOTS, Bridges
from stitchmesh.yarngen.embedding import PlacedParts

TIED = -1
"""Partner of a part end that is tied."""


def link_ends(fabric: StitchMesh, parts: PlacedParts, bridges: Bridges) -> IntArray:
    """The end that each part end meets, ``TIED`` where none, shape (2 P,).

    Args:
        fabric: the stitch mesh, bind-off row included.
        parts: its yarn parts.
        bridges: where yarn goes elsewhere than across a side.

    Raises:
        YarnError: two parts claim one crossing, or a loop is not held by the face across.
    """
    crossing = end_crossings(parts)
    if len(np.unique(crossing)) != len(crossing):
        twice = np.flatnonzero(np.bincount(crossing) > 1)[0] // SLOTS
        raise YarnError(f"face {fabric.side_face[twice]}: two yarn parts cross side {twice} in one place")
    end_at = np.full(fabric.side_count * SLOTS, TIED)
    end_at[crossing] = np.arange(len(crossing))
    across = _crossing_across(fabric, bridges)[crossing]
    link = np.where(across == TIED, TIED, end_at[across])
    loose = np.flatnonzero((link == TIED) & ((across != TIED) | ~fabric.is_wale[crossing // SLOTS]))
    if len(loose):
        side = int(crossing[loose[0]] // SLOTS)
        raise YarnError(
            f"face {fabric.side_face[side]}: the yarn that crosses {fabric.side_name(side)} meets none; put a stitch "
            "there that holds the loop, or bind off"
        )
    return link


def end_crossings(parts: PlacedParts) -> IntArray:
    """The crossing at which each part end lies, shape (2 P,)."""
    crossings: IntArray = (parts.end_side * SLOTS + parts.end_slot).ravel()
    return crossings


def _crossing_across(fabric: StitchMesh, bridges: Bridges) -> IntArray:
    """The crossing that each crossing of a side meets, shape (C * SLOTS,)."""
    sides = np.repeat(np.arange(fabric.side_count), SLOTS)
    slots = np.tile(np.arange(SLOTS), fabric.side_count)
    twin = fabric.twin[sides]
    swapped = np.where(fabric.is_wale[sides], slots, 1 - slots)
    across = np.where(twin == BORDER, TIED, twin * SLOTS + swapped)
    # a head over a bottom border is closed by itself: its two crossings meet
    alone = (twin == BORDER) & ~fabric.is_wale[sides]
    across[alone] = sides[alone] * SLOTS + 1 - slots[alone]
    across[list(bridges.ways)] = [way.to for way in bridges.ways.values()]
    across[list(bridges.tails)] = TIED
    return across


def trace(link: IntArray) -> list[tuple[list[int], bool]]:
    """Yarns as lists of the part ends at which their parts are entered, and whether each is closed.

    Open yarns first; every part belongs to exactly one yarn.
    """
    links, used = link.tolist(), np.zeros(len(link) // 2, dtype=bool)
    yarns = []
    for first in [*np.flatnonzero(link == TIED).tolist(), *range(0, len(links), 2)]:
        if used[first // 2]:
            continue
        entries, end = [], first
        while end != TIED and not used[end // 2]:
            used[end // 2] = True
            entries.append(end)
            end = links[end ^ 1]
        yarns.append((entries, end != TIED))
    return yarns
