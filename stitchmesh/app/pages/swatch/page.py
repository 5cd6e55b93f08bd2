# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Swatch: a chart on the left, the fabric in the middle, its measures and its dials on the right."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from stitchmesh.app.controls.field_panel import FieldPanel
from stitchmesh.app.controls.html_pieces import legend_of_key, message, range_html
from stitchmesh.app.pages.chart_panel import ChartPanel
from stitchmesh.app.pages.gauge_panel import FOUR_INCHES
from stitchmesh.app.pages.page import Page
from stitchmesh.app.pages.swatch.dial_panel import DialPanel
from stitchmesh.app.pages.swatch.exports import ExportPanel
from stitchmesh.app.pages.swatch.state import (
    LOOK_FIELDS,
    NAMES,
    Look,
    SwatchState,
    first_state,
    read_state,
    repeat_shape,
    state_table,
)
from stitchmesh.app.pages.swatch.stretch_panel import StretchPanel
from stitchmesh.app.pages.swatch.variant import FabricDrawing, Variant
from stitchmesh.app.task import FRAME_SECONDS
from stitchmesh.markup import Markup, joined, markup
from stitchmesh.periodic.gauge import FabricMeasures
from stitchmesh.periodic.resolve_pattern import Source
from stitchmesh.periodic.session.frames import Frame
from stitchmesh.periodic.swatch_design import SwatchDesign, SwatchDials
from stitchmesh.periodic.validated_range import fabric_of, gauge_verdict

if TYPE_CHECKING:
    from stitchmesh.app.application import App

MEASURES_STYLE = markup("""<style>
.sm-measures{border-collapse:collapse;width:100%;font-size:.86em;font-variant-numeric:tabular-nums}
.sm-measures th{text-align:left;font-weight:500}
.sm-measures td,.sm-measures thead th:not(:first-child){text-align:right;padding-left:.8em}
.sm-measures thead th{font-weight:700;border-bottom:1px solid var(--mantine-color-default-border)}
.sm-state{margin:.1em 0 .45em;font-size:.86em;line-height:1.35}
</style>""")


def measures_html(variants: Sequence[Variant]) -> Markup:
    """Return a line on each variant, a table with a column of measures for each, and the errors to expect."""
    several = len(variants) > 1
    states = joined(_state(variant, several) for variant in variants)
    shown = [variant for variant in variants if variant.frame is not None]
    table = _table(shown, several) if shown else Markup()
    return MEASURES_STYLE + states + table + joined(_ranges(variant, several) for variant in shown)


def _ranges(variant: Variant, several: bool) -> Markup:
    """Return a box that says whether the size of a free fabric at rest was compared with measurements."""
    frame, design = variant.frame, variant.design
    if frame is None or design is None or not frame.report["at_rest"] or design.dials.width or design.dials.height:
        return Markup()
    loops = frame.measures.loop_length / (2.0 * design.dials.yarn_radius)
    verdict = gauge_verdict(
        fabric_of(design.pattern), loops, frame.report["relaxation"], design.options()["material"],
        design.dials.yarn_radius,
    )  # fmt: skip
    return range_html(verdict, variant.name if several else "")


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
        ("Weight [g/m²]", f"{1e4 * measures.areal_density:.0f}"),  # the density is in g/cm²
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


RUN, PAUSE, STEP, AGAIN = "Start", "Stop", "Step", "From the start"
"""The commands to the yarns."""
BYTES_A_SECOND = 30e6
"""Bytes of positions that a browser gets in a second at most; larger fabrics get fewer frames."""
PART_OF_TIME = 0.25
"""Largest share of its time that the event thread spends on drawings."""


