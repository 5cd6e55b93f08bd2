# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The yarns of a repeat as they are generated, with the loop length of its stitches and before any relaxation.

A repeat that cannot be knitted is refused. A loop that every row slips never begins, and no yarn can be generated for
it. A float behind many stitches can be generated, but a knitter does not make it.
"""

from __future__ import annotations

import functools
from dataclasses import replace
from typing import Any

import numpy as np

from stitchmesh.errors import ParameterError, PatternError
from stitchmesh.mesh import BORDER, StitchMesh
from stitchmesh.mesh.courses import find_courses
from stitchmesh.patterns import Pattern
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
from stitchmesh.yarngen.finish import YarnFinish

LOOP_OVER_WIDTH = 4.07
"""Yarn length of a generated plain loop over the stitch width, for a yarn radius of an eighth of the width."""
LARGEST_RADIUS_OVER_WIDTH = 0.16
"""Largest yarn radius over the stitch width with which loops are generated; thicker yarn grows from this radius."""

WITHOUT_EFFECT = {
    "rest_lengths", "gamma", "period", "relax_cell", "relaxation", "friction", "unsupported", "blocked",
    "residual_twist", "steamed", "yield_curvature", "mass_per_length", "terms",
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
    fabric = _fabric(source, options.columns, options.rows, width, options.longest_float)
    radius = min(options.yarn_radius, LARGEST_RADIUS_OVER_WIDTH * width)
    yarns = generate_yarns(
        fabric, yarn_radius=radius, drawn_radius=drawn * radius, quality=quality,
        finish=YarnFinish(longest_float=options.longest_float),
    )
    if not plain_stitches(fabric).any():
        # no plain stitch can be measured; a plain stitch generated at this width would have the loop length
        return fabric, even_rest_lengths(yarns, fabric)
    yarns = apply_rest_lengths(yarns, RestLengths(loop_length=loop_length), fabric=fabric)
    return fabric, even_rest_lengths(yarns, fabric)


@functools.lru_cache(KEPT)
def _fabric(source: Pattern, columns: int, rows: int, width: float, longest_float: int) -> StitchMesh:
    """The stitch mesh of a repeat that can be knitted; its yarns are generated with several qualities."""
    height = COURSE_OVER_WALE_SPACING * width
    fabric = torus_mesh(source, stitch_width=width, stitch_height=height, columns=columns, rows=rows)
    check_loops_begin(fabric)
    check_floats(fabric, longest_float)
    return fabric


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


def check_loops_begin(fabric: StitchMesh) -> None:
    """Check that each slipped loop is made by a stitch in some row below.

    Raises:
        PatternError: a loop is slipped in every row; the message gives the row and the stitch.
    """
    below = fabric.slipped_from
    side = np.flatnonzero(below != BORDER)
    for _ in range(len(side) + 1):
        if not len(side):
            return
        across = fabric.twin[below[side]]
        side = np.unique(across[(across != BORDER) & (below[across] != BORDER)])
    where = _place(fabric, int(fabric.side_face[side].min()))
    raise PatternError(f"{where}: slips a loop that every row slips; knit or purl it in one of them")


def check_floats(fabric: StitchMesh, longest: int) -> None:
    """Check that no yarn floats behind more than ``longest`` stitches of other yarns.

    Raises:
        PatternError: a float is too long; the message names the longest one.
    """
    length, face = max(_floats(fabric), default=(0, 0))
    if length > longest:
        centimetres = length * float(fabric.side_length[~fabric.is_wale].mean())
        found = f"yarn {fabric.yarn[face]} floats behind {length} stitches ({centimetres:.2g} cm)"
        advice = f"at most {longest} are allowed; work a stitch of this yarn among them, or raise longest_float"
        raise PatternError(f"{_place(fabric, face)}: {found}; {advice} (--longest-float)")


def _floats(fabric: StitchMesh) -> list[tuple[int, int]]:
    """Return the length of each float in stitches, and the face to the left of the float."""
    found = []
    for course in find_courses(fabric):
        faces = np.array(course.faces)
        for yarn in np.unique(fabric.yarn[faces]):
            place = np.flatnonzero(fabric.yarn[faces] == yarn)
            length = np.diff(place, append=place[0] + len(faces)) - 1
            found += list(zip(length.tolist(), faces[place].tolist(), strict=True))
    return found


def _place(fabric: StitchMesh, face: int) -> str:
    """Return the words for the place of a face in its repeat."""
    number = np.flatnonzero(np.flatnonzero(fabric.row == fabric.row[face]) == face)[0]
    return f"row {fabric.row[face] + 1}, stitch {number + 1} from the left"
