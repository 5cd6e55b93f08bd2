# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The result of a relaxation: the yarns, the report, and messages about yarns that are not at rest."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import warp as wp

from stitchmesh.io.history import HistoryEntry
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.assessment import MORE_ITERATIONS
from stitchmesh.yarnrelax.convergence import LARGEST_ENERGY_FALL, hidden_by_rounding, rest_text
from stitchmesh.yarnrelax.loading import Loading
from stitchmesh.yarnrelax.relaxation_loop import RelaxationLoop


@dataclass(frozen=True)
class Relaxation:
    """Relaxed yarns, with a report and a history of the relaxation."""

    yarns: YarnSet
    """The yarns at rest, or in their last accepted state."""
    report: dict[str, Any]
    """seconds, iterations, converged, stopped (by the user), out_of_time (a limit on the time ended it), residual,
    hidden_by_rounding (the precision does not suffice to say whether the yarns are at rest, or to bring them there),
    remaining_change (estimate of the remaining change: spacing and energy, both relative, and rms_radii; None if it is
    not known), energy [erg], energies [erg], max_strain, min_distance_over_radius (2 if no yarns touch), pull_throughs,
    certificate, load_steps (None if the whole load was applied at once; else the share of the load that acts, the
    numbers of steps that were taken and refused, the factor of the radius at their start, the contact_samples of a
    segment, and the reason), solver, device."""
    history: list[HistoryEntry]
    """The figures of each assessment."""

    def __repr__(self) -> str:
        """Return one line: whether the yarns are at rest, and the yarns."""
        return f"Relaxation({rest_text(self.report)}, {self.yarns})"


def continued(relaxed: Relaxation, before: Relaxation) -> Relaxation:
    """Return a relaxation with the iterations, seconds and history of the one before it."""
    count, seconds = before.report["iterations"], before.report["seconds"]
    report = {"iterations": count + relaxed.report["iterations"], "seconds": seconds + relaxed.report["seconds"]}
    report["load_steps"] = relaxed.report["load_steps"] or before.report["load_steps"]
    history = list(before.history)
    for entry in relaxed.history:
        later = entry.copy()
        later["iteration"] += count
        later["seconds"] += seconds
        history.append(later)
    return Relaxation(relaxed.yarns, relaxed.report | report, history)


def relaxation_report(
    loading: Loading, relaxed: YarnSet, seconds: float, *, stopped: bool, out_of_time: bool
) -> dict[str, Any]:
    """Return the report of a relaxation (``Relaxation.report``)."""
    loop = loading.loop
    left = loop.remaining[0]
    return {
        "seconds": seconds,
        "iterations": loop.iteration,
        "converged": loading.at_rest,
        "stopped": stopped,
        "out_of_time": out_of_time,
        "residual": loop.last[0].residual,
        "hidden_by_rounding": bool(hidden_by_rounding(loop.last, loop.at_rest, loop.stalled, loop.tolerance)[0]),
        "remaining_change": None if left is None else asdict(left),
        "energy": loop.last[0].energy,
        "energies": loop.last[0].energies,
        "max_strain": float(np.abs(relaxed.strain).max()),
        "min_distance_over_radius": float(loop.simulation.smallest_distances()[0]),
        "pull_throughs": 0,
        "certificate": "unchanged",
        "load_steps": loading.position.report(loading.quality),
        "solver": loading.quality.solver,
        "device": str(loop.simulation.model.device),
    }


def unrest_text(loading: Loading, *, out_of_time: bool = False) -> str:
    """Say how far the yarns are from rest, what was expected, and what would help."""
    loop = loading.loop
    last, remedy = loop.last[0], loop.last[0].remedy(loop.tolerance)
    if out_of_time:
        remedy = "the time is over: allow more"
    elif loop.stalled[0] and remedy == MORE_ITERATIONS:
        single = loop.simulation.model.scalar is wp.float32
        remedy = f"no step lowers the energy; {'take quality reference (float64)' if single else 'accept this state'}"
    found = f"residual {last.residual:.2g} (expected {loop.tolerance:g})"
    if not loading.position.is_whole:
        found += f" under {loading.position.share:.2g} of the load"
    return f"{found}, {_change_text(loop)} after {loop.iteration} iterations; {remedy}"


def _change_text(loop: RelaxationLoop) -> str:
    """Say what is known of the remaining change, and what was expected."""
    left, fall = loop.remaining[0], float(loop.energy_fall[0])
    if left is not None:
        return f"spacing to change by about {left.spacing:.2g} of itself (expected {loop.largest_change:g})"
    if loop.newton is not None or loop.settling is not None:
        return f"spacing to change by an amount that is not known yet (expected {loop.largest_change:g} of itself)"
    falling = f"falling by {fall:.2g} of itself" if np.isfinite(fall) else "not level"
    return f"energy {falling} (expected {LARGEST_ENERGY_FALL * loop.tolerance:g})"
