# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Jammed weaves: the yarns are so close that they cannot bend around one another and still touch at every crossing.

In a plain weave a yarn is level at each crossing. Between two crossings it has at most two arcs, around the two yarns
that it crosses. Over a spacing p these arcs change its height by at most

    h = D - sqrt(D^2 - p^2)

where D is the sum of the radii of the two arcs, and the radius of an arc is the sum of the radii of two yarns that
touch. For p >= D the change of height is not limited. Around two wefts and two warps the sum of the four h must equal
the sum of the four axis distances at the crossings, which is half the sum of the four D. The weave is therefore
possible while

    jam ratio = sum of sqrt(D^2 - p^2) over the four sides / sum of the four distances <= 1

For yarns of one diameter d in a square weave this is p >= sqrt(3) d, the jammed plain weave of Peirce 1937. The
condition holds for round yarns with a rigid cross-section. In twills and satins a yarn reaches a crossing at a slope,
so that smaller spacings are possible; such crossings are not checked.
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

logger = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class WeaveBlock:
    """Two wefts and two warps of one layer whose four crossings form a plain weave."""

    wefts: IntArray
    """Indices of the wefts, shape (2,)."""
    warps: IntArray
    """Indices of the warps, shape (2,)."""
    gap: FloatArray
    """Distance between the warps and between the wefts [cm], shape (2,)."""
    touch: FloatArray
    """Sum of the radii of each weft and each warp [cm], shape (2, 2)."""

    def jam_ratio(self, wider: float = 1.0) -> float:
        """Return the jam ratio with all spacings multiplied by ``wider``."""
        along_wefts, along_warps = self.touch.sum(axis=1), self.touch.sum(axis=0)
        left = [reach**2 - (wider * gap) ** 2 for reach, gap in zip((along_wefts, along_warps), self.gap, strict=True)]
        return float(np.sqrt(np.maximum(left, 0.0)).sum() / self.touch.sum())

    def spacing_factor(self) -> float:
        """Return the factor of both spacings at which a jammed block has the jam ratio 1."""
        most = self.touch.sum(axis=0).max() + self.touch.sum(axis=1).max()
        return float(brentq(lambda wider: self.jam_ratio(wider) - 1.0, 1.0, most / self.gap.min()))


def jam_report(weave: Weave, yarns: YarnSet) -> dict[str, Any]:
    """Check whether a weave is jammed, and log a warning if it is.

    Args:
        weave: the weave.
        yarns: the wefts and warps of the weave on their lattice, in the order of ``weave_yarns``.

    Returns:
        jammed, and jam_ratio, the largest ratio of all blocks: above 1 the weave is jammed. The ratio is 0 if no
        crossings form a plain weave.
    """
    blocks = interlaced_blocks(weave, yarns)
    if not blocks:
        return {"jammed": False, "jam_ratio": 0.0}
    # Number of decimals to which the ratios of blocks are compared. If blocks are equal, the first one is reported.
    tightest = max(blocks, key=lambda block: round(block.jam_ratio(), 6))
    jammed = tightest.jam_ratio() > 1.0
    if jammed:
        logger.warning("%s", _warning(weave, tightest))
    return {"jammed": jammed, "jam_ratio": tightest.jam_ratio()}


def interlaced_blocks(weave: Weave, yarns: YarnSet) -> list[WeaveBlock]:
    """Return all blocks of crossings that form a plain weave; arguments as for ``jam_report``."""
    count, place = len(weave.wefts), _places(yarns)
    found = []
    for layer in range(weave.layer_count):
        wefts, warps = (_of_layer(threads, layer) for threads in (weave.wefts, weave.warps))
        next_wefts, next_warps = np.roll(wefts, -1), np.roll(warps, -1)
        # the first yarn of the next repeat follows the last yarn; wefts are numbered downwards
        between_warps = (place[count + next_warps, 0] - place[count + warps, 0]) % 1.0
        between_wefts = (place[wefts, 1] - place[next_wefts, 1]) % 1.0
        for row, column in np.argwhere(_is_plain(weave.over[np.ix_(wefts, warps)])).tolist():
            two_wefts = np.array([wefts[row], next_wefts[row]])
            two_warps = np.array([warps[column], next_warps[column]])
            gap = np.array([between_warps[column], between_wefts[row]]) * _sizes(yarns)
            touch = yarns.radius[two_wefts][:, None] + yarns.radius[count + two_warps]
            found.append(WeaveBlock(two_wefts, two_warps, gap, touch))
    return found


def _is_plain(over: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return whether each crossing and its next crossings along both yarns all differ from their neighbours."""
    level = np.ones_like(over)
    for axis in (0, 1):
        changes = over != np.roll(over, -1, axis)
        level &= changes & np.roll(changes, 1, axis)
    along = level & np.roll(level, -1, axis=1)
    return along & np.roll(along, -1, axis=0)


def _of_layer(threads: Sequence[Thread], layer: int) -> IntArray:
    return np.flatnonzero([thread.layer == layer for thread in threads])


def _places(yarns: YarnSet) -> FloatArray:
    """Return the mean position of each yarn in units of the periods, shape (Y, 2)."""
    assert yarns.lattice is not None
    middle = np.add.reduceat(yarns.points, yarns.start[:-1]) / np.diff(yarns.start)[:, None]
    places: FloatArray = middle @ np.linalg.pinv(yarns.lattice.periods)
    return places


def _sizes(yarns: YarnSet) -> FloatArray:
    """Return the lengths of the two periods [cm], along the wefts and along the warps, shape (2,)."""
    assert yarns.lattice is not None
    return np.linalg.norm(yarns.lattice.periods, axis=1)


def _warning(weave: Weave, block: WeaveBlock) -> str:
    """Return the warning: the jammed block, its spacings and the spacings that it needs in mean yarn diameters."""
    wefts, warps = (
        " and ".join(weave.number(kind, index) for index in pair.tolist())
        for kind, pair in (("weft", block.wefts), ("warp", block.warps))
    )
    got, need = (block.gap * wider / block.touch.mean() for wider in (1.0, block.spacing_factor()))
    return (
        f"weave {weave.name!r}: is jammed at wefts {wefts} and warps {warps}: got warp spacing {got[0]:.2f} and weft "
        f"spacing {got[1]:.2f} yarn diameters; expected {need[0]:.2f} and {need[1]:.2f}, which round yarns that "
        "interlace at every crossing need; widen the spacing or take thinner yarn"
    )
