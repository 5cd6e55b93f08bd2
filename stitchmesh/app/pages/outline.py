# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Outline: the natural outline of a chart, from mesh relaxation alone, watched live."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, get_args

import numpy as np

from stitchmesh.app.controls.controls import do_nothing
from stitchmesh.app.controls.field_panel import Field, FieldPanel, Number
from stitchmesh.app.controls.html_pieces import message
from stitchmesh.app.pages.chart_panel import ChartPanel
from stitchmesh.app.pages.page import Page
from stitchmesh.app.pages.page_run import BYTES_PER_STITCH, PageRun, WatchedWork
from stitchmesh.app.scene.drawing import Lines
from stitchmesh.app.scene.size_map import OUTLINE, SizeMapDrawing, legend_html
from stitchmesh.errors import ParameterError
from stitchmesh.io.checked import check_value
from stitchmesh.markup import Markup
from stitchmesh.mesh import FloatArray, StitchMesh
from stitchmesh.meshrelax.free.free_shape import FreeShape
from stitchmesh.meshrelax.free.relax_freely import FREE_MAX_ITERATIONS
from stitchmesh.patterns import Pattern, format_pattern, parse_pattern, read_pattern
from stitchmesh.periodic.natural_outline import PIECE, Form, natural_outline
from stitchmesh.periodic.resolve_pattern import Source
from stitchmesh.progress import Progress
from stitchmesh.run import Run
from stitchmesh.run_control import RunControl, Snapshot

if TYPE_CHECKING:
    from stitchmesh.app.application import App

FORMS: dict[str, Form] = {"Flat piece": "flat", "Tube": "tube", "Repeat": "lattice"}
"""The forms by the words of the user."""
LEAST, MOST = 4, 200
"""Bounds of the smallest numbers of stitches and of rows of a piece."""
FIELDS = (
    Field("form", "Form", "A piece with borders, a tube in rounds, or one repeat without borders", FORMS),
    Field("stitches", "Stitches", "Least number of stitches in a row; whole repeats are knitted",
          Number(LEAST, MOST, 1, slider=True)),
    Field("rows", "Rows", "Least number of rows; whole repeats are knitted", Number(LEAST, MOST, 1, slider=True)),
)  # fmt: skip
"""The form and the size of the piece."""
BUSY = "Other work goes on; press Relax again when it has ended"
"""Text in place of the figures while another task runs."""
WOVEN = "A weave has no stitches whose outline could relax. Choose a knitting pattern."
"""Notice for a weave."""


@dataclass(frozen=True)
class OutlineState:
    """What the page shows; the project keeps it."""

    pattern: str
    """Text of the pattern."""
    form: Form = "flat"
    """Form of the fabric."""
    stitches: int = PIECE
    """Smallest number of stitches in the width of a piece, or in half the girth of a tube."""
    rows: int = PIECE
    """Smallest number of rows."""


