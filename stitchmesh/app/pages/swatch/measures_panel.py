# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The measures of the fabric, and its present state in words."""

from __future__ import annotations

from collections.abc import Sequence

from stitchmesh.app.controls.controls import Controls
from stitchmesh.app.controls.html_pieces import message
from stitchmesh.app.pages.gauge_panel import FOUR_INCHES
from stitchmesh.app.pages.swatch.variant import Variant
from stitchmesh.markup import Markup, joined, markup
from stitchmesh.periodic.gauge import FabricMeasures
from stitchmesh.periodic.session.frames import Frame

STYLE = markup("""<style>
.sm-measures{border-collapse:collapse;width:100%;font-size:.86em;font-variant-numeric:tabular-nums}
.sm-measures th{text-align:left;font-weight:500}
.sm-measures td,.sm-measures thead th:not(:first-child){text-align:right;padding-left:.8em}
.sm-measures thead th{font-weight:700;border-bottom:1px solid var(--mantine-color-default-border)}
.sm-state{margin:.1em 0 .45em;font-size:.86em;line-height:1.35}
</style>""")
GRAMS_PER_SQUARE_METRE = 1e4
"""1 g/cm^2 in g/m^2."""


class MeasuresPanel:
    """A line on each variant, and a table with a column for each."""

    def __init__(self, controls: Controls) -> None:
        """Make the panel, which stays empty until ``show``."""
        self._html = controls.html(Markup())

    def show(self, variants: Sequence[Variant]) -> None:
        """Show the newest frames."""
        several = len(variants) > 1
        states = joined(_state(variant, several) for variant in variants)
        shown = [variant for variant in variants if variant.frame is not None]
        table = _table(shown, several) if shown else Markup()
        self._html.content = STYLE + states + table


def state_of(variant: Variant) -> tuple[str, bool]:
    """Return the present state of a variant in words, and whether it is a problem."""
    frame = variant.frame
    if variant.refusal is not None:
        return variant.refusal, True
    if frame is None:
        return "The yarns are being drawn.", False
    if frame.error is not None:
        return f"Not possible: {frame.error}", True
    iteration = frame.report["iteration"]
    if frame.report["at_rest"]:
        return f"At rest after {iteration} iterations.", False
    if frame.report["running"] and frame.report["preview"]:
        return f"A preview without friction; the knit then comes off the needles (iteration {iteration}).", False
    if frame.report["running"]:
        return f"The fabric moves: it finds its shape (iteration {iteration}{_residual(frame)}).", False
    if variant.stopped:
        return f"Stopped at iteration {iteration}{_residual(frame)}.", False
    return f"Not at rest after {iteration} iterations{_residual(frame)}; relax again, or turn a dial back.", True


def rows_of(measures: FabricMeasures, woven: bool) -> list[tuple[str, str]]:
    """Return the names and the values of the measures that a designer asks for."""
    across, upwards = ("Warps", "Wefts") if woven else ("Stitches", "Rows")
    return [
        (f"{across} in 10 cm", f"{measures.gauge.stitches:.1f}"),
        (f"{upwards} in 10 cm", f"{measures.gauge.rows:.1f}"),
        (f"{across} and {upwards.lower()} in 4 inches",
         f"{FOUR_INCHES * measures.gauge.stitches:.1f} and {FOUR_INCHES * measures.gauge.rows:.1f}"),
        ("Repeat [cm]", f"{measures.width:.2f} x {measures.height:.2f}"),
        ("Yarn at a crossing [cm]" if woven else "Loop length [cm]", f"{measures.loop_length:.2f}"),
        ("Thickness [cm]", f"{measures.thickness:.2f}"),
        ("Weight [g/m²]", f"{GRAMS_PER_SQUARE_METRE * measures.areal_density:.0f}"),
    ]


def _state(variant: Variant, several: bool) -> Markup:
    text, wrong = state_of(variant)
    named = f"{variant.name}: {text}" if several else text
    return message(named, "doubtful") if wrong else markup('<p class="sm-state" role="status">{}</p>', named)


def _table(variants: Sequence[Variant], several: bool) -> Markup:
    """Return the table; if one variant is knitted and one woven, it uses the words of the first."""
    frames = [variant.frame for variant in variants if variant.frame is not None]
    columns = [rows_of(frame.measures, frame.fabric is None) for frame in frames]
    names = joined(markup('<th scope="col">{}</th>', variant.name) for variant in variants)
    head = markup('<thead><tr><th scope="col">Fabric</th>{}</tr></thead>', names) if several else Markup()
    rows = joined(
        markup(
            '<tr><th scope="row">{}</th>{}</tr>',
            row[0][0], joined(markup("<td>{}</td>", value) for _, value in row),
        )
        for row in zip(*columns, strict=True)
    )
    return markup(
        '<table class="sm-measures" aria-label="Measures of the fabric">{}<tbody>{}</tbody></table>',
        head, rows,
    )


def _residual(frame: Frame) -> str:
    residual = frame.report["residual"]
    return "" if residual is None else f", residual {residual:.2g}"
