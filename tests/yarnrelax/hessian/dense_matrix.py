# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Hessians and forces of small scenes as arrays of NumPy, in double precision."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stitchmesh.compute.captured import CapturedLaunches
from stitchmesh.compute.device import device_named
from stitchmesh.quality import PRESETS
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial
from stitchmesh.yarnrelax.collision.budget import STRAIN_UNIT
from stitchmesh.yarnrelax.energies.term import TermChoice
from stitchmesh.yarnrelax.hessian.hessian_product import Hessian
from stitchmesh.yarnrelax.simulation import YarnSimulation

DOUBLE = replace(PRESETS["draft"], precision="float64")


def started(
    yarns: YarnSet, material: YarnMaterial, terms: Sequence[TermChoice] = (), cell: RelaxCell | None = None
) -> YarnSimulation:
    """A simulation in double precision before its first iteration."""
    return YarnSimulation.start(yarns, material, DOUBLE, device_named("cpu"), terms, cell=cell)


def forces_at(simulation: YarnSimulation, points: np.ndarray) -> np.ndarray:
    """Forces with the control points at ``points`` [units], shape (N, 3) [erg / unit]."""
    state, count = simulation.state, simulation.model.point_count
    state.points.assign(np.concatenate([points, state.points.numpy()[count:]]))
    CapturedLaunches(simulation.balance_launches(), simulation.model.device).launch()
    return np.array(state.force.numpy()[:count])


def points_of(simulation: YarnSimulation) -> np.ndarray:
    """The control points [units], shape (N, 3)."""
    return np.array(simulation.state.points.numpy()[: simulation.model.point_count])


class Products:
    """Products with the Hessian of the current state."""

    def __init__(self, simulation: YarnSimulation, exact: float) -> None:
        """Find the matrices with a share ``exact`` of the exact Hessian."""
        model = simulation.model
        forces_at(simulation, points_of(simulation))  # places the contact samples
        hessian = Hessian(model, simulation.state, simulation.candidates, simulation.strain, simulation.terms)
        hessian.exact.fill_(exact)
        hessian.find_launches(model.launch)
        self.simulation, self.hessian = simulation, hessian
        self.entries = model.point_count + (0 if simulation.strain is None else model.cell_count)

    def of(self, motion: np.ndarray) -> np.ndarray:
        """The product with a motion, both of shape (E, 3); strains are in their own unit and not in ``STRAIN_UNIT``."""
        model = self.simulation.model
        unit = np.ones((self.entries, 1))
        unit[model.point_count :] = float(STRAIN_UNIT)
        given, product = model.empty(self.entries, 3), model.empty(self.entries, 3)
        given.assign(motion * unit)
        self.hessian.product_launches(given, product, model.launch)
        return np.array(product.numpy() * unit)

    def matrix(self) -> np.ndarray:
        """The whole matrix, shape (3 E, 3 E)."""
        units = np.eye(3 * self.entries).reshape(-1, self.entries, 3)
        return np.stack([self.of(unit).ravel() for unit in units], axis=1)
