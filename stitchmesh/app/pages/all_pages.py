# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The pages by name, in the order of the navigation, and what a page shows that needs another one first.

The module of a page is imported when the page is first opened, because some pages need simulations whose modules take
longer to import than the application takes to start.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, TypeAlias

from stitchmesh.app.pages.page import Page
from stitchmesh.app.scene.mesh_drawing import draw_plainly

if TYPE_CHECKING:
    from stitchmesh.app.application import App

MakePage: TypeAlias = "Callable[[App], Page]"
"""Makes a page of the application."""


@dataclass(frozen=True)
class PageModule:
    """Makes a page; its first call imports the module of the page."""

    module: str
    """Name of the module in ``stitchmesh.app.pages``."""
    class_name: str
    """Name of the class of the page."""

    def __call__(self, app: App) -> Page:
        """Make the page."""
        page: Page = getattr(import_module(f"stitchmesh.app.pages.{self.module}"), self.class_name)(app)
        return page


PAGES: dict[str, MakePage] = {
    "Project": PageModule("project_page", "ProjectPage"),
    "Label": PageModule("label", "LabelPage"),
    "Divide": PageModule("divide", "DividePage"),
    "Rows": PageModule("rows.page", "RowsPage"),
    "Edit": PageModule("edit.edit_page", "EditPage"),
    "Even out": PageModule("even_out", "EvenOutPage"),
    "Yarns": PageModule("yarns.page", "YarnsPage"),
    "Take home": PageModule("take_home", "TakeHomePage"),
    "Swatch": PageModule("swatch.page", "SwatchPage"),
    "Outline": PageModule("outline", "OutlinePage"),
    "Drape": PageModule("drape.page", "DrapePage"),
    "View": PageModule("view.page", "ViewPage"),
}
"""The function that makes each page."""


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
