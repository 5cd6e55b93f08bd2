# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Which lattice images of two yarns are the same pair of yarns.

The step of a yarn maps the yarn onto itself. Two images of the second yarn, relative to the first, are therefore the
same pair if a sum of multiples of both steps leads from one to the other. Of two copies of one yarn, an image and the
opposite image are the same pair too.
"""

from __future__ import annotations

import numpy as np

from stitchmesh.mesh import IntArray


def representative_images(image: IntArray, pairs: IntArray, step: IntArray) -> IntArray:
    """Return one image for all that are the same pair of yarns, shape (n, 2).

    Args:
        image: image of the second yarn relative to the first, shape (n, 2).
        pairs: numbers of the two yarns, shape (n, 2).
        step: lattice step of each yarn, shape (Y, 2).
    """
    first, second = _reduced_steps(step[pairs[:, 0]].astype(np.int64), step[pairs[:, 1]].astype(np.int64))
    here, there = _modulo(image, first, second), _modulo(-image, first, second)
    swap = (there[:, 0] < here[:, 0]) | ((there[:, 0] == here[:, 0]) & (there[:, 1] < here[:, 1]))
    swap &= pairs[:, 0] == pairs[:, 1]
    return np.where(swap[:, None], there, here)


def _reduced_steps(first: IntArray, second: IntArray) -> tuple[IntArray, IntArray]:
    """Return steps that span the same images, (g, h) and (0, k) with g and k not negative (Hermite's normal form)."""
    while second[:, 0].any():
        some = second[:, 0] != 0
        rest = first[some] - (first[some, :1] // second[some, :1]) * second[some]
        first[some], second[some] = second[some], rest
    along = first[:, 0] == 0
    second[along, 1] = np.gcd(first[along, 1], second[along, 1])
    first[along] = 0
    return np.where(first[:, :1] < 0, -first, first), np.abs(second)


def _modulo(image: IntArray, first: IntArray, second: IntArray) -> IntArray:
    """Return the remainder of the image after steps (g, h) and (0, k), the smallest that is not negative."""
    x, y = image[:, 0], image[:, 1]
    turns: IntArray = np.where(first[:, 0] > 0, x // np.maximum(first[:, 0], 1), 0)
    x, y = x - turns * first[:, 0], y - turns * first[:, 1]
    return np.stack([x, np.where(second[:, 1] > 0, y % np.maximum(second[:, 1], 1), y)], axis=1)
