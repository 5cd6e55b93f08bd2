# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The natural shape of a fabric: its size, its slant and its outline."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stitchmesh.mesh import BORDER, BOTTOM, TOP, FloatArray, StitchMesh
from stitchmesh.meshrelax.report import MeshRelaxReport


@dataclass(frozen=True, eq=False)
class FreeShape:
    """A fabric after mesh relaxation without a surface.

    Courses run along the mean direction of the course sides, and wales along that of the wale sides. In a tube, where
    courses run around, sizes are those of the tube laid flat.
    """

    fabric: StitchMesh
    """The relaxed stitches, with the stretch of each edge."""
    report: MeshRelaxReport
    """Figures of the relaxation."""

    @cached_property
    def outline(self) -> tuple[FloatArray, ...]:
        """Each border as a closed polygon [cm], shape (n, 3); for a fabric on a lattice, the cell, shape (4, 3)."""
        fabric = self.fabric
        if fabric.lattice is not None:
            first, second = fabric.lattice.periods
            return (np.stack([np.zeros(3), first, first + second, second]),)
        return tuple(fabric.vertices[fabric.face_vertex[loop]] for loop in fabric.boundary_loops)

    @property
    def width(self) -> float:
        """Mean length of the rows, from end to end [cm]; of a tube half of its mean girth."""
        rows = np.bincount(self.fabric.row) > 0
        sides = np.flatnonzero(self.fabric.side_role == BOTTOM)
        length = np.bincount(self.fabric.row[self.fabric.side_face[sides]], self.fabric.side_length[sides])
        return float(length[length > 0.0].mean()) if rows.any() else 0.0
