# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Thumbnails of patterns: the yarns of a few repeats, drawn without a graphics library in some hundredths of a second.

The yarns are those of a flat fabric before relaxation. Each sample of a yarn is drawn as a shaded ball, and each pixel
shows the foremost of its balls. A pattern of several yarns has their colours. In a pattern of one yarn the colours tell
the stitches apart, as in the picture of a stitch mesh.
"""

from __future__ import annotations

import io

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError, check_kind
from stitchmesh.mesh import FloatArray
from stitchmesh.patterns.pattern import Pattern
from stitchmesh.patterns.swatch_mesh import pattern_mesh
from stitchmesh.render.colouring import colour_yarns
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.polyline import polylines_of_segments
from stitchmesh.yarngen import generate_yarns
from stitchmesh.yarngen.templates.template import RADIUS_OVER_WIDTH, STITCH_HEIGHT

FINER = 2
"""Number of drawn pixels for each pixel of the thumbnail, in each direction."""
SAMPLES = 4
"""Balls for each segment of a yarn."""
SIZES = range(16, 513)
"""Sizes of a thumbnail [pixels]."""
LIGHT = np.array([-0.35, 0.45, 0.82])
"""Direction to the light: above on the left, in front."""
AMBIENT, DEPTH = 0.42, 0.38
"""Brightness without light, and loss of brightness from the foremost to the rearmost yarn."""
GROUND = (74, 68, 62)
"""Colour behind the yarns (sRGB)."""


def pattern_thumbnail(pattern: Pattern, size: int = 72) -> bytes:
    """Draw some repeats of a pattern from the right side.

    Args:
        pattern: a pattern that repeats upwards.
        size: width and height [pixels], 16 to 512.

    Returns:
        A PNG file.

    Raises:
        ParameterError: the size is out of range.
        PatternError: the pattern does not close.
    """
    from PIL import Image

    check_kind("pattern_thumbnail", pattern, Pattern)
    if size not in SIZES:
        raise ParameterError(f"thumbnail: got a size of {size} pixels; expected {SIZES[0]} to {SIZES[-1]}")
    columns = -(-8 // pattern.width)  # Narrower patterns are repeated.
    width = columns * pattern.width
    rows = -(-int(np.ceil(width / STITCH_HEIGHT)) // pattern.height)
    fabric = pattern_mesh(pattern, columns, rows, stitch_width=1.0, stitch_height=STITCH_HEIGHT)
    yarns = generate_yarns(fabric, yarn_radius=RADIUS_OVER_WIDTH)
    left = float(pattern.rows[0].bottoms[0])
    colours = colour_yarns(yarns, "yarn" if pattern.yarn_count > 1 else "stitch", fabric=fabric).points
    picture = _balls(yarns, colours, np.array([left, STITCH_HEIGHT]), float(width), FINER * size)
    image = Image.fromarray(picture).resize((size, size), Image.Resampling.BOX)
    content = io.BytesIO()
    image.save(content, "PNG", optimize=True)
    return content.getvalue()


def _balls(yarns: YarnSet, colours: NDArray[np.uint8], low: FloatArray, extent: float, size: int) -> NDArray[np.uint8]:
    """Draw the samples of the yarns as balls.

    Args:
        yarns: the yarns; the viewer looks along -z.
        colours: colour of each control point (sRGB), shape (N, 3).
        low: lower left corner of the picture [cm], shape (2,).
        extent: width and height of the picture [cm].
        size: width and height [pixels].

    Returns:
        Colours (sRGB), shape (size, size, 3).
    """
    curves = polylines_of_segments(yarns, np.arange(len(yarns.segment_points)), SAMPLES)
    points = np.concatenate(curves.points)
    scale = size / extent
    radius = scale * float(yarns.radius.mean())
    shifts, normals = _ball(radius)
    colour = np.tile(colours[curves.control_point], (len(shifts), 1))
    place = (points[None, :, :2] - low) * scale
    pixel = np.rint(place + shifts[:, None]).astype(np.int64).reshape(-1, 2)
    height = (points[None, :, 2] * scale + radius * normals[:, None, 2]).ravel()
    bright = np.repeat(AMBIENT + (1.0 - AMBIENT) * np.maximum(normals @ LIGHT, 0.0), len(points))
    seen = np.flatnonzero(((pixel >= 0) & (pixel < size)).all(axis=1))
    order = seen[np.argsort(height[seen], kind="stable")]
    depth = (height[order] - height[order].min()) / max(float(np.ptp(height[order])), 1e-9)
    shade = bright[order] * (1.0 - DEPTH * (1.0 - depth))
    picture = np.full((size, size, 3), GROUND, dtype=np.uint8)
    x, y = pixel[order].T
    picture[size - 1 - y, x] = np.clip(colour[order] * shade[:, None], 0, 255).astype(np.uint8)
    return picture


def _ball(radius: float) -> tuple[FloatArray, FloatArray]:
    """Return the pixels of a ball relative to its centre, shape (n, 2), and its unit normals there, shape (n, 3)."""
    reach = int(np.ceil(radius))
    x, y = (axis.ravel() for axis in np.mgrid[-reach : reach + 1, -reach : reach + 1])
    inside = x**2 + y**2 <= radius**2
    flat = np.stack([x[inside], y[inside]], axis=1).astype(np.float64)
    across = flat / radius
    towards = np.sqrt(np.maximum(1.0 - (across**2).sum(axis=1), 0.0))
    return flat, np.column_stack([across, towards])
