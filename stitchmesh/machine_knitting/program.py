# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A knitting-machine program in the knitout format (textiles-lab.github.io/knitout).

At racking R the back needle B faces the front needle B + R. Yarn carriers are named by numbers from 1. A carrier stays
beside the needle that it passed last. If it is on the wrong side of its next needle, it is first moved back without
knitting (``miss``).
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
