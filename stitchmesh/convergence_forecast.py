# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How many iterations a relaxation still needs, forecast from the course of its residual.

Motions of every softness come to rest one after another, so that the residual r falls about by a power of the number of
iterations n. Through the last assessments goes the line

    ln r = ln R - POWER ln(n / N),        left = N ((R / goal)^(1 / POWER) - 1)

where N are the iterations so far and R, the level of the line there, is the one with as many assessments above it as
below, so that single bad assessments do not change it. The slope is a constant: one that is found from the last
assessments follows their noise, and forecasts worse. POWER and the bounds of what is left were chosen for the courses
of ``tests/courses``, where the tests say how well the forecast meets them.
"""

from __future__ import annotations

import math

import numpy as np

POWER = 0.8
"""Power of the iterations by which the residual falls."""
LEFT = (0.7, 2.7)
"""Least and most that is left, over what is done. A residual below its goal does not end a relaxation
(``yarnrelax.convergence``), and one far above it says little about more than a few times the way so far."""
RECENT = 4.0
"""Iterations so far over the iterations at the beginning of the line."""
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
        """Add an assessment; with an iteration that is not after the last one, another relaxation begins."""
        if self._assessments and iteration <= self._assessments[-1][0]:
            self._before += self._assessments[-1][0]
            self._assessments = []
        self._assessments.append((iteration, residual))

    def completed_part(self, goal: float, most: float = math.inf) -> float:
        """Return the part of the iterations that is done by the forecast; 0 while there is none.

        Args:
            goal: residual near which the relaxation ends.
            most: number of iterations after which the relaxation ends in any case.
        """
        n, r = np.array(self._assessments, dtype=np.float64).T
        known = (n > 0.0) & (r > 0.0) & np.isfinite(r)
        n, r = n[known], r[known]
        if len(n) < FEWEST:
            return 0.0
        late = n >= min(n[-1] / RECENT, n[-FEWEST])
        level = float(np.median(np.log(r[late]) + POWER * np.log(n[late] / n[-1])))
        growth = math.expm1(min((level - math.log(goal)) / POWER, math.log(1.0 + LEFT[1])))
        left = min(n[-1] * max(growth, LEFT[0]), max(most - n[-1], 0.0))
        done = self._before + float(n[-1])
        return done / (done + left)
