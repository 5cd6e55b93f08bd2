# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Crossings that kernels write, each as one integer.

With Y yarns, yarns i <= j, the image (a, b) of yarn j relative to yarn i, and the sign +1 or -1, the integer is

    code = 2 (((i Y + j) A + a + (A - 1) / 2) B + b + (B - 1) / 2) + (1 + sign) / 2

where A and B are the numbers of possible images along the two periods. Kernels write the codes in any order, because
sums do not depend on the order.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.slots import next_slot
from stitchmesh.errors import ParameterError
from stitchmesh.mesh import IntArray
from stitchmesh.yarnrelax.linking.projection import ProjectedPolylines


@wp.struct
class Crossings:
    """Found crossings, each one integer, in no particular order."""

    count: wp.array[wp.int32]
    """Number of crossings, which may exceed the capacity, shape (1,)."""
    code: wp.array[wp.int64]
    """Two yarns, the image of the second relative to the first, and the sign; see ``decoded``."""
    yarns: wp.int64
    """Number of yarns."""
    reach: wp.vec2i
    """Bound of the images."""


@wp.func
def note(crossings: Crossings, one: int, two: int, image: wp.vec2i, positive: bool) -> None:
    """Write a crossing of yarn one with the copy of yarn two in an image."""
    slot = next_slot(crossings.count)
    if slot < crossings.code.shape[0]:
        seen = wp.where(one <= two, image, -image)
        code = wp.int64(wp.min(one, two)) * crossings.yarns + wp.int64(wp.max(one, two))
        for axis in range(2):
            code = code * wp.int64(2 * crossings.reach[axis] + 1) + wp.int64(seen[axis] + crossings.reach[axis])
        crossings.code[slot] = wp.int64(2) * code + wp.where(positive, wp.int64(1), wp.int64(0))


def collected(projection: ProjectedPolylines, launch: Callable[[Any], None]) -> IntArray:
    """Return the codes that a launch writes; repeat the launch with more capacity if crossings outnumber edges.

    Raises:
        ParameterError: there are too many yarns over too many periods, so that a code does not fit 63 bits.
    """
    device = projection.vertices.device
    yarns = len(projection.yarn_edge) - 1
    if 2 * yarns**2 * int(np.prod(2 * projection.reach + 1, dtype=object)) >= 2**63:
        raise ParameterError(f"linking certificate: got {yarns} yarns; expected fewer, or nearer to one period")
    crossings = Crossings()
    crossings.yarns, crossings.reach = wp.int64(yarns), wp.vec2i(*projection.reach.tolist())
    room = projection.edge_yarn.shape[0]
    while True:
        crossings.count = wp.zeros(1, dtype=wp.int32, device=device)
        crossings.code = wp.empty(room, dtype=wp.int64, device=device)
        launch(crossings)
        found = int(crossings.count.numpy()[0])
        if found <= room:
            return crossings.code[:found].numpy()
        room = found


def decoded(projection: ProjectedPolylines, code: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Return for each code the two yarns, the image of the second relative to the first, and the sign."""
    code, positive = np.divmod(code, 2)
    image = np.empty((len(code), 2), dtype=np.int64)
    for axis in (1, 0):
        code, image[:, axis] = np.divmod(code, 2 * projection.reach[axis] + 1)
    yarns = np.stack(np.divmod(code, len(projection.yarn_edge) - 1), axis=1)
    return yarns, image - projection.reach, 2 * positive - 1
