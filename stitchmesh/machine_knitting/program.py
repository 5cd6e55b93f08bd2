# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A program in knitout (textiles-lab.github.io/knitout), line by line as operations are given.

At racking R the back needle B faces the front needle B + R. Carriers are named by numbers from 1 and stand beside the
needle that they passed last; one that stands on the wrong side of its next needle is brought back first (``miss``).
"""

from __future__ import annotations

from dataclasses import dataclass, field

FRONT, BACK = "f", "b"
CARRIERS = 10
"""Yarns that a machine has at hand."""
MOST_RACK = 4
"""Needles by which the beds are shifted at most."""


@dataclass
class Program:
    """Lines, and what the machine's racking and carriers are after them."""

    first: int = 0
    """Number written for needle 0, even; programs that read these files may know no negative numbers."""
    lines: list[str] = field(default_factory=list)
    rack: int = 0
    position: dict[int, float] = field(default_factory=dict)
    """Where each carrier in action stands, in needles."""
    hooked: int | None = None
    """The yarn whose end the inserting hook holds."""

    def comment(self, text: str) -> None:
        """A line that says what comes."""
        self.lines.append(f";{text}")

    def rack_to(self, rack: int) -> None:
        """Shift the beds."""
        if rack != self.rack:
            self.rack = rack
            self.lines.append(f"rack {rack}")

    def transfer(self, bed: str, needle: int, to: int) -> None:
        """Move all loops of a needle to one of the other bed, which the beds are shifted to face."""
        other = BACK if bed == FRONT else FRONT
        self.rack_to(needle - to if bed == FRONT else to - needle)
        self.lines.append(f"xfer {bed}{self.first + needle} {other}{self.first + to}")

    def stitch(self, operation: str, direction: str, bed: str, needle: int, yarn: int, note: str = "") -> None:
        """``knit``, ``tuck`` or ``miss`` with a yarn, numbered from 0."""
        self.rack_to(0)
        target = f"{direction} {bed}{self.first + needle} {yarn + 1}"
        if yarn not in self.position:
            self._bring_in(yarn, direction)
        elif (self.position[yarn] - needle) * _sign(direction) > 0:
            self.lines.append(f"miss {'-' if direction == '+' else '+'}{target[1:]}")
        if self.hooked == yarn and direction == "+":
            self.release()  # needles beyond the hook are blocked until it lets go
        self.lines.append(f"{operation} {target}{f' ;{note}' if note else ''}")
        self.position[yarn] = needle + 0.5 * _sign(direction)

    def release(self) -> None:
        """Open the inserting hook, if it holds a yarn."""
        if self.hooked is not None:
            self.lines.append(f"releasehook {self.hooked + 1}")
            self.hooked = None

    def take_out(self, yarn: int) -> None:
        """Cut a yarn and put its carrier away."""
        self.release()
        self.lines.append(f"outhook {yarn + 1}")
        del self.position[yarn]

    def drop(self, bed: str, needle: int, note: str) -> None:
        """Let the loops of a needle go."""
        self.rack_to(0)
        self.lines.append(f"drop {bed}{self.first + needle} ;{note}")

    def text(self) -> str:
        """The whole file."""
        carriers = " ".join(str(number) for number in range(1, CARRIERS + 1))
        return "\n".join([";!knitout-2", f";;Carriers: {carriers}", ";;Position: Center", *self.lines]) + "\n"

    def _bring_in(self, yarn: int, direction: str) -> None:
        self.release()
        if direction == "+":  # the hook stands at the right and leads a yarn leftwards only
            self.lines.append(f"in {yarn + 1}")
            return
        self.lines.append(f"inhook {yarn + 1}")
        self.hooked = yarn


def _sign(direction: str) -> int:
    return 1 if direction == "+" else -1
