# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Patches of stitches that keep the shape of a garment (Y section 6.3): loops, patches and their weights."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import BORDER, FloatArray, IntArray, StitchMesh
from stitchmesh.yarn import YarnSet

RINGS = 3
"""Radius of a patch: the largest number of sides between its central face and its other faces."""


@dataclass(frozen=True, eq=False)
class WeightedRows:
    """Lists of numbers in compressed rows, each with a weight."""

    start: IntArray
    """Where each row starts, shape (n + 1,)."""
    entry: IntArray
    """The entries, ascending within a row."""
    weight: FloatArray
    """The weight of each entry."""


@dataclass(frozen=True, eq=False)
class Loops:
    """The control points of each stitch face that has control points."""

    points: WeightedRows
    """Control points of each loop."""
    face: IntArray
    """Stitch face of each loop."""
    held: IntArray
    """Loops at the border of the fabric."""


def loops_of(yarns: YarnSet, fabric: StitchMesh) -> Loops:
    """Group control points by stitch face.

    Raises:
        ParameterError: the yarns were not generated from this fabric.
    """
    known = np.flatnonzero(yarns.face >= 0)
    if len(known) == 0 or yarns.face.max() >= fabric.face_count:
        found = f"stitch faces up to {yarns.face.max()}"
        raise ParameterError(f"keep_shape: got yarns with {found} and a fabric of {fabric.face_count}; pass its own")
    order = known[np.argsort(yarns.face[known], kind="stable")]
    face, first = np.unique(yarns.face[order], return_index=True)
    points = WeightedRows(np.append(first, len(order)), order, np.ones(len(order)))
    at_border = np.zeros(fabric.face_count, dtype=bool)
    at_border[fabric.side_face[fabric.twin == BORDER]] = True
    return Loops(points, face, np.flatnonzero(at_border[face]))


def choose_patches(fabric: StitchMesh, loops: Loops, rings: int = RINGS) -> tuple[WeightedRows, IntArray]:
    """Return overlapping patches of loops with tent weights, and the face at each patch's centre."""
    steps = _steps_apart(fabric, rings)
    centres = _greedy_centres(steps, loops.face, rings // 2)
    number = np.full(fabric.face_count, -1)
    number[loops.face] = np.arange(len(loops.face))
    chosen = steps[centres].tocoo()
    member = number[chosen.col]
    inside = member >= 0
    patch, member = chosen.row[inside], member[inside]
    # stored distances are one too large, so that the centre itself is stored
    weight = 1.0 - (chosen.data[inside] - 1.0) / (rings + 1.0)
    order = np.lexsort((member, patch))
    counts = np.bincount(patch, minlength=len(centres))
    rows = WeightedRows(np.concatenate([[0], np.cumsum(counts)]), member[order], weight[order])
    return rows, centres


def owners(patches: WeightedRows, loop_count: int) -> WeightedRows:
    """Return the patches of each loop: the transpose of ``patches``."""
    patch = np.repeat(np.arange(len(patches.start) - 1), np.diff(patches.start))
    order = np.argsort(patches.entry, kind="stable")
    counts = np.bincount(patches.entry, minlength=loop_count)
    return WeightedRows(np.concatenate([[0], np.cumsum(counts)]), patch[order], patches.weight[order])


def _steps_apart(fabric: StitchMesh, rings: int) -> csr_array:
    """Return the number of sides between faces plus one, for all pairs at most ``rings`` apart."""
    count = fabric.face_count
    inner = np.flatnonzero(fabric.twin != BORDER)
    ends = (fabric.side_face[inner], fabric.side_face[fabric.twin[inner]])
    link = coo_array((np.ones(len(inner)), ends), shape=(count, count)).tocsr()
    identity = coo_array((np.ones(count), (np.arange(count), np.arange(count))), shape=(count, count)).tocsr()
    near, total = identity, identity
    for _ in range(rings):
        near = near @ (link + identity)
        near.data[:] = 1.0
        total = total + near
    total.data = rings + 2.0 - total.data  # a face k sides away occurs in rings + 1 - k of the sums
    total.sort_indices()
    return total


def _greedy_centres(steps: csr_array, faces: IntArray, apart: int) -> IntArray:
    """Return faces so that none is within ``apart`` sides of one before it."""
    covered: NDArray[np.bool_] = np.zeros(steps.shape[0], dtype=bool)
    chosen = []
    for face in faces:
        if covered[face]:
            continue
        chosen.append(face)
        row = slice(steps.indptr[face], steps.indptr[face + 1])
        covered[steps.indices[row][steps.data[row] <= apart + 1]] = True
    return np.array(chosen, dtype=np.int64)
