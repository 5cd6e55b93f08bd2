# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Verdicts on a result: whether it is good, and if not, what was found and what helps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

LARGEST_STRAIN = 0.05
"""Strain above which some yarn is too long or too short for its place."""
SMALLEST_DISTANCE = 1.5
"""Distance between the axes of two yarns, over the radius, below which yarns are crowded; 2 is touching."""

Kind = Literal[
    "too few stitches", "too many stitches", "too few rows", "too many rows",
    "uneven stitches", "stopped", "out of time", "hidden by rounding", "not at rest", "strained", "crowded", "not flat",
    "drawn in", "change not known", "moved on the way", "not validated", "unmeasured yarn", "assumed contact", "coarse",
]  # fmt: skip
"""What can be wrong with a fabric, and with relaxed yarns."""


@dataclass(frozen=True)
class Finding:
    """One thing that is not good about a result."""

    kind: Kind
    """What was found, as a key."""
    text: str
    """What was found, as a clause with its number."""
    remedy: str = ""
    """What helps, as a clause; empty if ``text`` says it."""

    def __str__(self) -> str:
        """Return what was found and what helps."""
        return f"{self.text}; {self.remedy}" if self.remedy else self.text


@dataclass(frozen=True)
class Verdict:
    """Whether a result is good, and why."""

    findings: tuple[Finding, ...]
    """What is not good; empty if everything is good."""
    praise: str
    """The figures of a good result, as a clause; they also hold if the result is not good."""

    @property
    def good(self) -> bool:
        """Whether nothing was found."""
        return not self.findings

    def __str__(self) -> str:
        """Return one line: ``Good: ...`` or ``Not good: ...``."""
        return f"Good: {self.praise}." if self.good else f"Not good: {'; '.join(map(str, self.findings))}."


def relaxation_verdict(report: Mapping[str, Any], *, mesh_converged: bool = True) -> Verdict:
    """Return the verdict on relaxed yarns.

    Args:
        report: report of the relaxation, as ``Relaxation.report``.
        mesh_converged: whether the mesh relaxation before it had converged.
    """
    strain, distance = report["max_strain"], report["min_distance_over_radius"]
    found = []
    if not mesh_converged:
        cause = "because the mesh relaxation did not converge"
        found.append(Finding("uneven stitches", f"the stitches are not even, {cause}"))
    found += _findings_of_rest(report)
    if strain > LARGEST_STRAIN:
        misfit = f"some yarn is strained by {_percent(strain)}, too long or too short for its place"
        found.append(Finding("strained", misfit))
    if distance < SMALLEST_DISTANCE:
        crowded = f"yarns are crowded, their axes {distance:.2f} radii apart (2 is touching)"
        found.append(Finding("crowded", crowded, "use a thinner yarn"))
    if report.get("shape", "flat") != "flat":
        thick = f"the fabric is {report['shape']}, {report['thickness_ratio']:.2g} times as thick as its stitches need"
        found.append(Finding("not flat", f"{thick}{_by_floats(report)}", "let it lie on a table, or block it"))
    # Plain stitches are 0.77 times as high as they are wide, and those of the library's charts of two yarns in a row at
    # most 1.1 times. Narrower stitches hide the colours of their neighbours.
    elif report.get("yarns_in_row", 1) > 1 and report["course_spacing"] > 1.25 * report["wale_spacing"]:
        narrow = f"the stitches are {report['wale_spacing']:.2g} cm wide and {report['course_spacing']:.2g} cm high"
        hidden = f"{narrow}{_by_floats(report)}, and stitches of one colour hide those of another"
        found.append(Finding("drawn in", hidden, "hold its width, or take a chart of fewer yarns in a row"))
    touching = f"axes at least {distance:.2f} radii apart (2 is touching); none passed through another"
    praise = f"the yarns are at rest, strained by at most {_percent(strain)}, {touching}"
    return Verdict(tuple(found), praise)


def _by_floats(report: Mapping[str, Any]) -> str:
    """Return a clause with the cause of a fabric that is drawn together, where its rows have floats."""
    yarns = report.get("yarns_in_row", 1)
    return f": the floats of up to {yarns} yarns in a row draw it together" if yarns > 1 else ""


def _findings_of_rest(report: Mapping[str, Any]) -> list[Finding]:
    """Return the finding that the yarns are not at rest, or that nobody can say so, if there is one."""
    if report["converged"]:
        known = report.get("remaining_change", "not told") is not None or report.get("residual") == 0.0
        text = "the forces balance, but how far the spacing of the stitches still changes is not known"
        if not known:
            return [Finding("change not known", text, "see whether more iterations change the size")]
        return _findings_of_path(report)
    after = f"after {report['iterations']:,} iterations"
    if report.get("stopped", False):
        return [Finding("stopped", f"the relaxation was stopped {after}, before the yarns were at rest", "continue it")]
    if report.get("out_of_time", False):
        text = f"the time was over {after}, before the yarns were at rest{_left(report)}"
        return [Finding("out of time", text, "allow more time")]
    if report.get("hidden_by_rounding", False):
        text = f"rounding hides whether the yarns are at rest {after}"
        return [Finding("hidden by rounding", text, "take quality reference (float64), or smaller stiffnesses")]
    return [Finding("not at rest", f"the yarns are not at rest {after}", "allow more iterations")]


def _findings_of_path(report: Mapping[str, Any]) -> list[Finding]:
    """Return the finding that states on the way off the needles were not at rest, if there is one."""
    moving = report.get("steps_not_at_rest", 0)
    if not moving:
        return []
    text = f"the yarns are at rest, but in {moving} of the {report['steps']} steps before they were not"
    return [Finding("moved on the way", text, "see how far other starts change the size")]


def _left(report: Mapping[str, Any]) -> str:
    """Return a clause with the change of the spacing that is left, if it is known."""
    left = report.get("remaining_change")
    return "" if left is None else f" (their spacing will change by about {_percent(left['spacing'])})"


def _percent(part: float) -> str:
    return f"{100.0 * part:.1f} %"
