# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The figures of the report of a relaxation, each with its name, its value in words and its meaning."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from stitchmesh.reporting.verdict import LARGEST_STRAIN, SMALLEST_DISTANCE

JOULES_PER_ERG = 1e-7


@dataclass(frozen=True)
class Figure:
    """One figure of a report."""

    name: str
    """Name of the figure."""
    value: str
    """Its value, with its unit."""
    meaning: str
    """What the figure says, and which values are good; one sentence."""
    good: bool = True
    """Whether the value is a good one."""


def report_figures(report: Mapping[str, Any], *, tolerance: float) -> list[Figure]:
    """Return the figures of the report of a relaxation of yarns, in the order of their importance.

    Args:
        report: the report, as ``Relaxation.report``.
        tolerance: residual at which the relaxation has converged (``Quality.tolerance``).
    """
    residual, strain = report["residual"], report["max_strain"]
    distance = report["min_distance_over_radius"]
    return [
        Figure(
            "residual", f"{residual:.2g}",
            f"The force that is left, compared with the forces that balance. At rest it is below {tolerance:g}.",
            good=bool(report["converged"]),
        ),
        Figure(
            "largest strain", f"{100.0 * strain:.1f} %",
            "The largest change of length of a piece of yarn. "
            f"Above {100.0 * LARGEST_STRAIN:g} % some yarn is too long or too short for its place.",
            good=bool(strain <= LARGEST_STRAIN),
        ),
        Figure(
            "closest yarns", f"{distance:.2f} radii",
            "The smallest distance of two axes. "
            f"Yarns that touch are 2 radii apart; below {SMALLEST_DISTANCE:g} they are crowded.",
            good=bool(distance >= SMALLEST_DISTANCE),
        ),
        Figure(
            "pull-throughs", str(report["pull_throughs"]),
            "The number of places at which a yarn has passed through another one.",
            good=report["pull_throughs"] == 0,
        ),
        Figure("energy", joules(report["energy"]), f"The energy of the yarns: {shares(report['energies'])}."),
        Figure("iterations", f"{report['iterations']:,}", f"The solver {report['solver']} ran on {report['device']}."),
        Figure("time", duration(report["seconds"]), "The time of the relaxation without pauses."),
    ]  # fmt: skip


def shares(energies: Mapping[str, float]) -> str:
    """Return each energy as a percentage of their sum, the largest first.

    Args:
        energies: energies by the names of their terms [erg].
    """
    whole = sum(abs(energy) for energy in energies.values())
    if whole == 0.0:
        return "none"
    ordered = sorted(energies.items(), key=lambda item: -abs(item[1]))
    return ", ".join(f"{name} {100.0 * energy / whole:.0f} %" for name, energy in ordered)


def joules(energy: float) -> str:
    """Return an energy [erg] in the unit of joules that needs the fewest zeros."""
    size = abs(energy) * JOULES_PER_ERG
    for unit, factor in (("J", 1.0), ("mJ", 1e3), ("\N{MICRO SIGN}J", 1e6)):
        if size * factor >= 1.0 or unit == "\N{MICRO SIGN}J":
            return f"{energy * JOULES_PER_ERG * factor:.3g} {unit}"
    raise AssertionError


def duration(seconds: float) -> str:
    """Return a duration in seconds, or in minutes if it is long."""
    if seconds < 10.0:
        return f"{seconds:.1f} s"
    return f"{seconds:.0f} s" if seconds < 120.0 else f"{seconds / 60.0:.0f} min"