class OutlinePage(Page):
    """Natural outlines."""

    name: ClassVar[str] = "Outline"
    hint: ClassVar[str] = "See within seconds how a pattern draws in, scallops or slants, before yarns are relaxed."

    def __init__(self, app: App) -> None:
        """Make the page; nothing runs yet."""
        super().__init__(app)
        self.state = first_state()
        self._run: PageRun[StitchMesh, FreeShape] = PageRun(self, self._show_snapshot, self._ended)
        self._waiting = False

    def build(self) -> None:
        """Make the controls, and start the relaxation."""
        self.state = self.saved_state(read_state, "outline")
        self._map = SizeMapDrawing(self.app.scene)
        ChartPanel(self.app, parse_pattern(self.state.pattern), "", self._take_pattern, do_nothing)
        controls = self.app.controls
        FieldPanel(controls, FIELDS, lambda: self.state, lambda state, name: self._take(state))
        controls.button("Relax again", "Start again from the chart", self.start)
        self._run.build("one iteration")
        self._words = controls.html(Markup())
        controls.html(legend_html("compressed", "stretched"))
        if self._run.live is None:
            self.start()
        self._run.refresh()

    def leave(self) -> None:
        """Let the relaxation end unseen."""
        self._run.leave()

    def start(self) -> None:
        """Relax the mesh of the chart; a relaxation of an earlier chart ends first."""
        if self._run.live is not None:
            self._waiting = True
            self._run.live.control.stop()
            return
        if self.app.tasks.current is not None:
            self._words.content = message(f"{BUSY} ({self.app.tasks.current.name}).", "info")
            return
        state, pattern = self.state, parse_pattern(self.state.pattern)

        def relax(control: RunControl[StitchMesh], progress: Progress) -> FreeShape:
            return natural_outline(pattern, state.form, **_repeats(pattern, state), run=Run(False, control=control))

        watched = WatchedWork(
            name="relaxing the outline", relax=relax, stage="outline", max_iterations=FREE_MAX_ITERATIONS,
            frame_bytes=BYTES_PER_STITCH * state.stitches * state.rows,
        )  # fmt: skip
        self._run.start(watched, self._finish)
        self._run.refresh()

    def _take_pattern(self, source: Source) -> None:
        if not isinstance(source, Pattern):
            self.app.notice(WOVEN, "warning")
            return
        self._take(replace(self.state, pattern=format_pattern(source)))

    def _take(self, state: OutlineState) -> None:
        if state != self.state:
            self.state = state
            self.app.project.set_settings(self.name, asdict(state))
            self.start()

    def _finish(self, shape: FreeShape) -> None:
        """Show the result, unless the chart has changed since."""
        if self.app.page is self and not self._waiting:
            self._show_fabric(shape.fabric, shape.outline)
            self._words.content = message(_words(shape), "good" if shape.report.converged else "doubtful")

    def _ended(self) -> None:
        """Start the waiting relaxation."""
        again, self._waiting = self._waiting, False
        if self.app.page is not self:
            return
        self._run.refresh()
        if again:
            self.start()

    def _show_snapshot(self, snapshot: Snapshot[StitchMesh]) -> None:
        self._show_fabric(snapshot.state, ())

    def _show_fabric(self, fabric: StitchMesh, outline: tuple[FloatArray, ...]) -> None:
        other = self._map.show(fabric, "size")
        self._show_outline(outline)
        if other or outline:
            self.app.scene.look_at(fabric.vertices.min(axis=0), fabric.vertices.max(axis=0))

    def _show_outline(self, outline: tuple[FloatArray, ...]) -> None:
        segments = [np.stack([border, np.roll(border, -1, axis=0)], axis=1) for border in outline]
        self.app.scene.show("outline", Lines(np.concatenate([np.zeros((0, 2, 3)), *segments]), OUTLINE, 4.0))


def first_state() -> OutlineState:
    """Return the state of a new project."""
    # Its outline differs from the rectangle of its chart.
    return OutlineState(format_pattern(read_pattern("feather-and-fan")))


def read_state(table: Mapping[str, Any]) -> OutlineState:
    """Return the state from a project's table; the state of a new project if the table is empty.

    Raises:
        ParameterError: a key is missing, or a value is of another type or out of bounds.
        PatternError: the text does not describe a pattern.
    """
    if not table:
        return first_state()
    text, form = check_value(table.get("pattern"), str), check_value(table.get("form"), str)
    counts = [check_value(table.get(name), int) for name in ("stitches", "rows")]
    if form not in get_args(Form) or not all(LEAST <= count <= MOST for count in counts):
        raise ParameterError(f"outline: got form {form!r} with {counts[0]} stitches and {counts[1]} rows")
    parse_pattern(text)
    return OutlineState(text, next(known for known in get_args(Form) if known == form), *counts)


def _repeats(pattern: Pattern, state: OutlineState) -> dict[str, int]:
    """Return the numbers of repeats of a piece; a lattice has one repeat."""
    if state.form == "lattice":
        return {}
    around = 2 if state.form == "tube" else 1
    return {"columns": -(-around * state.stitches // pattern.width), "rows": -(-state.rows // pattern.height)}


def _words(shape: FreeShape) -> str:
    measures = shape.measures()
    slant = f" Its wales lean {abs(shape.slant):.1f}° to the {'right' if shape.slant > 0 else 'left'}."
    return (
        f"{shape.width:.3g} x {shape.height:.3g} cm: {100 * measures['width_over_plain']:.0f} % of the width and "
        f"{100 * measures['height_over_plain']:.0f} % of the height of plain knit with as many stitches and rows."
        f"{slant if abs(shape.slant) >= 0.5 else ''} Relaxed in {shape.report.seconds:.1f} s."
    )
