# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The natural shape of a fabric: its size, its slant and its outline."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from stitchmesh.mesh import BOTTOM, LEFT, RIGHT, TOP, FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.turns import SLIT_SIDES
from stitchmesh.meshrelax.report import MeshRelaxReport


@dataclass(frozen=True, eq=False)
class FreeShape:
    """A fabric after mesh relaxation without a surface; the axis of a tube is y."""

    fabric: StitchMesh
    """The relaxed stitches, with the stretch of each edge."""
    report: MeshRelaxReport
    """Figures of the relaxation."""
    plain: tuple[float, float]
    """Rest width and height of plain knit [cm]."""

    @cached_property
    def outline(self) -> tuple[FloatArray, ...]:
        """Each border as a closed polygon [cm], shape (n, 3); the cell of a fabric on a lattice, shape (4, 3)."""
        fabric = self.fabric
        if fabric.lattice is not None:
            first, second = fabric.lattice.periods
            return (np.stack([np.zeros(3), first, first + second, second]),)
        return tuple(fabric.vertices[fabric.face_vertex[loop]] for loop in self._borders)

    @property
    def width(self) -> float:
        """Distance between the middles of both side borders [cm]; half the girth of a tube; or the first period."""
        if self.is_tube:
            return float(np.pi * np.hypot(self.fabric.vertices[:, 0], self.fabric.vertices[:, 2]).mean())
        return float(np.linalg.norm(self._across))

    @property
    def height(self) -> float:
        """Distance between the middles of first and last row [cm]; in a flat fabric at right angles to the rows."""
        if self.is_tube:
            return float(np.linalg.norm(self._along))
        return float(np.linalg.norm(np.cross(self._across, self._along)) / np.linalg.norm(self._across))

    @property
    def slant(self) -> float:
        """Angle by which the wales lean to the right from the right angle to the rows [degrees]; 0 for a tube."""
        if self.is_tube:
            return 0.0
        across, along = self._across, self._along
        sine, cosine = np.linalg.norm(np.cross(across, along)), across @ along
        return float(np.degrees(np.arctan2(cosine, sine)))

    @property
    def is_flat_piece(self) -> bool:
        """Whether the fabric has side borders, where its rows begin and end."""
        return len(self._border(LEFT)) > 0

    @property
    def is_tube(self) -> bool:
        """Whether the rows close."""
        return self.fabric.lattice is None and not self.is_flat_piece

    def wave(self, role: int) -> float:
        """Return the depth of the waves of a border [cm]: how far it deviates from its straight line.

        Args:
            role: role of the border sides, such as ``BOTTOM`` for the border of the first row; 0 for a tube or a
                lattice.
        """
        sides = self._border(role)
        if not self.is_flat_piece or len(sides) == 0:
            return 0.0
        points = self.fabric.vertices[self._ends(sides)]
        centred = points - points.mean(axis=0)
        direction = np.linalg.svd(centred, full_matrices=False)[2][0]
        across = np.cross(self.fabric.face_vector_area.sum(axis=0), direction)
        place = centred @ (across / np.linalg.norm(across))
        return float(np.ptp(place))

    def measures(self) -> dict[str, Any]:
        """Return the figures of the shape as plain numbers, in cm and degrees."""
        rows = len(np.unique(self.fabric.row))
        loops = float(self.fabric.n_bottom.sum()) / rows
        return {
            "width": self.width,
            "height": self.height,
            "slant": self.slant,
            "width_over_plain": self.width * (2.0 if self.is_tube else 1.0) / (loops * self.plain[0]),
            "height_over_plain": self.height / (rows * self.plain[1]),
            "wave_below": self.wave(BOTTOM),
            "wave_above": self.wave(TOP),
            "wave_left": self.wave(LEFT),
            "wave_right": self.wave(RIGHT),
        }

    @cached_property
    def _borders(self) -> list[IntArray]:
        """The border sides of each border, without the slits of bobbles."""
        return [loop for loop in self.fabric.boundary_loops if len(loop) > SLIT_SIDES]

    def _border(self, role: int) -> IntArray:
        """Return the border sides with a role."""
        sides = np.concatenate([np.zeros(0, dtype=np.int64), *self._borders])
        return sides[self.fabric.side_role[sides] == role]

    def _ends(self, sides: IntArray) -> IntArray:
        """Return the vertices of some sides, each once."""
        fabric = self.fabric
        return np.unique(fabric.face_vertex[np.concatenate([sides, fabric.side_next[sides]])])

    def _middle(self, role: int) -> FloatArray:
        """Return the mean of the vertices of the border sides with a role [cm]."""
        middle: FloatArray = self.fabric.vertices[self._ends(self._border(role))].mean(axis=0)
        return middle

    @property
    def _across(self) -> FloatArray:
        """Vector along the rows over the whole fabric [cm]."""
        lattice = self.fabric.lattice
        return self._middle(RIGHT) - self._middle(LEFT) if lattice is None else lattice.periods[0]

    @property
    def _along(self) -> FloatArray:
        """Vector from the first row to the last one [cm]."""
        lattice = self.fabric.lattice
        return self._middle(TOP) - self._middle(BOTTOM) if lattice is None else lattice.periods[1]
