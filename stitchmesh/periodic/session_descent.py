# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A relaxation that goes on burst by burst, and can be looked at and left between two of them."""

from __future__ import annotations

import numpy as np

from stitchmesh.device import device_named
from stitchmesh.errors import SolverError
from stitchmesh.quality import Quality
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial
from stitchmesh.yarnrelax.convergence import Assessment, has_converged
from stitchmesh.yarnrelax.iteration import PART_THEM, Iteration
from stitchmesh.yarnrelax.solver import CHECK


class Descent:
    """Yarns on their way to rest, judged after each burst as ``relax_yarns`` does."""

    def __init__(
        self, yarns: YarnSet, material: YarnMaterial, quality: Quality, device: str | None, cell: RelaxCell | None
    ) -> None:
        """Send yarns to the device.

        Raises:
            SolverError: their energy is not finite.
        """
        self.quality = quality
        self.solver = Iteration.start(yarns, material, quality, device_named(device), cell=cell)
        self.last = self.solver.assess()
        if not self.last.finite:
            raise SolverError(f"{self.solver.blame()}: not finite at the start; {PART_THEM}")
        self.iterations = 0
        self.fall = np.inf
        self.moving = 0.0

    def advance(self) -> None:
        """One burst; back to the state before where the energy is not finite or rose too far.

        Raises:
            SolverError: the relaxation cannot go on.
        """
        solver, before = self.solver, self.last
        solver.run(CHECK)
        self.iterations += CHECK
        now, moving = solver.assess(), solver.method.kinetic_energy()
        allowed = solver.method.allowed_rise * (_size(before) + self.moving) + float(solver.noise[0])
        if now.finite and now.energy + moving <= before.energy + self.moving + allowed:
            solver.keep()
            self.last, self.moving = now, moving
            self.fall = (before.energy - now.energy) / _size(now) if _size(now) > 0.0 else 0.0
        else:
            solver.back_off()
            self.moving, self.fall = 0.0, np.inf

    @property
    def at_rest(self) -> bool:
        """Whether both conditions of ``convergence`` hold."""
        return has_converged(self.last.residual, self.fall, self.quality.tolerance)

    @property
    def used_up(self) -> bool:
        """Whether it has gone on for as long as it may."""
        return self.iterations >= self.quality.max_iterations

    @property
    def yarns(self) -> YarnSet:
        """The yarns in the last good state."""
        return self.solver.good_yarns()


def _size(assessment: Assessment) -> float:
    """Sum of the sizes of the energies [erg]."""
    return sum(abs(energy) for energy in assessment.energies.values())
