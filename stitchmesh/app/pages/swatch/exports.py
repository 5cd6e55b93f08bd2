# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Files of a swatch for other programs: yarns, textures, pictures and tables."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from stitchmesh.app.pages.swatch.state import Look
from stitchmesh.errors import ParameterError
from stitchmesh.io.yarns import write_yarns
from stitchmesh.periodic.session.frames import Frame
from stitchmesh.periodic.stretch import StretchCurve, write_stretch
from stitchmesh.periodic.swatch_design import SwatchDesign
from stitchmesh.periodic.textures.files import texture_archive
from stitchmesh.periodic.textures.textures import texture_maps

if TYPE_CHECKING:
    from stitchmesh.app.application import App

FORMATS = {
    "one repeat, exact (.h5)": ("h5", False), "one repeat (.pyp)": ("pyp", False),
    "piece, curves (.bcc)": ("bcc", True), "piece, curves (.usda)": ("usda", True),
    "piece, curves (.obj)": ("obj", True), "piece, tubes (.glb)": ("glb", True),
}  # fmt: skip
"""Suffix of each format of yarns, and whether the file holds the whole visible piece."""
PICTURE = (1600, 1000)
"""Width and height of a picture [pixels]."""


class ExportPanel:
    """Controls of the downloads."""

    def __init__(self, app: App, shown: Callable[[], tuple[SwatchDesign, Frame | None, Look]]) -> None:
        """Make the controls; ``shown`` returns the edited design, its newest frame and the look."""
        self._app, self._shown = app, shown
        controls = app.controls
        with controls.group("Download", opened=False):
            controls.button("Download the pattern (PDF)", "Picture, measures, yarn, chart and legend, to take home",
                            self.pattern)  # fmt: skip
            self._format = controls.choice(
                "Yarns as", "Format of the file of yarns; a piece has the repeats that are shown", tuple(FORMATS),
                next(iter(FORMATS)),
            )  # fmt: skip
            controls.button("Download the yarns", "The yarns as they are now, for other programs", self.yarns)
            self._pixels = controls.number(
                "Width of the textures [pixels]", "The height follows from the shape of the repeat", 512, least=16,
                most=4096, step=1,
            )  # fmt: skip
            controls.button("Download the textures", "Colour, height, normals, opacity and direction of one repeat",
                            self.textures)  # fmt: skip
            controls.button("Download a picture", "The scene as it is seen now, 1600 x 1000 pixels", self.picture)

    def yarns(self) -> None:
        """Send the yarns of the newest frame."""
        design, frame, look = self._drawn()
        suffix, tiled = FORMATS[self._format.value]
        tiles = (look.columns, look.rows) if tiled else None
        self._send(f"{file_stem(design)}.{suffix}", lambda path: write_yarns(path, frame.yarns, tiles=tiles))

    def pattern(self) -> None:
        """Send the pattern to take home."""
        from stitchmesh.render.pattern_sheet import swatch_sheet, write_pattern_sheet

        design, frame, _look = self._drawn()
        picture = self._app.scene.screenshot(*PICTURE)
        sheet = swatch_sheet(design.pattern, frame.yarns, frame.measures.gauge, picture=picture)
        self._send(f"{file_stem(design)}.pdf", lambda path: write_pattern_sheet(path, sheet))

    def textures(self) -> None:
        """Compute the textures of the newest frame in the background, and send them."""
        design, frame, _look = self._drawn()
        yarns, pixels, name = frame.yarns, int(self._pixels.value), f"{file_stem(design)}-textures.zip"
        client = self._app.front.acting_client
        self._app.notice(f"textures of {pixels} pixels are being made")
        self._app.tasks.start(
            "making textures", lambda control: texture_archive(texture_maps(yarns, width=pixels)),
            lambda content: self._app.download(name, content, client),
        )  # fmt: skip

    def picture(self) -> None:
        """Send a picture of the scene."""
        self._app.download(f"{file_stem(self._shown()[0])}.png", self._app.scene.screenshot(*PICTURE))

    def curve(self, name: str, curve: StretchCurve) -> None:
        """Send the table of a stretch curve."""
        stem = file_stem(self._shown()[0])
        self._send(f"{stem}-{name}-{curve.direction}.csv", lambda path: write_stretch(path, curve))

    def _drawn(self) -> tuple[SwatchDesign, Frame, Look]:
        """Return the edited design, its newest frame and the look.

        Raises:
            ParameterError: there is no frame yet.
        """
        design, frame, look = self._shown()
        if frame is None:
            raise ParameterError("download: the yarns are not drawn yet; wait for the fabric")
        return design, frame, look

    def _send(self, name: str, write: Callable[[Path], object]) -> None:
        path = self._app.project.folder / "exports" / name
        write(path)
        self._app.download(name, path.read_bytes())


def file_stem(design: SwatchDesign) -> str:
    """Return the name of the pattern as part of a file name."""
    kept = "".join(letter if letter.isalnum() else "-" for letter in design.pattern.name.lower())
    return "-".join(part for part in kept.split("-") if part)[:60] or "swatch"
