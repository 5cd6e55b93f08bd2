# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The panels of a garment: its surface, cut along the seams."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from stitchmesh.errors import MeshError, ParameterError
from stitchmesh.mesh import BORDER, FloatArray, IntArray, Mesh, frozen_array
from stitchmesh.mesh.orientation import turn_inside_out

UPWARDS = (0.0, 1.0)
"""Direction of knitting in the texture of a panel for which none is given."""


@dataclass(frozen=True, eq=False)
class Seam:
    """Two lines of border vertices that are sewn together; a dart joins a panel to itself."""

    panels: tuple[int, int]
    """Panels of the two lines."""
    first: IntArray
    """Vertices of one line in the order of its border, with the panel on the left, shape (n,)."""
    second: IntArray
    """Vertex of the other line that lies on each of them, shape (n,)."""

    def __post_init__(self) -> None:
        for name in ("first", "second"):
            object.__setattr__(self, name, frozen_array(getattr(self, name), np.int64))
        if self.first.shape != self.second.shape or self.first.ndim != 1 or len(self.first) < 2:
            found = f"seam of panels {self.panels}: lines of shape {self.first.shape} and {self.second.shape}"
            raise MeshError(f"{found}; expected two lines of equally many vertices, at least 2")


@dataclass(frozen=True, eq=False)
class PanelMesh:
    """The surface of a garment, cut along its seams into panels.

    V and F are the numbers of vertices and faces of ``mesh``, P is the number of panels.

    Raises:
        MeshError: an array has the wrong shape or a number that is not finite, an edge joins two panels, or a line of a
            seam does not run along a border.
    """

    mesh: Mesh
    """The panels in space [cm]; vertices on seams occur once for each side."""
    texture: FloatArray
    """Texture coordinates (u, v) of each vertex in any unit, shape (V, 2)."""
    face_panel: IntArray
    """Panel of each face, counted from 0, shape (F,)."""
    seams: tuple[Seam, ...] = ()
    """The seams."""
    direction: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))
    """Direction of knitting of each panel in its texture (u, v), shape (P, 2); (0, 1) by default."""
    names: tuple[tuple[str, ...], ...] = ()
    """Names of the object, the group and the material of each panel, where the file has them; none by default."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "texture", frozen_array(self.texture, np.float64))
        object.__setattr__(self, "face_panel", frozen_array(self.face_panel, np.int64))
        default = np.tile(UPWARDS, (self.panel_count, 1))
        direction = self.direction if len(self.direction) else default
        object.__setattr__(self, "direction", frozen_array(direction, np.float64))
        self._check_arrays()
        self._check_seams()

    @property
    def panel_count(self) -> int:
        """Number of panels."""
        return int(self.face_panel.max(initial=-1)) + 1

    def turned_inside_out(self) -> PanelMesh:
        """Return the panels with every face reversed, so that their other side is outside."""
        # A line of a seam runs along its border with the panel on the left, and the border now runs the other way.
        seams = tuple(Seam(seam.panels, seam.first[::-1], seam.second[::-1]) for seam in self.seams)
        return replace(self, mesh=turn_inside_out(self.mesh), seams=seams)

    def panels_named(self, panel: int | str) -> list[int]:
        """Return the number of one panel, or the numbers of all panels whose object, group or material has a name.

        Args:
            panel: a number, a name, or a text of a number that is no name.

        Raises:
            ParameterError: no panel has the number or the name.
        """
        named = [number for number, names in enumerate(self.names) if panel in names]
        if named:
            return named
        number = int(panel) if str(panel).isdecimal() else -1
        if number not in range(self.panel_count):
            known = sorted({name for names in self.names for name in names})
            # Number of names of panels that a message lists.
            words = f"; or a name: {', '.join(known[:8])}" if known else ""
            raise ParameterError(f"panel {panel} does not exist; expected 0 to {self.panel_count - 1}{words}")
        return [number]

    def __repr__(self) -> str:
        """Return one line: the numbers of panels and seams, and the mesh."""
        return f"PanelMesh({self.panel_count} panels, {len(self.seams)} seams, {self.mesh!r})"

    def _check_arrays(self) -> None:
        expected = {
            "texture": (len(self.mesh.vertices), 2),
            "face_panel": (self.mesh.face_count,),
            "direction": (self.panel_count, 2),
        }
        for name, shape in expected.items():
            found = getattr(self, name)
            if found.shape != shape or not np.isfinite(found).all():
                raise MeshError(f"{name}: got shape {found.shape}; expected finite numbers of shape {shape}")
        if len(np.unique(self.face_panel)) != self.panel_count or self.face_panel.min() < 0:
            raise MeshError(f"face_panel: expected every panel from 0 to {self.panel_count - 1} to have faces")
        inner = np.flatnonzero(self.mesh.twin != BORDER)
        panel = self.face_panel[self.mesh.side_face]
        bad = inner[panel[inner] != panel[self.mesh.twin[inner]]]
        if len(bad):
            raise MeshError(f"{self.mesh.side_name(bad[0])}: joins two panels; cut the mesh along its seams")

    def _check_seams(self) -> None:
        border = np.flatnonzero(self.mesh.twin == BORDER)
        after = np.full(len(self.mesh.vertices), -1)
        after[self.mesh.face_vertex[border]] = self.mesh.face_vertex[self.mesh.side_next[border]]
        for number, seam in enumerate(self.seams):
            back = seam.second[::-1]
            if (after[seam.first[:-1]] != seam.first[1:]).any() or (after[back[:-1]] != back[1:]).any():
                raise MeshError(f"seam {number} of panels {seam.panels}: its lines do not run along borders")
