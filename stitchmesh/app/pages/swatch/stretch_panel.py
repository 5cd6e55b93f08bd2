# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The stretch test: the tension of each variant at increasing strains, as a plot."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from stitchmesh.app.controls.html_pieces import message, range_html
from stitchmesh.app.task import Task, TaskControl
from stitchmesh.markup import Markup, joined, markup
from stitchmesh.periodic.stretch import NEWTONS_PER_METRE, StretchCurve, StretchPath, StretchPoint, stretch_test
from stitchmesh.periodic.swatch_design import SwatchDesign
from stitchmesh.run import Run

if TYPE_CHECKING:
    import plotly.graph_objects as go

    from stitchmesh.app.application import App

DIRECTIONS = {"across, along the courses": "course", "upwards, along the wales": "wale"}
"""Direction of a test, by its name on the page."""
COLOURS = ("#1f5673", "#c97d10")
"""Colours of the curves of the variants."""
DASHES = ("solid", "dash")
MARKS = ("circle", "square")
STEPS = 7
"""Number of states of a curve, the free state included."""


@dataclass(frozen=True)
class Curve:
    """The points of a variant that have been measured so far."""

    name: str
    points: tuple[StretchPoint, ...]
    direction: str

    @property
    def percent(self) -> list[float]:
        """Strains [%]."""
        return [100.0 * point.strain for point in self.points]

    @property
    def tension(self) -> list[float]:
        """Tensions in the direction of the stretch [N/m]."""
        return [NEWTONS_PER_METRE * getattr(point, f"{self.direction}_tension") for point in self.points]


class StretchPanel:
    """Controls and plot of the stretch test."""

    def __init__(
        self, app: App, designs: Callable[[], Sequence[tuple[str, SwatchDesign]]],
        exported: Callable[[str, StretchCurve], object],
    ) -> None:  # fmt: skip
        """Make the controls.

        Args:
            app: the application.
            designs: returns the names and designs of the variants.
            exported: called with the name of a variant and its curve when the user asks for the tables.
        """
        self._app, self._designs, self._exported = app, designs, exported
        self._curves: list[tuple[str, StretchCurve]] = []
        self._task: Task[Any] | None = None
        self._left = False
        controls = app.controls
        with controls.group("Stretch test", opened=False):
            self._direction = controls.choice(
                "Direction", "Direction in which the fabric is pulled; it is free across", tuple(DIRECTIONS),
                next(iter(DIRECTIONS)),
            )  # fmt: skip
            self._strain = controls.number(
                "Strain [%]", "Largest strain; the test begins at the free fabric", 40.0, least=1.0, most=300.0,
                step=1.0,
            )  # fmt: skip
            self._run = controls.button("Run the stretch test", "Relax the fabric at growing strains; it takes a while",
                                        self.run)  # fmt: skip
            self._stop = controls.button("Stop the test", "End the test; its points stay in the plot", app.tasks.cancel)
            self._bar = controls.progress_bar()
            self._plot = controls.plot(aspect=1.35)
            self._snaps = controls.html(Markup())
            self._save = controls.button("Download the curve (CSV)", "A table of strains, tensions, sizes and energies",
                                         self._download)  # fmt: skip
        self._show_running(False)
        self._save.visible = False

    def run(self) -> None:
        """Start the test of all variants."""
        designs, direction = list(self._designs()), DIRECTIONS[self._direction.value]
        strain = (0.0, self._strain.value / 100.0)
        self._task = self._app.tasks.start(
            "the stretch test", lambda control: _test(designs, direction, strain, control), self._done, self._failed
        )
        self._task.on_frame = self._show
        self._show_running(True)
        self._say_progress(0)

    def leave(self) -> None:
        """End a running test, because its controls will be removed."""
        self._left = True
        if self._task is not None and self._task is self._app.tasks.current:
            self._app.tasks.cancel()

    def _done(self, curves: list[tuple[str, StretchCurve]]) -> None:
        if self._left:
            return
        self._curves = curves
        self._show_running(False)
        self._save.visible = True
        self._show([Curve(name, curve.points, curve.direction) for name, curve in curves])
        snaps = joined(message(text, "doubtful") for text in snap_texts(curves))
        names = [name if len(curves) > 1 else "" for name, _ in curves]
        ranges = joined(range_html(curve.ranges, name) for name, (_, curve) in zip(names, curves, strict=True))
        self._snaps.content = snaps + ranges

    def _failed(self, error: Exception | None) -> None:
        if not self._left:
            self._show_running(False)
            self._snaps.content = Markup()

    def _show(self, curves: list[Curve]) -> None:
        if self._left:
            return
        count = sum(len(curve.points) for curve in curves)
        self._bar.value = 100.0 * count / (STEPS * len(self._designs()))
        if self._stop.visible:
            self._say_progress(count)
        if any(curve.points for curve in curves):
            self._plot.figure = stretch_figure(curves)

    def _say_progress(self, count: int) -> None:
        of_all = f"{count} of {STEPS * len(self._designs())} states are at rest"
        self._snaps.content = message(f"The stretch test runs: {of_all}. The live fabric waits meanwhile.", "info")

    def _show_running(self, running: bool) -> None:
        self._run.disabled, self._stop.visible, self._bar.visible = running, running, running
        if running:
            self._bar.value = 0.0

    def _download(self) -> None:
        for name, curve in self._curves:
            self._exported(name, curve)


def stretch_figure(curves: Sequence[Curve]) -> go.Figure:
    """Return the plot of tensions over strains; the curves differ in colour, dashes and marks."""
    import plotly.graph_objects as go

    figure = go.Figure()
    for number, curve in enumerate(curves):
        figure.add_scatter(
            x=curve.percent, y=curve.tension, name=str(markup("{}", curve.name)), mode="lines+markers",
            line={"color": COLOURS[number], "dash": DASHES[number]}, marker={"symbol": MARKS[number], "size": 7},
        )  # fmt: skip
    along = "courses" if curves[0].direction == "course" else "wales"
    return figure.update_layout(
        xaxis_title=f"strain along the {along} [%]", yaxis_title="tension [N/m]", showlegend=len(curves) > 1,
        legend={"x": 0.02, "y": 0.98},
    )  # fmt: skip


def snap_texts(curves: Sequence[tuple[str, StretchCurve]]) -> list[str]:
    """Return a sentence on each strain at which a fabric snapped to another shape."""
    return [
        f"{name}: {text}." if len(curves) > 1 else f"{text[0].upper()}{text[1:]}."
        for name, curve in curves
        for text in curve.snap_texts
    ]


def _test(
    designs: Sequence[tuple[str, SwatchDesign]], direction: str, strain: tuple[float, float], control: TaskControl
) -> list[tuple[str, StretchCurve]]:
    """Test all designs one after another, and publish the points so far."""
    found: list[tuple[str, StretchCurve]] = []
    for name, design in designs:
        points: list[StretchPoint] = []

        def publish(point: StretchPoint, own: list[StretchPoint] = points, name: str = name) -> None:
            own.append(point)
            earlier = [Curve(other, curve.points, direction) for other, curve in found]
            control.frame([*earlier, Curve(name, tuple(own), direction)])
            control.check()

        options: dict[str, Any] = {key: value for key, value in design.options().items() if key != "period"}
        course, wale = (strain if direction == name else None for name in ("course", "wale"))
        path = StretchPath(course=course, wale=wale, steps=STEPS)
        run: Run[StretchPoint] = Run(lambda stage, done, note: control.check(), publish)
        curve = stretch_test(design.pattern, path, quality=design.quality, run=run, **options)
        found.append((name, curve))
    return found
