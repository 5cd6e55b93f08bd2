# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The number of stitches along each edge.

The count of a course edge is its length divided by the stitch width. All wale edges of a row have the same count, their
mean length divided by the stitch height, so that the two wale edges of every face agree.

Each edge of the mesh is divided into whole stitches, at least one. Stitches can therefore not be wider or higher than
the faces of the mesh. Where faces are much smaller, as on a fine mesh or on a mesh in a wrong unit, the requested size
is not possible.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping

import numpy as np

from stitchmesh.errors import ParameterError, TessellationError, check_positive
from stitchmesh.memory_need import BYTES_PER_STITCH_OF_GARMENT, GIGABYTE, check_memory
from stitchmesh.mesh import BOTTOM, FloatArray, IntArray, StitchMesh

ALLOWED_DEVIATION = 0.2
"""A warning is given if the median deviates from the requested size by more than this part of it."""
DIGITS = 9
"""Decimal digits to which this ratio is rounded, so that the last bit does not decide."""
logger = logging.getLogger(__name__)

EdgeName = int | tuple[int, int]

MOST_STITCHES = 1_000_000
"""Largest number of stitch faces; a larger request is refused, because it could exhaust the memory of the machine."""


def reached_sizes(fabric: StitchMesh) -> dict[str, dict[str, float]]:
    """Return the median, the 5th and the 95th percentile of the stitch width and of the stitch height [cm].

    Args:
        fabric: a tessellated fabric.
    """
    wale = fabric.is_wale[fabric.edge_side]
    length = fabric.side_length[fabric.edge_side]
    return {name: _percentiles(length[part]) for name, part in (("width_cm", ~wale), ("height_cm", wale))}


def doubt_of_size(labeled: StitchMesh, counts: IntArray, stitch_width: float, stitch_height: float) -> str:
    """Refuse a stitch size that is far from possible, and say in one line where it is not met; else no text.

    Args:
        labeled: the labeled mesh.
        counts: number of stitches along each edge that follows from the size, shape (E,).
        stitch_width: requested wale spacing [cm].
        stitch_height: requested course spacing [cm].

    Raises:
        TessellationError: the median of the stitches' widths or heights is less than a quarter of the requested size.
    """
    wale = labeled.is_wale[labeled.edge_side]
    length = labeled.side_length[labeled.edge_side]
    for name, part, asked in (("width", ~wale, stitch_width), ("height", wale, stitch_height)):
        median = float(np.median(np.repeat(length[part] / counts[part], counts[part])))
        face = float(np.median(length[part]))
        ratio = round(median / asked, DIGITS)
        # A size is refused if the median, divided by the requested size, is below this.
        if ratio < 0.25:
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


def edge_counts(
    labeled: StitchMesh, stitch_width: float, stitch_height: float, given: Mapping[EdgeName, int]
) -> IntArray:
    """Return the number of stitches along each edge, shape (E,).

    Args:
        labeled: the labeled mesh.
        stitch_width: wale spacing [cm].
        stitch_height: course spacing [cm].
        given: counts of single edges; the count of a wale edge applies to its whole row.

    Raises:
        ParameterError: the stitch size is not positive or larger than the garment, a given count is below 1, or its
            edge does not exist.
        TessellationError: two given counts of one row differ, the stitches would not fit in memory, or the faces of
            the mesh are so small that stitches of this size are far from possible.
    """
    counts, doubt = counts_and_doubt(labeled, stitch_width, stitch_height, given)
    if doubt:
        logger.warning(doubt)
    return counts


def counts_and_doubt(
    labeled: StitchMesh, stitch_width: float, stitch_height: float, given: Mapping[EdgeName, int]
) -> tuple[IntArray, str]:
    """Return the number of stitches along each edge, shape (E,), and why the size may be wrong, or no text.

    The arguments and the errors are the same as for ``edge_counts``.
    """
    _check_size(labeled, stitch_width, stitch_height)
    first = labeled.edge_side
    length = labeled.side_length[first]
    counts = whole_count(length / stitch_width)
    rows = _row_counts(labeled, length, stitch_height)
    wale = labeled.is_wale[first]
    counts[wale] = rows[labeled.row[labeled.side_face[first[wale]]]]
    _refuse_too_many(labeled, counts, stitch_width)
    whole = counts.astype(np.int64)
    doubt = doubt_of_size(labeled, whole, stitch_width, stitch_height)
    counted = _with_given(labeled, whole, given)
    _refuse_too_many(labeled, counted.astype(np.float64), stitch_width)
    return counted, doubt


