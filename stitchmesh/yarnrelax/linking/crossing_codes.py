# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Crossings written down by kernels, each as one whole number.

With Y yarns, yarns i <= j, image (a, b) of yarn j relative to yarn i and sign +1 or -1 the number is

    code = 2 (((i Y + j) A + a + (A - 1) / 2) B + b + (B - 1) / 2) + (1 + sign) / 2

where A and B count the images that there may be. Kernels write them in no order, which sums do not depend on.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import warp as wp

from stitchmesh.errors import ParameterError
from stitchmesh.mesh import IntArray
from stitchmesh.yarnrelax.linking.projection import Picture


@wp.struct
class Crossings:
    """Found crossings, each one number, in no order."""

    count: wp.array[wp.int32]
    """How many there are, more than fit maybe, shape (1,)."""
    code: wp.array[wp.int64]
    """Two yarns, the image of the second relative to the first, and the sign; see ``decoded``."""
    yarns: wp.int64
    """Number of yarns."""
    reach: wp.vec2i
    """Bound of the images."""


@wp.func
def note(crossings: Crossings, one: int, two: int, image: wp.vec2i, positive: bool) -> None:
    """Write down a crossing of yarn one with the copy of yarn two in an image."""
    slot = wp.atomic_add(crossings.count, 0, 1)
    if slot < crossings.code.shape[0]:
        seen = wp.where(one <= two, image, -image)
        code = wp.int64(wp.min(one, two)) * crossings.yarns + wp.int64(wp.max(one, two))
        for axis in range(2):
            code = code * wp.int64(2 * crossings.reach[axis] + 1) + wp.int64(seen[axis] + crossings.reach[axis])
        crossings.code[slot] = wp.int64(2) * code + wp.where(positive, wp.int64(1), wp.int64(0))


def collected(picture: Picture, launch: Callable[[Any], None]) -> IntArray:
    """Codes that a launch writes; it is repeated with more room where there are more than one for each edge.

    Raises:
        ParameterError: so many yarns over so many periods that a code does not fit 63 bits.
    """
    device = picture.vertices.device
    yarns = len(picture.yarn_edge) - 1
    if 2 * yarns**2 * int(np.prod(2 * picture.reach + 1, dtype=object)) >= 2**63:
        raise ParameterError(f"linking certificate: got {yarns} yarns; expected fewer, or nearer to one period")
    crossings = Crossings()
    crossings.yarns, crossings.reach = wp.int64(yarns), wp.vec2i(*picture.reach.tolist())
    room = picture.edge_yarn.shape[0]
    while True:
        crossings.count = wp.zeros(1, dtype=wp.int32, device=device)
        crossings.code = wp.empty(room, dtype=wp.int64, device=device)
        launch(crossings)
        found = int(crossings.count.numpy()[0])
        if found <= room:
            return crossings.code[:found].numpy()
        room = found


def decoded(picture: Picture, code: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Two yarns, image of the second relative to the first, and sign, of each code."""
    code, positive = np.divmod(code, 2)
    image = np.empty((len(code), 2), dtype=np.int64)
    for axis in (1, 0):
        code, image[:, axis] = np.divmod(code, 2 * picture.reach[axis] + 1)
    yarns = np.stack(np.divmod(code, len(picture.yarn_edge) - 1), axis=1)
    return yarns, image - picture.reach, 2 * positive - 1
