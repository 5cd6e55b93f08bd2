# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How a piece settles: the remaining change, estimated from the changes so far.

Large pieces may stop before Newton's method begins, and the method does not end the relaxation of free open yarns
(``newton``). Their stitches slide along the fabric in motions of every softness. An iteration of a quasi-Newton method
finds the stiff motions first, and the softest ones only after thousands of iterations, so that a small change from one
iteration to the next says nothing. The changes are therefore compared over spans that grow. Let x be the energy, or the
mean distance of neighbouring stitches along the yarns or across them. After n iterations,

    c = |x(n) - x(n / s)|,    c' = |x(n / s) - x(n / s^2)|,    r = c / c' within FASTEST and SLOWEST,    s^2 = 2
    left = max(c, c' FASTEST^2) r / (1 - r)

is the sum of the changes over all further spans, each s times as long as the one before it. If x decays by a power of
n, as it does with motions of every softness, r is constant. Longer spans would see the end of a decay later; shorter
ones would see little besides noise.

The spacing can stand still before the softest motions are found. The remaining forces then say more than the changes:
the spacing has to change by at least

    SLIDE residual

with the residual of ``convergence``. SLIDE (``quality``) is measured (docs/accuracy.md, Garments at rest): between 240
and 3,600 iterations, the spacings of a skirt, a hat and a sweater differed by 1 to 8 residuals from the spacings after
29,000, and most of them by 4.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.quality import SLIDE
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.assessment import Assessment, RemainingChange
from stitchmesh.yarnrelax.newton import Newton
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.spacing_change import SpacingChange

EXACT = 3e-4
"""Below this residual large pieces are so near to a minimum that an exact step says more than the changes so far."""
SPAN = 2.0**0.5
"""Ratio of the iterations at the end and at the beginning of a span."""
FASTEST, SLOWEST = (1.0 / 3.0) ** 0.5, 0.75**0.5
"""Smallest and largest ratio of the changes over two successive spans with which an estimate is made."""
MARK = 2.0**0.25
"""Ratio of the iterations of two successive marks."""


@dataclass(frozen=True, eq=False)
class Milestone:
    """The figures of a piece after some iterations."""

    iteration: int
    """Number of iterations of the solver with the present load."""
    energy: float
    """Energy [erg]."""
    size: float
    """Sum of the magnitudes of the energy's parts [erg]."""
    residual: float
    """Residual of ``convergence``."""
    spacing: NDArray[np.float64]
    """Mean distance of neighbouring stitches along the yarns and across them [mean radii], shape (2,)."""
    middles: NDArray[np.float64]
    """Middle of each stitch [mean radii], shape (G, 3)."""


class Settling:
    """The marks of one piece."""

    def __init__(self, yarns: YarnSet, device: wp.Device) -> None:
        """Find the stitches and their neighbours in the given yarns; their middles are found on the device."""
        self.stitches = SpacingChange(yarns, device)
        self.marks: list[Milestone] = []
        """Marks in the order of their iterations; those older than an estimate needs are dropped."""

    def is_due(self, iteration: int) -> bool:
        """Return whether a mark is to be made after ``iteration`` iterations."""
        return not self.marks or iteration >= self.marks[-1].iteration * MARK

    def note_state(self, simulation: YarnSimulation, iteration: int, now: Assessment) -> RemainingChange | None:
        """Make a mark of the current state of a simulation (``note``)."""
        return self.note(iteration, now, simulation.state.points)

    def note(
        self, iteration: int, now: Assessment, points: NDArray[np.float64] | wp.array[Any]
    ) -> RemainingChange | None:
        """Make a mark, and estimate the remaining change.

        Args:
            iteration: number of iterations of the solver with the present load.
            now: assessment of the present state.
            points: control points [mean radii], shape (N, 3), or (N,) on the device.

        Returns:
            The estimate, or None while the marks span too few iterations.
        """
        middles = self.stitches.middles(points)
        spacing = self.stitches.mean_distances(middles)
        self.marks.append(Milestone(iteration, now.energy, now.size, now.residual, spacing, middles))
        # an estimate needs marks of the last two spans
        while len(self.marks) > 1 and self.marks[1].iteration * (SPAN**2 * MARK**2) <= iteration:
            del self.marks[0]
        return self.remaining_change()

    def remaining_change(self) -> RemainingChange | None:
        """Return the estimate at the last mark; None while the marks span too few iterations."""
        now = self.marks[-1]
        middle = self._span_before(now)
        first = None if middle is None else self._span_before(middle)
        if middle is None or first is None:
            return None
        fall = float(_left(abs(now.energy - middle.energy), abs(middle.energy - first.energy)))
        energy = fall / now.size if now.size > 0.0 else 0.0
        along, before = (np.abs(b.spacing / a.spacing - 1.0) for a, b in ((middle, now), (first, middle)))
        spacing = max(float(_left(along, before).max()), SLIDE * now.residual)
        rms = float(_left(_rms(now.middles - middle.middles), _rms(middle.middles - first.middles)))
        return RemainingChange(spacing, energy, rms)

    def _span_before(self, end: Milestone) -> Milestone | None:
        """Return the mark at the beginning of the span that ends with a mark; spans are as equal as the marks allow."""
        latest = end.iteration / SPAN * MARK**0.5
        return next((mark for mark in reversed(self.marks) if mark.iteration <= latest), None)

    def arrays(self) -> dict[str, NDArray[np.float64]]:
        """Return the marks for a checkpoint: figures in the order of ``Milestone``, (M, 6), and middles, (M, G, 3)."""
        rows = [[mark.iteration, mark.energy, mark.size, mark.residual, *mark.spacing] for mark in self.marks]
        table = np.array(rows, dtype=np.float64).reshape(-1, 6)
        middles = np.array([mark.middles for mark in self.marks]).reshape(-1, self.stitches.group_count, 3)
        return {"table": table, "middles": middles}

    def resume(self, table: NDArray[np.float64], middles: NDArray[np.float64]) -> None:
        """Restore the marks from ``arrays``."""
        rows = zip(table.tolist(), table[:, 4:], middles, strict=True)
        self.marks = [Milestone(int(row[0]), row[1], row[2], row[3], spacing, middle) for row, spacing, middle in rows]


def settling_of(
    simulation: YarnSimulation, newton: Newton | None, tolerance: float, largest_change: float
) -> Settling | None:
    """Return the marks of the only piece; None if rest is judged in another way.

    Iterations of ``Dynamics`` do not measure time, and terms that lag move the state of rest. Newton's method judges
    small pieces; in double precision it also judges large pieces if the tolerances ask for a residual below ``EXACT``.
    """
    model, lags = simulation.model, any(term.lags for term in simulation.yarn_terms)
    loose = min(tolerance, largest_change / SLIDE) > EXACT or model.scalar is wp.float32
    judges = newton is None or (newton.is_late and loose)
    settles = judges and not model.on_lattice and simulation.is_quasistatic and not lags
    return Settling(model.cells[0].yarns, model.device) if settles else None


def _left(change: NDArray[np.float64] | float, before: NDArray[np.float64] | float) -> NDArray[np.float64]:
    """Return the sum of the changes over all further spans, from the changes over the last two spans."""
    now, earlier = np.asarray(change), np.asarray(before)
    ratio = np.divide(now, earlier, out=np.full(now.shape, FASTEST), where=earlier > 0.0)
    ratio = np.clip(ratio, FASTEST, SLOWEST)
    return np.maximum(now, earlier * FASTEST**2) * ratio / (1.0 - ratio)


def _rms(motion: NDArray[np.float64]) -> float:
    return float(np.sqrt((motion**2).sum(axis=1).mean()))
