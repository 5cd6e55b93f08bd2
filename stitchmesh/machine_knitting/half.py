# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The loops of a flat piece, or of one half of a folded tube, and their moves between and along the beds.

A half has a bed on the outside of the fabric, where knit stitches are made; purl stitches are made on the opposite
needle of the other bed. A loop stays on the bed where it was made until a stitch needs it on the other one.

To move along a bed, a loop is transferred to the other bed, the beds are racked (shifted against each other), and the
loop is transferred back. The needles across are free for this, because the two halves of a tube use alternate needles.
A loop that is transferred to an occupied needle lies behind the loops that are already there, as seen from the outside
of the fabric, because a needle extends from the outside to the inside.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from stitchmesh.machine_knitting.program import BACK, FRONT, MOST_RACK, Program


@dataclass
class Half:
    """Loops of a flat piece, or of one half of a tube."""

    bed: str
    """The bed on the outside of the fabric, ``FRONT`` or ``BACK``."""
    spacing: int
    """Number of needles from one loop to the next."""
    parity: int
    """Remainder of the needle numbers modulo the spacing."""
    loops: dict[int, int] = field(default_factory=dict)
    """Needle of each loop, from left to right along the bed; a loop is identified by its top side."""
    across: set[int] = field(default_factory=set)
    """The loops that are on the other bed, on the needle opposite to theirs."""

    @property
    def other(self) -> str:
        """The opposite bed."""
        return BACK if self.bed == FRONT else FRONT

    def centred(self, width: int) -> int:
        """Return the first of ``width`` needles that are centred on the bed."""
        return self.parity - self.spacing * (width // 2)

    def bed_of(self, loop: int) -> str:
        """Return the bed on which a loop is."""
        return self.other if loop in self.across else self.bed

    def bring(self, program: Program, loop: int, *, across: bool) -> None:
        """Transfer a loop to the opposite needle, unless it is on the bed where it is needed."""
        if (loop in self.across) != across:
            needle = self.loops[loop]
            program.transfer(self.bed_of(loop), needle, needle)
            self.across ^= {loop}

    def move(self, program: Program, targets: dict[int, int]) -> None:
        """Move loops to needles, in as many steps as racking requires; two loops never share a needle.

        The moved loops are on the bed of this half afterwards.

        Args:
            program: program to which the operations are added.
            targets: needle for each loop; needles increase along the bed in the order of the loops.
        """
        while any(self.loops[loop] != needle for loop, needle in targets.items()):
            step = {loop: _clamped(needle - self.loops[loop]) for loop, needle in targets.items()}
            moved = [loop for loop, by in step.items() if by]
            for loop in moved:
                self.bring(program, loop, across=True)
            for loop in sorted(moved, key=lambda loop: step[loop]):
                program.transfer(self.other, self.loops[loop], self.loops[loop] + step[loop])
                self.loops[loop] += step[loop]
            self.across -= set(moved)
        self.loops = dict(sorted(self.loops.items(), key=lambda item: item[1]))

    def stack(self, program: Program, sequences: list[list[tuple[int, int]]]) -> None:
        """Move loops to needles of the bed of this half in a given order, with as many loops per racking as possible.

        Args:
            program: program to which the operations are added.
            sequences: for each stack, the moves (loop, target needle) from the outermost loop to the innermost; loops
                that do not move are left out.
        """
        for sequence in sequences:
            for loop, _ in sequence:
                self.bring(program, loop, across=True)
        pending = [list(sequence) for sequence in sequences]
        while any(pending):
            racks = [self._rack_for(*sequence[0]) for sequence in pending if sequence]
            rack = max(sorted(set(racks), key=abs), key=racks.count)
            for sequence in pending:
                while sequence and self._rack_for(*sequence[0]) == rack:
                    loop, needle = sequence.pop(0)
                    program.transfer(self.other, self.loops[loop], needle)
                    self.loops[loop] = needle
                    self.across.remove(loop)

    def _rack_for(self, loop: int, to: int) -> int:
        """Racking at which a loop on the other bed faces needle ``to`` of this bed."""
        return to - self.loops[loop] if self.bed == FRONT else self.loops[loop] - to


def _clamped(shift: int) -> int:
    """Limit a shift to the range of racking."""
    return max(-MOST_RACK, min(MOST_RACK, shift))
