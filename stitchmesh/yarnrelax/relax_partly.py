# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Relaxation of yarns for a few iterations, without a report."""

from __future__ import annotations

from collections.abc import Sequence

from stitchmesh.compute.device import alone, device_named
from stitchmesh.compute.shared_work import shared
from stitchmesh.quality import Quality
from stitchmesh.time_limit import without_limit
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.energies.term import TermChoice
from stitchmesh.yarnrelax.model.material import YarnMaterial
from stitchmesh.yarnrelax.relaxation_loop import RelaxationLoop
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.cell_strain import RelaxCell


@shared
@alone()
def relax_partly(
    yarns: YarnSet, *, material: YarnMaterial, quality: Quality, iterations: int, device: str | None = None,
    cell: RelaxCell | None = None, terms: Sequence[TermChoice] = (),
) -> YarnSet:  # fmt: skip
    """Relax yarns for some iterations only, for changes in small steps; the arguments are as in ``relax_yarns``.

    The solver does all iterations; Newton's method does not end this relaxation.

    Raises:
        SolverError: the relaxation cannot continue.
    """
    simulation = YarnSimulation.start(yarns, material, quality, device_named(device), terms, cell=cell)
    with without_limit():  # the next change of size needs all of these iterations
        RelaxationLoop(simulation, quality.tolerance, quality.largest_change, by_newton=False).run(iterations)
    return simulation.good_yarns()
