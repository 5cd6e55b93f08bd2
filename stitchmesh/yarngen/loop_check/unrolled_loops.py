# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Loops of a fabric that repeats, told apart from their images.

In a cell of a stitch or two a loop meets its own images, and closings would have to be led from image to image. So the
cell stands in the middle of copies of it, and all yarn is drawn in the image in which its stitch lies: arcs that do not
cross the border of all copies together run on as they do in a piece of fabric, and those of the middle are told.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import YarnError
from stitchmesh.mesh import IntArray, StitchMesh
from stitchmesh.quality import PRESETS
from stitchmesh.yarn import YarnSet
from stitchmesh.yarngen.finish import YarnFinish
from stitchmesh.yarngen.generate import drawn_yarns, images_of_points, yarn_course
from stitchmesh.yarngen.loop_check.loops import Arc, Arcs, find_arcs
from stitchmesh.yarngen.loop_check.passes import expected_passes, spanned_sides
from stitchmesh.yarngen.loop_check.strands import SAMPLES
from stitchmesh.yarngen.loop_check.supercell import supercell

MARGINS = (5, 10, 20, 40)
"""Stitches and rows around the cell: the first of them within which all arcs of the middle lie is taken."""


@dataclass(frozen=True, eq=False)
class UnrolledLoops:
    """Arcs that can be told."""

    arcs: Arcs
    """All loops and links."""
    yarns: YarnSet
    """Their yarns, without a lattice."""
    links: NDArray[np.bool_]
    """Which links are to be told, shape (links,)."""
    loops: NDArray[np.bool_]
    """Which loops they may pass through, shape (loops,)."""
    image: IntArray
    """The image of the larger cell in which each control point's stitch was drawn, shape (N, 2)."""


def unroll_loops(fabric: StitchMesh, radius: float, finish: YarnFinish) -> UnrolledLoops:
    """The drawn yarns of a fabric on a lattice, unrolled, and the arcs of one cell."""
    for margin in MARGINS:
        found = _within(fabric, radius, finish, margin)
        if _is_whole(found):
            return found
    raise YarnError(f"yarns: a loop or float is longer than {MARGINS[-1]} stitches or rows; expected shorter ones")


def _within(fabric: StitchMesh, radius: float, finish: YarnFinish, margin: int) -> UnrolledLoops:
    size = np.array([np.bincount(fabric.row).min(), fabric.row.max() + 1])
    beside = -(-margin // size)
    columns, rows = (2 * beside + 1).tolist()
    cover = supercell(fabric, columns, rows)
    course = yarn_course(cover, radius, PRESETS["draft"].control_points_per_stitch, finish)
    drawn = drawn_yarns(course, radius)
    image = images_of_points(course)
    assert cover.lattice is not None
    flat = replace(drawn, points=drawn.points - cover.lattice.shift(image), lattice=None, lattice_step=None)
    arcs = _named_by_cell(find_arcs(cover, flat, finish), fabric.face_count)
    middle = int(beside[0] + columns * beside[1])
    own = np.array([arcs.pieces.face[link.pieces[0]] // fabric.face_count == middle for link in arcs.links])
    return UnrolledLoops(arcs, flat, own, np.array([_runs_on(flat, image, loop) for loop in arcs.loops]), image)


def _named_by_cell(arcs: Arcs, face_count: int) -> Arcs:
    """Arcs whose faces have the numbers of those in the cell that they are copies of."""
    course = arcs.pieces.course
    return replace(arcs, pieces=replace(arcs.pieces, course=replace(course, face_below=course.face_below % face_count)))


def _runs_on(yarns: YarnSet, image: IntArray, arc: Arc) -> bool:
    """Whether an arc stays in one image, with the control points beside it that shape its ends."""
    start, after = yarns.start[arc.yarn : arc.yarn + 2]
    first = arc.first // SAMPLES - start
    places = np.arange(first - 1, first + arc.count // SAMPLES + 4)
    images = image[start + places % (after - start)]
    return bool((images == images[0]).all())


def _is_whole(told: UnrolledLoops) -> bool:
    """Whether all loops that the links to be told name or pass beside, and these links, are in one image."""
    arcs = told.arcs
    named = np.flatnonzero(abs(expected_passes(arcs))[told.links].sum(axis=0))
    links = [arcs.links[k] for k in np.flatnonzero(told.links)]
    spanned = [arcs.loop_over[side] for link in links for side, _ in spanned_sides(arcs, link)]
    return bool(told.loops[[*named, *spanned]].all()) and all(_runs_on(told.yarns, told.image, link) for link in links)
