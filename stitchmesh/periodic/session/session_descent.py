# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A relaxation of one swatch that proceeds by assessment intervals, and can be examined or left between two of them."""

from __future__ import annotations

from stitchmesh.compute.device import device_named
from stitchmesh.quality import Quality
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial
from stitchmesh.yarnrelax.convergence import Assessment
from stitchmesh.yarnrelax.relaxation_loop import RelaxationLoop
from stitchmesh.yarnrelax.simulation import YarnSimulation


class SwatchDescent:
    """The yarns of a swatch on their way to rest."""

    def __init__(
        self, yarns: YarnSet, material: YarnMaterial, quality: Quality, device: str | None, cell: RelaxCell | None
    ) -> None:
        """Send yarns to the device.

        Raises:
            SolverError: their energy is not finite.
        """
        self.max_iterations = quality.max_iterations
        self.loop = RelaxationLoop(
            YarnSimulation.start(yarns, material, quality, device_named(device), cell=cell), quality.tolerance
        )
        self.loop.start()

    def advance(self) -> None:
        """Iterate for one assessment interval.

        Raises:
            SolverError: the relaxation cannot go on.
        """
        self.loop.advance()

    @property
    def iterations(self) -> int:
        """Iterations done."""
        return self.loop.iteration

    @property
    def last(self) -> Assessment:
        """Assessment of the last accepted state."""
        return self.loop.last[0]

    @property
    def at_rest(self) -> bool:
        """Whether the yarns are at rest."""
        return bool(self.loop.at_rest[0])

    @property
    def used_up(self) -> bool:
        """Whether the iterations of the quality are used up."""
        return self.loop.iteration >= self.max_iterations

    @property
    def yarns(self) -> YarnSet:
        """The yarns in the last accepted state."""
        return self.loop.simulation.good_yarns()
