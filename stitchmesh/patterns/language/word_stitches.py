# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What one word of a written row works: stitches on a group of loops, left to right as the reader faces them."""

from __future__ import annotations

from dataclasses import dataclass, replace

from stitchmesh.mesh.stitch import from_wrong_side
from stitchmesh.patterns.pattern import Cell, Loop


@dataclass(frozen=True)
class WordStitches:
    """Stitches that stay together: one stitch, a cable, or none where a chart leaves a square empty."""

    cells: tuple[Cell, ...]
    """The stitches, left to right."""
    loops: tuple[Loop, ...]
    """How the loops below them are held, left to right as they come."""
    columns: int = 1
    """How many squares of a chart it covers."""
    tuck: bool = False
    """Whether the next row works its two loops together."""

    def turned(self) -> WordStitches:
        """The same work seen from the other side: turned about its wale."""
        front = max((loop.layer for loop in self.loops), default=0)
        cells = tuple(
            Cell(from_wrong_side(cell.stitch), cell.twist[::-1], cell.yarn) for cell in reversed(self.cells)
        )  # a half turn of a loop keeps its hand when it is seen from behind
        loops = tuple(Loop(-loop.shift, front - loop.layer, loop.twist) for loop in reversed(self.loops))
        return replace(self, cells=cells, loops=loops)


def single(cell: Cell, twist_below: tuple[int, ...] = (), *, tuck: bool = False) -> WordStitches:
    """One stitch on plain loops, or on loops twisted by it."""
    below = twist_below or (0,) * cell.n_bottom
    return WordStitches((cell,), tuple(Loop(twist=twist) for twist in below), tuck=tuck)


def cable(cells: tuple[Cell, ...], target: list[int], layers: list[int], twists: list[int]) -> WordStitches:
    """Stitches on loops that are reordered first: loop i goes to place ``target[i]``; ``twists`` after reordering."""
    loops = [Loop(end - place, layers[place], twists[end]) for place, end in enumerate(target)]
    return WordStitches(cells, tuple(loops), columns=max(len(target), len(cells)))
