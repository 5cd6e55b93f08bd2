# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The report of a run of the mixed system, as plain numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.enrichment.region import HYBRID, TRIANGLES, YARNS, Region
from stitchmesh.mixed.layout.spline_yarns import LaidYarns


@dataclass
class RunTotals:
    """The sums over the steps of a run."""

    steps: int = 0
    """Steps in time, or equilibria."""
    newton_iterations: int = 0
    """Newton iterations."""
    solve_iterations: int = 0
    """Iterations of conjugate gradients: products with the matrix."""
    halvings: int = 0
    """Attempts that were repeated with half the time step."""
    seconds: float = 0.0
    """Time of all steps [s]."""
    not_converged: int = 0
    """Steps whose error is above the tolerance."""
    error: float = field(default=0.0)
    """Error of the last step [cm/s or dyn]."""


def region_counts(cloth: Cloth, yarns: LaidYarns, region: Region) -> dict[str, int]:
    """Return the sizes of a mixed system, as table 1 of Casafranca et al. 2020 lists them."""
    corners = [np.unique(region.triangles[region.triangle_kind == kind]) for kind in (TRIANGLES, HYBRID)]
    hybrid = len(corners[1])
    return {
        "yarns": yarns.yarn_count,
        "yarn_nodes": yarns.node_count,
        "yarn_nodes_full": int((region.node_kind == YARNS).sum()),
        "yarn_nodes_hybrid": int((region.node_kind == HYBRID).sum()),
        "triangles": len(cloth.triangles),
        "vertices": len(cloth.vertices),
        "vertices_triangle_only": len(np.setdiff1d(corners[0], corners[1])),
        "vertices_hybrid": hybrid,
    }


def mixed_report(totals: RunTotals, counts: Mapping[str, int], **more: Any) -> dict[str, Any]:
    """Return the entry ``mixed`` of a report.

    Args:
        totals: sums over all steps.
        counts: sizes of the system.
        more: other entries, such as energies.
    """
    steps = max(totals.steps, 1)
    return {
        "seconds_per_step": totals.seconds / steps,
        "steps": totals.steps,
        **work_of(totals),
        "solve_iterations_per_step": totals.solve_iterations / steps,
        "halvings": totals.halvings,
        **counts,
        **more,
    }


def work_of(totals: RunTotals) -> dict[str, float]:
    """Return the time and the iterations of a run."""
    return {
        "seconds": round(totals.seconds, 3),
        "newton_iterations": totals.newton_iterations,
        "solve_iterations": totals.solve_iterations,
    }
