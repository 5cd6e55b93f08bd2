# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The pages by name, in the order of the navigation."""

from __future__ import annotations

from stitchmesh.app.pages.divide import DividePage
from stitchmesh.app.pages.drape.page import DrapePage
from stitchmesh.app.pages.edit.edit_page import EditPage
from stitchmesh.app.pages.even_out import EvenOutPage
from stitchmesh.app.pages.label import LabelPage
from stitchmesh.app.pages.page import Page
from stitchmesh.app.pages.project_page import ProjectPage
from stitchmesh.app.pages.swatch.page import SwatchPage
from stitchmesh.app.pages.view.page import ViewPage
from stitchmesh.app.pages.yarns.page import YarnsPage

_CLASSES: tuple[type[Page], ...] = (
    ProjectPage,
    LabelPage,
    DividePage,
    EditPage,
    EvenOutPage,
    YarnsPage,
    SwatchPage,
    DrapePage,
    ViewPage,
)
PAGES: dict[str, type[Page]] = {page.name: page for page in _CLASSES}
"""Class of each page."""
