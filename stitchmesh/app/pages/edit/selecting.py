# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The tool that selects stitches, rows, wales and rectangles."""

from __future__ import annotations

import numpy as np

from stitchmesh.app.pages.edit.brush_tool import BrushTool
from stitchmesh.app.pages.edit.edit_session import NO_FACES
from stitchmesh.app.scene.scene import Pick, Stroke
from stitchmesh.errors import StitchMeshError
from stitchmesh.mesh import IntArray


class SelectStitches(BrushTool):
    """Selects what the brush covers; with the control key held, adds to the selection or takes away from it."""

    name, key, brush_label = "Select", "S", "Selects"
    hint = "Click or drag to select; hold ctrl to add or take away; shift+drag selects a rectangle of the screen."

    def take(self, path: list[int], pick: Pick) -> None:
        """Select what the brush covers; with the control key, a click toggles it, and a drag adds it."""
        self.session.view.unmark()
        faces = self.covered(path)
        if pick.modifier != "ctrl":
            self.session.choose(faces)
        elif isinstance(pick, Stroke):
            self.session.choose(np.union1d(self.session.state.selection.faces, faces))
        else:
            self._toggle(faces)

    def preview(self, path: list[int]) -> None:
        """Mark what a drag covers."""
        try:
            faces = self.covered(path)
        except StitchMeshError:
            faces = NO_FACES  # A rectangle that does not exist yet; the end of the drag says so.
        self.session.view.mark_faces(self.session.fabric, faces)

    def _toggle(self, faces: IntArray) -> None:
        """Add faces to the selection; take them away if all of them are selected."""
        selected = self.session.state.selection.faces
        inside = np.isin(faces, selected).all()
        self.session.choose(np.setdiff1d(selected, faces) if inside else np.union1d(selected, faces))
