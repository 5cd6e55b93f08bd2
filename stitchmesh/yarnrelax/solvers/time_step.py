# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The common time step of all yarns: the longest one that is stable and moves no control point too far.

Stability. Semi-implicit Euler with mass M, stiffness K and damping C is, in every mode,

    x_(n+1) - 2 x_n + x_(n-1) = - dt^2 M^-1 K x_n - dt M^-1 C (x_n - x_(n-1))

and stays bounded while dt^2 K + 2 dt C < 4 M. Row sums bound a matrix by its diagonal (Gershgorin). It is therefore
sufficient that at each control point, with w^2 = (row sum of K) / m and g = (row sum of C) / m,

    dt^2 w^2 + 2 dt g <= 4     or     dt <= 4 / (g + sqrt(g^2 + 4 w^2)),

which is 2 / w without damping. The stiffness belongs to the state before the step, and contacts become stiffer during
the step, so only a part of this time step is used.

Distance. Let a control point of velocity v and acceleration a move by at most e. Its time step is at most

    dt = [- |v| + sqrt(|v|^2 + 4 e |a|)] / (2 |a|)  =  2 e / (|v| + sqrt(|v|^2 + 4 e |a|))

which is L's eq (2), derived in its appendix A, with control points instead of samples. The weights of the spline are
not negative and sum to one, so that no sample moves farther than its control points. e is the smaller of two lengths:
the largest move of an iteration, and the remaining budget of the control point (``budget``).
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.captured import Launcher
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.reduction import strand_maxima, strands_for

LONGEST_TIME_STEP = 4e-4
"""Longest time step [s] (L section 3.1)."""
STABLE_PART = wp.constant(0.8)
"""Part of the longest stable time step that is used. Measured on knitting without damping: at 0.8 and below the energy
stays within a few percent, at 1 the energy doubles."""
FEW_STRANDS = 32
"""Number of partial results that the last thread of a reduction combines."""


@wp.func
def stable_time(stiffness: Any, damping: Any) -> Any:
    """Longest stable time step for row sums of stiffness and damping over mass."""
    size = damping + wp.sqrt(damping * damping + type(damping)(4.0) * stiffness)
    return type(damping)(4.0 * STABLE_PART) / wp.max(size, type(damping)(1.0e-30))


@wp.func
def time_within(reach: Any, speed: Any, acceleration: Any) -> Any:
    """Longest time step that stays within a reach (L eq 2)."""
    fast = speed + wp.sqrt(speed * speed + type(speed)(4.0) * reach * acceleration)
    return type(speed)(2.0) * reach / wp.max(fast, type(speed)(1.0e-30))


@kernel
def set_time_step(
    # model
    bounds: wp.array[wp.float64],
    # state in
    maxima: wp.array[wp.float64],
    step_scale: wp.array[wp.float64],
    # state out
    clock: wp.array[wp.float64],
) -> None:
    """Set the shortest time step and advance the time; one thread. ``maxima`` are those of minus the time steps.

    ``bounds`` are the longest time step and the time at which the motion ends; there the time step is 0.
    """
    shortest = bounds[0]
    for k in range(maxima.shape[0]):
        if -maxima[k] < shortest:  # a value that is not a number is ignored here; the forces show it
            shortest = -maxima[k]
    step, left = shortest * step_scale[0], bounds[1] - clock[1]
    if step >= left:
        clock[0] = left
        clock[1] = bounds[1]
    else:
        clock[0] = step
        clock[1] = clock[1] + step


class Clock:
    """Time and the time step, on a device."""

    def __init__(self, count: int, device: wp.Device) -> None:
        """Start at time 0, for ``count`` control points."""
        self.now = wp.zeros(2, dtype=wp.float64, device=device)
        """The last time step, and the time since the start [s]."""
        self.step_scale = wp.ones(1, dtype=wp.float64, device=device)
        """Scale of time steps."""
        self.bounds = wp.array([LONGEST_TIME_STEP, np.inf], dtype=wp.float64, device=device)
        """Longest time step, and the time at which the motion ends [s]."""
        self.many = wp.zeros(strands_for(count), dtype=wp.float64, device=device)
        self.few = wp.zeros(FEW_STRANDS, dtype=wp.float64, device=device)

    def run_until(self, end: float, longest: float = LONGEST_TIME_STEP) -> None:
        """Let the motion end at a time, with time steps of at most ``longest`` [s]."""
        self.bounds.assign(np.array([min(longest, LONGEST_TIME_STEP), end]))

    def launches(self, longest: wp.array[Any], launcher: Launcher) -> list[Any]:
        """Return the launches that advance the time by the shortest of the control points' longest time steps."""
        largest, smallest = wp.float64(1.0), wp.float64(-1.0)
        return [
            launcher(strand_maxima, len(self.many), [smallest, longest], [self.many]),
            launcher(strand_maxima, len(self.few), [largest, self.many], [self.few]),
            launcher(set_time_step, 1, [self.bounds, self.few, self.step_scale], [self.now]),
        ]
