# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Yarns: the user generates the yarns, looks at them, relaxes them and watches the relaxation."""

from __future__ import annotations

import time
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from stitchmesh.app.controls.field_panel import FieldPanel
from stitchmesh.app.controls.html_pieces import figures_html, message, paragraph, verdict_html
from stitchmesh.app.pages.gauge_panel import (
    DIGITS,
    GROUP,
    add_yarn_choice,
    drawn_height,
    gauge_words,
    take_yarn,
    yarn_of,
)
from stitchmesh.app.pages.page import Page
from stitchmesh.app.pages.page_run import PageRun, WatchedWork, garment_of, is_wanted
from stitchmesh.app.pages.yarns.energy_plot import Assessed, energy_plot, history_plot
from stitchmesh.app.pages.yarns.holding_panels import BodyPanel, PinPanel, check_pins
from stitchmesh.app.pages.yarns.settings import (
    AUTOMATIC,
    FORCES,
    YarnSettings,
    accuracy_fields,
    decisive_choices,
    settings_of,
    settings_table,
)
from stitchmesh.app.pages.yarns.yarn_view import COLOURINGS, GarmentYarnView
from stitchmesh.app.scene.mesh_drawing import draw_plainly
from stitchmesh.app.scene.scene import Pick, ScreenBox
from stitchmesh.compute.device import device_names
from stitchmesh.errors import ParameterError
from stitchmesh.markup import Markup, joined, markup
from stitchmesh.mesh import StitchMesh
from stitchmesh.pipeline.garment import Made
from stitchmesh.pipeline.stage_table import GENERATE_YARNS, RELAX_YARNS
from stitchmesh.progress import Progress
from stitchmesh.render.colouring import Coloured
from stitchmesh.reporting.figures import report_figures
from stitchmesh.reporting.verdict import relaxation_verdict
from stitchmesh.run import Run
from stitchmesh.run_control import RunControl, Snapshot
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.stitch_size import fabric_gauge, yarn_gauge
from stitchmesh.yarn.yarn_presets import WIDTH_OVER_CORE, Gauge, Yarn, yarn_for_gauge
from stitchmesh.yarnrelax import Relaxation

if TYPE_CHECKING:
    from stitchmesh.app.application import App

GENERATE, GENERATE_AGAIN = "Generate the yarns", "Generate the yarns again"
RELAX, RELAX_AGAIN, CONTINUE = "Relax the yarns", "Relax from the start again", "Continue the relaxation"
"""Labels of the buttons that start a relaxation."""
OTHER_SETTINGS = "The yarns were generated with other settings. Generate them again to use yours."
BYTES_PER_POINT = 6
"""Size of a frame for each control point."""
INTERRUPTED = "interrupted"
"""Key of the settings that holds the choices of a relaxation from its start until it has converged."""


