# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Walks through the application in a real browser, by clicks alone, and prints the time of each step.

The first walk leads from a mesh to the relaxed yarns of a sweater, the second one from a mesh of triangles to even
stitches of a glove, the third one from a pattern to a swatch, and the fourth one from a scene to a cloth with yarns in
a painted region. The browser draws in software here, so that the times are longer than those of a machine with a
graphics card.
"""

from __future__ import annotations

import io
import os
import platform
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Literal

import numpy as np
from PIL import Image
from playwright.sync_api import Browser

from benchmarks.places import DOCS, MESHES, MIXED_SCENES
from benchmarks.table import Rows
from stitchmesh.io.meshes import read_mesh, write_mesh
from stitchmesh.mesh import FloatArray, Mesh
from stitchmesh.mesh.face_triangles import face_triangles
from tests.app.browser import LONGEST_TASK, Rig, rig_on, started_browser
from tests.app.controls.test_chart_in_browser import PLACE

SIZES = ((1280, 800), (1000, 700))
"""Widths and heights of the window [pixels]."""
FOLDER = DOCS / "application"
"""Folder of the pictures."""
PAGES = (DOCS / "application.md", DOCS / "drape-page.md")
"""The pages that show the pictures; those that they do not name are not drawn."""
THUMBNAILS = "() => !document.querySelector('.sm-patterns span.sm-picture')"
"""Whether no thumbnail of a pattern is missing."""
SCENE = MIXED_SCENES / "swinging.toml"
"""The scene that is draped."""
STITCH_WIDTH = 1.5
"""Width of the stitches of the sweater [cm]."""


class Walk:
    """A walk: its steps with their times, and its pictures."""

    def __init__(self, rig: Rig, name: str, folder: Path | None) -> None:
        """Start the clock; pictures are written if there is a folder."""
        self.rig, self.name, self.folder = rig, name, folder
        self.began = self.last = time.perf_counter()

    def step(
        self, what: str, *acts: Callable[[], object], until: Callable[[], object] = bool, picture: str = ""
    ) -> tuple[str, str, str]:
        """Do something, wait until it is done and drawn, draw a picture, and return the row with the time."""
        for act in acts:
            act()
            self.rig.settle()
        if until is not bool:
            self.rig.wait_for(until, what, LONGEST_TASK)
            self.rig.settle()
        now = time.perf_counter()
        row = self.name, what, f"{now - self.last:.1f}"
        page = self.rig.browser_page
        file = f"{picture}-{page.viewport_size['width']}.jpg"
        if picture and self.folder is not None and any(f"/{file}" in shown.read_text() for shown in PAGES):
            page.mouse.move(5, 5)  # No hint of a control covers the picture.
            page.evaluate("() => document.activeElement && document.activeElement.blur()")
            page.wait_for_function(THUMBNAILS)
            page.wait_for_timeout(1500)
            self.folder.mkdir(parents=True, exist_ok=True)
            image = Image.open(io.BytesIO(self.rig.screenshot())).convert("RGB")
            image.save(self.folder / file, quality=86, optimize=True)
        self.last = time.perf_counter()
        return row


def border_point(mesh: Mesh) -> FloatArray:
    """Return the middle of the border edge that is lowest and in front [cm]."""
    sides = np.flatnonzero(mesh.twin < 0)
    middle = 0.5 * (mesh.corner_position[sides] + mesh.corner_position[mesh.side_next[sides]])
    low = middle[middle[:, 1] < middle[:, 1].min() + 0.2 * np.ptp(mesh.vertices[:, 1])]
    return low[np.argmax(low[:, 2] - np.abs(low[:, 0]))]


def sweater(walk: Walk) -> Rows:
    """From a mesh to a sweater."""
    rig, press = walk.rig, walk.rig.press
    yield walk.step("the page Project", picture="sweater-1-project")
    yield walk.step("take the example", lambda: rig.choose("Example", "sweater"), lambda: press("Take the example"),
                    picture="sweater-2-mesh")  # fmt: skip
    project, mesh = rig.app.project, rig.app.project.mesh
    yield walk.step(
        "click the hem: the first row", lambda: rig.click_at(border_point(mesh)), picture="sweater-3-first-row"
    )
    yield walk.step("label all rows", lambda: press("Label all"), picture="sweater-4-rows")
    yield walk.step("go on to Divide", lambda: press("Go on: divide into stitches"))
    yield walk.step("divide", lambda: rig.type("Stitch width [cm]", STITCH_WIDTH),
                    lambda: press("Divide into stitches"), picture="sweater-5-divided")  # fmt: skip
    yield walk.step("go on to Edit", lambda: press("Go on: edit the stitches"), picture="sweater-6-edit")
    yield walk.step("select the hem", lambda: rig.type("Select by words", "hem 6"), lambda: press("Select these"))
    yield walk.step("choose a rib", lambda: press("Lay a pattern"), lambda: rig.act("pattern", "rib2x2"),
                    picture="sweater-7-preview")  # fmt: skip
    yield walk.step("lay the rib", lambda: press("Lay the pattern"), picture="sweater-8-rib")
    yield walk.step("go on to Even out", lambda: rig.page_button("Even out"))
    yield walk.step("even out", lambda: press("Even out the stitches"), until=lambda: project.evened,
                    picture="sweater-9-even")  # fmt: skip
    yield walk.step("go on to Yarns", lambda: press("Go on to the yarns"))
    yield walk.step("choose the quality draft", lambda: rig.open_group("Accuracy and edges"),
                    lambda: rig.choose("Quality", "draft"))  # fmt: skip
    yield walk.step("generate the yarns", lambda: press("Generate the yarns"), until=lambda: project.yarns,
                    picture="sweater-10-yarns")  # fmt: skip
    yield walk.step("relax the yarns", lambda: press("Relax the yarns"), until=lambda: project.relaxed,
                    picture="sweater-11-relaxed")  # fmt: skip
    yield walk.step("look at the result", lambda: rig.page_button("View"), picture="sweater-12-view")
    yield walk.step("go to Project", lambda: rig.page_button("Project"))
    rig.open_group("Download")
    name, content = rig.downloaded(lambda: rig.act("download", "relaxed.usdc"))
    yield walk.step(f"download {name}, {len(content) / 1e6:.1f} MB", picture="sweater-13-download")


def rows(walk: Walk) -> Rows:
    """From a mesh of triangles to even stitches."""
    rig, press = walk.rig, walk.rig.press
    path = rig.app.project.folder.parent / "glove.obj"
    write_mesh(path, triangles_of(read_mesh(MESHES / "glove.obj")))
    yield walk.step("import a mesh of triangles", lambda: rig.upload(path), until=lambda: rig.app.page.name == "Rows")
    rig.close_notices()
    project = rig.app.project
    yield walk.step(
        "click the wrist: knitting begins", lambda: rig.click_at(border_point(project.mesh)), picture="rows"
    )
    yield walk.step("find the stitches", lambda: press("Find the stitches"), picture="rows-2-stitches")
    yield walk.step("knit these rows", lambda: press("Knit these rows"), until=lambda: project.fabric)
    yield walk.step("go on to Even out", lambda: rig.page_button("Even out"))
    yield walk.step(
        "even out", lambda: press("Even out the stitches"), until=lambda: project.evened, picture="rows-3-even"
    )


def triangles_of(mesh: Mesh) -> Mesh:
    """Return a mesh with each face divided into triangles, as a scan has them."""
    return Mesh.from_polygons(mesh.vertices, mesh.face_vertex[face_triangles(mesh).corners].tolist())


def swatch(walk: Walk) -> Rows:
    """From a pattern to a swatch."""
    rig = walk.rig
    yield walk.step("the page Swatch", lambda: rig.page_button("Swatch"), lambda: rest(rig), picture="swatch-1-start")
    yield walk.step("choose a stitch of the palette", lambda: rig.act("stitch", "k"))
    yield walk.step("paint the chart", lambda: paint(rig, (0, 0), (0, 1)), lambda: rest(rig),
                    picture="swatch-2-painted")  # fmt: skip
    yield walk.step("start from moss stitch", lambda: rig.choose("Start from", "moss"), lambda: rest(rig),
                    picture="swatch-3-moss")  # fmt: skip
    yield walk.step("turn the dial Tightness", lambda: rig.type("Tightness", 1.25), lambda: rest(rig),
                    picture="swatch-4-tight")  # fmt: skip
    yield walk.step("compare two variants", lambda: rig.open_group("Two variants"),
                    lambda: rig.tick("Compare two variants"), lambda: rig.type("Tightness", 0.9), lambda: rest(rig),
                    picture="swatch-5-compared")  # fmt: skip
    rig.open_group("Stretch test")
    curve = rig.browser_page.get_by_role("button", name="Download the curve (CSV)")
    yield walk.step("stretch test", lambda: rig.press("Run the stretch test"), curve.wait_for,
                    curve.scroll_into_view_if_needed, picture="swatch-6-stretch")  # fmt: skip
    rig.open_group("Download")
    name, content = rig.downloaded(lambda: rig.press("Download the yarns"))
    yield walk.step(f"download {name}, {len(content) / 1e3:.0f} kB")


def drape(walk: Walk) -> Rows:
    """From a scene to a draped cloth."""
    rig, press = walk.rig, walk.rig.press
    yield walk.step("the page Drape", lambda: rig.page_button("Drape"))
    yield walk.step("open a scene", lambda: rig.type("Path", SCENE), lambda: press("Open path"),
                    until=lambda: rig.app.page.session.opened, picture="drape-1-scene")  # fmt: skip
    session = rig.app.page.session
    yield walk.step("paint with the brush", lambda: rig.choose("A drag", "adds to the region"),
                    lambda: rig.drag([[0.6, 1.2, 0.0], [1.6, 1.6, 0.0]]),
                    until=lambda: session.opened.scene.region.faces, picture="drape-2-painted")  # fmt: skip
    yield walk.step("the weight of the yarns", lambda: rig.choose("Colours", "Alpha"), picture="drape-3-alpha")
    yield walk.step("run", lambda: press("Run the scene"), until=lambda: rig.app.page.run.result, picture="drape-4-run")
    yield walk.step("the tension of the cloth", lambda: rig.choose("Colour the run by", "Tension of the cloth"),
                    picture="drape-5-tension")  # fmt: skip
    yield walk.step("a frame in the middle", lambda: rig.type("Moment", 50))
    yield walk.step("look on the page View", lambda: press("Look on the page View"), picture="drape-6-view")


def paint(rig: Rig, *squares: tuple[int, int]) -> None:
    """Drag over squares of the chart, each a row and a column."""
    rig.drag_page([rig.browser_page.evaluate(PLACE, list(square)) for square in squares])


def rest(rig: Rig) -> None:
    """Wait until the fabric rests."""

    def at_rest() -> bool:
        frames = [variant.frame for variant in rig.app.page.variants]
        return all(frame is not None and not frame.report["running"] for frame in frames)

    rig.browser_page.wait_for_timeout(300)
    rig.wait_for(at_rest, "the fabric rests")


def run(browser: Browser, size: tuple[int, int], pictures: bool, only: str | None) -> Rows:
    """Make all walks, or only one of them, in a window of one size."""
    for walk in (each for each in (sweater, rows, swatch, drape) if only in (None, each.__name__)):
        with tempfile.TemporaryDirectory(prefix="walk-") as home:
            os.environ.update(HOME=home, STITCHMESH_PROJECTS=f"{home}/StitchMesh", XDG_STATE_HOME=f"{home}/state")
            with rig_on(browser, Path(home) / "StitchMesh" / "Garment", "Project", size) as rig:
                steps = Walk(rig, f"{walk.__name__} {size[0]} x {size[1]}", FOLDER if pictures else None)
                yield from walk(steps)
                yield steps.name, "**all**", f"**{time.perf_counter() - steps.began:.1f}**"


def app_walks(*, pictures: bool = False, only: Literal["sweater", "rows", "swatch", "drape"] | None = None) -> Rows:
    """Parse the options, and walk.

    Args:
        pictures: draw the pictures of docs/application.md
        only: make one walk
    """
    yield f"{platform.processor() or platform.machine()}, {os.cpu_count()} cores"
    yield "walk", "step", "s"
    with started_browser() as browser:
        for size in SIZES:
            yield from run(browser, size, pictures, only)
