# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The loops of a flat piece, or of one half of a folded tube, on one bed, and their moves along the bed.

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
    """Loops on one bed."""

    bed: str
    """The bed of the loops, ``FRONT`` or ``BACK``."""
    spacing: int
    """Number of needles from one loop to the next."""
    parity: int
    """Remainder of the needle numbers modulo the spacing."""
    loops: dict[int, int] = field(default_factory=dict)
    """Needle of each loop, from left to right along the bed; a loop is identified by its top side."""

    @property
    def other(self) -> str:
        """The opposite bed."""
        return BACK if self.bed == FRONT else FRONT

    def centred(self, width: int) -> int:
        """Return the first of ``width`` needles that are centred on the bed."""
        return self.parity - self.spacing * (width // 2)

    def to_other_bed(self, program: Program, needle: int) -> None:
        """Transfer the loops of a needle to the opposite needle."""
        program.transfer(self.bed, needle, needle)

    def from_other_bed(self, program: Program, needle: int, to: int) -> None:
        """Transfer the loops of a needle of the other bed to a needle of this bed."""
        program.transfer(self.other, needle, to)

    def rack_for(self, needle: int, to: int) -> int:
        """Return the racking at which needle ``needle`` of the other bed faces needle ``to`` of this bed."""
        return to - needle if self.bed == FRONT else needle - to

    def move(self, program: Program, targets: dict[int, int]) -> None:
        """Move loops to needles, in as many steps as racking requires; two loops never share a needle.

        Args:
            program: program to which the operations are added.
            targets: needle for each loop; needles increase along the bed in the order of the loops.
        """
        while any(self.loops[loop] != needle for loop, needle in targets.items()):
            step = {loop: _clamped(needle - self.loops[loop]) for loop, needle in targets.items()}
            moved = [loop for loop, by in step.items() if by]
            for loop in moved:
                self.to_other_bed(program, self.loops[loop])
            for loop in sorted(moved, key=lambda loop: step[loop]):
                self.from_other_bed(program, self.loops[loop], self.loops[loop] + step[loop])
                self.loops[loop] += step[loop]
        self.loops = dict(sorted(self.loops.items(), key=lambda item: item[1]))

    def stack(self, program: Program, sequences: list[list[tuple[int, int]]]) -> None:
        """Move loops to needles in a given order, with as many loops per racking as possible.

        Args:
            program: program to which the operations are added.
            sequences: for each stack, the moves (needle of a loop, target needle) from the outermost loop to the
                innermost; loops that do not move are left out.
        """
        for sequence in sequences:
            for needle, _ in sequence:
                self.to_other_bed(program, needle)
        pending = [list(sequence) for sequence in sequences]
        while any(pending):
            racks = [self.rack_for(*sequence[0]) for sequence in pending if sequence]
            rack = max(sorted(set(racks), key=abs), key=racks.count)
            for sequence in pending:
                while sequence and self.rack_for(*sequence[0]) == rack:
                    self.from_other_bed(program, *sequence.pop(0))


def _clamped(shift: int) -> int:
    """Limit a shift to the range of racking."""
    return max(-MOST_RACK, min(MOST_RACK, shift))
