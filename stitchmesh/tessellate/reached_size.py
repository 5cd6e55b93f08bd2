# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The width and the height that the stitches reach, compared with those that were asked for.

Each edge of the mesh is divided into whole stitches, at least one. Stitches can therefore not be wider or higher than
the faces of the mesh. Where faces are much smaller, as on a fine mesh or on a mesh in a wrong unit, the size that was
asked for is not possible.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.errors import TessellationError
from stitchmesh.mesh import FloatArray, IntArray, StitchMesh

ALLOWED_DEVIATION = 0.2
"""Relative deviation of the median from the size that was asked for, above which a warning is given."""
SMALLEST_RATIO = 0.25
"""Median divided by the size that was asked for, below which the size is refused."""
DIGITS = 9
"""Decimal digits to which that ratio is rounded, so that no last bit decides."""


def reached_sizes(fabric: StitchMesh) -> dict[str, dict[str, float]]:
    """Return the median, the 5th and the 95th percentile of the stitch width and of the stitch height [cm].

    Args:
        fabric: a tessellated fabric.
    """
    wale = fabric.is_wale[fabric.edge_side]
    length = fabric.side_length[fabric.edge_side]
    return {name: _percentiles(length[part]) for name, part in (("width_cm", ~wale), ("height_cm", wale))}


def doubt_of_size(labeled: StitchMesh, counts: IntArray, stitch_width: float, stitch_height: float) -> str:
    """Refuse a stitch size that is far from possible, and say in one line where it is not met; no text if it is met.

    Args:
        labeled: the labeled mesh.
        counts: number of stitches along each edge that follows from the size, shape (E,).
        stitch_width: wale spacing that was asked for [cm].
        stitch_height: course spacing that was asked for [cm].

    Raises:
        TessellationError: the median of the stitches' widths or heights is less than a quarter of what was asked for.
    """
    wale = labeled.is_wale[labeled.edge_side]
    length = labeled.side_length[labeled.edge_side]
    for name, part, asked in (("width", ~wale, stitch_width), ("height", wale, stitch_height)):
        median = float(np.median(np.repeat(length[part] / counts[part], counts[part])))
        face = float(np.median(length[part]))
        ratio = round(median / asked, DIGITS)
        if ratio < SMALLEST_RATIO:
            raise TessellationError(
                f"stitch {name}: got {asked:g} cm, but each face holds at least one stitch, and faces of this mesh "
                f"have a {name} of {face:.3g} cm (median); at most {face / (1.0 - ALLOWED_DEVIATION):.2g} cm is "
                "possible, so use a smaller size or a mesh with larger faces"
            )
        if abs(round(ratio - 1.0, DIGITS)) > ALLOWED_DEVIATION:
            return (
                f"stitch {name}: asked for {asked:g} cm, reached {median:.3g} cm (median), because each edge of the "
                f"mesh is divided into whole stitches and faces have a {name} of {face:.3g} cm (median)"
            )
    return ""


def _percentiles(length: FloatArray) -> dict[str, float]:
    """Return the median, the 5th and the 95th percentile of lengths [cm]."""
    low, median, high = np.percentile(length, [5, 50, 95])
    return {"median": round(float(median), 4), "p5": round(float(low), 4), "p95": round(float(high), 4)}
