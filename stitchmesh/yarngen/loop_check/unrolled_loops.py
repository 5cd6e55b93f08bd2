# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Loops of a periodic fabric, unrolled so that they can be distinguished from their lattice images.

In a cell of one or two stitches a loop meets its own images, and its closure would have to continue from image to
image. The cell is therefore put in the middle of a supercell, and all yarn is placed in the lattice image of its
stitch. Arcs that do not cross the border of the supercell are then continuous, as in a piece of fabric that is not
periodic. The links of the middle cell are checked. A supercell consists of copies of the cell beside and above each
other.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import YarnError
from stitchmesh.lattice import Lattice
from stitchmesh.linking.yarn_polylines import SAMPLES_PER_POINT
from stitchmesh.mesh import BORDER, IntArray, StitchMesh
from stitchmesh.quality import PRESETS
from stitchmesh.yarn import YarnSet
from stitchmesh.yarngen.finish import YarnFinish
from stitchmesh.yarngen.generate import control_point_images, trace_yarn_routes, yarns_along_routes
from stitchmesh.yarngen.loop_check.loops import Arc, Arcs, find_arcs
from stitchmesh.yarngen.loop_check.threadings import expected_threadings, spanned_sides

MARGINS = (5, 10, 20, 40)
"""Numbers of stitches and rows around the cell. They are tried in this order, until all arcs of the middle cell are
complete."""


def supercell(fabric: StitchMesh, columns: int, rows: int) -> StitchMesh:
    """A stitch mesh on a lattice that consists of copies of a cell.

    Args:
        fabric: the stitch mesh of the cell, on a lattice.
        columns: number of copies along the courses.
        rows: number of copies along the wales.

    Returns:
        The supercell. Its copies are numbered along the courses first and then upwards.
    """
    assert fabric.lattice is not None and fabric.corner_image is not None
    size = np.array([columns, rows])
    copy = np.stack([index.ravel() for index in np.indices((rows, columns))[::-1]], axis=1)
    vertex_copy, corner_image = _reached(copy, fabric.corner_image, size)
    side_copy, _ = _reached(copy, fabric.side_image, size)
    count, corners = len(copy), fabric.side_count
    starts = (np.arange(count)[:, None] * corners + fabric.face_start[:-1]).ravel()
    marks = {
        name: np.tile(getattr(fabric, name), count)
        for name in ("n_bottom", "n_top", "stitch", "yarn", "twist", "cable_shift", "cable_layer")
    }
    return replace(
        fabric,
        vertices=(fabric.vertices + fabric.lattice.shift(copy)[:, None]).reshape(-1, 3),
        face_start=np.append(starts, count * corners),
        face_vertex=(fabric.face_vertex + vertex_copy * len(fabric.vertices)).ravel(),
        twin=np.where(fabric.twin == BORDER, BORDER, fabric.twin + side_copy * corners).ravel(),
        lattice=Lattice(fabric.lattice.periods * size[:, None]),
        corner_image=corner_image.reshape(-1, 2),
        row=(fabric.row + copy[:, 1:] * (fabric.row.max() + 1)).ravel(),
        stretch=None,
        **marks,  # type: ignore[arg-type]
    )


def _reached(copy: IntArray, image: IntArray, size: IntArray) -> tuple[IntArray, IntArray]:
    """The copy that each image leads to from each copy, and its image in the supercell.

    Args:
        copy: column and row of each copy, shape (n, 2).
        image: lattice images in the cell, shape (k, 2).
        size: numbers of columns and rows.

    Returns:
        Numbers of the copies, shape (n, k), and lattice images of the supercell, shape (n, k, 2).
    """
    there = copy[:, None] + image
    inside = there % size
    return inside[..., 0] + inside[..., 1] * size[0], there // size


