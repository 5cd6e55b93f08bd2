# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Loops of a flat piece, or of one half of a folded tube, on their bed; how they are moved along it.

The other bed is free where these loops may have to go: of a tube each half has every second needle. Loops move along
their bed by going over to the other one, the beds shifting, and coming back. A loop that comes to a needle lies
behind those that are there, seen from the outside of the fabric: a needle reaches from outside in.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from stitchmesh.machine_knitting.program import BACK, FRONT, MOST_RACK, Program


@dataclass
class Half:
    """Loops on one bed."""

    bed: str
    spacing: int
    """Needles from one loop to the next."""
    parity: int
    """Remainder of its needles by the spacing."""
    loops: dict[int, int] = field(default_factory=dict)
    """Needle of each loop, which is named by a top side; from left to right along the bed."""

    @property
    def other(self) -> str:
        """The bed across."""
        return BACK if self.bed == FRONT else FRONT

    def centred(self, width: int) -> int:
        """The first needle of so many, about the middle of the bed."""
        return self.parity - self.spacing * (width // 2)

    def lift(self, program: Program, needle: int) -> None:
        """To the needle across."""
        program.transfer(self.bed, needle, needle)

    def lower(self, program: Program, needle: int, to: int) -> None:
        """From the needle across to one of its own bed."""
        program.transfer(self.other, needle, to)

    def rack_for(self, needle: int, to: int) -> int:
        """Racking at which ``lower`` goes straight."""
        return to - needle if self.bed == FRONT else needle - to

    def move(self, program: Program, targets: dict[int, int]) -> None:
        """Move loops to needles, in as many steps as racking needs; no two ever share one.

        Args:
            program: takes the operations.
            targets: needle for each loop, increasing along the bed as the loops do.
        """
        while any(self.loops[loop] != needle for loop, needle in targets.items()):
            step = {loop: _clamped(needle - self.loops[loop]) for loop, needle in targets.items()}
            moved = [loop for loop, by in step.items() if by]
            for loop in moved:
                self.lift(program, self.loops[loop])
            for loop in sorted(moved, key=lambda loop: step[loop]):
                self.lower(program, self.loops[loop], self.loops[loop] + step[loop])
                self.loops[loop] += step[loop]
        self.loops = dict(sorted(self.loops.items(), key=lambda item: item[1]))

    def stack(self, program: Program, sequences: list[list[tuple[int, int]]]) -> None:
        """Bring loops to needles in a given order, one racking for as many as can go.

        Args:
            program: takes the operations.
            sequences: for each stack (needle of a loop, needle to go to), from the outermost loop inwards; loops that
                stay are left out.
        """
        for sequence in sequences:
            for needle, _ in sequence:
                self.lift(program, needle)
        pending = [list(sequence) for sequence in sequences]
        while any(pending):
            racks = [self.rack_for(*sequence[0]) for sequence in pending if sequence]
            rack = max(sorted(set(racks), key=abs), key=racks.count)
            for sequence in pending:
                while sequence and self.rack_for(*sequence[0]) == rack:
                    self.lower(program, *sequence.pop(0))


def _clamped(shift: int) -> int:
    return max(-MOST_RACK, min(MOST_RACK, shift))
