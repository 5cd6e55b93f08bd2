# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Renewal of terms that lag: friction keeps its normal forces while yarns come to rest (``YarnTerm.lags``).

A state of rest is renewed; it is at rest only if it still is so after the renewal.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stitchmesh.yarnrelax.relaxation_loop import RelaxationLoop
from stitchmesh.yarnrelax.simulation import YarnSimulation


def renew_at_rest(loop: RelaxationLoop, cells: NDArray[np.bool_] | None = None) -> NDArray[np.bool_]:
    """Renew the terms that lag in those cells, of some or all, that are at rest and have moved since the last renewal.

    Returns:
        Which cells were renewed, shape (C,); Newton's method judges them again.
    """
    simulation, resting = loop.simulation, loop.at_rest & ~loop.failed
    if cells is not None:
        resting &= cells
    if not resting.any() or not any(term.lags for term in simulation.yarn_terms):
        return np.zeros_like(resting)
    loop.search_contacts(cells=resting)
    renewed = renew_lagging(simulation, resting)
    if renewed.any():
        loop.last = loop.last.replaced(renewed, simulation.assess_cells(renewed))
        loop.remaining = loop.remaining.forgotten(renewed & loop.ending)
        if loop.newton is not None:
            loop.newton.idle[renewed] = 0
    return renewed


def renew_lagging(simulation: YarnSimulation, cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Renew the terms that lag in those of some cells that have moved since the last renewal; return these, shape (C,).

    Samples and candidate lists must be up to date.
    """
    renewed = np.zeros_like(cells)
    for term in simulation.yarn_terms:
        if term.lags and (moved := cells & term.has_moved(simulation.state)).any():
            renewed |= moved
            term.renew(simulation.state, simulation.candidates, moved)
    return renewed
