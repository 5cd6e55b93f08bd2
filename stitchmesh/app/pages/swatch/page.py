# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Swatch: a chart on the left, the fabric in the middle, and its dials on the right."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

from stitchmesh.app.controls.field_panel import FieldPanel
from stitchmesh.app.controls.legend import legend_of_key
from stitchmesh.app.pages.page import Page
from stitchmesh.app.pages.swatch.chart_panel import ChartPanel
from stitchmesh.app.pages.swatch.dial_panel import DialPanel
from stitchmesh.app.pages.swatch.exports import ExportPanel
from stitchmesh.app.pages.swatch.fabric_drawing import FabricDrawing
from stitchmesh.app.pages.swatch.measures_panel import MeasuresPanel
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
from stitchmesh.app.pages.swatch.variant import Variant
from stitchmesh.app.task import FRAME_SECONDS
from stitchmesh.errors import StitchMeshError
from stitchmesh.markup import Markup, joined
from stitchmesh.periodic.resolve_pattern import Source
from stitchmesh.periodic.session.frames import Frame
from stitchmesh.periodic.swatch_design import SwatchDesign, SwatchDials

if TYPE_CHECKING:
    from stitchmesh.app.application import App

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
        self.state = self._saved_state()
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
        self._measures = MeasuresPanel(controls)
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

    def _saved_state(self) -> SwatchState:
        """Return the state from the project; if it is damaged, say so and begin anew."""
        try:
            return read_state(self.app.project.settings(self.name))
        except StitchMeshError as error:
            self.app.notice(f"the saved swatch cannot be shown ({error}); a new one begins", "warning")
            return first_state()

    def _keep(self, state: SwatchState) -> None:
        """Take a state, and save it in the project."""
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
        self._measures.show(self.variants)
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
        """Show the state of the page in the controls."""
        design, compared = self.state.design, len(self.state.designs) > 1
        self._dials.show(design, self.variant.frame)
        self._look.show()
        self._edited.visible = compared
        self._edited.value = NAMES[self.state.edited]
        self._measures.show(self.variants)

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
        """Start, stop, step or restart all variants."""
        self._stopped = what in (PAUSE, STEP) or (what == AGAIN and self._stopped)
        actions: dict[str, Callable[[Variant], None]] = {
            RUN: Variant.start, PAUSE: Variant.stop, STEP: Variant.step, AGAIN: Variant.restart,
        }  # fmt: skip
        for variant in self.variants:
            actions[what](variant)
        self._measures.show(self.variants)

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
        """Make chart and dials change another variant."""
        self._keep(replace(self.state, edited=NAMES.index(name)))
        self._chart.show(self.state.design.pattern, self.state.charts[self.state.edited])
        self._show()

    def _named_designs(self) -> list[tuple[str, SwatchDesign]]:
        return list(zip(NAMES, self.state.designs, strict=False))
