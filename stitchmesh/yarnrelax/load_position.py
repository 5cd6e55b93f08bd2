# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The place of a relaxation on the path of loads (``load_path``), and which step comes next.

The whole load is tried first. Yarns that start too close to each other are tried again with twice as many contact
samples, because samples that are far apart leave a wide bound on the distance of two yarns. If the load is still too
large, it is applied in steps. The step to share 0 begins where the yarns are; if they are too close to each other even
there, it begins with thinner yarn. Each later step starts where the step before it ended, and is relaxed for at most
``STEP_ITERATIONS``. A step that is refused is halved. Where steps below ``SMALLEST_STEP`` are refused, the contact
samples are doubled, up to ``MOST_FINER`` times as many.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from stitchmesh.mesh import FloatArray
from stitchmesh.quality import Quality
from stitchmesh.yarn import YarnSet

STEP_ITERATIONS = 300
"""Iterations of a step before the whole load acts."""
FIRST_STEP, LARGEST_STEP, SMALLEST_STEP = 0.25, 0.25, 1.0 / 128.0
"""First, largest and smallest share of the load that is added in one step."""
LONGER_STEP = 1.5
"""Factor from one step to the next."""
MOST_FINER = 8
"""Largest factor of the contact samples."""
THIN, THINNEST = 0.6, 0.1
"""Factors of the radius of yarns that start too close to each other: ``THIN``, its square, the square of that, and so
on, down to ``THINNEST``."""


@dataclass(frozen=True, eq=False)
class LoadPosition:
    """A place on the path of loads: the step that is tried, and where it starts."""

    share: float = 1.0
    """Share of the load that is tried."""
    reached: float | None = None
    """Largest share that the yarns took; None before the first one."""
    thin: float = 1.0
    """Factor of the radius at share 0."""
    finer: int = 1
    """Factor of the contact samples."""
    steps: int = 0
    """Steps that were taken."""
    refusals: int = 0
    """Steps that were refused."""
    reason: str = ""
    """Why the first one was refused."""
    iterations: int = 0
    """Iterations before this step."""
    points: FloatArray | None = None
    """Control points at the share that was reached [cm], shape (N, 3)."""
    periods: FloatArray | None = None
    """Periods of a cell that relaxes at that share [cm], shape (2, 3)."""

    @property
    def is_whole(self) -> bool:
        """Whether the whole load is tried."""
        return self.share == 1.0

    def after_step(self, yarns: YarnSet, iterations: int) -> LoadPosition:
        """The next step after one that ended with these yarns, and with that many iterations since the start."""
        step = FIRST_STEP if self.reached is None else self.share - self.reached
        step = FIRST_STEP if self.share == 0.0 else min(LONGER_STEP * step, LARGEST_STEP)
        periods = None if yarns.lattice is None else yarns.lattice.periods
        share = min(self.share + step, 1.0)
        return replace(
            self, share=share, reached=self.share, steps=self.steps + 1, iterations=iterations, points=yarns.points,
            periods=periods,
        )  # fmt: skip

    def after_refusal(self, reason: str, iterations: int, *, began: bool) -> LoadPosition | None:
        """The next step after a refusal; None where nothing is left to be tried.

        Args:
            reason: why the step was refused.
            iterations: iterations since the start of the relaxation.
            began: whether the step began, so that the yarns were far enough from each other at its start.
        """
        at = replace(self, refusals=self.refusals + 1, iterations=iterations, reason=self.reason or reason)
        if self.reached is None:
            if self.is_whole:
                return replace(at, finer=2) if self.finer == 1 and not began else replace(at, share=0.0)
            thin = THIN if self.thin == 1.0 else self.thin**2
            return None if thin < THINNEST else replace(at, thin=thin)
        step = (self.share - self.reached) / 2.0
        if step >= SMALLEST_STEP:
            return replace(at, share=self.reached + step)
        if 2 * self.finer > MOST_FINER:
            return None
        return replace(at, finer=2 * self.finer, share=min(self.reached + 8.0 * step, 1.0))

    @property
    def why(self) -> str:
        """Why the first step was refused, without the advice."""
        return self.reason.split(";")[0]

    def report(self, quality: Quality) -> dict[str, Any] | None:
        """What the report of a relaxation says; None where the whole load was applied at once."""
        if self.refusals == 0:
            return None
        return {
            "share": self.share, "steps": self.steps, "refused": self.refusals, "first_radius": self.thin,
            "contact_samples": self.finer * quality.contact_samples, "reason": self.why,
        }  # fmt: skip


AT_ONCE = LoadPosition()
"""The whole load, before the first step."""
