# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A summary of the result of a command in a few lines: what it is, whether it is good, and which file to open.

The report of the command has all numbers; the option ``--json`` prints it instead of these lines.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from tyro.conf import arg

from stitchmesh.cli.say import say
from stitchmesh.mesh import StitchMesh, extent
from stitchmesh.reporting.verdict import Finding, Kind, relaxation_verdict
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.stitch_size import fabric_gauge
from stitchmesh.yarn.yarn_presets import Gauge, Yarn, yarn_for_gauge

if TYPE_CHECKING:
    from stitchmesh.periodic.explore import Exploration
    from stitchmesh.periodic.swatch import Swatch
    from stitchmesh.periodic.swatch_to import SizedSwatch
    from stitchmesh.recipe.finished import FinishedGarment

AsJson = Annotated[bool, arg(help="print the report as JSON instead of a summary", help_behavior_hint="")]
"""Option of a command that prints a summary."""
REMEDIES: Mapping[Kind, str] = {
    "hidden by rounding": "take --quality reference (float64), or smaller values of --stiffness",
    "not at rest": "raise --max-iterations",
    "drawn in": "hold its width (--period WIDTH free), or take a chart of fewer yarns in a row",
    "not flat": "use --relax-cell without --unsupported, or --blocked",
}
"""What helps on the command line, in place of the remedy of a finding."""


def print_result(report: Mapping[str, Any], lines: Sequence[str], *, as_json: bool) -> None:
    """Print the lines of a summary, or the report as JSON."""
    say(json.dumps(report, indent=2) if as_json else "\n".join(lines))


def knit_summary(fabric: StitchMesh, yarns: YarnSet, report: Mapping[str, Any], yarn: Yarn | None) -> list[str]:
    """Return the lines about a knitted garment: the stitches, gauge and yarn, and the state of the yarns.

    Args:
        fabric: the stitch mesh.
        yarns: the relaxed yarns.
        report: the report of all stages.
        yarn: the yarn that the user has named; None if no yarn was named.
    """
    gauge = fabric_gauge(fabric)
    return [
        f"Knitted {fabric.face_count:,} stitches in {int(fabric.row.max()) + 1:,} rows, {extent(yarns.points)}.",
        f"Gauge: {gauge}. Yarn: {_length(yarns)}{_weight(yarns, yarn, gauge)}.",
        state_of(report["yarnrelax"], mesh_converged=report["meshrelax"]["converged"]),
        *dressed_lines(report["yarnrelax"]),
        *_pattern_lines(report),
        *(f"Repair: {entry['text']}." for entry in report.get("repair", ())),
        *shape_lines(report),
    ]


def finished_lines(made: FinishedGarment) -> list[str]:
    """Return the lines about finished measures: what a garment has that nothing holds, and what is not possible."""
    measures = ", ".join(f"{name} {made.measures[name]:.4g} cm ({asked:g} asked)" for name, asked in made.asked.items())
    gauges = ", ".join(f"{name} {each.stitches:.3g} x {each.rows:.3g}" for name, each in made.gauges.items())
    return [
        f"Finished, when nothing holds it: {measures}; gauges at rest: {gauges} in 10 cm.",
        *(f"Not possible: {note}." for note in made.notes),
    ]


def shape_lines(report: Mapping[str, Any]) -> list[str]:
    """Return two lines on rows that were found: how well the stitches fit the surface; none for a labeled mesh."""
    if "shape" not in report:
        return []
    shape = report["shape"]
    return [
        f"Surface: stitches are off by {shape['rms_distance']:.2g} stitch widths (rms), at most "
        f"{shape['largest_distance']:.2g}; their stretch differs by {100 * shape['rms_stretch']:.2g} % (rms).",
        f"Shaping: {shape['irregular_per_thousand']:.3g} irregular stitches in a thousand, "
        f"{shape['mismatched_edges']} grafted edges, {shape['short_rows']} short rows.",
        *_panel_lines(shape),
    ]


def _panel_lines(shape: Mapping[str, Any]) -> list[str]:
    """Return one line on the panels of a sewing pattern: their seams and directions; none for other meshes."""
    if "panels" not in shape:
        return []
    return [
        f"Panels: {shape['panels']}, with {shape['grafted_edges']} grafted and {shape['joined_edges']} joined edges; "
        f"{shape['sewn_edges']} are left to be sewn. Rows are off their directions by {shape['mean_angle']:.2g} "
        "degrees (mean)."
    ]


