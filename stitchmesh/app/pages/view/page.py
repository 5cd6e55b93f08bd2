# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page View: results, files and running jobs, in colours that show their state."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stitchmesh.app.controls.field_panel import FieldPanel
from stitchmesh.app.controls.html_pieces import figures, status_line
from stitchmesh.app.pages.page import Page
from stitchmesh.app.pages.view.draped_view import DrapedView, FramePanel
from stitchmesh.app.pages.view.opened import SUFFIXES, Opened, Thing, Viewed, project_results, read_upload
from stitchmesh.app.pages.view.state import COLOUR_FIELDS, ONE_COLOUR, Measurement, ViewState
from stitchmesh.app.pages.view.thing_view import SIDES, ClipBox, MeshView, Place, ThingView, YarnView, box_of_shares
from stitchmesh.app.pages.view.view_html import (
    FRAMES,
    job_html,
    legend_of,
    list_of_results,
    report_html,
    shown_in_panel,
)
from stitchmesh.app.pages.yarns.energy_plot import history_plot
from stitchmesh.app.scene.mesh_drawing import BODY_COLOUR, plain_surface
from stitchmesh.app.scene.scene import Pick, ViewName
from stitchmesh.errors import ParameterError, StitchMeshError
from stitchmesh.markup import Markup, markup
from stitchmesh.mesh import Mesh
from stitchmesh.mixed.drape import Draped
from stitchmesh.render.colouring import Coloured
from stitchmesh.yarn import YarnSet

if TYPE_CHECKING:
    from stitchmesh.app.application import App
    from stitchmesh.app.task import TaskControl

OPENED = "Opened file"
"""Entry of the list for the opened file or folder."""
VIEWS: tuple[ViewName, ...] = ("front", "back", "left", "right", "top")
MOST_STITCHES = 99_999_999
"""Largest number of a stitch that a user can type."""
COLOURING = "finding the colours"
"""Name of the task that computes colours."""
BODY = "viewed body"
"""Name of the drawing of the body."""
BOX = "clip box"
"""Name of the drawing of the box."""


