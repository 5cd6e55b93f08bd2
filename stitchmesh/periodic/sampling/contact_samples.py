# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How many contact samples a repeat needs: more in small free cells (``sampling``) and for loose loops."""

from __future__ import annotations

import math
from dataclasses import replace

from stitchmesh.mesh import StitchMesh
from stitchmesh.periodic.repeat.smallest_cell import SmallestCell
from stitchmesh.periodic.sampling.sampling import SMALL_CELL, with_smooth_contacts
from stitchmesh.periodic.swatch_options import COMPACT_LOOP, SwatchOptions
from stitchmesh.quality import Quality
from stitchmesh.yarnrelax import RelaxCell

CLOSER = 1.5
"""Exponent of the looseness in the number of contact samples. Contact spheres that interlock hold a loop back. In a
looser loop the bends of the yarn are further apart, so both this holding force and the forces that straighten the yarn
are smaller (docs/validation.md)."""
LOOSEST = 4.0
"""Looseness above which the number of contact samples stays constant."""
ROUNDING = 1e-12
"""Relative rounding error of a quotient of lengths."""


def with_contacts(
    quality: Quality, options: SwatchOptions, fabric: StitchMesh | None, smallest: SmallestCell, cell: RelaxCell | None
) -> Quality:
    """Return a quality with as many contact samples as a repeat needs: more in small free cells and for loose loops.

    Args:
        quality: a quality of the path to rest.
        options: options of the swatch.
        fabric: the stitch mesh of the repeat; None for a weave.
        smallest: the cell that comes to rest.
        cell: its degrees of freedom; None for constant periods.
    """
    is_free = cell is not None and cell.free.any()
    return close_contacts(with_smooth_contacts(quality) if is_free and is_small(fabric, smallest) else quality, options)


def is_small(fabric: StitchMesh | None, smallest: SmallestCell) -> bool:
    """Return whether the cell that comes to rest has few stitches; for a weave (None) it has none."""
    return fabric is not None and fabric.face_count <= SMALL_CELL * smallest.copies


def close_contacts(quality: Quality, options: SwatchOptions) -> Quality:
    """Return the quality with more contact samples if loops are looser than compact ones.

    The number of control points of a stitch is the same for long and short loops, so the contact spheres of a segment
    are further apart in long loops. Such spheres interlock, and the loops stay narrower than in equilibrium.
    """
    looseness = options.plain_loop / (2 * COMPACT_LOOP * options.yarn_radius * options.gamma)
    closer = min(max(looseness, 1.0), LOOSEST) ** CLOSER
    return replace(quality, contact_samples=math.ceil(quality.contact_samples * closer * (1.0 - ROUNDING)))