def _pattern_lines(report: Mapping[str, Any]) -> list[str]:
    """Return one line for each reason why a pattern leaves out stitches."""
    laid = report.get("patterns", {}).get("laid", [])
    return [f"{entry['name']}, {line}" for entry in laid for line in entry["summary"]]


def swatch_summary(made: Swatch, name: str, yarn: Yarn | None) -> list[str]:
    """Return the lines about a swatch: the repeat, gauge and yarn, and the state of the yarns.

    Args:
        made: the relaxed swatch.
        name: name of the pattern.
        yarn: the yarn that the user has named; None if no yarn was named.
    """
    report, size = made.report, f"{made.report['width']:.3g} x {made.report['height']:.3g} cm"
    gauge = Gauge.of_stitch(report["wale_spacing"], report["course_spacing"])
    if made.fabric is None:
        repeat = f"{report['wales']} warps x {report['courses']} wefts"
        spacing = f"{gauge.stitches:.3g} warps and {gauge.rows:.3g} wefts in 10 cm"
    else:
        repeat = f"{report['wales']} stitches x {report['courses']} rows"
        spacing = f"Gauge: {gauge}"
    weight = "" if made.fabric is None and yarn is None else _weight(made.yarns, yarn, gauge)
    return [
        f"Relaxed one repeat of {name}: {repeat}, {size}.",
        f"{spacing}. Yarn: {_length(made.yarns)}{weight}.",
        _physics(report),
        *spirality_lines(report),
        *_spread_lines(report),
        state_of(report),
        *range_lines(report),
    ]


def range_lines(report: Mapping[str, Any]) -> list[str]:
    """Return one line on what lies where no measurement was compared; none if nothing does."""
    found = tuple(Finding(**entry) for entry in report.get("ranges", ()))
    if not found:
        return []
    from stitchmesh.periodic.validated_range import RangeVerdict

    return [str(RangeVerdict(found, ""))]


def spirality_lines(report: Mapping[str, Any]) -> list[str]:
    """Return one line on the lean of the wales, if the yarn has a torque or the wales lean."""
    angle, torque = report.get("spirality", 0.0), report.get("torque")
    if torque is None and abs(angle) < 0.05:
        return []
    side = "right" if angle > 0.0 else "left"
    how = "stand upright" if abs(angle) < 0.05 else f"lean {abs(angle):.1f} degrees to the {side}"
    twisted = "" if torque is None else (
        f" under a torque of {1e2 * abs(torque):.3g} nN m ({'Z' if torque > 0.0 else 'S'} twist), "
        f"{100.0 * report['snarling']:.2g} % of what makes free loops snarl"
    )  # fmt: skip
    return [f"Spirality: the wales {how}{twisted}."]


def sized_lines(made: SizedSwatch) -> list[str]:
    """Return the lines about a size that came true: the piece, what gives it, and what is not possible."""
    asked = ", ".join(f"{name} {value:g}" for name, value in made.asked.items())
    piece = []
    if {"width", "height"} & set(made.asked):
        width, height = made.size
        piece = [f"Piece: {made.stitches:,} stitches x {made.rows:,} rows, {width:.4g} x {height:.4g} cm."]
    yarn = f"loops of {10 * made.loop_length:.4g} mm, needle about {made.needle:.2g} mm"
    return [
        f"Asked for {asked}: {yarn}, yarn radius {10 * made.yarn_radius:.3g} mm, after {made.relaxations} swatches.",
        *piece,
        *(f"Not possible: {note}." for note in made.notes),
    ]


def _spread_lines(report: Mapping[str, Any]) -> list[str]:
    """Return one line on the sizes of shaken starts; none where there are no such starts."""
    if "shaken" not in report:
        return []
    resting = f"{report['shaken_at_rest']} of {report['shaken']} shaken starts are at rest"
    if report["size_spread"] is None:
        return [f"Spread: unknown; {resting}."]
    width, height = (f"{100 * each:.2g} %" for each in report["size_spread"])
    return [f"Spread: widths differ by {width}, heights by {height}; {resting}."]


def _physics(report: Mapping[str, Any]) -> str:
    """Return the line that says which friction a swatch relaxed with, and what presses on it."""
    path = "Relaxed without friction between its yarns"
    if report["relaxation"] != "frictionless":
        path = f"Let go off the needles ({report['relaxation']}) with a friction of {report['friction']:g}"
    if report["planes_pressure"] is None:
        return f"{path}."
    from stitchmesh.simulation.dead_load import EARTH

    weights = report["planes_pressure"] / (report["areal_density"] * -EARTH[1])
    lies = f"between planes {report['planes_distance']:.2g} cm apart that press with {weights:.2g} of its weight"
    return f"{path}, {lies}."


