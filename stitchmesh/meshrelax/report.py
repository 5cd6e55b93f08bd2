# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Figures of a mesh relaxation."""

from __future__ import annotations

from dataclasses import dataclass


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
