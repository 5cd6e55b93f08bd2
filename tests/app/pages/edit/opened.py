# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Edit without a browser, on a fabric of a test."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from stitchmesh.app.pages.edit.edit_page import EditPage
from stitchmesh.app.project.project import Project
from stitchmesh.app.scene.scene import Modifier, Stroke
from stitchmesh.editing.edit import Edit, apply_edit
from stitchmesh.errors import StitchMeshError
from stitchmesh.io import write_stitches
from stitchmesh.mesh import StitchMesh
from tests.app.pages.headless import Headless, face_middle, on_project
from tests.editing.fabrics import flat
from tests.editing.random_edits import bits

WIDE = flat(10, 12)
"""A flat piece of knit stitches; faces are numbered row * 10 + column."""


class OpenedEdit(Headless):
    """The page Edit."""

    @property
    def fabric(self) -> StitchMesh:
        """The fabric of the project."""
        assert self.project.fabric is not None
        return self.project.fabric

    @property
    def page(self) -> EditPage:
        """The page."""
        assert isinstance(self.app.page, EditPage)
        return self.app.page

    @property
    def selected(self) -> list[int]:
        """The selected faces."""
        return self.page.session.state.selection.faces.tolist()

    def click_stitch(self, face: int, modifier: Modifier = "") -> None:
        """Click at the middle of a face, from outside."""
        self.click(face_middle(self.fabric, face), -self._normal(face), modifier)

    def click_edge(self, side: int, modifier: Modifier = "") -> None:
        """Click at a face just beside the middle of one of its sides."""
        fabric = self.fabric
        face = int(fabric.side_face[side])
        middle = (fabric.corner_position[side] + fabric.corner_position[fabric.side_next[side]]) / 2
        self.click(0.9 * middle + 0.1 * face_middle(fabric, face), -self._normal(face), modifier)

    def drag(self, faces: Sequence[int], modifier: Modifier = "") -> None:
        """Drag from the middle of a face over those of others."""
        try:
            for phase, face in zip(["start", *["move"] * (len(faces) - 1), "end"], [*faces, faces[-1]], strict=True):
                towards = -self._normal(face)
                origin = face_middle(self.fabric, face) - 100.0 * towards
                self.page.stroked(Stroke(origin, towards, modifier, 0, phase))
        except StitchMeshError as error:
            self.app.report(error)

    def act(self, action: str, value: str = "") -> None:
        """Click an element of HTML, in either panel; an error becomes a notice, as in the browser."""
        held = [panel for panel in (self.front.controls, self.front.left_controls) if _holds(panel, action, value)]
        self.run(lambda: held[0].act(action, value))

    def press(self, label: str, option: str | None = None) -> None:
        """Press a button; an error becomes a notice, as in the browser."""
        self.run(lambda: self.front.controls.press(label, option))

    def run(self, call: object) -> None:
        """Make a call; an error of the library becomes a notice, as in the browser."""
        assert callable(call)
        try:
            call()
        except StitchMeshError as error:
            self.app.report(error)

    def _normal(self, face: int) -> np.ndarray:
        return self.fabric.face_vector_area[face] / np.linalg.norm(self.fabric.face_vector_area[face])


def _holds(panel: object, action: str, value: str) -> bool:
    texts = [control.content for control in panel.made]  # type: ignore[attr-defined]
    return any(f'data-action="{action}"' in text and f'data-value="{value}"' in text for text in texts)


def same_as(page: OpenedEdit, *edits: Edit, start: StitchMesh = WIDE) -> bool:
    """Whether the fabric of the page is that of the edits."""
    for edit in edits:
        start = apply_edit(start, edit).fabric
    return bits(page.fabric) == bits(start)


@contextmanager
def edit_page(folder: Path, fabric: StitchMesh) -> Iterator[OpenedEdit]:
    """Open the page Edit on a fabric."""
    project = Project.create(folder / "project")
    write_stitches(folder / "fabric.h5", fabric)
    project.import_mesh("fabric.h5", (folder / "fabric.h5").read_bytes())
    with on_project(project, "Edit") as opened:
        yield OpenedEdit(opened.app, opened.front)
