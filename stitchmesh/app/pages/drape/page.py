# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Drape: the user opens a scene, chooses or paints its region of yarns, runs it and watches the run."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

from stitchmesh.app.controls.field_panel import Field, FieldPanel, Number, Words, same_words, setting_field
from stitchmesh.app.controls.html_pieces import figures, message
from stitchmesh.app.pages.drape.cloth_drawing import COLOURS, ClothColour, ClothDrawing, legend_of
from stitchmesh.app.pages.drape.drape_session import DrapeSession
from stitchmesh.app.pages.drape.files_panel import FilesPanel
from stitchmesh.app.pages.drape.loads_panel import BodiesPanel, HeldPanel
from stitchmesh.app.pages.drape.opened_scene import OpenedScene
from stitchmesh.app.pages.drape.paint_tool import PaintTool
from stitchmesh.app.pages.drape.region_panel import RegionPanel
from stitchmesh.app.pages.drape.scene_run import SceneRun
from stitchmesh.app.pages.page import Page
from stitchmesh.app.pages.page_run import AnyRun, PageRun, progress_words
from stitchmesh.app.pages.view.draped_view import LARGE, WORDS, DrapedSketch, DrapedView, FramePanel
from stitchmesh.app.pages.view.state import DRAPED_COLOURS
from stitchmesh.app.pages.view.view_html import legend_of as legend_of_colours
from stitchmesh.app.pages.view.view_html import report_html
from stitchmesh.app.project.project import Project
from stitchmesh.app.scene.scene import Pick, ScreenBox, Stroke
from stitchmesh.compute.device import device_names
from stitchmesh.io.toml_file import read_table
from stitchmesh.markup import Markup
from stitchmesh.mixed.crossings.crossing_material import DEFAULT, CrossingMaterial
from stitchmesh.mixed.drape import Draped
from stitchmesh.mixed.scene.scene import MATCHED, ClothSection, Scene, SceneSolverSection, YarnsSection
from stitchmesh.mixed.scene.scene_fabric import STITCHES
from stitchmesh.mixed.triangles.material_file import material_names
from stitchmesh.reporting.figures import duration
from stitchmesh.run_control import Snapshot

if TYPE_CHECKING:
    from stitchmesh.app.application import App

MODES = {"comes to rest": "static", "moves": "dynamic"}
"""The two modes of a scene, by the words of the page."""
DENSITY = Number(0.1, 1000.0, 0.5)
"""Yarns or stitches for each cm."""


def yarn_materials(scene: Scene) -> Words:
    """Return the materials that the yarns of a scene can have; a scene without a named material has the default."""
    file = scene.yarns.material_file
    names = CrossingMaterial.names() if file is None else tuple(read_table(file))
    return {name: None if name == DEFAULT and scene.yarns.material is None else name for name in names}


def is_weave(scene: Scene) -> bool:
    """Return whether the yarns of a scene are a weave."""
    return scene.yarns.weave is not None


def is_knit(scene: Scene) -> bool:
    """Return whether the yarns of a scene are stitches of their own, and not the stitches of the cloth."""
    return scene.yarns.weave is None and scene.yarns.knit != STITCHES


def has_loops(scene: Scene) -> bool:
    """Return whether the yarns of a scene follow stitches of the cloth, as crossings."""
    return scene.yarns.knit == STITCHES and scene.yarns.model == "crossings"


SCENE_FIELDS = (
    setting_field(Scene, "mode", "The cloth", MODES),
    setting_field(Scene, "duration", "Time", Number(1e-4, 3600.0, 0.05)),
    setting_field(YarnsSection, "material", "Yarn", yarn_materials, at="yarns.material"),
    setting_field(ClothSection, "material", "Cloth",
                  {"from the yarns": None, **same_words((MATCHED, *material_names()))}, at="cloth.material"),
    setting_field(YarnsSection, "ends", "Warps per cm", DENSITY, at="yarns.ends", shown=is_weave),
    setting_field(YarnsSection, "picks", "Wefts per cm", DENSITY, at="yarns.picks", shown=is_weave),
    setting_field(YarnsSection, "wales", "Wales per cm", DENSITY, at="yarns.wales", shown=is_knit),
    setting_field(YarnsSection, "courses", "Courses per cm", DENSITY, at="yarns.courses", shown=is_knit),
    setting_field(YarnsSection, "divisions", "Loops per stitch", Number(1, 20, 1), at="yarns.divisions",
                  shown=has_loops),
    setting_field(SceneSolverSection, "precision", "Precision", same_words(("float64", "float32")),
                  at="solver.precision"),
    setting_field(SceneSolverSection, "device", "Device",
                  lambda scene: {"automatic": None, **same_words(device_names())}, at="solver.device"),
)  # fmt: skip
"""The fields of a scene that the page shows."""


