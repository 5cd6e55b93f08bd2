# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The place of a relaxation on the path of loads (``loading``), and which step comes next.

The whole load is tried first. Yarns that start too close to each other are tried again with twice as many contact
samples, because samples that are far apart give only a weak bound on the distance of two yarns. If the load is still
too large, it is applied in steps. The step to share 0 begins where the yarns are. If they are too close to each other
even there, it begins with thinner yarn. Each later step starts where the step before it ended, and has at most
``STEP_ITERATIONS``. A refused step is halved. If steps below ``SMALLEST_STEP`` are refused, the contact samples are
doubled, up to ``MOST_FINER`` times as many.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from stitchmesh.mesh import FloatArray
from stitchmesh.quality import Quality
from stitchmesh.yarn import YarnSet

STEP_ITERATIONS = 300
"""Largest number of iterations of a step before the whole load acts."""
TRIAL_ITERATIONS, THICK_ITERATIONS = 2000, 10_000
"""Iterations of thin yarn under the whole load before it is relaxed from thicker yarn; and iterations of that yarn."""
LARGEST_STEP, SMALLEST_STEP = 0.25, 1.0 / 128.0
"""Largest and smallest share of the load that is added in one step; the first step is the largest."""
MOST_FINER = 8
"""Largest factor of the contact samples."""
THIN, THINNEST = 0.6, 0.1
"""Factors of the radius of yarns that start too close to each other. The first is ``THIN``, and each next one is the
square of the one before it, down to ``THINNEST``."""


@dataclass(frozen=True, eq=False)
class LoadPosition:
    """A place on the path of loads: the step that is tried, and where it starts."""

    share: float = 1.0
    """Share of the load of the present step."""
    reached: float | None = None
    """Largest share that the yarns took; None before they took one."""
    thin: float = 1.0
    """Factor of the radius at share 0."""
    finer: int = 1
    """Factor of the contact samples."""
    steps: int = 0
    """Number of steps that the yarns took."""
    refusals: int = 0
    """Number of steps that were refused."""
    reason: str = ""
    """Why the first refused step was refused; empty before."""
    iterations: int = 0
    """Iterations before this step."""
    points: FloatArray | None = None
    """Control points at the share that was reached [cm], shape (N, 3)."""
    periods: FloatArray | None = None
    """Periods of a relaxing cell at the share that was reached [cm], shape (2, 3)."""

    @property
    def is_whole(self) -> bool:
        """Whether the whole load is tried."""
        return self.share == 1.0

    @property
    def is_first(self) -> bool:
        """Whether no step came before this one."""
        return self.is_whole and not self.reason

    @property
    def most_iterations(self) -> int:
        """Largest number of iterations of this step, if the whole load does not act yet."""
        return THICK_ITERATIONS if self.thin > 1.0 and self.share == 0.0 else STEP_ITERATIONS

    def after_step(self, yarns: YarnSet, iterations: int) -> LoadPosition:
        """Return the next step after one that ended with ``yarns``, and with ``iterations`` since the start."""
        step = LARGEST_STEP
        if self.share != 0.0 and self.reached is not None:
            step = min(1.5 * (self.share - self.reached), LARGEST_STEP)
        periods = None if yarns.lattice is None else yarns.lattice.periods
        share = min(self.share + step, 1.0)
        return replace(
            self, share=share, reached=self.share, steps=self.steps + 1, iterations=iterations, points=yarns.points,
            periods=periods,
        )  # fmt: skip

    def after_refusal(self, reason: str, iterations: int, *, began: bool) -> LoadPosition | None:
        """Return the next step after a refusal; None if nothing is left to try.

        Args:
            reason: why the step was refused.
            iterations: iterations since the start of the relaxation.
            began: whether the step began, so that the yarns were far enough from each other at its start.
        """
        at = replace(self, refusals=self.refusals + 1, iterations=iterations, reason=self.reason or reason)
        if self.reached is None:
            if self.is_whole:
                return replace(at, finer=2) if self.finer == 1 and not began else replace(at, share=0.0)
            return at._with_another_radius()
        step = (self.share - self.reached) / 2.0
        if step >= SMALLEST_STEP:
            return replace(at, share=self.reached + step)
        if 2 * self.finer > MOST_FINER:
            return replace(AT_ONCE, reason=at.reason, iterations=iterations) if self.thin > 1.0 else None
        return replace(at, finer=2 * self.finer, share=min(self.reached + 8.0 * step, 1.0))

    def _with_another_radius(self) -> LoadPosition | None:
        """Return another start at share 0: less thick, or thinner."""
        if self.thin > 2.0:  # below this factor of the radius thicker yarn does not help
            return replace(self, thin=self.thin**0.5)
        if self.thin > 1.0:
            return replace(self, thin=1.0, share=1.0)
        thin = THIN if self.thin == 1.0 else self.thin**2
        return None if thin < THINNEST else replace(self, thin=thin)

    @property
    def why(self) -> str:
        """Why the first step was refused, without the advice."""
        return self.reason.split(";")[0]

    def report(self, quality: Quality) -> dict[str, Any] | None:
        """Return the entry of the report of a relaxation; None if the whole load was applied at once."""
        if self.is_first:
            return None
        return {
            "share": self.share, "steps": self.steps, "refused": self.refusals, "first_radius": self.thin,
            "contact_samples": self.finer * quality.contact_samples, "reason": self.why,
        }  # fmt: skip


AT_ONCE = LoadPosition()
"""The whole load, before the first step."""
