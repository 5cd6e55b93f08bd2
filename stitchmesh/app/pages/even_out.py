# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Even out: mesh relaxation, watched live, and places with too few or too many stitches."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, get_args

import numpy as np

from stitchmesh.app.controls.field_panel import FieldPanel, Number, setting_field
from stitchmesh.app.controls.html_pieces import message, verdict_html
from stitchmesh.app.pages.page import NO_STITCHES, Page
from stitchmesh.app.pages.page_run import BYTES_PER_STITCH, PageRun, WatchedWork, garment_of, is_wanted
from stitchmesh.app.scene.size_map import SizeMapDrawing, legend_html, outline
from stitchmesh.errors import StitchMeshError
from stitchmesh.markup import Markup
from stitchmesh.mesh import StitchMesh
from stitchmesh.meshrelax.evenness import Measure, evenness_verdict, uneven_rows
from stitchmesh.meshrelax.options import MeshRelaxOptions
from stitchmesh.meshrelax.relax import MAX_ITERATIONS, MeshRelaxReport, not_converged
from stitchmesh.pipeline.garment import Made
from stitchmesh.pipeline.options import KnitOptions
from stitchmesh.pipeline.stage_table import RELAX_MESH
from stitchmesh.progress import Progress
from stitchmesh.run import Run
from stitchmesh.run_control import RunControl, Snapshot

if TYPE_CHECKING:
    from stitchmesh.app.application import App
    from stitchmesh.app.project.project import Project

MEASURES: dict[str, Measure] = {measure.capitalize(): measure for measure in get_args(Measure)}
"""The measures that the map can show, by the words of the user."""
START, AGAIN = "Even out the stitches", "Even out the stitches again"
"""Labels of the button that starts, before the first time and later."""
START_HINT = "Move the stitches over the surface until they are even"
NEXT = "The sizes of the stitches are known after evening out. Start it above."
"""Text in place of the verdict before the first mesh relaxation."""
SETTINGS = (
    setting_field(MeshRelaxOptions, "alpha", "Covered part", Number(0.3, 1.0, 0.05, slider=True)),
    setting_field(MeshRelaxOptions, "aspect", "Height over width", Number(0.2, 3.0, 0.01)),
    setting_field(MeshRelaxOptions, "area_force", "Resist folding"),
)  # fmt: skip
"""The options of the mesh relaxation."""


@dataclass(frozen=True)
class EvenOutState:
    """The user's choices on the page."""

    measure: Measure = "size"
    """The measure that the map shows."""
    marked: int | None = None
    """Number of the finding whose rows are marked; None without a mark."""