class YarnsPage(Page):
    """Generation and relaxation of yarns."""

    name: ClassVar[str] = "Yarns"
    needs = "Even out"
    hint: ClassVar[str] = "Generate the yarns, then relax them: they find the shape that real yarn would have."

    def __init__(self, app: App) -> None:
        """Make the page; nothing runs yet."""
        super().__init__(app)
        self._run: PageRun[YarnSet, Relaxation] = PageRun(self, self._show_snapshot, self._after)
        self._view = GarmentYarnView(app.scene)
        self._plotted = 0.0

    @property
    def settings(self) -> YarnSettings:
        """The choices of the user."""
        return settings_of(self.app.project.settings(self.name).get("choices", {}))

    @property
    def fabric(self) -> StitchMesh | None:
        """The stitches from which yarns are generated; None before mesh relaxation."""
        project = self.app.project
        if project.evened is not None:
            return project.evened
        # Stitches from a file may have been relaxed before.
        return project.fabric if project.fabric is not None and project.fabric.stretch is not None else None

    def unavailable(self) -> str | None:
        """Return what the user must do first while there are no even stitches."""
        if self.fabric is None:
            return "The stitches are not even yet. Even them out first, on the page Even out."
        return None

    def build(self) -> None:
        """Make the controls and show the yarns."""
        controls = self.app.controls
        self._view = GarmentYarnView(self.app.scene, self._view.colouring)
        self._generate = controls.button(GENERATE, "Make yarn curves from the stitches", self.generate, main=True)
        self._continue = controls.button(CONTINUE, "Go on from the last checkpoint", self.resume, main=True)
        self._relax = controls.button(RELAX, "Let the yarns move until they are at rest", self.relax, main=True)
        self._run.build("20 iterations")
        self._verdict = controls.html(Markup())
        self._plot = controls.plot(None, aspect=1.15)
        self._colouring = controls.choice(
            "Colours show", "What the colours of the yarns mean", list(COLOURINGS), self._view.colouring, self._recolour
        )
        self._legend = controls.html(Markup())
        with controls.group("Figures", opened=False) as self._figure_group:
            self._figures = controls.html(Markup())
        with controls.group(GROUP):
            add_yarn_choice(controls, yarn_of(self.app.project), self._take_yarn)
            self._gauge = controls.html(Markup())
        if self.settings.device not in (AUTOMATIC, *device_names()):  # The project comes from another machine.
            self.keep_settings(choices=settings_table(replace(self.settings, device=AUTOMATIC)))
        groups = {"Accuracy and edges": accuracy_fields(self._usual_radius()), "Lengths and forces": FORCES}
        self._choices = [
            FieldPanel(controls, fields, lambda: self.settings, self._take, group=group, opened=False)
            for group, fields in groups.items()
        ]
        self._body = BodyPanel(self.app, self._view, lambda: self.settings, self._set)
        self._pins = PinPanel(self.app, self._view, lambda: self.settings, self._set)
        self._generate_again = controls.button(GENERATE_AGAIN, "Make new yarn curves", self.generate)
        self._relax_again = controls.button(RELAX_AGAIN, "Relax from the generated yarns", self.relax)
        self.refresh()
        self._view.look_at_all()

    def leave(self) -> None:
        """Let the relaxation go on unseen."""
        self._run.leave()

    def refresh(self) -> None:
        """Show the yarns of the project and the possible actions."""
        if self.unavailable() is not None:
            return
        self._run.refresh()
        live = self._run.live
        for panel in self._choices:
            panel.set_disabled(live is not None)
        self._show_buttons()
        if live is None:
            self._show_result()
        elif live.newest is not None:
            self._show_snapshot(live.newest)

    def generate(self) -> None:
        """Generate yarns from the stitches."""
        project, settings, fabric = self.app.project, self.settings, self._even_fabric()
        yarn = yarn_of(project)
        garment = garment_of(project, fabric, settings.knit_options(yarn))

        def done(made: Made[YarnSet]) -> None:
            if is_wanted(self, project, self.fabric is fabric):
                project.set_yarns(made.value, settings.generation(yarn))
                self.keep_settings(**{INTERRUPTED: None})
            self._after()

        self.app.tasks.start(
            "generating the yarns", lambda task: GENERATE_YARNS.run(garment, Run(task.progress)), done,
            lambda error: self._after(),
        )  # fmt: skip
        self._show_buttons()
        self._verdict.content = message("Generating the yarns.", "info")

    def relax(self) -> None:
        """Relax the generated yarns."""
        self._start(resume=False)

    def resume(self) -> None:
        """Continue the relaxation from its last checkpoint."""
        self._start(resume=True)

    def picked(self, pick: Pick) -> None:
        """Pin the stitch under the pointer, or free it."""
        if self._run.live is None:
            self._pins.picked(pick)

    def boxed(self, box: ScreenBox) -> None:
        """Pin all stitches in the rectangle."""
        if self._run.live is None:
            self._pins.boxed(box)

    def _start(self, *, resume: bool) -> None:
        """Start a relaxation in the worker thread."""
        project, settings, fabric = self.app.project, self.settings, self._even_fabric()
        if project.yarns is None:
            raise ParameterError(f"relaxation: there are no yarns; press {GENERATE} first")
        yarns, quality = project.yarns, settings.solver_quality()
        check_pins(settings.pins, yarns)
        options = settings.knit_options(yarn_of(project), settings.relax_options(project))
        garment, checkpoints = garment_of(project, fabric, options), settings.checkpoints(project)

        def relax(control: RunControl[YarnSet], progress: Progress) -> Relaxation:
            start = checkpoints.path if resume else None
            return RELAX_YARNS.run(garment, Run(False, checkpoints=checkpoints, resume=start, control=control)).value

        def done(result: Relaxation) -> None:
            if is_wanted(self, project, project.yarns is yarns):
                project.set_relaxed(result.yarns, result.report, result.history)
                if result.report["converged"]:
                    self.keep_settings(**{INTERRUPTED: None})

        watched = WatchedWork(
            name="relaxing the yarns", relax=relax, stage="yarnrelax", max_iterations=quality.max_iterations,
            frame_bytes=BYTES_PER_POINT * len(yarns.points), goal=quality.resting_residual,
        )  # fmt: skip
        self._run.start(watched, done)
        self.keep_settings(**{INTERRUPTED: decisive_choices(settings), "tolerance": quality.tolerance})
        self._verdict.content = self._figures.content = Markup()
        self._plot.figure = None
        self.refresh()

    def _after(self) -> None:
        if self.app.page is self:
            self.refresh()

    def _show_buttons(self) -> None:
        project, idle = self.app.project, not self.app.tasks.running
        has_yarns, has_result = project.yarns is not None, project.relaxed is not None
        can_continue = has_yarns and self._is_unfinished()
        self._generate.visible = idle and not has_yarns
        self._continue.visible = idle and can_continue
        self._relax.visible = idle and has_yarns and not has_result and not can_continue
        self._relax_again.visible = idle and has_yarns and (has_result or can_continue)
        self._generate_again.visible = idle and has_yarns
        self._figure_group.visible = project.report is not None and self._run.live is None

    def _is_unfinished(self) -> bool:
        """Return whether a relaxation with the present choices was stopped or killed and has left its checkpoint."""
        choices = self.app.project.settings(self.name).get(INTERRUPTED)
        return choices == decisive_choices(self.settings) and self.settings.checkpoints(self.app.project).path.exists()

    def _show_result(self) -> None:
        """Show the yarns while nothing runs, and the texts about them."""
        project = self.app.project
        yarns = project.relaxed or project.yarns
        self._colouring.visible = yarns is not None
        self._verdict.content = self._verdict_content()
        self._gauge.content = self._gauge_content()
        if yarns is None:
            self._legend.content = Markup()
            draw_plainly(self.app.scene, self._even_fabric())
            return
        first = self._view.view is None
        self._view.show(yarns, self.fabric)
        self._view.show_pins(self.settings.pins)
        self._show_legend()
        if first:
            self._view.look_at_all()
        if project.report is not None and project.history is not None:
            tolerance = project.settings(self.name).get("tolerance", self.settings.solver_quality().tolerance)
            self._figures.content = figures_html(report_figures(project.report, tolerance=tolerance))
            self._plot.figure = history_plot(project.history, tolerance)
        else:
            self._plot.figure = None

    def _verdict_content(self) -> Markup:
        project = self.app.project
        if project.yarns is None:
            return message("There are no yarns yet. Generate them above.", "info")
        amount = self._amount(project.relaxed or project.yarns)
        if project.report is None:
            interrupted = " The relaxation was interrupted; it can be continued." if self._is_unfinished() else ""
            return self._changed_note() + message(f"{amount} Not relaxed yet.{interrupted}", "info")
        evened = project.settings("Even out").get("report")
        verdict = relaxation_verdict(project.report, mesh_converged=evened is None or bool(evened["converged"]))
        box = verdict_html(verdict, "Good", "Not good yet")
        return markup('{}{}<p style="font-size:.86em;margin:.3em 0 0">{}</p>', self._changed_note(), box, amount)

    def _changed_note(self) -> Markup:
        """Return a box that says that the yarns do not match the present settings; nothing if they do."""
        made = self.app.project.yarn_settings
        if made is None or made == self.settings.generation(yarn_of(self.app.project)):
            return Markup()
        return message(OTHER_SETTINGS, "doubtful")

    def _amount(self, yarns: YarnSet) -> str:
        metres = float(yarns.lengths.sum()) / 100.0
        own = yarn_of(self.app.project)
        known = own or yarn_for_gauge(fabric_gauge(self._even_fabric()))
        grams = yarns.mass(known.mass_per_length)
        typical = f" if it is {known.name}" if np.isnan(yarns.mass_per_length).any() else ""
        count = f"{yarns.yarn_count:,} yarn{'' if yarns.yarn_count == 1 else 's'}"
        return (
            f"{count}, {len(yarns.points):,} control points, {metres:,.4g} m; "
            f"about {grams:,.{0 if grams >= 10.0 else 1}f} g{typical if own is None else f' of {known.name}'}."
        )

    def _usual_radius(self) -> float:
        """Return the radius of the project's yarn, or else an eighth of the width of a stitch [cm]."""
        yarn = yarn_of(self.app.project)
        width = fabric_gauge(self._even_fabric()).stitch_width
        return round(width / WIDTH_OVER_CORE if yarn is None else yarn.core_radius, DIGITS)

    def _gauge_content(self) -> Markup:
        """Return the gauge of the stitches, and the gauge of the relaxed yarns."""
        project, even = self.app.project, self._even_fabric()
        lines = [paragraph(f"Even stitches: {gauge_words(fabric_gauge(even))}")]
        sizes = project.division or project.shaping
        if sizes is not None:
            asked = Gauge.of_stitch(sizes.stitch_width, drawn_height(sizes.stitch_width, sizes.stitch_height))
            lines.insert(0, paragraph(f"Asked for: {gauge_words(asked)}"))
        reached = None if project.relaxed is None else yarn_gauge(project.relaxed, even)
        if reached is not None:
            lines.append(paragraph(f"Reached by the relaxed yarns: {gauge_words(reached)}"))
        return joined(lines)

    def _show_snapshot(self, snapshot: Snapshot[YarnSet]) -> None:
        self._view.show(snapshot.state, self.fabric, moving=True)
        live, now = self._run.live, time.monotonic()
        if live is not None and (live.paused or now - self._plotted > 1.0):
            self._plotted = now
            history = [Assessed(one.iteration, one.residual, one.energies) for one in live.history]
            self._plot.figure = energy_plot(history, snapshot.tolerance)

    def _recolour(self, colouring: str) -> None:
        """Show other colours; the worker thread finds those that take long.

        Raises:
            ParameterError: the colours take long, and another task runs.
        """
        if not self._view.is_slow(colouring):
            self._view.set_colouring(colouring)
            self._show_legend()
            return
        try:
            work, done = self._view.colouring_work(colouring), partial(self._take_colours, colouring)
            self.app.tasks.start("finding the colours", lambda task: work(), done, lambda error: self._after())
        finally:  # If a task runs, the list still shows what the present colours mean.
            self._show_legend()
        self._legend.content = message(f"Finding the colours of {colouring.lower()}.", "info")
        self._show_buttons()

    def _take_colours(self, colouring: str, coloured: Coloured) -> None:
        if self.app.page is self:
            self._view.take_colours(colouring, coloured)
            self._show_legend()
            self._show_buttons()

    def _show_legend(self) -> None:
        self._colouring.value = self._view.colouring
        self._legend.content = self._view.legend()

    def _take_yarn(self, yarn: Yarn | None) -> None:
        take_yarn(self.app.project, yarn)
        self._take(self.settings)

    def _set(self, **changes: Any) -> None:
        self._take(replace(self.settings, **changes))

    def _take(self, settings: YarnSettings, name: str = "") -> None:
        self.keep_settings(choices=settings_table(settings))
        if self._run.live is None and self.app.page is self:
            self._verdict.content = self._verdict_content()
            self._show_buttons()

    def _even_fabric(self) -> StitchMesh:
        assert self.fabric is not None
        return self.fabric
