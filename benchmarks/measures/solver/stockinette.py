# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Relaxed stockinette: loop length, wale spacing and course spacing in the middle of a flat swatch, and a picture.

The border stitches of the swatch are held, so that the gauge is that of the stitch mesh and only the shape of the loops
relaxes. Munden's constants K_c = loop length / course spacing and K_w = loop length / wale spacing are printed for
comparison with relaxed plain knit (5.0 to 5.5 and 3.8 to 4.2).
"""

from __future__ import annotations

import numpy as np

from benchmarks.table import Rows
from stitchmesh.labeling import label
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.tessellate import COURSE_OVER_WALE_SPACING, tessellate
from stitchmesh.yarn import YarnSet
from stitchmesh.yarngen import generate_yarns
from stitchmesh.yarnrelax import relax_yarns

BORDER_STITCHES = 4
"""Number of stitches between the border and the middle region."""


def swatch(wales: int, courses: int, stitch_width: float) -> StitchMesh:
    """A flat rectangle of plain stitches."""
    width, height = wales * stitch_width, courses * stitch_width * COURSE_OVER_WALE_SPACING
    mesh = Mesh.from_polygons([[0, 0, 0], [width, 0, 0], [width, height, 0], [0, height, 0]], [[0, 1, 2, 3]])
    return tessellate(label(mesh), stitch_width=stitch_width)


def gauge(fabric: StitchMesh, yarns: YarnSet, wales: int, courses: int) -> dict[str, float]:
    """Return the loop length, the wale spacing and the course spacing of the stitches in the middle [cm]."""
    count = np.bincount(yarns.face, minlength=fabric.face_count)
    centre = np.stack([np.bincount(yarns.face, axis, fabric.face_count) / count for axis in yarns.points.T], axis=1)
    grid = centre.reshape(courses, wales, 3)
    inner = slice(BORDER_STITCHES, -BORDER_STITCHES)
    middle = grid[inner, inner]
    owner = yarns.face[yarns.segment_points[:, 1]]
    length = np.bincount(owner, yarns.lengths, fabric.face_count).reshape(courses, wales)[inner, inner]
    return {
        "loop_length": float(length.mean()),
        "wale_spacing": float(np.linalg.norm(np.diff(middle, axis=1), axis=2).mean()),
        "course_spacing": float(np.linalg.norm(np.diff(middle, axis=0), axis=2).mean()),
    }


def stockinette(
    *,
    wales: int = 20,
    courses: int = 24,
    stitch_width: float = 0.8,
    quality: str = "standard",
    device: str = "cpu",
    picture: str | None = None,
) -> Rows:
    """Relax a swatch and print its gauge.

    Args:
        picture: PNG to draw
    """
    fabric = swatch(wales, courses, stitch_width)
    yarns = generate_yarns(fabric, quality=quality)
    relaxed = relax_yarns(yarns, quality=quality, device=device, keep_shape=fabric)
    for name, state in (("as generated", yarns), ("relaxed", relaxed.yarns)):
        sizes = gauge(fabric, state, wales, courses)
        diameters = sizes["loop_length"] / (2 * state.radius[0])
        yield f"{name}: " + ", ".join(f"{key} {value:.4f} cm" for key, value in sizes.items())
        k_c, k_w = (sizes["loop_length"] / sizes[name] for name in ("course_spacing", "wale_spacing"))
        yield f"loop length {diameters:.2f} yarn diameters, K_c {k_c:.2f}, K_w {k_w:.2f}"
    yield f"residual {relaxed.report['residual']:.2g} after {relaxed.report['iterations']} iterations"
    if picture:
        from stitchmesh.render import render_yarns

        render_yarns(relaxed.yarns, picture)
