# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A weave: a matrix that gives the upper yarn at each crossing of a weft and a warp (Leaf et al. 2018, section 4).

One repeat is a matrix, seen from the front, with a row for each weft from the top and a column for each warp from the
left. The value is 1 if the weft passes over the warp, and 0 if the warp passes over the weft. The matrix describes the
whole fabric: for a fabric of several layers it contains the yarns of all layers, side by side as seen from the front.
A yarn of the front layer then passes over the yarns of the layers behind, except where the layers are stitched
together.

A fabric hangs together if no set of yarns can be lifted off the others: each yarn can be reached from each other yarn
along the relation "lies over at some crossing" (C. R. J. Clapham 1980, "When a fabric hangs together").
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from stitchmesh.errors import PatternError, first_few


@dataclass(frozen=True)
class Thread:
    """Properties of one weft or warp, as factors of the values for all yarns.

    Raises:
        PatternError: a factor is not a positive number, or a number is negative.
    """

    layer: int = 0
    """Layer of the yarn, 0 for the front layer; the matrix alone decides which yarns it passes over."""
    radius: float = 1.0
    """Factor of the radius."""
    spacing: float = 1.0
    """Factor of the width of the strip that the yarn occupies; the distance of two yarns is the mean of their
    widths."""
    length: float = 1.0
    """Factor of the rest length; with 1 the yarn has its generated length at rest."""
    colour: int = 0
    """Number of the colour."""

    def __post_init__(self) -> None:
        for name in ("radius", "spacing", "length"):
            factor = getattr(self, name)
            if not (math.isfinite(factor) and factor > 0.0):
                raise PatternError(f"{name} of a yarn: got {factor}; expected a positive factor")
        for name in ("layer", "colour"):
            if getattr(self, name) < 0:
                raise PatternError(f"{name} of a yarn: got {getattr(self, name)}; expected a number from 0")


@dataclass(frozen=True)
class Weave:
    """One repeat of a woven fabric.

    Raises:
        PatternError: the matrix is empty, not rectangular or holds numbers other than 0 and 1, the number of threads
            differs from its rows or columns, a yarn never interlaces, or the fabric falls apart.
    """

    matrix: tuple[tuple[int, ...], ...]
    """1 where the weft of a row passes over the warp of a column, otherwise 0."""
    wefts: tuple[Thread, ...] = ()
    """Properties of the weft of each row, from the top; all equal by default."""
    warps: tuple[Thread, ...] = ()
    """Properties of the warp of each column, from the left; all equal by default."""
    name: str = "weave"
    """The name weavers use for the weave."""
    source: str = ""
    """The publication or tradition from which the weave comes."""
    palette: tuple[tuple[int, int, int], ...] = ()
    """Colour of each colour number (sRGB, 0 to 255); empty if the weave numbers its colours only."""

    def __post_init__(self) -> None:
        self._check_matrix()
        object.__setattr__(self, "matrix", tuple(tuple(int(sign) for sign in row) for row in self.matrix))
        for kind, count in (("wefts", len(self.matrix)), ("warps", len(self.matrix[0]))):
            threads = tuple(getattr(self, kind)) or (Thread(),) * count
            object.__setattr__(self, kind, threads)
            if len(threads) != count:
                raise PatternError(f"weave: got {len(threads)} {kind} for {count} in the matrix; expected as many")
        for text in (self.name, self.source):
            if '"' in text or "\n" in text:
                raise PatternError(f"weave: got the name or source {text!r}; expected one line without quotes")
        self._check_every_yarn_interlaces()
        self._check_hangs_together()

    def __repr__(self) -> str:
        """Return one line: the name and the size."""
        return f"Weave({self.name!r}, {len(self.warps)} warps x {len(self.wefts)} wefts)"

    @cached_property
    def over(self) -> NDArray[np.bool_]:
        """Whether each weft passes over each warp, shape (wefts, warps)."""
        return np.array(self.matrix, dtype=np.bool_)

    @property
    def layer_count(self) -> int:
        """Number of layers."""
        return 1 + max(thread.layer for thread in (*self.wefts, *self.warps))

    def number(self, kind: str, index: int) -> str:
        """Return the number of a yarn from 1; with several layers, the layer and the number in the layer ("2.1")."""
        threads: Sequence[Thread] = self.wefts if kind == "weft" else self.warps
        if self.layer_count == 1:
            return str(index + 1)
        layer = threads[index].layer
        return f"{layer + 1}.{sum(thread.layer == layer for thread in threads[: index + 1])}"

    def _check_matrix(self) -> None:
        if len(self.matrix) == 0 or len(self.matrix[0]) == 0:
            raise PatternError("weave: got an empty matrix; expected a row of 0 and 1 for each weft")
        for index, row in enumerate(self.matrix):
            if len(row) != len(self.matrix[0]):
                found = f"got {len(row)} numbers where row 1 has {len(self.matrix[0])}"
                raise PatternError(f"weave, row {index + 1}: {found}; expected one for each warp", row=index)
            for column, sign in enumerate(row):
                if sign not in (0, 1):
                    where = f"weave, row {index + 1}, column {column + 1}"
                    raise PatternError(f"{where}: got {sign}; expected 1 (weft over) or 0 (warp over)", row=index)

    def _check_every_yarn_interlaces(self) -> None:
        for kind, other, over in (("weft", "warp", self.over), ("warp", "weft", ~self.over.T)):
            for index in np.flatnonzero(over.all(axis=1) | ~over.any(axis=1)).tolist():
                side = "over" if over[index].all() else "under"
                raise PatternError(
                    f"weave: {kind} {self.number(kind, index)} passes {side} every {other} and never interlaces, so "
                    f"the fabric falls apart; let one {other} pass {side} it",
                    row=index if kind == "weft" else None,
                )

    def _check_hangs_together(self) -> None:
        top = top_sheet(self.over)
        if top.all():
            return
        count = len(self.wefts)
        wefts = [self.number("weft", index) for index in np.flatnonzero(top[:count]).tolist()]
        warps = [self.number("warp", index) for index in np.flatnonzero(top[count:]).tolist()]
        raise PatternError(
            f"weave: the fabric falls apart: wefts {first_few(wefts)} and warps {first_few(warps)} lie over all "
            "other yarns wherever they cross, and lift off; let one of the other yarns pass over one of them"
        )


def top_sheet(over: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Find a set of yarns that can be lifted off the others; all yarns if the fabric hangs together.

    Consider the graph with an edge from each yarn to every yarn over which it lies at some crossing. Yarns that hang
    together are a strongly connected component of this graph. One repeat is sufficient, because two yarns cross in the
    same way in all their images.

    Args:
        over: whether each weft passes over each warp, shape (wefts, warps).

    Returns:
        Whether each yarn belongs to the set: first the wefts, then the warps, shape (wefts + warps,).
    """
    wefts, warps = over.shape
    count_below = np.concatenate([over.sum(axis=1), (~over).sum(axis=0)])
    lower = np.concatenate([wefts + np.nonzero(over)[1], np.nonzero(~over.T)[1]]).astype(np.int32)
    ends = np.concatenate([[0], np.cumsum(count_below)]).astype(np.int32)
    graph = csr_array((np.ones(len(lower)), lower, ends), shape=(wefts + warps,) * 2)
    count, sheet = connected_components(graph, connection="strong")
    upper_sheet, lower_sheet = np.repeat(sheet, count_below), sheet[lower]
    covered = np.zeros(count, dtype=np.bool_)
    covered[lower_sheet[upper_sheet != lower_sheet]] = True
    return np.asarray(sheet == np.flatnonzero(~covered)[0])
