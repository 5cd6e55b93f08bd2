# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Several layers of cloth, each with its own wefts and warps, as one matrix.

The yarns of all layers are distributed evenly over the repeat; the yarns of equal layers alternate. The spacing of each
yarn is smaller, so that each layer alone has the spacing of a single cloth.
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
    """Layers of cloth one behind another, before stitches bind them."""

    over: NDArray[np.bool_]
    """Whether each weft passes over each warp, shape (wefts, warps)."""
    wefts: IntArray
    """Layer of each weft, and its number in that layer from 0, shape (wefts, 2)."""
    warps: IntArray
    """Layer of each warp, and its number in that layer from 0, shape (warps, 2)."""

    def threads(self, kind: str) -> tuple[Thread, ...]:
        """Return the threads of ``wefts`` or ``warps``, evenly spaced."""
        place: IntArray = getattr(self, kind)
        spacing = float(np.bincount(place[:, 0]).max() / len(place))
        return tuple(Thread(layer=int(layer), spacing=spacing) for layer in place[:, 0])


def stack_layers(layers: Sequence[NDArray[np.bool_]]) -> Stack:
    """Combine layers of cloth to one matrix.

    Args:
        layers: for each layer from the front, whether each of its wefts passes over each of its warps, shape
            (wefts, warps).
    """
    wefts = _distribute([len(layer) for layer in layers])
    warps = _distribute([layer.shape[1] for layer in layers])
    over = wefts[:, None, 0] < warps[None, :, 0]
    for index, layer in enumerate(layers):
        rows, columns = np.flatnonzero(wefts[:, 0] == index), np.flatnonzero(warps[:, 0] == index)
        over[np.ix_(rows, columns)] = layer
    return Stack(over, wefts, warps)


def _distribute(counts: Sequence[int]) -> IntArray:
    """Return the layer and number of the yarns of several layers in their order across the repeat, shape (n, 2)."""
    places = [(Fraction(2 * number + 1, 2 * count), layer, number)
              for layer, count in enumerate(counts) for number in range(count)]  # fmt: skip
    return np.array([(layer, number) for _, layer, number in sorted(places)])
