# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The cloth of a scene: a rectangle, panels with seams, or a file; and its material."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.units import DEFAULT_UNIT
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.cloth.panel_file import PanelTable, read_panels
from stitchmesh.mixed.cloth.panel_position import PanelPosition
from stitchmesh.mixed.cloth.panels import Panel
from stitchmesh.mixed.cloth.seams import Seam, cloth_from_panels

EDGE_LENGTH = 1.0
"""Length of the edges of triangles if none is given [cm]."""


@dataclass(frozen=True, kw_only=True)
class ClothSection:
    """A cloth as triangles: one of ``rectangle``, ``panels`` and ``file``.

    Raises:
        ParameterError: not exactly one of them is given, or seams are given without panels.
    """

    rectangle: tuple[float, float] | None = None
    """Width and height of one flat panel [cm]; x along wefts or courses, y along warps or wales."""
    position: PanelPosition = field(default_factory=PanelPosition)
    """Where the rectangle lies in space at the start: ``origin``, ``x_axis``, ``y_axis``, ``radius``."""
    panels: tuple[PanelTable, ...] = ()
    """Panels: ``name``, ``outline``, ``position``, ``side_edges``."""
    seams: tuple[Seam, ...] = ()
    """Seams between them: ``first`` and ``second`` (``panel``, ``start``, ``end``), ``angle``, ``edges``."""
    file: str | None = None
    """A file of panels and seams (``.toml``), or a polygon mesh whose texture coordinates are its rest shape
    (``.obj``)."""
    unit: str = DEFAULT_UNIT
    """Unit of the coordinates in an OBJ file."""
    edge_length: float | None = None
    """Length of the edges of triangles [cm], 1 by default; that of the file of panels; an OBJ file has its own
    triangles."""
    material: str | None = None
    """Name of a measured cloth, or a file (``.toml``); by default, a material is computed from the yarns."""

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
        panels = [table.panel() for table in self.panels]
        if self.rectangle is not None:
            width, height = self.rectangle
            outline = [[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]]
            panels = [Panel(name="panel", outline=outline, position=self.position)]
        return cloth_from_panels(panels, self.seams, edge_length=self.edge_length or EDGE_LENGTH)

    def _from_file(self, path: str) -> Cloth:
        suffix = Path(path).suffix.lower()
        if suffix == ".toml":
            content = read_panels(path)
            tables = [table.panel() for table in content.panels]
            return cloth_from_panels(tables, content.seams, edge_length=self.edge_length or content.edge_length)
        if suffix == ".obj":
            from stitchmesh.mixed.cloth.from_obj import cloth_from_obj

            return cloth_from_obj(path, unit=self.unit)
        raise FileError(f"{path}: got the suffix {suffix!r}; expected .toml (panels) or .obj (texture coordinates)")