def exploration_summary(found: Exploration, folder: Path, *, drawn: bool) -> list[str]:
    """Return the table of the states as lines of text, and the files to open."""
    head = "state  starts  erg/stitch    wales x courses [cm]  thickness [cm]  shape     posture   lean"
    lines = [head] if found.rests else []
    for number, row in enumerate(found.table(), 1):
        size = f"{row['wale_spacing']:10.3f} x {row['course_spacing']:.3f}"
        own = "  (the state of a swatch)" if row["usual"] else ""
        lines.append(
            f"{number:5d}  {row['count']:6d}  {row['energy_per_stitch']:10.2f}  {size:>24}  {row['thickness']:14.2f}  "
            f"{row['shape']:8}  {row['posture']:8}  {row['lean']:+.2f}{own}"
        )
    states = "1 state" if len(found.rests) == 1 else f"{len(found.rests)} states"
    resting = f"Found {states} of rest from {found.starts} starts"
    missing = f"; {found.not_at_rest} did not come to rest (raise --max-iterations)" if found.not_at_rest else ""
    picture = f"Open {folder / 'rests.png'}" if drawn else "No picture was drawn"
    if lines:
        width, height = (100.0 * part for part in found.spread)
        lines.append(f"The starts differ by {width:.2g} % in width and {height:.2g} % in height.")
    return [*lines, f"{resting}{missing}.", f"{picture}; {folder / 'rests.json'} holds all numbers."]


def relax_summary(yarns: YarnSet, report: Mapping[str, Any]) -> list[str]:
    """Return the lines about relaxed yarns: the yarns, and their state."""
    count = f"{yarns.yarn_count:,} yarn{'s' if yarns.yarn_count > 1 else ''}"
    line = f"Relaxed {count}, {_length(yarns)}, {extent(yarns.points)}."
    made_of = yarns.made_of if "made_of" in report else None
    return [line, state_of(report), *dressed_lines(report), *material_lines(made_of)]


def material_lines(made_of: Yarn | None) -> list[str]:
    """Return one line on the yarn of which yarns were made, if it decided their material; none without one."""
    return [] if made_of is None else [f"Material: that of the yarn {made_of.name}, of which these yarns were made."]


def dressed_lines(report: Mapping[str, Any]) -> list[str]:
    """Return one line on yarns that were moved out of a body before their relaxation; none if none were in it."""
    if "dressed" not in report:
        return []
    moved = report["dressed"]
    return [f"Body: the yarns were {moved['depth_cm']:.2g} cm inside, and were moved by up to "
            f"{moved['farthest_cm']:.2g} cm before their relaxation."]  # fmt: skip


def files_to_open(folder: Path, drawn: bool) -> str:
    """Return the line that names the picture in an output folder, if it was drawn, and the report."""
    picture = f"Open {folder / 'preview.png'}" if drawn else "No picture was drawn"
    return f"{picture}; {folder / 'report.json'} holds all numbers."


def _length(yarns: YarnSet) -> str:
    metres = float(yarns.lengths.sum()) / 100.0
    return f"{metres:.3g} m" if metres < 1000.0 else f"{metres:,.0f} m"


def _weight(yarns: YarnSet, yarn: Yarn | None, gauge: Gauge) -> str:
    """Return the weight of all yarn; without a name or a stated mass, that of the yarn that is usual at the gauge."""
    known = yarn or yarn_for_gauge(gauge)
    grams = float(f"{yarns.mass(known.mass_per_length):.2g}")  # Two digits, for the yarn is typical.
    typical = f" if it is {known.name}" if yarn is None and np.isnan(yarns.mass_per_length).any() else ""
    return f"{f' of {known.name}' if yarn else ''}, about {grams:,g} g{typical}"


def state_of(report: Mapping[str, Any], *, mesh_converged: bool = True) -> str:
    """Return the line that says in words whether a relaxation has ended well.

    Args:
        report: report of the relaxation.
        mesh_converged: whether the mesh relaxation before it had converged.
    """
    verdict = relaxation_verdict(report, mesh_converged=mesh_converged)
    findings = [replace(found, remedy=REMEDIES.get(found.kind, found.remedy)) for found in verdict.findings]
    return str(replace(verdict, findings=tuple(findings)))
