# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Rest lengths of course and wale edges from the area of the surface (Yuksel et al. 2012, section 6.1).

The rest lengths satisfy N r_wale r_course = alpha A and r_wale = a r_course, where A is the area of the surface and a
is the aspect. An unstressed face with b bottom and t top sides is a trapezoid of area (b + t) / 2 r_course r_wale. It
therefore counts as (b + t) / 2 stitches in N: a plain stitch as 1, a 1-to-3 increase as 2, and the triangle at the end
of a short row as 1/2. A bobble counts as one stitch, because it stands in the place of one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.mesh import StitchMesh
from stitchmesh.meshrelax.bobbles import NO_BOBBLES, Bobbles


@dataclass(frozen=True)
class RestRectangle:
    """The rectangle of an unstressed plain stitch."""

    course: float
    """Rest length of a course edge [cm]."""
    wale: float
    """Rest length of a wale edge [cm]."""

    @property
    def diagonal(self) -> float:
        """Rest length of the diagonals [cm]."""
        return float(np.hypot(self.course, self.wale))

    @property
    def unit(self) -> float:
        """Size of a stitch: side of the square with the same area [cm]."""
        return float(np.sqrt(self.course * self.wale))


def rest_lengths(
    fabric: StitchMesh, area: float, *, aspect: float, alpha: float, bobbles: Bobbles = NO_BOBBLES
) -> RestRectangle:
    """Compute the rest lengths with which unstressed stitches cover the part ``alpha`` of an area.

    Args:
        fabric: stitch mesh.
        area: area A of the surface [cm^2].
        aspect: rest length of a wale edge divided by the rest length of a course edge.
        alpha: covered part of the area.
        bobbles: the bobbles of the fabric.
    """
    loops = fabric.n_bottom + fabric.n_top
    stitches = 0.5 * float(loops.sum() - loops[bobbles.faces].sum()) + bobbles.count
    course = float(np.sqrt(alpha * area / (stitches * aspect)))
    return RestRectangle(course, aspect * course)