class EvenOutPage(Page):
    """Mesh relaxation."""

    name: ClassVar[str] = "Even out"
    needs = "Divide"
    hint: ClassVar[str] = "Make the stitches equally large. The map shows where there are too few or too many of them."

    def __init__(self, app: App) -> None:
        """Make the page; nothing runs yet."""
        super().__init__(app)
        self._run: PageRun[StitchMesh, Made[StitchMesh]] = PageRun(self, self._show_snapshot, self._ended)
        self._state = EvenOutState()

    def unavailable(self) -> str | None:
        """Return what the user must do first while there are no stitches."""
        return NO_STITCHES if self.app.project.fabric is None else None

    def build(self) -> None:
        """Make the controls and show the fabric."""
        controls = self.app.controls
        self._start = controls.button(START, START_HINT, self.start, main=True)
        self._next = controls.button(
            "Go on to the yarns", "Open the page Yarns", lambda: self.app.open_page("Yarns"), main=True
        )
        self._run.build("one iteration")
        self._verdict = controls.html(Markup(), self._act)
        self._legend = controls.html(legend_html())
        self._choice = controls.choice(
            "Colours show", "The mean size of each stitch, its width, or its height", list(MEASURES),
            self._state.measure.capitalize(), self._set_measure,
        )  # fmt: skip
        FieldPanel(
            controls, SETTINGS, lambda: shown_options(self.app.project),
            lambda options, name: self._set(**{name: getattr(options, name)}), group="Settings", opened=False,
        )  # fmt: skip
        self._again = controls.button(AGAIN, START_HINT, self.start)
        self._map = SizeMapDrawing(self.app.scene)
        self._state = replace(self._state, marked=None)
        self.refresh()
        low, high = (edge(self._fabric().vertices, axis=0) for edge in (np.min, np.max))
        self.app.scene.look_at(low, high)

    def leave(self) -> None:
        """Let the relaxation continue unseen."""
        self._run.leave()

    def refresh(self) -> None:
        """Show the fabric of the project, and the verdict on it."""
        if self.unavailable() is not None:
            return
        evened = self.app.project.evened
        running = self._run.live is not None
        self._run.refresh()
        self._start.visible = evened is None and not running
        self._next.visible = self._again.visible = evened is not None and not running
        if not running:
            self._show_fabric(self._fabric())
            self._verdict.content = self._verdict_content()

    def start(self) -> None:
        """Start the mesh relaxation."""
        project = self.app.project
        fabric = project.fabric
        assert fabric is not None
        garment = garment_of(project, fabric, even_out_options(project))

        def relax(control: RunControl[StitchMesh], progress: Progress) -> Made[StitchMesh]:
            return RELAX_MESH.run(garment, Run(False, control=control))

        watched = WatchedWork(
            name="evening out the stitches", relax=relax, stage="meshrelax", max_iterations=MAX_ITERATIONS,
            frame_bytes=BYTES_PER_STITCH * fabric.face_count,
        )  # fmt: skip
        self._run.start(watched, lambda made: self._finish(project, fabric, made))
        self._verdict.content = Markup()
        self._mark(None)
        self.refresh()

    def _set(self, **changes: Any) -> None:
        options = replace(mesh_relax_options(self.app.project), **changes)
        self.keep_settings(options=asdict(options))

    def _set_measure(self, measure: str) -> None:
        self._state = replace(self._state, measure=MEASURES[measure])
        if self._map.shown is not None:
            self._show_fabric(self._map.shown)

    def _finish(self, project: Project, before: StitchMesh, made: Made[StitchMesh]) -> None:
        """Keep a result, unless another project or fabric has replaced the one that it belongs to."""
        if not is_wanted(self, project, project.fabric is before):
            return
        dropped = project.set_evened(made.value)
        self.keep_settings(report=made.report["meshrelax"])
        if dropped:
            self.app.notice(f"The stitches have moved, so these were removed: {', '.join(dropped)}.", "warning")

    def _ended(self) -> None:
        if self.app.page is self:
            self.refresh()

    def _fabric(self) -> StitchMesh:
        fabric = self.app.project.evened or self.app.project.fabric
        assert fabric is not None
        return fabric

    def _show_snapshot(self, snapshot: Snapshot[StitchMesh]) -> None:
        self._show_fabric(snapshot.state)

    def _show_fabric(self, fabric: StitchMesh) -> None:
        self._legend.visible = self._choice.visible = fabric.stretch is not None
        self._map.show(fabric, self._state.measure)

    def _verdict_content(self) -> Markup:
        evened = self.app.project.evened
        if evened is None:
            return message(NEXT, "info")
        verdict = evenness_verdict(evened)
        box = verdict_html(verdict, "The stitches are even", "Some rows are uneven; click one to see it", action="rows")
        return unfinished_html(self.app.project) + box

    def _act(self, action: str, value: str) -> None:
        if action == "rows":
            number = int(value)
            self._mark(None if number == self._state.marked else number)

    def _mark(self, number: int | None) -> None:
        """Draw a line around the rows of a finding; None removes the line."""
        self._state = replace(self._state, marked=number)
        evened = self.app.project.evened
        if number is None or evened is None:
            self.app.scene.remove("rows")
            return
        rows = uneven_rows(evened)[number]
        self.app.scene.show("rows", outline(evened, (evened.row >= rows.first) & (evened.row <= rows.last)))


def mesh_relax_options(project: Project) -> MeshRelaxOptions:
    """Return the options of a project; the default ones if the kept ones are not valid."""
    try:
        return MeshRelaxOptions(**project.settings(EvenOutPage.name).get("options", {}))
    except (TypeError, StitchMeshError):  # Another version of the program, or a user, wrote the file.
        return MeshRelaxOptions()


def shown_options(project: Project) -> MeshRelaxOptions:
    """Return the options of a project as the page shows them, with the resulting aspect."""
    options = even_out_options(project).mesh_relax_options
    assert options.aspect is not None
    return replace(options, aspect=round(options.aspect, 3))


def even_out_options(project: Project) -> KnitOptions:
    """Return the options of the mesh relaxation of a project; the default aspect is that of its stitches."""
    options, sizes = KnitOptions(mesh_relaxation=mesh_relax_options(project)), project.division or project.shaping
    if sizes is None:
        return options
    return replace(options, stitch_width=sizes.stitch_width, stitch_height=sizes.stitch_height)


def unfinished_html(project: Project) -> Markup:
    """Return a box that says that the last mesh relaxation has not converged; nothing if it has."""
    kept = project.settings(EvenOutPage.name).get("report")
    if kept is None or kept["converged"]:
        return Markup()
    report = MeshRelaxReport(**kept)
    if report.stopped:
        text = f"You stopped after {report.iterations} iterations, before the stitches were even; start again to go on."
        return message(text, "doubtful")
    return message(not_converged(report), "doubtful")
