# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The cloth of a scene: a rectangle, panels with seams, or a file; and its material."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.units import DEFAULT_UNIT
from stitchmesh.mesh import BOTTOM, TOP, StitchMesh
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.cloth.panel_file import read_panels
from stitchmesh.mixed.cloth.panel_position import PanelPosition
from stitchmesh.mixed.cloth.panels import Panel
from stitchmesh.mixed.cloth.seams import PanelSeam, cloth_from_panels
from stitchmesh.settings import setting

STITCH_SUFFIXES = (".h5", ".smobj")
"""Suffixes of stitch meshes."""


@dataclass(frozen=True, kw_only=True)
class ClothSection:
    """A cloth as triangles: one of ``rectangle``, ``panels`` and ``file``.

    Raises:
        ParameterError: not exactly one of them is given, or seams are given without panels.
    """

    rectangle: tuple[float, float] | None = setting(
        None, "width and height of one flat panel; x along wefts or courses, y along warps or wales", unit="cm",
        unset="none",
    )  # fmt: skip
    position: PanelPosition = field(default_factory=PanelPosition)
    """Where the rectangle lies in space at the start: ``origin``, ``x_axis``, ``y_axis``, ``radius``."""
    panels: tuple[Panel, ...] = setting((), "panels: name, outline, position, side_edges")
    seams: tuple[PanelSeam, ...] = setting(
        (), "seams between panels: first and second (panel, start, end), angle, edges"
    )
    seam_rods: bool = setting(
        False, "whether the rods along seams, to which other yarns are joined, go on where triangles are simulated; "
        "alpha blends their stiffness and mass as it does for other yarns",
    )  # fmt: skip
    file: str | None = setting(
        None, "panels and seams (.toml), a polygon mesh whose texture coordinates are its rest shape (.obj), or a "
        "stitch mesh (.h5, .smobj)", unset="none",
    )  # fmt: skip
    stitch_width: float | None = setting(
        None, "wale spacing of a stitch mesh at rest", unit="cm", unset="the median of its sides"
    )
    course_height: float | None = setting(
        None, "course spacing of a stitch mesh at rest", unit="cm", unset="the median of its sides"
    )
    unit: str = setting(DEFAULT_UNIT, "unit of the coordinates in an OBJ file")
    edge_length: float | None = setting(
        None, "length of the edges of triangles; an OBJ file has its own triangles", unit="cm",
        unset="1, or as the file of panels states",
    )  # fmt: skip
    material: str | None = setting(
        None, "a measured cloth (docs/cloth-materials.md), a material file (.toml), or matched: fitted to the yarns by "
        "tests of one repeat, which takes seconds and is kept in the output folder",
        unset="the stiffness of straight yarns for a weave, interlock for a knit",
    )  # fmt: skip

    def __post_init__(self) -> None:
        given = [name for name in ("rectangle", "panels", "file") if getattr(self, name)]
        if len(given) != 1:
            found = " and ".join(given) or "nothing"
            raise ParameterError(f"cloth: got {found}; expected exactly one of rectangle, panels and file")
        if self.seams and not self.panels:
            raise ParameterError("cloth.seams: got seams without panels; expected the panels that they join")

    def cloth(self) -> Cloth:
        """Make the cloth.

        Raises:
            ParameterError: a panel or a seam is not possible.
            FileError: a file cannot be read.
            MeshError: the panels sewn together are not a manifold surface.
        """
        if self.file is not None:
            return self._from_file(self.file)
        panels = self.panels
        if self.rectangle is not None:
            width, height = self.rectangle
            outline = ((0.0, 0.0), (width, 0.0), (width, height), (0.0, height))
            panels = (Panel(name="panel", outline=outline, position=self.position),)
        return cloth_from_panels(panels, self.seams, edge_length=self.edge_length or 1.0)

    def _from_file(self, path: str) -> Cloth:
        suffix = Path(path).suffix.lower()
        if suffix == ".toml":
            content = read_panels(path)
            return replace(content, edge_length=self.edge_length or content.edge_length).cloth()
        if suffix == ".obj":
            from stitchmesh.mixed.cloth.from_obj import cloth_from_obj

            return cloth_from_obj(path, unit=self.unit)
        if suffix in STITCH_SUFFIXES:
            from stitchmesh.mixed.cloth.from_stitches import cloth_from_stitches

            fabric = self.stitches()
            width, height = self.stitch_size(fabric)
            return cloth_from_stitches(fabric, stitch_width=width, course_height=height)
        expected = ".toml (panels), .obj (texture coordinates), .h5 or .smobj (stitches)"
        raise FileError(f"{path}: got the suffix {suffix!r}; expected {expected}")

    def stitches(self) -> StitchMesh:
        """Return the stitch mesh of the file.

        Raises:
            FileError: the file cannot be read.
            ParameterError: the file does not hold stitches.
        """
        from stitchmesh.io import read_stitches

        if self.file is None or Path(self.file).suffix.lower() not in STITCH_SUFFIXES:
            raise ParameterError("yarns.knit: got 'stitches' without any; expected a cloth.file of .h5 or .smobj")
        return read_stitches(self.file)

    def stitch_size(self, fabric: StitchMesh) -> tuple[float, float]:
        """Return the wale and course spacing of a stitch mesh at rest [cm]."""
        across = (fabric.side_role == BOTTOM) | (fabric.side_role == TOP)
        found = [float(np.median(fabric.side_length[chosen])) for chosen in (across, ~across)]
        return self.stitch_width or found[0], self.course_height or found[1]
