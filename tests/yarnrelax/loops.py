# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Relaxation loops of simulations that a test drives step by step."""

from __future__ import annotations

from weakref import WeakKeyDictionary

from stitchmesh.yarnrelax.relaxation_loop import RelaxationLoop
from stitchmesh.yarnrelax.simulation import YarnSimulation

_loops: WeakKeyDictionary[YarnSimulation, RelaxationLoop] = WeakKeyDictionary()


def loop_of(simulation: YarnSimulation) -> RelaxationLoop:
    """The loop of a simulation, the same each time."""
    if simulation not in _loops:
        _loops[simulation] = RelaxationLoop(simulation, tolerance=0.0)
    return _loops[simulation]


def iterate(simulation: YarnSimulation, count: int) -> None:
    """Iterations as in a relaxation, with new candidate lists where they are too old."""
    loop_of(simulation).iterate(count)