NO_SCENE = "There is no scene yet. Open a scene file, or a cloth: panels, a mesh or stitches."


def no_scene_html(project: Project) -> Markup:
    """Return what the user can open while there is no scene, such as the garment of the project."""
    if project.fabric is not None:
        return message(f"{NO_SCENE} The stitches of the garment of this project are a cloth too.", "info")
    if project.mesh is not None:
        return message(f"{NO_SCENE} The garment of this project is a cloth once it is divided into stitches.", "info")
    return message(NO_SCENE, "info")


def counts_html(opened: OpenedScene) -> Markup:
    """Return the numbers of nodes and vertices of a scene, and the memory that it needs."""
    counts, free = opened.counts, opened.free_memory()
    rows = [
        ("Yarn nodes, simulated", f"{counts['yarn_nodes_full']:,}"),
        ("Yarn nodes, hybrid", f"{counts['yarn_nodes_hybrid']:,}"),
        ("Yarn nodes, all", f"{counts['yarn_nodes']:,} of {counts['yarns']:,} yarns"),
        ("Vertices, triangles only", f"{counts['vertices_triangle_only']:,}"),
        ("Vertices, hybrid", f"{counts['vertices_hybrid']:,}"),
        ("Triangles", f"{counts['triangles']:,}"),
        ("Memory, about", f"{1e-6 * opened.memory:,.0f} of {1e-6 * free:,.0f} MB that are free"),
    ]
    trouble = message(opened.trouble, "doubtful") if opened.trouble else Markup()
    if not trouble and opened.memory > free:
        trouble = message("The run needs more memory than is free; make the region smaller.", "doubtful")
    if not trouble and opened.scene.region.yarns == "automatic":
        trouble = message("The region is found at the start of the run, or now by the button below.", "info")
    return figures(rows) + trouble


def run_words(run: AnyRun) -> str:
    """Return the progress of a run in words."""
    if run.newest is None:
        return f"Running: {run.task.stage}, {100 * run.task.done:.0f} %." if run.task.stage else "Preparing."
    now = run.newest
    static = now.state.prepared.scene.mode == "static"
    work = _counted(now.iteration, *(("iteration", "iterations") if static else ("step", "steps")))
    return progress_words(run, f"{now.state.end.time:.4g} s of the scene, {work}")


def end_html(draped: Draped | None, *, current: bool) -> Markup:
    """Return how a run ended, of the current scene or of an earlier one; an empty text without a run."""
    mixed = {} if draped is None else draped.report.get("mixed", {})
    if not mixed:
        return Markup()
    if not current:
        return message("The scene has changed since the run, which shows it as it was.", "info")
    unit = "dyn" if mixed["mode"] == "static" else "cm/s"
    names = ("equilibrium", "equilibria") if mixed["mode"] == "static" else ("step", "steps")
    if mixed["converged"]:
        work = _counted(mixed["steps"], *names)
        return message(f"The run has converged: {work}, {duration(mixed['seconds'])}.", "good")
    return message(f"The run was stopped or has not converged: the error is {mixed['error']:.2g} {unit}.", "doubtful")


def _counted(count: int, one: str, many: str) -> str:
    return f"{count:,} {one if count == 1 else many}"


RUN, RUN_AGAIN, CONTINUE = "Run the scene", "Run from the start again", "Continue the run"
"""Labels of the buttons that start a run."""
SCENE, RESULT = "Scene", "Run"
"""The choices of what the page shows."""


@dataclass(frozen=True)
class DrapeState:
    """What the page shows: scene or run, and their colours."""

    shows: str = SCENE
    """Whether the scene or the run is shown."""
    colour: ClothColour = COLOURS[0]
    """What the colours of the scene show."""
    run_colour: str = next(iter(DRAPED_COLOURS))
    """What the colours of the run show, a word of ``DRAPED_COLOURS``."""


