# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command ``render``."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated

from tyro.conf import Positional, arg

from stitchmesh.cli.options import FileReading, Overwrite
from stitchmesh.cli.say import say
from stitchmesh.cli.words import DirectionWord, Flag, help_entry
from stitchmesh.io.units import DEFAULT_UNIT
from stitchmesh.mesh.upright import Y


@dataclass(frozen=True)
class RenderCommand:
    """Draw a picture of yarns, of stitches, of rows or of a mesh."""

    file: Annotated[Positional[str], help_entry("FILE")]
    """polygon mesh, stitch mesh or yarns"""
    output: Annotated[str, help_entry("PNG", short="-o")]
    """picture file"""
    view: Annotated[str | None, help_entry("VIEW", "front; the outward direction in a close-up")] = None
    """front, back, left, right, top, bottom, or azimuth,elevation in degrees"""
    close_up: Annotated[str | None, help_entry("PLACE", "the whole object")] = None
    """place to look at: 'face 120', 'row 12', 'point X Y Z' in cm, 'share U V' of the picture of the whole object, or a
    selection such as 'hem 6'"""
    extent: Annotated[float | None, help_entry("CM", "about twelve stitches")] = None
    """width of the region of a close-up [cm]"""
    colour_by: Annotated[str | None, help_entry("WHAT", "the colours of the yarns; rows or stitches of a mesh")] = None
    """yarn, row, stitch, strain, stretch, contact, distance or body-distance, of a stitch mesh also irregular, or one
    colour: #rrggbb or a name such as navy"""
    blend: Annotated[float, help_entry("X")] = 1.0
    """weight of the colours of rows or stitches over those of the yarns, 0 to 1"""
    stitches: Annotated[str | None, help_entry("FILE", "none")] = None
    """stitch mesh of the yarns, for colours by stitch and close-ups of a selection"""
    size: Annotated[tuple[int, int], help_entry("W H")] = (1600, 1000)
    """width and height [pixels]"""
    background: Annotated[str | None, help_entry("COLOUR", "a pale gradient")] = None
    """transparent, or a colour"""
    body: Annotated[str | None, help_entry("MESH", "none")] = None
    """polygon mesh of a body that is drawn too"""
    body_unit: Annotated[str, help_entry("UNIT")] = DEFAULT_UNIT
    """unit of the file of the body"""
    body_up: Annotated[DirectionWord, help_entry("AXIS|X,Y,Z", "y")] = None
    """direction in the file of the body that points up"""
    look: Annotated[str | None, help_entry("NAME", "that of the yarn, or wool")] = None
    """how yarns look: wool, cotton, mohair, silk, acrylic, tweed or monofilament"""
    tile: Annotated[tuple[int, int] | None, help_entry("C R", "5 5")] = None
    """numbers of periods of yarns that repeat, along the courses and along the wales"""
    no_inset: Flag = False
    """no close-up beside the picture of whole yarns"""
    no_occlusion: Flag = False
    """no shadows, and no darker hollows"""
    no_scale_bar: Flag = False
    """no scale bar"""
    reading: Annotated[FileReading, arg(name="")] = field(default_factory=FileReading)
    overwrite: Overwrite = False

    def run(self) -> None:
        """Draw the picture, write it, and print its size."""
        from stitchmesh.io import read_stitches
        from stitchmesh.io.garments import read_body
        from stitchmesh.render import render

        thing = self.reading.read(self.file)
        render(
            thing, self.output, view=self.view, close_up=self.close_up, extent=self.extent, size=self.size,
            colour=self.colour_by, blend=self.blend, background=self.background,
            body=None if self.body is None else read_body(self.body, unit=self.body_unit, up=self.body_up or Y),
            fabric=None if self.stitches is None else read_stitches(self.stitches),
            look=self.look, tiles=self.tile, inset=not self.no_inset, occlusion=not self.no_occlusion,
            scale_bar=not self.no_scale_bar,
        )  # fmt: skip
        say(f"wrote {self.output}: {self._seen()} of {self.file}")

    def _seen(self) -> str:
        """Return in words what the picture shows."""
        if self.close_up is not None:
            return f"close-up of {self.close_up}"
        return "picture" if self.view is None else f"view {self.view}"
