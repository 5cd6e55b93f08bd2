# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Layers of cloth, each with its own wefts and warps, as one matrix.

The yarns of all layers are dealt out across the repeat, in equal layers one of each in turn, and each takes so much
less room that a layer alone is spaced like a cloth of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from stitchmesh.mesh import IntArray
from stitchmesh.periodic.weave.weave import Thread


@dataclass(frozen=True, eq=False)
class Stack:
    """Layers of cloth that lie on each other, not stitched together yet."""

    over: NDArray[np.bool_]
    """Whether each weft passes over each warp, shape (wefts, warps)."""
    wefts: IntArray
    """Layer of each weft and its number in that layer, from 0, shape (wefts, 2)."""
    warps: IntArray
    """Layer of each warp and its number in that layer, from 0, shape (warps, 2)."""

    def threads(self, kind: str) -> tuple[Thread, ...]:
        """Its ``wefts`` or ``warps``, spaced evenly."""
        place: IntArray = getattr(self, kind)
        room = float(np.bincount(place[:, 0]).max() / len(place))
        return tuple(Thread(layer=int(layer), spacing=room) for layer in place[:, 0])


def stacked(layers: Sequence[NDArray[np.bool_]]) -> Stack:
    """Layers on top of each other.

    Args:
        layers: whether each weft of a layer passes over each warp of it, from the front, shape (wefts, warps) each.
    """
    wefts = _dealt([len(layer) for layer in layers])
    warps = _dealt([layer.shape[1] for layer in layers])
    over = wefts[:, None, 0] < warps[None, :, 0]
    for index, layer in enumerate(layers):
        rows, columns = np.flatnonzero(wefts[:, 0] == index), np.flatnonzero(warps[:, 0] == index)
        over[np.ix_(rows, columns)] = layer
    return Stack(over, wefts, warps)


def _dealt(counts: Sequence[int]) -> IntArray:
    """Layer and number of yarns of several layers in the order in which they lie side by side, shape (n, 2)."""
    places = [(Fraction(2 * number + 1, 2 * count), layer, number)
              for layer, count in enumerate(counts) for number in range(count)]  # fmt: skip
    return np.array([(layer, number) for _, layer, number in sorted(places)])