class DrapePage(Page):
    """Scenes of mixed yarns and triangles."""

    name: ClassVar[str] = "Drape"
    hint: ClassVar[str] = "Open a scene or a cloth, choose where yarns are simulated, and run it."

    def __init__(self, app: App) -> None:
        """Make the page; nothing is open yet."""
        super().__init__(app)
        self.session = DrapeSession(app, self._changed)
        self.run = SceneRun(self.session, PageRun(self, self._show_snapshot, self._refresh_if_open))
        self._drawing = ClothDrawing(app.scene)
        self._paint = PaintTool(self.session, self._drawing)
        self._state = DrapeState()
        self._view: DrapedView | None = None
        self._sketch: DrapedSketch | None = None
        self._is_built = self._was_empty = False

    def build(self) -> None:
        """Make the controls, and draw."""
        controls, session = self.app.controls, self.session
        self._counts = controls.html(Markup())
        self._end = controls.html(Markup())
        self._continue = controls.button(CONTINUE, "Go on where the run was stopped.", self.resume, main=True)
        self._start = controls.button(RUN, "Simulate yarns in the region, and triangles elsewhere.", self.start,
                                      main=True)  # fmt: skip
        self.run.of_page.build("a time step, or an iteration of an equilibrium", run_words)
        self._make_look()
        self._files = FilesPanel(session, controls, lambda: self.run.result)
        self._region = RegionPanel(session, self._drawing, self._paint, controls, self.run.find_region)
        self._held = HeldPanel(session, controls)
        self._paint.hold = self._held.paint
        self._bodies = BodiesPanel(session, controls)
        self._scene_panel = FieldPanel(
            controls, SCENE_FIELDS, lambda: session.scene, lambda scene, name: session.change(scene), group="Scene",
            opened=False,
        )  # fmt: skip
        self._files.build_save(controls)
        self._report = controls.html(Markup())
        self._is_built, self._was_empty = True, session.opened is None
        self._drawing.clear()
        self._view = self._sketch = None
        session.open_kept()
        self.run.read_result()
        self.refresh()
        self._drawing.look()

    def leave(self) -> None:
        """Let the run continue unseen."""
        self.run.of_page.leave()
        self._is_built = False

    def refresh(self) -> None:
        """Show the scene or the run, and the possible actions."""
        opened, live = self.session.opened, self.run.live
        self._counts.content = no_scene_html(self.app.project) if opened is None else counts_html(opened)
        self._end.content = Markup() if live is not None else end_html(self.run.result, current=self.run.is_current)
        self.run.of_page.refresh()
        can_continue, idle = self.run.can_continue, live is None and opened is not None
        self._start.label = RUN_AGAIN if can_continue or self.run.result is not None else RUN
        self._start.visible, self._continue.visible = idle, idle and can_continue
        self._region.refresh()
        self._held.refresh()
        self._bodies.refresh()
        self._scene_panel.show()
        self._files.refresh()
        self._draw()

    def start(self) -> None:
        """Run the scene from its start."""
        self._begin(resume=False)

    def resume(self) -> None:
        """Continue the stopped run."""
        self._begin(resume=True)

    def picked(self, pick: Pick) -> None:
        """Paint at a click, or describe the place of the run there."""
        if self._state.shows == SCENE:
            self._paint.clicked(pick)

    def stroked(self, stroke: Stroke) -> None:
        """Paint along a drag."""
        if self._state.shows == SCENE:
            self._paint.stroked(stroke)

    def boxed(self, box: ScreenBox) -> None:
        """Paint a rectangle of the screen."""
        if self._state.shows == SCENE:
            self._paint.boxed(box)

    def _make_look(self) -> None:
        controls = self.app.controls
        self._look = FieldPanel(
            controls, self._look_fields(), lambda: self._state, lambda state, name: self._show(state)
        )
        self._frames = FramePanel(controls, self._frame_chosen)
        self._legend = controls.html(Markup())
        self._follow = controls.button("Look on the page View", "The run with all tools of that page.", self._to_view)

    def _look_fields(self) -> tuple[Field, ...]:
        return (
            Field("shows", "Show", "The scene at its start, or the run.", same_words((SCENE, RESULT)),
                  lambda state: self._has_run()),
            Field("colour", "Colours", "What is simulated where, or the weight of the yarns.", same_words(COLOURS),
                  lambda state: not self._shows_run() and self.session.opened is not None),
            Field("run_colour", "Colour the run by", "What decides the colours of yarns and triangles.",
                  same_words(tuple(DRAPED_COLOURS)), lambda state: self._shows_run()),
        )  # fmt: skip

    def _has_run(self) -> bool:
        return self.run.live is not None or self.run.result is not None

    def _shows_run(self) -> bool:
        return self._state.shows == RESULT and self._has_run()

    def _begin(self, *, resume: bool) -> None:
        self.run.start(resume=resume)
        self._state = replace(self._state, shows=RESULT)
        self._view = None
        self.refresh()

    def _changed(self) -> None:
        """Show an opened or changed scene; the first scene folds the group Open."""
        if self._is_built and self._was_empty and self.session.opened is not None:
            self.app.open_page(self.name)
        elif self._is_built:
            self.refresh()
            self._drawing.look()

    def _refresh_if_open(self) -> None:
        if self._is_built:
            self.refresh()

    def _newest(self) -> Draped | None:
        """The visible state of the run: the newest state of a present run, or the result of the last one."""
        live = self.run.live
        if live is not None:
            return None if live.newest is None else live.newest.state
        return self.run.result

    def _draw(self) -> None:
        draped, opened = self._newest(), self.session.opened
        shows_run = self._shows_run()
        self._look.show()
        self._follow.visible = self._has_run()
        self._report.content = Markup()
        if shows_run and draped is not None:
            self._draw_run(draped)
            return
        self._frames.show(None)
        self._end_sketch()
        if self._view is not None:
            self._view.clear(self.app.scene)
            self._view = None
        if opened is not None:
            self._drawing.show(opened, self._state.colour, takes_strokes=self._paint.paints and not shows_run)
            self._legend.content = legend_of(opened, self._state.colour)

    def _draw_run(self, draped: Draped) -> None:
        self._drawing.clear()
        if self._is_sketched(draped):
            self._draw_sketch(draped)
            return
        first = self._view is None and self._sketch is None
        self._end_sketch()
        self._view = self._frames.view(draped, self._view)
        word = DRAPED_COLOURS[self._state.run_colour] or "#c9b89a"
        coloured = self._view.coloured(word, None, None)
        self._view.draw(self.app.scene, coloured.points, None)
        self._legend.content = legend_of_colours(coloured)
        self._report.content = figures(self._view.figures(), "Frame") + report_html(draped.report)
        if first:
            self.app.scene.look_at(*self._view.bounds())

    def _is_sketched(self, draped: Draped) -> bool:
        """Return whether a run is so large that the page only sketches it while it runs."""
        live = self.run.live
        return live is not None and not live.paused and draped.prepared.fabric.yarns.node_count > LARGE

    def _draw_sketch(self, draped: Draped) -> None:
        """Draw the newest state of a large present run."""
        first = self._view is None and self._sketch is None
        if self._view is not None:
            self._view.clear(self.app.scene)
            self._view = None
        self._sketch = DrapedSketch(draped, self._sketch)
        self._sketch.draw(self.app.scene, alpha=DRAPED_COLOURS[self._state.run_colour] == "alpha")
        self._frames.show(None)
        self._legend.content = message(WORDS, "info")
        if first:
            self.app.scene.look_at(*self._sketch.bounds())

    def _end_sketch(self) -> None:
        if self._sketch is not None:
            self._sketch.clear(self.app.scene)
            self._sketch = None

    def _show_snapshot(self, snapshot: Snapshot[Draped]) -> None:
        if self._state.shows == RESULT:
            self._draw()

    def _frame_chosen(self) -> None:
        self.app.queue.post_newest((id(self), "frame"), self._draw_if_open)

    def _draw_if_open(self) -> None:
        if self._is_built:
            self._draw()

    def _show(self, state: DrapeState) -> None:
        self._state = state
        self._draw()

    def _to_view(self) -> None:
        """Open the run on the page View, which follows it."""
        from stitchmesh.app.pages.view.page import ViewPage

        folder = self.session.run_folder
        self.app.open_page(ViewPage.name)
        assert isinstance(self.app.page, ViewPage)
        self.app.page.show_path(str(folder))
