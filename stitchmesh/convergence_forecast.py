# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How many iterations a relaxation still needs, forecast from the course of its residual.

The soft motions of a fabric come to rest after the stiff ones, so that the residual r falls about by a power of the
number of iterations n. A line is laid through the last assessments:

    ln r = ln R - POWER ln(n / N),        left = N ((R / goal)^(1 / POWER) - 1)

Here N is the number of iterations so far. R is the level of the line at N, chosen so that as many assessments lie above
the line as below it; single bad assessments therefore do not change it. The slope is a constant, because a slope that
is fitted to the last assessments follows their noise and forecasts worse. POWER and the bounds of the remaining
iterations were chosen for the courses of ``tests/courses``, where the tests say how well the forecast meets them.
"""

from __future__ import annotations

import math

import numpy as np

POWER = 0.8
"""The residual falls with this power of the number of iterations."""
LEFT = (0.7, 2.7)
"""Least and most remaining iterations, over the iterations so far. A residual below its goal does not end a relaxation
(``yarnrelax.convergence``), and one far above its goal says little beyond a few times the iterations so far."""
FEWEST = 3
"""Number of assessments that a line needs."""


class ResidualCourse:
    """The residuals of a stage, which may be several relaxations one after another."""

    def __init__(self) -> None:
        """Begin without assessments."""
        self._before = 0
        """Iterations of the relaxations that have ended."""
        self._assessments: list[tuple[int, float]] = []

    def add(self, iteration: int, residual: float) -> None:
        """Add an assessment; if its iteration is not after the last one, another relaxation has begun."""
        if self._assessments and iteration <= self._assessments[-1][0]:
            self._before += self._assessments[-1][0]
            self._assessments = []
        self._assessments.append((iteration, residual))

    def completed_part(self, goal: float, most: float = math.inf) -> float:
        """Return the forecast part of the iterations that is done; 0 while there is no forecast.

        Args:
            goal: residual near which the relaxation ends.
            most: number of iterations after which the relaxation ends in any case.
        """
        n, r = np.array(self._assessments, dtype=np.float64).T
        known = (n > 0.0) & (r > 0.0) & np.isfinite(r)
        n, r = n[known], r[known]
        if len(n) < FEWEST:
            return 0.0
        late = n >= min(n[-1] / 4.0, n[-FEWEST])  # the line begins at a quarter of the iterations so far
        level = float(np.median(np.log(r[late]) + POWER * np.log(n[late] / n[-1])))
        growth = math.expm1(min((level - math.log(goal)) / POWER, math.log(1.0 + LEFT[1])))
        left = min(n[-1] * max(growth, LEFT[0]), max(most - n[-1], 0.0))
        done = self._before + float(n[-1])
        return done / (done + left)
