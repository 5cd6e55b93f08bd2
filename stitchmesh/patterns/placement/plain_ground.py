# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The plain ground of a region: the region without the increases and decreases of the patterns in it.

"All faces inside this region are removed from the stitch mesh and new faces are generated" (Yuksel et al. 2012, section
5.3). A run of the region keeps the loops below and above it and the wale edges at its ends. The number of increases or
decreases that remain is the difference of the two numbers of loops; they stay where the old stitches leave or gain
these loops. A run that has increases alone, or decreases alone, shapes the garment and stays as it is.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import BORDER, FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.courses import Course
from stitchmesh.mesh.own_stitch import FIRST_OWN
from stitchmesh.mesh.shaping_stitches import Keeps, shaping_stitch
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.patterns.placement.placement import find_runs, is_plain, is_worked
from stitchmesh.patterns.placement.rebuilt_runs import (
    MOST_LOOPS,
    CourseLine,
    Rebuilt,
    RunPlan,
    line_above,
    line_below,
    rebuild_runs,
    spread_loops,
)


def plain_ground(fabric: StitchMesh, inside: NDArray[np.bool_]) -> Rebuilt | None:
    """Return the patch that turns a region into plain stitches with the shaping that its loops need.

    Args:
        fabric: stitch mesh.
        inside: whether each face belongs to the region, shape (F,).

    Returns:
        The patch and the numbers of the faces before and after it; None if nothing changes.
    """
    worked = inside & is_worked(fabric)
    if not (worked & ~is_plain(fabric)).any():
        return None
    ground = _Ground(fabric, find_runs(fabric, worked))
    plans = ground.plans()
    if not plans:
        return None
    return rebuild_runs(fabric, plans, np.array(ground.positions).reshape(-1, 3))


@dataclass
class _Ground:
    """Plans of all runs that change."""

    fabric: StitchMesh
    runs: list[Course]
    positions: list[FloatArray] = field(default_factory=list)
    new_loops: int = 0

    def plans(self) -> list[RunPlan]:
        """Return the plans of all runs that hold a pattern, or that have a course line with new loops beside them."""
        fabric, runs = self.fabric, self.runs
        below, above = [line_below(fabric, run) for run in runs], [line_above(fabric, run) for run in runs]
        patterned = [_holds_pattern(fabric, run) for run in runs]
        changed = np.zeros((len(runs), 2), dtype=bool)
        for chain in self._chains(below, above):
            counts = np.array([len(below[chain[0]].loops), *(len(above[run].loops) for run in chain)])
            free = np.array([
                (patterned[one] or patterned[two]) and not fabric.cable_shift[above[one].loops].any()
                for one, two in pairwise(chain)
            ], dtype=bool)  # fmt: skip
            for place in np.flatnonzero(free & (_without_excess(counts) != counts)[1:-1]).tolist():
                one, two = chain[place], chain[place + 1]
                wanted = int(_without_excess(counts)[place + 1])
                above[one], below[two] = self._new_line(runs[one], above[one], below[two], wanted)
                changed[one, 1] = changed[two, 0] = patterned[one] = patterned[two] = True
        plans = []
        for number, run in enumerate(runs):
            loops = len(below[number].loops), len(above[number].loops)
            if patterned[number] and min(loops) and max(loops) <= MOST_LOOPS * min(loops):
                cells = spread_loops(*loops, None if changed[number].any() else _steps(fabric, run))
                plans.append(RunPlan(run, below[number], above[number], cells, _stitches(cells)))
        return plans

    def _chains(self, below: list[CourseLine], above: list[CourseLine]) -> list[list[int]]:
        """Return the chains of runs in which each run takes exactly the loops of the run before."""
        fabric = self.fabric
        run_of = np.full(fabric.face_count, BORDER)
        for number, run in enumerate(self.runs):
            run_of[list(run.faces)] = number
        upper: dict[int, int] = {}
        for number, line in enumerate(above):
            across = fabric.twin[line.loops]
            following = np.unique(np.where(across == BORDER, BORDER, run_of[fabric.side_face[across]]))
            if len(following) == 1 and following[0] not in (BORDER, number):
                other = int(following[0])
                if set(below[other].loops.tolist()) == set(across.tolist()):
                    upper[number] = other
        chains = []
        for start in sorted(set(range(len(self.runs))) - set(upper.values())):
            chain = [start]
            while chain[-1] in upper:
                chain.append(upper[chain[-1]])
            chains.append(chain)
        return chains

    def _new_line(self, run: Course, above: CourseLine, below: CourseLine, count: int) -> tuple[CourseLine, CourseLine]:
        """Return a course line with another number of loops: as the run below it and as the run above it see it."""
        fabric, old = self.fabric, len(above.loops)
        loops = fabric.side_count + self.new_loops + np.arange(count)
        ends = len(fabric.vertices) + len(self.positions) + np.arange(count - 1)
        at = np.arange(1, count) * old / count
        place = np.minimum(at.astype(np.int64), old - 1)
        points = fabric.vertices[above.vertices]
        self.positions += list(points[place] + (at - place)[:, None] * (points[place + 1] - points[place]))
        self.new_loops += count
        line = CourseLine(loops, np.concatenate([above.vertices[:1], ends, above.vertices[-1:]]))
        if not run.closed:
            return line, line
        start = int(np.flatnonzero(above.vertices == below.vertices[0])[0])
        turn = round(start * count / old) % count
        turned = np.roll(line.vertices[:-1], -turn)
        return line, CourseLine(np.roll(loops, -turn), np.append(turned, turned[0]))


