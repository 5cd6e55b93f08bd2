# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Momentum that dies where it stops helping: the damping of the relaxation.

Each iteration keeps a part of the last move and adds the force over the row sum of stiffness,

    v <- beta v + eta F / D,     x <- x + v

(heavy ball; a semi-implicit Euler step with mass D, time step sqrt(eta) and mass-proportional damping). beta grows as
a / (a + 3) with the iterations a since the last restart, and momentum restarts from nothing as soon as the moves point
up the energy, sum F . v < 0 (O'Donoghue and Candes 2015; kinetic damping of form finding). The power is that of the
previous iteration, so nothing is read back to the host. Damping of contacts and of all motion (Kaldor's k_dt, k_dn,
k_global) changes how a yarn comes to rest and not where, and has no part in it.
"""

from __future__ import annotations

from typing import Any

import warp as wp

wp.set_module_options({"enable_backward": False})

KEPT = 0
"""Place of beta in the array of pace."""
AGE = 1
"""Place of the iterations since the last restart."""
EAGERNESS = 2
"""Place of eta."""
LARGEST_EAGERNESS = 2.0
"""eta of an undisturbed run. Row sums overestimate the stiffness; measured, 2 needs 0.7 times the iterations of 1."""


@wp.func
def damped_step(force: Any, last_step: Any, stiffness: Any, pace: wp.array[wp.float64]) -> Any:
    """The move [cm] that momentum and force ask for."""
    kept, eagerness = type(stiffness)(pace[0]), type(stiffness)(pace[2])
    return last_step * kept + force * (eagerness / stiffness)


@wp.kernel(module="unique")
def update_pace(
    # state in
    power_sums: wp.array[wp.float64],
    # state out
    pace: wp.array[wp.float64],
) -> None:
    """Let momentum grow, or restart it; one thread."""
    power = wp.float64(0.0)
    for k in range(power_sums.shape[0]):
        power += power_sums[k]
    age = pace[1] + wp.float64(1.0)
    if power < wp.float64(0.0):
        age = wp.float64(0.0)
    pace[1] = age
    pace[0] = age / (age + wp.float64(3.0))