def whole_count(quotient: FloatArray) -> FloatArray:
    """Return the nearest integers, at least 1, shape (n,); halves, up to rounding errors, become even integers."""
    count: FloatArray = np.maximum(1.0, np.rint(np.round(quotient, DIGITS)))
    return count


def _check_size(labeled: StitchMesh, width: float, height: float) -> None:
    for name, size in (("stitch width", width), ("stitch height", height)):
        check_positive(name, size, "cm")
    bottom = labeled.side_role == BOTTOM
    around = np.bincount(labeled.row[labeled.side_face[bottom]], labeled.side_length[bottom])
    if width > around.max() * (1.0 + 10.0**-DIGITS):
        raise ParameterError(
            f"stitch width: got {width} cm, but the widest row is {around.max():.4g} cm around; "
            "use a narrower stitch or check the unit of the mesh"
        )


def _row_counts(labeled: StitchMesh, length: np.ndarray, height: float) -> np.ndarray:
    """Number of stitch rows in each row of panels, shape (rows,)."""
    wale_length = length[labeled.side_edge[labeled.left_wale]] + length[labeled.side_edge[labeled.right_wale]]
    total = np.bincount(labeled.row, wale_length / 2)
    return whole_count(total / np.bincount(labeled.row) / height)


def _refuse_too_many(labeled: StitchMesh, counts: np.ndarray, width: float) -> None:
    """Raise an error if there would be more than ``MOST_STITCHES`` stitches."""
    along = np.where(labeled.is_wale, 0.0, counts[labeled.side_edge])
    stitches = np.add.reduceat(along, labeled.face_start[:-1]) / 2 * counts[labeled.side_edge[labeled.left_wale]]
    total = stitches.sum()
    needed = total * BYTES_PER_STITCH_OF_GARMENT
    if total > MOST_STITCHES:
        raise TessellationError(
            f"stitch width {width:g} cm: needs about {total:.2g} stitches and {needed / GIGABYTE:.3g} GB "
            f"of memory; at most {MOST_STITCHES:,} stitches are allowed, so use fewer, or a width of at least "
            f"{width * (total / MOST_STITCHES) ** 0.5:.2g} cm"
        )
    check_memory(f"a garment of {total:,.3g} stitches", needed, "wider stitches, or smaller counts of edges")


def _with_given(labeled: StitchMesh, counts: IntArray, given: Mapping[EdgeName, int]) -> IntArray:
    """Replace the counts of single edges by given counts."""
    rows: dict[int, int] = {}
    for name, count in given.items():
        edge = edge_named(labeled, name)
        if count < 1:
            raise ParameterError(f"count of edge {name}: got {count}; expected at least 1")
        counts[edge] = count
        side = labeled.edge_side[edge]
        if labeled.is_wale[side]:
            row = int(labeled.row[labeled.side_face[side]])
            if rows.setdefault(row, count) != count:
                raise TessellationError(
                    f"count of edge {name}: got {count}, but another wale edge of row {row} was given {rows[row]}; "
                    "all wale edges of a row take one count"
                )
    for row, count in rows.items():
        first = int(labeled.left_wale[np.flatnonzero(labeled.row == row)[0]])
        counts[edges_with_one_count(labeled, int(labeled.side_edge[first]))] = count
    return counts


def edges_with_one_count(labeled: StitchMesh, edge: int) -> IntArray:
    """Return the edges that have the same number of stitches as an edge by rule: all wale edges of its row.

    A course edge is returned alone. Shape (n,).
    """
    side = labeled.edge_side[edge]
    if not labeled.is_wale[side]:
        return np.array([edge])
    in_row = labeled.row[labeled.side_face] == labeled.row[labeled.side_face[side]]
    return np.unique(labeled.side_edge[in_row & labeled.is_wale])


def edge_named(labeled: StitchMesh, name: EdgeName) -> int:
    """Return the edge of a side number or of a pair of vertices.

    Raises:
        ParameterError: there is no such edge.
    """
    if isinstance(name, (int, np.integer)):
        if not 0 <= name < labeled.side_count:
            raise ParameterError(f"side {name}: does not exist; the mesh has sides 0 to {labeled.side_count - 1}")
        return int(labeled.side_edge[name])
    tail, head = labeled.face_vertex, labeled.face_vertex[labeled.side_next]
    found = np.flatnonzero(((tail == name[0]) & (head == name[1])) | ((tail == name[1]) & (head == name[0])))
    if len(found) == 0:
        raise ParameterError(f"edge {name}: no edge joins these vertices; name two neighbours")
    return int(labeled.side_edge[found[0]])