class ViewPage(Page):
    """Shows things and changes nothing."""

    name = "View"
    hint = "Choose what to see, or open a file. Click it to read what is there."

    def __init__(self, app: App) -> None:
        """Make the page, and open again what was opened last."""
        super().__init__(app)
        self._state = ViewState.of_table(app.project.settings(self.name))
        self._viewed: Viewed | None = None
        self._view: ThingView | None = None
        self._coloured: Coloured | None = None
        self._opened = Opened(app.post, self._job_changed)

    def build(self) -> None:
        """Make the controls, and draw."""
        self._make_sources()
        self._make_colours()
        self._make_tools()
        self._attempt(self._opened.follow_again)
        if self._state.path and self._opened.viewed is None:
            shown = self._state.show or OPENED
            self._attempt(lambda: self.open_path(self._state.path))
            self._keep(show=shown)
        self._look_again = True
        self.refresh()

    def refresh(self) -> None:
        """Show the newest state of the chosen thing."""
        found = self._sources()
        chosen = self._state.show if self._state.show in found else next(iter(found), "")
        self._list.content = list_of_results(tuple(found), chosen)
        self._show(found.get(chosen))

    def leave(self) -> None:
        """End the watch of a folder while another page is open."""
        self._opened.pause()

    def picked(self, pick: Pick) -> None:
        """Describe the clicked place, or take it as a place to measure."""
        if self._view is None or self._viewed is None:
            return
        place = self._view.pick(pick.ray_origin, pick.ray_direction, self._viewed.fabric)
        if place is None:
            return
        if self._measures.value:
            self._measure_between(self._state.measurement.with_place(place))
        else:
            self._say(place.text)

    def open_path(self, text: str) -> None:
        """Open a file, or the output folder of a job.

        Raises:
            StitchMeshError: the file or the folder cannot be read.
        """
        path = Path(text).expanduser()
        self._opened.open_path(path)
        self._keep(show=OPENED, path=str(path.absolute()))
        self._path.value = str(path.absolute())

    def show_path(self, text: str) -> None:
        """Open a file or a folder, and show it.

        Raises:
            StitchMeshError: the file or the folder cannot be read.
        """
        self.open_path(text)
        self._look_again = True
        self.refresh()

    # ---- controls ----------------------------------------------------------------------------------------------------

    def _make_sources(self) -> None:
        controls = self.app.controls
        self._list = controls.html(Markup(), lambda _, name: self._chosen(name))
        with controls.group("Open", opened=not self._sources()):
            controls.upload("Open a file", "Open a file that StitchMesh wrote, or any mesh.", SUFFIXES, self._uploaded)
            self._path = controls.text(
                "Path", "A file, or the output folder of a job that runs, on the computer of StitchMesh.",
                self._state.path,
            )  # fmt: skip
            controls.button("Open path", "Open the file, or follow the job in the folder.", self._open_typed)
            controls.upload(
                "Open a body", "Open the mesh of a body, from which distances are measured.", SUFFIXES,
                self._body_received,
            )  # fmt: skip
        self._job = controls.html(Markup())
        self._picture = controls.html(Markup())

    def _make_colours(self) -> None:
        controls, state = self.app.controls, self._state
        fields = [
            replace(field, shown=partial(self._is_shown, kind)) for kind, field in COLOUR_FIELDS.items()
        ]
        self._colours = FieldPanel(
            controls, fields, lambda: self._state, lambda state, name: self._recolour(**{name: getattr(state, name)})
        )
        self._one_colour = controls.colour(
            "Colour", "The colour of everything.", state.one_colour, lambda word: self._recolour(one_colour=word)
        )
        self._frame_panel = FramePanel(controls, self._frame_chosen)
        self._legend = controls.html(Markup())
        self._status = controls.html(Markup())

    def _make_tools(self) -> None:
        controls, state = self.app.controls, self._state
        controls.buttons("Side", "The side from which the camera looks.", [v.capitalize() for v in VIEWS], self._turn)
        self._measures = controls.toggle(
            "Measure", "Click two places: their distance, and the length of yarn between them.", False, self._measure
        )
        with controls.group("Clip box", opened=False):
            self._clips = controls.toggle("Clip", "Show only what lies in a box.", False, lambda _: self._draw())
            for side, (_, far) in SIDES.items():
                controls.slider(
                    side, f"Where the box ends at this side ({side.lower()}), in percent.", state.shares.get(side, far),
                    self._share_of(side), least=0.0, most=100.0, step=1.0,
                )  # fmt: skip
        with controls.group("Without the mouse", opened=False):
            self._numbers = [
                controls.number(label, hint, 0, least=0, most=MOST_STITCHES, step=1)
                for label, hint in (("Stitch", "Number of a stitch, or of a face of a mesh."),
                                    ("Other stitch", "Number of the stitch up to which is measured."))
            ]  # fmt: skip
            controls.button("Describe", "Say what the stitch is.", self._describe_stitch)
            controls.button("Measure between them", "Measure from one stitch to the other.", self._measure_stitches)
        with controls.group("Picture", opened=False):
            self._picture_size = [
                controls.number(
                    label, f"{label} of the picture [pixels].", start, least=64, most=4096, step=1
                )
                for label, start in (("Width", 1600), ("Height", 1000))
            ]  # fmt: skip
            controls.button("Save picture", "Save what the scene shows as a PNG file.", self._save_picture)
        controls.toggle("Frame rate", "Show how fluently this browser draws.", False, self._show_frames)
        self._frames = controls.html(FRAMES)
        self._frames.visible = False
        self._report = controls.html(Markup())
        self._plot = controls.plot(None, aspect=1.15)

    # ---- what is shown -----------------------------------------------------------------------------------------------

    def _sources(self) -> dict[str, Viewed]:
        """Return the things that the page can show, by their names in the list."""
        opened = self._opened.viewed
        return ({} if opened is None else {OPENED: opened}) | project_results(self.app.project)

    def _show(self, viewed: Viewed | None) -> None:
        """Show another thing, or another state of the same one."""
        changed = viewed is None or self._viewed is None or viewed.thing is not self._viewed.thing
        self._viewed = viewed
        if viewed is None or viewed.thing is None:
            self._view, self._coloured = None, None
            self.app.scene.clear()
            self._frame_panel.show(None)
        elif changed or self._view is None:
            self._view = self._view_of(viewed.thing)
            if self._coloured is not None and len(self._coloured.points) != self._view.coloured_count:
                self._coloured = None
            if not isinstance(viewed.thing, YarnSet):
                self._state = replace(self._state, measurement=Measurement())
        self._show_controls()
        self._describe()
        self._colour()
        if self._look_again and self._view is not None:
            self._look_again = False
            self._turn("front")

    def _view_of(self, thing: Thing) -> ThingView:
        """Return the view of a thing; the view of an earlier state of the same thing saves work."""
        before = self._view
        if isinstance(thing, Draped):
            if not isinstance(before, DrapedView):
                self.app.scene.clear()
            return self._frame_panel.view(thing, before)
        self._frame_panel.show(None)
        if isinstance(before, DrapedView):
            before.clear(self.app.scene)
        return YarnView(thing, before) if isinstance(thing, YarnSet) else MeshView(thing)

    def _frame_chosen(self) -> None:
        """Show the chosen frame; of several choices, only the newest counts."""
        self.app.queue.post_newest((id(self), "frame"), self._show_frame)

    def _show_frame(self) -> None:
        thing = None if self._viewed is None else self._viewed.thing
        if self.app.page is self and isinstance(thing, Draped):
            self._view = self._frame_panel.view(thing, self._view)
            self._describe()
            self._colour()

    def _show_controls(self) -> None:
        thing = None if self._viewed is None else self._viewed.thing
        self._colours.show()
        self._one_colour.visible = thing is not None and self._colour_word().startswith("#")

    def _is_shown(self, kind: type, state: ViewState) -> bool:
        return self._viewed is not None and isinstance(self._viewed.thing, kind)

    def _describe(self) -> None:
        viewed = self._viewed
        rows = [] if self._view is None else self._view.figures()
        title = "" if viewed is None else viewed.name
        self._facts = figures(rows, title) if rows else markup("<strong>{}</strong>", title)
        self._say("" if viewed is None or self._view is None else viewed.text)
        self._job.content = Markup() if viewed is None else job_html(viewed.job)
        self._picture.content = Markup() if viewed is None else shown_in_panel(viewed)
        report = viewed.thing.report if viewed is not None and isinstance(viewed.thing, Draped) else {}
        self._report.content = report_html(report)
        self._plot.figure = history_plot(viewed.history, None) if viewed is not None and viewed.history else None

    def _say(self, text: str) -> None:
        self._status.content = self._facts + status_line(text)

    def _colour(self) -> None:
        """Find the colours, at once or as a task, and draw."""
        if self._view is None or self._viewed is None:
            self._legend.content = Markup()
            return
        view, word, fabric, body = self._view, self._colour_word(), self._viewed.fabric, self._state.body
        if not view.is_slow(word):
            self._attempt(lambda: self._take_colours(view, view.coloured(word, fabric, body)))
            return
        self._draw()
        if self._is_colouring():
            return  # The colours of this state follow after those of the earlier one.

        def work(control: TaskControl) -> Coloured:
            control.progress("colours", 0.0, "")
            return view.coloured(word, fabric, body)

        self._attempt(lambda: self.app.tasks.start(COLOURING, work, lambda found: self._take_colours(view, found)))

    def _is_colouring(self) -> bool:
        return self.app.tasks.current is not None and self.app.tasks.current.name == COLOURING

    def _take_colours(self, view: ThingView, coloured: Coloured) -> None:
        if self.app.page is not self:
            return
        if view is not self._view:
            self._colour()  # The page shows something else by now.
            return
        if self._coloured is not None and np.array_equal(self._coloured.points, coloured.points):
            coloured = replace(coloured, points=self._coloured.points)  # The same array is not sent again.
        self._coloured = coloured
        self._legend.content = legend_of(coloured)
        self._draw()

    def _draw(self) -> None:
        """Draw the thing and its marks, in its last colours until new ones are found."""
        if self._view is None or self.app.page is not self:
            return
        colours = self._plain_colours() if self._coloured is None else self._coloured.points
        box = self._box()
        self._view.draw(self.app.scene, colours, box)
        self.app.scene.show(BOX, None if box is None else box.edges())
        self._draw_body()
        self._draw_measurement()

    def _draw_body(self) -> None:
        body = self._state.body
        if body is None or self._colour_word() != "body-distance":
            self.app.scene.remove(BODY)
            return
        self.app.scene.show(BODY, plain_surface(body, BODY_COLOUR, flat=False, opacity=0.6))

    def _plain_colours(self) -> NDArray[np.uint8]:
        """Return one colour for everything, for the time until the colours are found."""
        assert self._view is not None
        return self._view.coloured(ONE_COLOUR, None, None).points

    def _colour_word(self) -> str:
        return self._state.colour_word(None if self._viewed is None else self._viewed.thing)

    # ---- what the user does ------------------------------------------------------------------------------------------

    def _chosen(self, name: str) -> None:
        self._keep(show=name, measurement=Measurement())
        self._look_again = True
        self.refresh()

    def _open_typed(self) -> None:
        text = str(self._path.value).strip()
        if not text:
            raise ParameterError("path: got nothing; expected a file, or the output folder of a job")
        self.show_path(text)

    def _uploaded(self, name: str, content: bytes) -> None:
        self._opened.receive(name, content)
        self._keep(show=OPENED, path="")
        self._look_again = True
        self.refresh()

    def _body_received(self, name: str, content: bytes) -> None:
        thing = read_upload(name, content).thing
        if not isinstance(thing, Mesh):
            raise ParameterError(f"{name}: holds no mesh; expected the mesh of a body")
        self._state = replace(self._state, body=thing)
        self._colour()

    def _job_changed(self) -> None:
        """Show the newest state of the followed job; often only its status is newer."""
        before, now = self._viewed, self._opened.viewed
        if self.app.page is not self:
            return
        if before is not None and now is not None and before.thing is now.thing and before.history is now.history:
            self._viewed = now
            self._job.content = job_html(now.job)
        else:
            self.refresh()

    def _recolour(self, **words: str) -> None:
        self._keep(**words)
        self._show_controls()
        self._colour()

    def _turn(self, side: str) -> None:
        view = next(one for one in VIEWS if one == side.lower())
        if self._view is not None:
            self.app.scene.look_at(*self._view.bounds(), view)

    def _save_picture(self) -> None:
        width, height = (int(control.value) for control in self._picture_size)
        self.app.download("view.png", self.app.scene.screenshot(width, height))

    def _measure(self, on: bool) -> None:
        self._measure_between(Measurement())
        if not on:
            self._say("")

    def _measure_between(self, measurement: Measurement) -> None:
        self._state = replace(self._state, measurement=measurement)
        self._draw_measurement()

    def _draw_measurement(self) -> None:
        self._state.measurement.draw(self.app.scene)
        if self._measures.value:
            self._say(self._state.measurement.text(None if self._viewed is None else self._viewed.thing))

    def _describe_stitch(self) -> None:
        self._say(self._stitch(int(self._numbers[0].value)).text)

    def _measure_stitches(self) -> None:
        first, second = (self._stitch(int(control.value)) for control in self._numbers)
        self._measures.value = True
        self._measure_between(Measurement((first, second)))

    def _stitch(self, number: int) -> Place:
        place = None
        if self._view is not None and self._viewed is not None:
            place = self._view.stitch(number, self._viewed.fabric)
        if place is None:
            raise ParameterError(f"stitch: there is no stitch {number} in what is shown; give another number")
        return place

    def _share_of(self, side: str) -> Callable[[float], None]:
        def changed(share: float) -> None:
            self._state = replace(self._state, shares={**self._state.shares, side: share})
            if self._clips.value:
                self.app.queue.post_newest((id(self), "clip"), self._draw)

        return changed

    def _box(self) -> ClipBox | None:
        if not self._clips.value or self._view is None:
            return None
        return box_of_shares(*self._view.bounds(), self._state.shares)

    def _show_frames(self, on: bool) -> None:
        self._frames.visible = on

    # ---- help --------------------------------------------------------------------------------------------------------

    def _attempt(self, act: Callable[[], object]) -> None:
        """Do something; an error becomes a notice, and the page stays as it is."""
        try:
            act()
        except StitchMeshError as error:
            self.app.report(error)

    def _keep(self, **values: Any) -> None:
        self._state = replace(self._state, **values)
        self.app.project.set_settings(self.name, self._state.table)