@dataclass(frozen=True, eq=False)
class UnrolledLoops:
    """The arcs of a supercell, and which of them can be checked."""

    arcs: Arcs
    """All loops and links of the supercell."""
    yarns: YarnSet
    """The yarns of the arcs, without a lattice."""
    links: NDArray[np.bool_]
    """Which links are checked, shape (links,): the links of the middle cell."""
    loops: NDArray[np.bool_]
    """Which loops the links are checked against, shape (loops,): the loops that do not cross the border of the
    supercell."""
    image: IntArray
    """The lattice image of the supercell in which the stitch of each control point lies, shape (N, 2)."""


def unroll_loops(fabric: StitchMesh, radius: float, finish: YarnFinish) -> UnrolledLoops:
    """Generate the yarns of a periodic fabric and unroll the loops of one cell.

    Args:
        fabric: the stitch mesh, on a lattice.
        radius: yarn radius [cm].
        finish: the finish of its yarns.

    Raises:
        YarnError: a loop or a float is longer than the largest margin.
    """
    for margin in MARGINS:
        found = _unroll_with_margin(fabric, radius, finish, margin)
        if _is_complete(found):
            return found
    raise YarnError(f"yarns: a loop or float is longer than {MARGINS[-1]} stitches or rows; expected shorter ones")


def _unroll_with_margin(fabric: StitchMesh, radius: float, finish: YarnFinish, margin: int) -> UnrolledLoops:
    """The unrolled loops of a supercell with ``margin`` stitches and rows around the cell."""
    size = np.array([np.bincount(fabric.row).min(), fabric.row.max() + 1])
    cells_beside = -(-margin // size)
    columns, rows = (2 * cells_beside + 1).tolist()
    larger_mesh = supercell(fabric, columns, rows)
    routes = trace_yarn_routes(larger_mesh, radius, PRESETS["draft"].control_points_per_stitch, finish)
    generated = yarns_along_routes(routes, radius)
    image = control_point_images(routes)
    assert larger_mesh.lattice is not None
    flat = replace(
        generated, points=generated.points - larger_mesh.lattice.shift(image), lattice=None, lattice_step=None
    )
    arcs = _with_cell_face_numbers(find_arcs(larger_mesh, flat, finish), fabric.face_count)
    middle_copy = int(cells_beside[0] + columns * cells_beside[1])
    is_checked = np.array([arcs.pieces.face[link.pieces[0]] // fabric.face_count == middle_copy for link in arcs.links])
    return UnrolledLoops(
        arcs, flat, is_checked, np.array([_lies_in_one_image(flat, image, loop) for loop in arcs.loops]), image
    )


def _with_cell_face_numbers(arcs: Arcs, face_count: int) -> Arcs:
    """The arcs with the face numbers of the cell instead of the numbers of the supercell."""
    routes = arcs.pieces.routes
    return replace(arcs, pieces=replace(arcs.pieces, routes=replace(routes, face_below=routes.face_below % face_count)))


def _lies_in_one_image(yarns: YarnSet, image: IntArray, arc: Arc) -> bool:
    """Whether an arc, with the control points beside it that shape its ends, lies in one image of the supercell."""
    start, after = yarns.start[arc.yarn : arc.yarn + 2]
    first = arc.first // SAMPLES_PER_POINT - start
    places = np.arange(first - 1, first + arc.count // SAMPLES_PER_POINT + 4)
    images = image[start + places % (after - start)]
    return bool((images == images[0]).all())


def _is_complete(unrolled: UnrolledLoops) -> bool:
    """Whether the checked links, and all loops that they thread or pass, lie in one image of the supercell each."""
    arcs = unrolled.arcs
    threaded = np.flatnonzero(abs(expected_threadings(arcs))[unrolled.links].sum(axis=0))
    links = [arcs.links[k] for k in np.flatnonzero(unrolled.links)]
    spanned = [arcs.loop_of_side[side] for link in links for side, _ in spanned_sides(arcs, link)]
    return bool(unrolled.loops[[*threaded, *spanned]].all()) and all(
        _lies_in_one_image(unrolled.yarns, unrolled.image, link) for link in links
    )
