# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The stitches of one word of a row and the loops below them, left to right as the reader faces the fabric."""

from __future__ import annotations

from dataclasses import dataclass, replace

from stitchmesh.mesh.own_stitch import built_in
from stitchmesh.mesh.stitch import from_wrong_side
from stitchmesh.patterns.pattern import Cell, Loop


@dataclass(frozen=True)
class WordStitches:
    """Stitches of one word: a single stitch, a cable, or nothing for an empty square of a chart."""

    cells: tuple[Cell, ...]
    """The stitches, left to right."""
    loops: tuple[Loop, ...]
    """How the loops below are held, left to right before any crossing."""
    columns: int = 1
    """Number of squares of a chart that the word covers."""
    tuck: bool = False
    """Whether the next row works the two loops of this stitch together."""

    def turned(self) -> WordStitches:
        """Return the same stitches seen from the other side of the fabric, turned about the wale."""
        front = max((loop.layer for loop in self.loops), default=0)
        cells = tuple(
            Cell(from_wrong_side(built_in(cell.stitch)), cell.twist[::-1], cell.yarn) for cell in reversed(self.cells)
        )  # a half turn of a loop has the same direction when it is seen from behind
        loops = tuple(Loop(-loop.shift, front - loop.layer, loop.twist) for loop in reversed(self.loops))
        return replace(self, cells=cells, loops=loops)


def single(cell: Cell, twist_below: tuple[int, ...] = (), *, tuck: bool = False) -> WordStitches:
    """Return one stitch on loops that no cable moves; ``twist_below`` gives the half turn of each loop below."""
    below = twist_below or (0,) * cell.n_bottom
    return WordStitches((cell,), tuple(Loop(twist=twist) for twist in below), tuck=tuck)


def cable(cells: tuple[Cell, ...], target: list[int], layers: list[int], twists: list[int]) -> WordStitches:
    """Return stitches on loops that are reordered before they are worked.

    Args:
        cells: the stitches, left to right.
        target: loop i moves to place ``target[i]``.
        layers: the layer of each loop, in the order before the crossing.
        twists: the half turn that the stitches give to each loop, in the order after the crossing.
    """
    loops = [Loop(end - place, layers[place], twists[end]) for place, end in enumerate(target)]
    return WordStitches(cells, tuple(loops), columns=max(len(target), len(cells)))
