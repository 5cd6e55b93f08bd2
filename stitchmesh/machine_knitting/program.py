# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A knitting-machine program in the knitout format (textiles-lab.github.io/knitout).

At racking R the back needle B faces the front needle B + R. Yarn carriers are named by numbers from 1. A carrier stays
beside the needle that it passed last. If it is on the wrong side of its next needle, it is first moved back without
knitting (``miss``).

``Half`` holds the loops of a flat piece, or of one half of a folded tube, and moves them between and along the beds. A
half has a bed on the outside of the fabric, where knit stitches are made; purl stitches are made on the opposite needle
of the other bed. A loop stays on the bed where it was made until a stitch needs it on the other bed.

To move along a bed, a loop is transferred to the other bed, the beds are racked (shifted against each other), and the
loop is transferred back. The needles across are free for this, because the two halves of a tube use alternate needles.
A loop that is transferred to an occupied needle lies behind the loops that are already there, as seen from the outside
of the fabric, because a needle extends from the outside to the inside.
"""

from __future__ import annotations

from dataclasses import dataclass, field

FRONT, BACK = "f", "b"
CARRIERS = 10
"""Number of yarn carriers of a machine."""
MOST_RACK = 4
"""Largest racking (shift of the beds) in needles."""


@dataclass
class Program:
    """The lines of a program, and the state of the machine after them."""

    first: int = 0
    """Number written for needle 0; it is even, and avoids negative numbers, which some readers do not accept."""
    lines: list[str] = field(default_factory=list)
    """Lines of the program after the header."""
    rack: int = 0
    """Present racking in needles."""
    position: dict[int, float] = field(default_factory=dict)
    """Position of the carrier of each yarn in use, in needles."""
    hooked: int | None = None
    """The yarn whose end is held by the yarn-inserting hook."""

    def comment(self, text: str) -> None:
        """Add a comment line."""
        self.lines.append(f";{text}")

    def rack_to(self, rack: int) -> None:
        """Rack the beds, if the present racking differs."""
        if rack != self.rack:
            self.rack = rack
            self.lines.append(f"rack {rack}")

    def transfer(self, bed: str, needle: int, to: int) -> None:
        """Transfer all loops of a needle to a needle of the other bed, after the required racking."""
        other = BACK if bed == FRONT else FRONT
        self.rack_to(needle - to if bed == FRONT else to - needle)
        self.lines.append(f"xfer {bed}{self.first + needle} {other}{self.first + to}")

    def stitch(self, operation: str, direction: str, bed: str, needle: int, yarn: int, note: str = "") -> None:
        """Add a ``knit``, ``tuck`` or ``miss`` operation.

        Args:
            operation: ``knit``, ``tuck`` or ``miss``.
            direction: ``+`` to the right or ``-`` to the left.
            bed: ``FRONT`` or ``BACK``.
            needle: number of the needle.
            yarn: number of the yarn, from 0.
            note: comment at the end of the line.
        """
        self.rack_to(0)
        target = f"{direction} {bed}{self.first + needle} {yarn + 1}"
        if yarn not in self.position:
            self._bring_in(yarn, direction)
        elif (self.position[yarn] - needle) * _sign(direction) > 0:
            self.lines.append(f"miss {'-' if direction == '+' else '+'}{target[1:]}")
        if self.hooked == yarn and direction == "+":
            self.release()  # The needles beyond the hook are blocked until the hook releases the yarn.
        self.lines.append(f"{operation} {target}{f' ;{note}' if note else ''}")
        self.position[yarn] = needle + 0.5 * _sign(direction)

    def release(self) -> None:
        """Release the yarn-inserting hook if it holds a yarn."""
        if self.hooked is not None:
            self.lines.append(f"releasehook {self.hooked + 1}")
            self.hooked = None

    def take_out(self, yarn: int) -> None:
        """Cut a yarn and take its carrier out of use."""
        self.release()
        self.lines.append(f"outhook {yarn + 1}")
        del self.position[yarn]

    def drop(self, bed: str, needle: int, note: str) -> None:
        """Drop the loops of a needle."""
        self.rack_to(0)
        self.lines.append(f"drop {bed}{self.first + needle} ;{note}")

    def text(self) -> str:
        """Return the text of the whole file."""
        carriers = " ".join(str(number) for number in range(1, CARRIERS + 1))
        return "\n".join([";!knitout-2", f";;Carriers: {carriers}", ";;Position: Center", *self.lines]) + "\n"

    def _bring_in(self, yarn: int, direction: str) -> None:
        self.release()
        if direction == "+":  # The hook is at the right and can only insert a yarn that moves to the left.
            self.lines.append(f"in {yarn + 1}")
            return
        self.lines.append(f"inhook {yarn + 1}")
        self.hooked = yarn


def _sign(direction: str) -> int:
    return 1 if direction == "+" else -1


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
