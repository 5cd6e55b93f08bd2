# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Relaxation loops for simulations that a test advances step by step."""

from __future__ import annotations

from weakref import WeakKeyDictionary

from stitchmesh.yarnrelax.relaxation_loop import RelaxationLoop
from stitchmesh.yarnrelax.simulation import YarnSimulation

_loops: WeakKeyDictionary[YarnSimulation, RelaxationLoop] = WeakKeyDictionary()


def loop_of(simulation: YarnSimulation) -> RelaxationLoop:
    """The relaxation loop of a simulation; every call returns the same object."""
    if simulation not in _loops:
        _loops[simulation] = RelaxationLoop(simulation, tolerance=0.0)
    return _loops[simulation]


def iterate(simulation: YarnSimulation, count: int) -> None:
    """Run ``count`` iterations as in a relaxation, with new candidate lists where the old ones are no longer valid."""
    loop_of(simulation).iterate(count)
