# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The yarns of a repeat as they are generated, with the loop length of its stitches and before any relaxation."""

from __future__ import annotations

import functools
from dataclasses import replace
from typing import Any

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import StitchMesh
from stitchmesh.patterns import Pattern
from stitchmesh.periodic.repeat.repeat_checks import check_floats, check_loops_begin
from stitchmesh.periodic.repeat.torus import torus_mesh
from stitchmesh.periodic.resolve_pattern import Source
from stitchmesh.periodic.swatch_options import SwatchOptions
from stitchmesh.periodic.weave.weave import Weave
from stitchmesh.periodic.weave.yarns import weave_yarns
from stitchmesh.quality import Quality
from stitchmesh.tessellate import COURSE_OVER_WALE_SPACING
from stitchmesh.yarn import APPARENT_OVER_CONTACT, YarnSet
from stitchmesh.yarn.rest_length import RestLengths, apply_rest_lengths, carried_segments, plain_stitches, segment_faces
from stitchmesh.yarngen import belongs_to_loop_below, generate_yarns

LOOP_OVER_WIDTH = 4.07
"""Yarn length of a generated plain loop over the stitch width, for a yarn radius of an eighth of the width."""
LARGEST_RADIUS_OVER_WIDTH = 0.16
"""Largest yarn radius over the stitch width with which loops are generated; thicker yarn grows from this radius."""

WITHOUT_EFFECT = {
    "rest_lengths", "gamma", "period", "relax_cell", "relaxation", "friction", "unsupported", "blocked",
    "mass_per_length",
}  # fmt: skip
"""Options that do not change the yarns as they are generated."""
KEPT = 16
"""Number of repeats that are kept, because variants of one repeat often differ in the material alone."""


def draw_swatch(source: Source, options: SwatchOptions, quality: Quality) -> tuple[StitchMesh | None, YarnSet]:
    """Generate the yarns of a repeat with a radius that its loops can hold; return the mesh or None, and the yarns.

    Raises:
        ParameterError: an option does not apply to the pattern.
        PatternError: the pattern does not repeat, a loop is slipped in every row, or a float is too long.
    """
    given = {name: value for name, value in vars(options).items() if name not in WITHOUT_EFFECT}
    spacing = tuple(given["spacing"]) if isinstance(given["spacing"], list) else given["spacing"]
    return _draw(source, tuple((given | {"spacing": spacing}).items()), quality)


@functools.lru_cache(KEPT)
def _draw(
    source: Source, given: tuple[tuple[str, Any], ...], quality: Quality
) -> tuple[StitchMesh | None, YarnSet]:  # fmt: skip
    """Generate the yarns with the options that have an effect."""
    options = SwatchOptions(**dict(given))
    drawn = options.drawn_over_contact(APPARENT_OVER_CONTACT if isinstance(source, Pattern) else 1.0)
    if isinstance(source, Weave):
        if options.loop_length is not None:
            raise ParameterError("loop length: got one for a weave, which has no loops; give spacing or rest lengths")
        if (options.columns, options.rows) != (1, 1):
            raise ParameterError("columns, rows: the cell of a weave is one repeat; tile the weave when it is written")
        woven = weave_yarns(source, yarn_radius=options.yarn_radius, spacing=options.spacing, quality=quality)
        return None, replace(woven, drawn_radius=drawn * woven.radius)
    if options.spacing is not None:
        raise ParameterError("spacing: got one for a knitted swatch, whose spacing follows from loop_length; give that")
    loop_length = options.plain_loop
    width = loop_length / LOOP_OVER_WIDTH
    fabric = _fabric(source, options.columns, options.rows, width)
    check_loops_begin(fabric)
    check_floats(fabric, options.longest_float)
    radius = min(options.yarn_radius, LARGEST_RADIUS_OVER_WIDTH * width)
    yarns = generate_yarns(
        fabric, yarn_radius=radius, drawn_radius=drawn * radius, quality=quality, longest_float=options.longest_float
    )
    if not plain_stitches(fabric).any():
        # no plain stitch can be measured; a plain stitch generated at this width would have the loop length
        return fabric, even_rest_lengths(yarns, fabric)
    yarns = apply_rest_lengths(yarns, RestLengths(loop_length=loop_length), fabric=fabric)
    return fabric, even_rest_lengths(yarns, fabric)


@functools.lru_cache(KEPT)
def _fabric(source: Pattern, columns: int, rows: int, width: float) -> StitchMesh:
    """The stitch mesh of a repeat, whose yarns are generated with several qualities."""
    return torus_mesh(
        source, stitch_width=width, stitch_height=COURSE_OVER_WALE_SPACING * width, columns=columns, rows=rows
    )


def even_rest_lengths(yarns: YarnSet, fabric: StitchMesh) -> YarnSet:
    """Distribute the rest length evenly over the segments of each stitch.

    The loop below a stitch is treated as a separate part. If all stitches are plain and equal, the rest length is
    distributed within each loop instead: this follows from symmetry, and yarn can slide through its loops. Without an
    even distribution, a spline stretches locally even if its total length is right, and this costs energy.
    """
    below = fabric.side_face[fabric.twin[fabric.face_start[:-1]]]
    alike = plain_stitches(fabric).all() and len(np.unique([fabric.stitch, fabric.yarn], axis=1).T) == 1
    head_of = below if alike else fabric.face_count + np.arange(fabric.face_count)
    face = segment_faces(yarns)
    stitch = np.where(belongs_to_loop_below(yarns, fabric)[yarns.segment_points[:, 1]], head_of[face], face)
    stitch = np.where(carried_segments(yarns), 2 * fabric.face_count + face, stitch)
    _, run, count = np.unique(
        3 * fabric.face_count * yarns.segment_yarn + stitch, return_inverse=True, return_counts=True
    )
    return replace(yarns, rest_length=(np.bincount(run, yarns.rest_length) / count)[run])
