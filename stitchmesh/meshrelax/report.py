# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Figures of a mesh relaxation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from stitchmesh.mesh import FloatArray
from stitchmesh.meshrelax.dynamics import Outcome


@dataclass(frozen=True)
class MeshRelaxReport:
    """Figures of a mesh relaxation."""

    seconds: float
    """Duration of the relaxation without pauses [s]."""
    iterations: int
    """Number of iterations."""
    converged: bool
    """Whether the residual is at most the tolerance."""
    residual: float
    """Root mean square of the net force in the directions in which the fabric may move, dimensionless."""
    tolerance: float
    """Residual at which a relaxation has converged."""
    remedy: str
    """What helps if the relaxation has not converged; empty if it has."""
    max_stretch: float
    """Largest stretch (length divided by rest length) of an edge."""
    rms_stretch: float
    """Root mean square of the stretch of the edges."""
    stopped: bool = False
    """Whether the user or a limit on the time stopped the relaxation before it had converged."""

    @classmethod
    def of(
        cls, outcome: Outcome[Any], stretch: FloatArray, *, tolerance: float, seconds: float, remedy: str
    ) -> MeshRelaxReport:
        """Return the figures of a relaxation.

        Args:
            outcome: how the relaxation ended.
            stretch: stretch of the edges for which it is known, shape (n,).
            tolerance: residual at which a relaxation has converged.
            seconds: duration without pauses [s].
            remedy: what helps if the relaxation has not converged.
        """
        converged = outcome.residual <= tolerance
        return cls(
            seconds=seconds,
            iterations=outcome.iterations,
            converged=converged,
            residual=outcome.residual,
            tolerance=tolerance,
            remedy="" if converged else remedy,
            max_stretch=float(stretch.max()),
            rms_stretch=float(np.sqrt(np.mean(stretch**2))),
            stopped=outcome.stopped and not converged,
        )
