# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The content of a page that needs another step first: the garment so far, and a button that opens that step."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stitchmesh.app.scene.drawing import Lines
from stitchmesh.app.scene.mesh_drawing import plain_surface
from stitchmesh.app.scene.scene import DrawingScene
from stitchmesh.mesh import Mesh

if TYPE_CHECKING:
    from stitchmesh.app.application import App
    from stitchmesh.app.pages.all_pages import MakePage
    from stitchmesh.app.pages.page import Page

NO_MESH = "There is no mesh yet. Open the page Project and import one, or choose an example."
NO_STITCHES = "There are no stitches yet. Divide the labeled mesh into stitches first, on the page Divide."
HAS_STITCHES = "The imported file holds stitches already. Go on with Edit."
"""The reason why pages that work on a mesh are not available."""
GARMENT, EDGES = "garment", "edges"
"""Names of the drawings of a plain garment."""


def show_not_yet(app: App, page: Page, pages: dict[str, MakePage]) -> None:
    """Draw the garment, and make the button that opens the page of the next step."""
    name = page_needed(app, page, pages)
    app.controls.button(f"Go to {name}", f"Opens the page {name}.", lambda: app.open_page(name), main=True)
    mesh = app.project.evened or app.project.fabric or app.project.mesh
    if mesh is not None:
        draw_plainly(app.scene, mesh)


def page_needed(app: App, page: Page, pages: dict[str, MakePage]) -> str:
    """Return the nearest available page that makes what a page needs."""
    if app.project.mesh is None and app.project.fabric is not None:
        return "Edit"  # The imported file holds stitches, so nothing is labeled or divided.
    while page.needs in pages:
        name, page = page.needs, pages[page.needs](app)
        if page.unavailable() is None:
            return name
    return page.needs


def draw_plainly(scene: DrawingScene, mesh: Mesh, opacity: float = 1.0) -> None:
    """Draw a mesh in one colour with its edges."""
    scene.show(GARMENT, plain_surface(mesh, (206, 200, 186), opacity=opacity))
    ends = np.stack([mesh.edge_side, mesh.side_next[mesh.edge_side]], axis=1)
    scene.show(EDGES, Lines(mesh.vertices[mesh.face_vertex[ends]], (96, 96, 104), 1.0))
    scene.look_at(mesh.vertices.min(axis=0), mesh.vertices.max(axis=0))


def remove_plain(scene: DrawingScene) -> None:
    """Remove the drawing of ``draw_plainly``."""
    scene.remove(GARMENT)
    scene.remove(EDGES)
