# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Take home: the files of a garment under plain names, and all other files under More."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from stitchmesh.app.controls.html_pieces import action_button
from stitchmesh.app.pages.downloads import PATTERN_FILE, STYLE, Export, download_list, exports, send_file
from stitchmesh.app.pages.page import NO_STITCHES, Page
from stitchmesh.app.pages.yarns.yarn_view import GarmentYarnView
from stitchmesh.app.scene.mesh_drawing import draw_plainly
from stitchmesh.errors import DisplayError
from stitchmesh.markup import Markup, joined, markup

if TYPE_CHECKING:
    from stitchmesh.app.application import App

KINDS: tuple[tuple[str, str, tuple[str, ...]], ...] = (
    ("A pattern to knit by hand", "PDF with picture, measures, yarn, charts and instructions", (PATTERN_FILE,)),
    ("Instructions in words", "a text for any program", ("instructions.txt",)),
    ("A program for a knitting machine", "knitout, for V-bed machines", ("stitches.k",)),
    ("Yarns for Blender and film", "USD curves with their thickness and colours", ("relaxed.usda", "yarns.usda")),
    ("Yarns for the web and games", "GLB tubes", ("relaxed.glb", "yarns.glb")),
    ("Stitches for StitchMesh", "HDF5 without loss", ("evened.h5", "stitches.h5")),
)
"""Purpose and description of each kind of file, and its names; the first of these that the project holds is sent."""


class TakeHomePage(Page):
    """Sends the garment as files."""

    name = "Take home"
    needs = "Divide"
    hint = "Choose what you need the garment for; the browser saves the file."

    def __init__(self, app: App) -> None:
        """Make the page; nothing is shown yet."""
        super().__init__(app)
        self._files: list[Export] = []

    def unavailable(self) -> str | None:
        """Return what is missing while there are no stitches to take home."""
        return NO_STITCHES if self.app.project.fabric is None else None

    def build(self) -> None:
        """Make the buttons, and draw the yarns, or the stitches if there are no yarns."""
        controls = self.app.controls
        self._kinds = controls.html(Markup(), self._clicked)
        with controls.group("More", opened=False):
            self._more = controls.html(Markup(), self._clicked)
        self._view = GarmentYarnView(self.app.scene)
        self.refresh()

    def refresh(self) -> None:
        """Show the files that the project holds now."""
        project = self.app.project
        self._files = exports(project)
        shown = [(title, what, _first_held(names, self._files)) for title, what, names in KINDS]
        self._kinds.content = _kinds_html(shown)
        self._more.content = download_list([file for file in self._files if file.name not in {n for _, _, n in shown}])
        yarns, fabric = project.relaxed or project.yarns, project.evened or project.fabric
        assert fabric is not None
        if yarns is None:
            draw_plainly(self.app.scene, fabric)
        else:
            self._view.show(yarns, fabric)
            self._view.look_at_all()

    def _clicked(self, action: str, name: str) -> None:
        files = exports(self.app.project, self._picture()) if name == PATTERN_FILE else self._files
        send_file(self.app, files, name)

    def _picture(self) -> bytes | None:
        """Return the picture in the browser as a PNG; None, with a notice, if no browser draws it."""
        try:
            return self.app.scene.screenshot(*(1600, 1000))
        except DisplayError as error:
            self.app.notice(f"the pattern has no picture: {error}", "warning")
            return None


def _first_held(names: Sequence[str], files: Sequence[Export]) -> str:
    """Return the first of these names that a file has; an empty text if no file has one."""
    held = {file.name for file in files}
    return next((name for name in names if name in held), "")


def _kinds_html(kinds: Sequence[tuple[str, str, str]]) -> Markup:
    """Return a button for each kind; kinds that need yarns are grey before there are yarns."""
    buttons = joined(
        action_button("download", name, _kind_words(title, what, name), disabled=not name, wide=True)
        for title, what, name in kinds
    )
    return markup('{}<div class="sm-project">{}</div>', STYLE, buttons)


def _kind_words(title: str, what: str, name: str) -> Markup:
    return markup("<b>{}</b><br><small>{}</small>", title, what if name else f"{what}: make the yarns first")
