# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Loops of a stretch test with friction: the work that they return, whether they close, and whether they are congruent.

A fabric with friction remembers where the stretch has turned. Real knits have return-point memory (Dresselhaus 2025, a
1x1 rib of acrylic yarn): drawn from e1 back to e0 and again to e1, the fabric rejoins the curve that it had left at e1.
A larger strain wipes this memory, and loops between the same two strains have the same shape, whatever went before. The
spring and slider of Jenkins, and all assemblies of them, behave so. Here the anchors of friction are the memory
(``yarnrelax/friction``), and normal forces that change with the strain disturb it.

A loop begins where the stretch turns, at a strain e1, and ends when the strain is e1 again. Inside it the stretch may
turn more often. With the tension T, the work given to the fabric is the integral of T de where e rises, and the work
that it returns is the one where e falls. The gap T(end) - T(turn) is zero for a loop that closes. Only loops within the
strains that came before are to close: the others wipe the memory.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from stitchmesh.mesh import FloatArray

SAME_STRAIN = 1e-9
"""Two strains of a path are one if they differ by less than this, by rounding."""


@dataclass(frozen=True, eq=False)
class StretchLoop:
    """A loop of a stretch test: from a turning point away, and back to its strain for the first time."""

    first: int
    """Number of the point of the curve at which the loop begins."""
    strain: FloatArray
    """Strains from the turning point to its strain again, shape (n,)."""
    tension: FloatArray
    """Tensions in the stretch direction [dyn/cm], shape (n,)."""

    is_inner: bool
    """Whether its strains lie within the strains before it."""

    @property
    def turn(self) -> float:
        """The strain at which the loop begins and ends."""
        return float(self.strain[0])

    @property
    def away(self) -> float:
        """The strain of the loop that is farthest from the turn."""
        return float(self.strain[np.abs(self.strain - self.strain[0]).argmax()])

    @property
    def gap(self) -> float:
        """Tension at the end of the loop minus tension at its beginning, over the largest tension of the loop."""
        return float(self.tension[-1] - self.tension[0]) / self.peak

    @property
    def peak(self) -> float:
        """The largest tension of the loop, or pressure [dyn/cm]."""
        return float(np.abs(self.tension).max())

    @property
    def work_given(self) -> float:
        """Work on the fabric while the strain rises, over its free area [erg/cm^2]."""
        return float(self._steps[self._rises].sum())

    @property
    def work_returned(self) -> float:
        """Share of this work that the fabric gives back while the strain falls."""
        return -float(self._steps[~self._rises].sum()) / self.work_given

    @property
    def _rises(self) -> np.ndarray:
        return np.diff(self.strain) > 0.0

    @property
    def _steps(self) -> FloatArray:
        """Work of each step by the trapezoid rule, shape (n - 1,)."""
        return (self.tension[1:] + self.tension[:-1]) / 2.0 * np.diff(self.strain)

    def difference(self, other: StretchLoop) -> tuple[float, float]:
        """Return how far another loop through the same strains differs from this one, over the largest tension of this.

        The first number is the largest difference of tensions; the second one is the same after the other loop is moved
        along the tension so that it fits best: loops of one shape are congruent.
        """
        apart = other.tension - self.tension
        return float(np.abs(apart).max()) / self.peak, float(apart.max() - apart.min()) / 2.0 / self.peak

    def is_like(self, other: StretchLoop) -> bool:
        """Whether two loops go through the same strains."""
        same = len(self.strain) == len(other.strain)
        return same and bool(np.abs(self.strain - other.strain).max() < SAME_STRAIN)


def closed_loops(strain: FloatArray, tension: FloatArray) -> tuple[StretchLoop, ...]:
    """Return the loops of a curve, in the order of their beginnings.

    Args:
        strain: strains one after another, shape (n,).
        tension: tension at each strain [dyn/cm], shape (n,).
    """
    return tuple(_loops(strain, tension))


def _loops(strain: FloatArray, tension: FloatArray) -> Iterator[StretchLoop]:
    ways = np.sign(np.diff(strain))
    turns = [0, *(np.flatnonzero(ways[1:] != ways[:-1]) + 1).tolist()]
    for turn in turns:
        if turn == len(strain) - 1:
            continue
        back = np.flatnonzero((strain[turn + 1 :] - strain[turn]) * ways[turn] < SAME_STRAIN)
        if len(back) and abs(strain[end := turn + 1 + int(back[0])] - strain[turn]) < SAME_STRAIN:
            before, own = strain[: turn + 1], strain[turn : end + 1]
            is_inner = own.min() > before.min() - SAME_STRAIN and own.max() < before.max() + SAME_STRAIN
            yield StretchLoop(turn, own, tension[turn : end + 1], bool(is_inner))


def loop_texts(loops: Sequence[StretchLoop]) -> list[str]:
    """Return a sentence about each loop, which compares it with the last loop before it through the same strains."""
    texts = []
    for number, loop in enumerate(loops):
        text = f"from {100 * loop.turn:.4g} % to {100 * loop.away:.4g} % and back: "
        text += f"{loop.work_returned:.1%} of the work returned"
        if loop.is_inner:
            text += f", open by {loop.gap:+.2%} of its largest tension"
        if before := next((each for each in reversed(loops[:number]) if each.is_like(loop)), None):
            whole, moved = before.difference(loop)
            text += f"; differs from the loop before by {whole:.2%}, in shape by {moved:.2%}"
        texts.append(text)
    return texts