def _holds_pattern(fabric: StitchMesh, run: Course) -> bool:
    """Whether a run has yarn-overs or tucks, or decreases near increases."""
    faces = np.array(run.faces)
    if (np.isin(fabric.stitch[faces], _OF_PATTERNS) | (fabric.stitch[faces] >= FIRST_OWN)).any():
        return True
    excess = np.sign(fabric.n_top[faces] - fabric.n_bottom[faces])
    shaped = np.flatnonzero(excess)
    turns = np.flatnonzero(np.diff(excess[shaped]))
    # Largest number of stitches between an increase and a decrease that cancel one another in a pattern
    return bool((np.diff(shaped)[turns] <= 12).any())


_OF_PATTERNS = [Stitch.YARN_OVER, Stitch.SY, Stitch.YS, Stitch.YKY]
"""Stitches with more loops above than below with which no garment is shaped."""


def _without_excess(counts: IntArray) -> IntArray:
    """Return numbers of loops on course lines, without excesses that last for a few adjacent lines only.

    This is a morphological opening followed by a closing. Both leave monotone sequences unchanged.
    """
    from scipy.ndimage import grey_closing, grey_opening

    # Extra loops on up to four adjacent course lines count as a pattern, for example the yarn-overs of tucks; on more
    # lines they shape the garment.
    size = min(5, len(counts))
    opened = grey_opening(counts, size=size, mode="nearest")
    closed: IntArray = grey_closing(opened, size=size, mode="nearest")
    closed[0], closed[-1] = counts[0], counts[-1]
    return closed


def _steps(fabric: StitchMesh, run: Course) -> list[int]:
    """Return the places on the narrower side of a run where its wider side has one loop more."""
    faces = np.array(run.faces)
    loops = np.cumsum(np.stack([fabric.n_bottom[faces], fabric.n_top[faces]], axis=1), axis=0)
    more = int(loops[-1, 1] - loops[-1, 0])
    passed = loops if more > 0 else loops[:, ::-1]
    return [_step(passed, number + 1) for number in range(abs(more))]


def _step(passed: IntArray, number: int) -> int:
    """Return the place on the narrow side where the wide side gains its n-th extra loop.

    It is the place before which the fewest faces have gained the loop, and after which the fewest faces lack it.
    """
    gained = passed[:, 1] - passed[:, 0] >= number
    before = np.concatenate([[0], np.cumsum(gained)[:-1]])
    after = np.cumsum(~gained[::-1])[::-1]
    face = int(np.argmin(before + after))
    return int(passed[face - 1, 0]) if face else 0


def _stitches(cells: IntArray) -> IntArray:
    """Return the stitches of new faces; increases and decreases lean towards the middle of the run."""
    count = len(cells)
    stitch = np.full(count, int(Stitch.KNIT))
    for place in np.flatnonzero((cells != 1).any(axis=1)).tolist():
        below, above = cells[place].tolist()
        keeps: Keeps = "left" if 2 * place < count else "right"
        stitch[place] = shaping_stitch(below, above, keeps="middle" if below == MOST_LOOPS else keeps)
    return stitch
