# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A relaxation of one swatch that goes on burst by burst, and can be looked at and left between two of them."""

from __future__ import annotations

from stitchmesh.compute.device import device_named
from stitchmesh.quality import Quality
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial
from stitchmesh.yarnrelax.convergence import Assessment
from stitchmesh.yarnrelax.relaxation_loop import ASSESSMENT_INTERVAL, RelaxationLoop
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
        self.quality = quality
        self.simulation = YarnSimulation.start(yarns, material, quality, device_named(device), cell=cell)
        self.descent = RelaxationLoop.start(self.simulation, quality.tolerance)
        self.iterations = 0

    def advance(self) -> None:
        """One burst.

        Raises:
            SolverError: the relaxation cannot go on.
        """
        self.descent.advance()
        self.iterations += ASSESSMENT_INTERVAL

    @property
    def last(self) -> Assessment:
        """What is known of the last good state."""
        return self.descent.last[0]

    @property
    def at_rest(self) -> bool:
        """Whether the yarns are."""
        return bool(self.descent.at_rest[0])

    @property
    def used_up(self) -> bool:
        """Whether it has gone on for as long as it may."""
        return self.iterations >= self.quality.max_iterations

    @property
    def yarns(self) -> YarnSet:
        """The yarns in the last good state."""
        return self.simulation.good_yarns()
