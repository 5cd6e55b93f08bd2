# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Small scenes out of balance, their Hessians and their forces as arrays of NumPy, in double precision."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.sparse import csc_array

from stitchmesh.compute.captured import CapturedLaunches
from stitchmesh.compute.device import device_named
from stitchmesh.quality import PRESETS
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial
from stitchmesh.yarnrelax.assembled_hessian import HessianAssembly
from stitchmesh.yarnrelax.energies.term import YarnChoice
from stitchmesh.yarnrelax.simulation import YarnSimulation
from tests.yarnrelax.solvers.test_cell_strain import sheared
from tests.yarnrelax.stockinette import flat_patch, periodic_patch, shaken, tube, woven_cell

DOUBLE = replace(PRESETS["draft"], precision="float64")
KALDOR, LEAF = YarnMaterial.named("kaldor-simulation"), YarnMaterial.named("leaf")
FREE = RelaxCell()
Scene = tuple[YarnSet, YarnMaterial]


def assembled_hessian(simulation: YarnSimulation) -> csc_array:
    """The exact Hessian of the current state [erg / unit^2]."""
    return HessianAssembly(simulation).matrix()


def curved(yarns: YarnSet, curvature: float) -> YarnSet:
    """The yarns with a natural curvature."""
    return replace(yarns, natural_curvature=np.full(len(yarns.points), curvature))


def of_unequal_radii(yarns: YarnSet) -> YarnSet:
    """The yarns with radii that differ."""
    return replace(yarns, radius=yarns.radius * np.linspace(0.9, 1.2, len(yarns.radius)))


SCENES: dict[str, Scene] = {
    "closed piece": (shaken(tube(2, 4)), LEAF),
    "compressed open piece": (shaken(flat_patch(2, 2), 1.1), KALDOR),
    "sheared cell": (shaken(sheared(periodic_patch(1, 1), 0.1)), KALDOR),
    "woven of unequal radii": (shaken(of_unequal_radii(sheared(woven_cell(), 0.05))), LEAF),
    "little natural curvature": (shaken(curved(periodic_patch(1, 1), 0.5)), KALDOR),
    "large natural curvature": (shaken(curved(periodic_patch(1, 1), 30.0)), KALDOR),
    "length penalty alone": (shaken(periodic_patch(1, 1)), YarnMaterial(0.0, 1e4, 0.0, 0.0, 0.0, 0.0, 0.0, 0.006)),
}


def started(
    yarns: YarnSet, material: YarnMaterial, terms: Sequence[YarnChoice] = (), cell: RelaxCell | None = None
) -> YarnSimulation:
    """A simulation in double precision before its first iteration."""
    return YarnSimulation.start(yarns, material, DOUBLE, device_named("cpu"), terms, cell=cell)


def mixture(yarns: YarnSet, material: YarnMaterial, exact: float, cell: RelaxCell | None = None) -> np.ndarray:
    """The mixture with a share of the exact Hessian at the start of some yarns, shape (3 E, 3 E)."""
    simulation = started(yarns, material, cell=cell)
    shares = np.full(simulation.model.segment_count, exact)
    return np.array(HessianAssembly(simulation).matrix(shares).toarray())


def forces_at(simulation: YarnSimulation, points: np.ndarray) -> np.ndarray:
    """Forces with the control points at ``points`` [units], shape (N, 3) [erg / unit]."""
    state, count = simulation.state, simulation.model.point_count
    state.points.assign(np.concatenate([points, state.points.numpy()[count:]]))
    CapturedLaunches(simulation.balance_launches(), simulation.model.device).launch()
    return np.array(state.force.numpy()[:count])


def points_of(simulation: YarnSimulation) -> np.ndarray:
    """The control points [units], shape (N, 3)."""
    return np.array(simulation.state.points.numpy()[: simulation.model.point_count])


def derivative_of_forces(simulation: YarnSimulation, direction: np.ndarray, step: float = 1e-6) -> np.ndarray:
    """Minus the derivative of the forces along a motion of the control points, both of shape (N, 3)."""
    places = points_of(simulation)
    ends = [forces_at(simulation, places + side * step * direction) for side in (1.0, -1.0)]
    forces_at(simulation, places)
    return np.asarray((ends[1] - ends[0]) / (2 * step))


def assert_close(found: np.ndarray, expected: np.ndarray) -> None:
    """Compare with central differences: errors of third order in a step of 1e-6, and rounding over the step."""
    np.testing.assert_allclose(found, expected, atol=2e-7 * np.abs(expected).max())
