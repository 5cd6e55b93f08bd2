# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Rest lengths of course and wale edges from the size of the fabric (Yuksel et al. 2012, section 6.1).

They satisfy N r_wale r_course = alpha A and r_wale = a r_course. A face with b bottom and t top sides is at rest a
trapezoid of area (b + t) / 2 r_course r_wale, so it counts as (b + t) / 2 stitches in N: a plain stitch as one, a
1-to-3 increase as two, the triangle at the end of a short row as a half.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.mesh import StitchMesh


@dataclass(frozen=True)
class RestLengths:
    """The rectangle that a plain stitch is at rest."""

    course: float
    """Length of a course edge [cm]."""
    wale: float
    """Length of a wale edge [cm]."""

    @property
    def diagonal(self) -> float:
        """Length of the diagonals [cm]."""
        return float(np.hypot(self.course, self.wale))

    @property
    def unit(self) -> float:
        """Side of the square of the same area [cm]."""
        return float(np.sqrt(self.course * self.wale))


def rest_lengths(fabric: StitchMesh, area: float, *, aspect: float, alpha: float) -> RestLengths:
    """Rest lengths at which the fabric's stitches cover the part ``alpha`` of an area.

    Args:
        fabric: the stitch faces.
        area: area of the surface they lie on [cm^2].
        aspect: wale edge over course edge.
        alpha: covered part of the area.
    """
    stitches = 0.5 * float((fabric.n_bottom + fabric.n_top).sum())
    course = float(np.sqrt(alpha * area / (stitches * aspect)))
    return RestLengths(course, aspect * course)
