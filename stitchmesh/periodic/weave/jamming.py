# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Jammed weaves: yarns so close that they cannot touch where they cross and bend around one another in between.

In plain cloth a yarn lies level at each crossing, and from there to the next it has at most two arcs around the yarns
that it crosses. Over a spacing p these bring it from one side to the other by no more than

    h = D - sqrt(D^2 - p^2)

with D the sum of the radii of the arcs, each the sum of the radii of two yarns that touch; for p >= D by as much as is
asked for. Around two wefts and two warps the four h have to add up to the four distances of the axes at the crossings,
which are half the sum of the four D. So there is room while

    jam ratio = sum of sqrt(D^2 - p^2) over the four sides / sum of the four distances <= 1

For yarns of one diameter d in a square weave this is p >= sqrt(3) d, the jammed plain weave of Peirce 1937. It holds
for round yarns that keep their shape. Elsewhere, as in twills and satins, a yarn comes to a crossing at a slope and
has more room.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.periodic.weave.weave import Thread, Weave
from stitchmesh.yarn import YarnSet

DIGITS = 6
"""Decimals to which blocks are compared; the first of equals is named."""

logger = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class Block:
    """Two wefts and two warps of one layer, neighbours in plain cloth."""

    wefts: IntArray
    """Their numbers from 0, shape (2,)."""
    warps: IntArray
    """Their numbers from 0, shape (2,)."""
    gap: FloatArray
    """Distance between the warps and between the wefts [cm], shape (2,)."""
    touch: FloatArray
    """Sum of the radii of each weft and each warp [cm], shape (2, 2)."""

    def jam_ratio(self, wider: float = 1.0) -> float:
        """The module's ratio, with the yarns so many times as far apart."""
        along_wefts, along_warps = self.touch.sum(axis=1), self.touch.sum(axis=0)
        left = [reach**2 - (wider * gap) ** 2 for reach, gap in zip((along_wefts, along_warps), self.gap, strict=True)]
        return float(np.sqrt(np.maximum(left, 0.0)).sum() / self.touch.sum())

    def room(self) -> float:
        """Factor of both distances at which a jammed block is so no more."""
        most = self.touch.sum(axis=0).max() + self.touch.sum(axis=1).max()
        return float(brentq(lambda wider: self.jam_ratio(wider) - 1.0, 1.0, most / self.gap.min()))


def jam_report(weave: Weave, yarns: YarnSet) -> dict[str, Any]:
    """Whether a weave is jammed anywhere; says so in one line of the log.

    Args:
        weave: which yarn lies over which.
        yarns: its wefts and warps as they lie on their lattice, in the order of ``weave_yarns``.

    Returns:
        jammed, and jam_ratio of the block that has least room: above 1 it is jammed; 0 where there is no such block.
    """
    blocks = interlaced_blocks(weave, yarns)
    if not blocks:
        return {"jammed": False, "jam_ratio": 0.0}
    tightest = max(blocks, key=lambda block: round(block.jam_ratio(), DIGITS))
    jammed = tightest.jam_ratio() > 1.0
    if jammed:
        logger.warning("%s", _warning(weave, tightest))
    return {"jammed": jammed, "jam_ratio": tightest.jam_ratio()}


def interlaced_blocks(weave: Weave, yarns: YarnSet) -> list[Block]:
    """All such blocks; arguments as for ``jam_report``."""
    count, place = len(weave.wefts), _places(yarns)
    found = []
    for layer in range(weave.layer_count):
        wefts, warps = (_of_layer(threads, layer) for threads in (weave.wefts, weave.warps))
        next_wefts, next_warps = np.roll(wefts, -1), np.roll(warps, -1)
        # a repeat ends where the next one begins; wefts are counted downwards
        between_warps = (place[count + next_warps, 0] - place[count + warps, 0]) % 1.0
        between_wefts = (place[wefts, 1] - place[next_wefts, 1]) % 1.0
        for row, column in np.argwhere(_is_plain(weave.over[np.ix_(wefts, warps)])).tolist():
            two_wefts = np.array([wefts[row], next_wefts[row]])
            two_warps = np.array([warps[column], next_warps[column]])
            gap = np.array([between_warps[column], between_wefts[row]]) * _sizes(yarns)
            touch = yarns.radius[two_wefts][:, None] + yarns.radius[count + two_warps]
            found.append(Block(two_wefts, two_warps, gap, touch))
    return found


def _is_plain(over: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Whether both yarns change sides before and after each crossing, the next one of each and the one across."""
    level = np.ones_like(over)
    for axis in (0, 1):
        changes = over != np.roll(over, -1, axis)
        level &= changes & np.roll(changes, 1, axis)
    along = level & np.roll(level, -1, axis=1)
    return along & np.roll(along, -1, axis=0)


def _of_layer(threads: Sequence[Thread], layer: int) -> IntArray:
    return np.flatnonzero([thread.layer == layer for thread in threads])


def _places(yarns: YarnSet) -> FloatArray:
    """Where the middle of each yarn lies, in periods, shape (Y, 2)."""
    assert yarns.lattice is not None
    middle = np.add.reduceat(yarns.points, yarns.start[:-1]) / np.diff(yarns.start)[:, None]
    places: FloatArray = middle @ np.linalg.pinv(yarns.lattice.periods)
    return places


def _sizes(yarns: YarnSet) -> FloatArray:
    """Lengths of the two periods [cm], along the wefts and along the warps."""
    assert yarns.lattice is not None
    return np.linalg.norm(yarns.lattice.periods, axis=1)


def _warning(weave: Weave, block: Block) -> str:
    """What is jammed and how to mend it, in mean yarn diameters of the block."""
    wefts, warps = (
        " and ".join(weave.number(kind, index) for index in pair.tolist())
        for kind, pair in (("weft", block.wefts), ("warp", block.warps))
    )
    got, need = (block.gap * wider / block.touch.mean() for wider in (1.0, block.room()))
    return (
        f"weave {weave.name!r}: is jammed at wefts {wefts} and warps {warps}: got warp spacing {got[0]:.2f} and weft "
        f"spacing {got[1]:.2f} yarn diameters; expected {need[0]:.2f} and {need[1]:.2f}, which round yarns that "
        "interlace at every crossing need; widen the spacing or take thinner yarn"
    )