class SwatchPage(Page):
    """Designs swatches of knits and weaves."""

    name = "Swatch"
    hint = "Paint the chart on the left, or choose a pattern; the fabric follows. Turn its dials on the right."

    def __init__(self, app: App) -> None:
        """Make the page; nothing is shown yet."""
        super().__init__(app)
        self.state = first_state()
        """All that the page shows."""
        self.variants: list[Variant] = []
        """The variants in the scene."""
        self._stopped = False
        self._drawing = FabricDrawing(app.scene)

    def build(self) -> None:
        """Make the controls, and start the sessions."""
        self.state = self.saved_state(read_state, "swatch")
        self._stopped = False
        self._build_left()
        self._build_right()
        self._drawing = FabricDrawing(self.app.scene)
        for design in self.state.designs:
            self._add_variant(design)
        self._show()

    def refresh(self) -> None:
        """Do nothing, because the garment of the project is not part of this page."""

    def leave(self) -> None:
        """End the sessions, and a stretch test."""
        self._stretch.leave()
        for variant in self.variants:
            variant.close()
        self.variants.clear()

    @property
    def variant(self) -> Variant:
        """The variant that the chart and the dials change."""
        return self.variants[self.state.edited]

    def change(self, design: SwatchDesign) -> None:
        """Take another design for the edited variant, and let its fabric follow."""
        if design.pattern != self.state.design.pattern:
            self._drawing.expect_other_size()
        self.variant.change(design)
        self._keep(self.state.with_design(design))
        self._show()

    def _build_left(self) -> None:
        state = self.state
        self._chart = ChartPanel(
            self.app, state.design.pattern, state.charts[state.edited], self._take_pattern, self._take_text
        )

    def _build_right(self) -> None:
        controls, design = self.app.controls, self.state.design
        self._measures = controls.html(Markup())
        controls.buttons("Yarns", "Start, stop or step the relaxation, or return to the yarns as drawn",
                         (RUN, PAUSE, STEP, AGAIN), self._tell)  # fmt: skip
        controls.slider("Iterations per frame", "More iterations show larger steps of the relaxation",
                        self.state.iterations, self._set_iterations, least=1, most=200, step=1)  # fmt: skip
        controls.key("Start or stop the yarns", "Let the yarns relax or stand", "R", "shift", self._toggle)
        controls.key("One step of the yarns", "Relax for one frame", "N", "shift", lambda: self._tell(STEP))
        self._dials = DialPanel(controls, design, self.change)
        controls.button("Set all dials back", "The values of a new swatch; the chart stays", self._set_back)
        with controls.group("Look"):
            self._look = FieldPanel(
                controls, LOOK_FIELDS, lambda: self.state, lambda state, name: self._set_look(state.look)
            )
            self._legend = controls.html(Markup())
        with controls.group("Two variants", opened=len(self.state.designs) > 1):
            controls.toggle("Compare two variants", "A second fabric beside the first, with dials and chart of its own",
                            len(self.state.designs) > 1, self._compare)  # fmt: skip
            self._edited = controls.choice("Chart and dials of", "The variant that the chart and the dials change",
                                           NAMES, NAMES[self.state.edited], self._edit)  # fmt: skip
        self._exports = ExportPanel(self.app, lambda: (self.state.design, self.variant.frame, self.state.look))
        self._stretch = StretchPanel(self.app, self._named_designs, self._exports.curve)

    def _keep(self, state: SwatchState) -> None:
        self.state = state
        self.app.project.set_settings(self.name, state_table(state))

    def _add_variant(self, design: SwatchDesign) -> None:
        name = NAMES[len(self.variants)]
        variant = Variant(name, self.app.queue, self.state.iterations, self._stopped, self._take_frame)
        self.variants.append(variant)
        variant.change(design)

    def _take_frame(self, variant: Variant, frame: Frame) -> None:
        """Show a frame of a variant, but not one that was waiting while the user left the page."""
        if variant not in self.variants:
            return
        began = time.perf_counter()
        if frame.error is not None and (variant.frame is None or variant.frame.error is not frame.error):
            self.app.notice(f"{frame.error}", "error")
        drawing = variant.draw(frame, self.state.look)
        self._show_fabric()
        if frame.report["at_rest"]:
            self._drawing.fit_at_rest()
        self._measures.content = measures_html(self.variants)
        if variant is self.variant:
            self._dials.show(self.state.design, frame)
        sent = 12.0 * sum(len(part.vertices) for part in drawing.parts)
        variant.slow_down(max(FRAME_SECONDS, (time.perf_counter() - began) / PART_OF_TIME, sent / BYTES_A_SECOND))

    def _show_fabric(self) -> None:
        self._drawing.show(self.variants)
        several = len(self.variants) > 1
        self._legend.content = joined(
            legend_of_key(variant.legend, f"Colours of {variant.name}" if several else "")
            for variant in self.variants
            if variant.legend
        )

    def _show(self) -> None:
        design, compared = self.state.design, len(self.state.designs) > 1
        self._dials.show(design, self.variant.frame)
        self._look.show()
        self._edited.visible = compared
        self._edited.value = NAMES[self.state.edited]
        self._measures.content = measures_html(self.variants)

    def _take_pattern(self, source: Source) -> None:
        """Take a pattern from the chart; another size of the repeat gets other numbers of copies, and no held size."""
        design, before = replace(self.state.design, pattern=source), self.state.design
        if design.pattern == before.pattern:
            return
        if repeat_shape(source) != repeat_shape(before.pattern):
            design = design.turned(width=None, height=None)
            self._keep(replace(self.state, look=self.state.look.fitted(source)))
        self.change(design)

    def _take_text(self, text: str) -> None:
        self._keep(self.state.with_chart(text))

    def _set_back(self) -> None:
        self.change(replace(self.state.design, dials=SwatchDials()))

    def _set_look(self, look: Look) -> None:
        before = self.state.look
        self._keep(replace(self.state, look=look))
        if (look.columns, look.rows) != (before.columns, before.rows):
            self._drawing.fit_next()
        for variant in self.variants:
            if variant.frame is not None:
                variant.draw(variant.frame, look)
        self._show_fabric()

    def _set_iterations(self, count: float) -> None:
        self._keep(replace(self.state, iterations=int(count)))
        for variant in self.variants:
            variant.session.iterations_per_frame = int(count)

    def _tell(self, what: str) -> None:
        self._stopped = what in (PAUSE, STEP) or (what == AGAIN and self._stopped)
        actions: dict[str, Callable[[Variant], None]] = {
            RUN: Variant.start, PAUSE: Variant.stop, STEP: Variant.step, AGAIN: Variant.restart,
        }  # fmt: skip
        for variant in self.variants:
            actions[what](variant)
        self._measures.content = measures_html(self.variants)

    def _toggle(self) -> None:
        self._tell(RUN if self._stopped else PAUSE)

    def _compare(self, compare: bool) -> None:
        """Add a second variant, equal to the first, or keep only the edited one."""
        edited = self.state.edited
        self._keep(self.state.compared(compare))
        if compare:
            self._add_variant(self.state.design)
        else:
            for variant in [each for each in self.variants if each is not self.variants[edited]]:
                self._drawing.remove(variant)
                variant.close()
                self.variants.remove(variant)
            self.variant.name = NAMES[0]
        self._drawing.expect_other_size()
        self._drawing.fit_next()
        self._show_fabric()
        self._show()

    def _edit(self, name: str) -> None:
        self._keep(replace(self.state, edited=NAMES.index(name)))
        self._chart.show(self.state.design.pattern, self.state.charts[self.state.edited])
        self._show()

    def _named_designs(self) -> list[tuple[str, SwatchDesign]]:
        return list(zip(NAMES, self.state.designs, strict=False))
