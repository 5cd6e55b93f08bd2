# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Relaxation loops for simulations that a test advances step by step, and assessments of yarns where they lie."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from weakref import WeakKeyDictionary

from stitchmesh.compute.device import device_named
from stitchmesh.quality import PRESETS
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial
from stitchmesh.yarnrelax.assessment import Assessment
from stitchmesh.yarnrelax.energies.term import ConstraintChoice
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


def assessed(
    yarns: YarnSet, material: YarnMaterial, precision: str = "float64", constraints: Sequence[ConstraintChoice] = ()
) -> Assessment:
    """The assessment of yarns before the first iteration."""
    quality = replace(PRESETS["draft"], precision=precision)
    return YarnSimulation.start(yarns, material, quality, device_named("cpu"), (), constraints).assess_cells()[0]
