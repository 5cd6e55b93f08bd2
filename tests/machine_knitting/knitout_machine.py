# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A simulated V-bed knitting machine that executes a knitout file and records how the loops are connected.

Each needle holds its loops in order from the front to the back. The hook of a front needle opens to the back, so that
a new loop lies behind the others; the hook of a back needle opens to the front. An operation that no machine can do is
an error: a carrier that is not in action or is on the wrong side, a transfer between needles that are not opposite to
each other, knitting on an empty needle, or a loop that is dropped or remains on a needle.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field

MOST_RACK = 4


class MachineError(AssertionError):
    """The program contains an operation that a machine cannot do."""


@dataclass(frozen=True)
class Made:
    """A knit, tuck or miss operation."""

    operation: str
    direction: str
    bed: str
    needle: int
    carrier: str
    note: str
    through: tuple[int, ...]
    """Loops through which the new loop is drawn, or which a miss passes, from front to back."""
    loop: int
    """Number of the new loop; -1 for a miss."""


@dataclass
class Machine:
    """The needle beds and the yarn carriers."""

    carriers: list[str] = field(default_factory=list)
    needles: dict[tuple[str, int], list[int]] = field(default_factory=lambda: defaultdict(list))
    rack: int = 0
    position: dict[str, float | None] = field(default_factory=dict)
    hooked: str | None = None
    hooked_at: int | None = None
    """First needle of the yarn in the yarn inserting hook; the needles to the right of it are blocked."""
    made: list[Made] = field(default_factory=list)
    in_front: dict[tuple[int, int], int] = field(default_factory=dict)
    """For two loops that passed each other on different beds: the loop in front when they passed last."""
    left: dict[tuple[int, int], int] = field(default_factory=dict)
    """For two loops that were on different beds: the left loop when they were so last."""
    dropped: list[int] = field(default_factory=list)
    loops: int = 0

    def run(self, text: str) -> Machine:
        """Execute a whole file."""
        lines = text.split("\n")
        if lines[0] != ";!knitout-2":
            raise MachineError(f"magic: {lines[0]!r}")
        for line in lines[1:]:
            if line.startswith(";;Carriers: "):
                self.carriers = line.removeprefix(";;Carriers: ").split()
            operation, _, note = line.partition(";")
            if operation.split():
                self._do(operation.split(), note.strip())
        if not self.carriers:
            raise MachineError("no ;;Carriers: header")
        left = [needle for needle, loops in self.needles.items() if loops]
        if left or self.position:
            raise MachineError(f"left behind: loops on {left}, carriers {list(self.position)}")
        return self

    def _do(self, words: list[str], note: str) -> None:
        name, *rest = words
        actions = {
            "in": self._in,
            "inhook": self._inhook,
            "releasehook": self._releasehook,
            "outhook": self._outhook,
            "rack": self._rack_to,
            "xfer": self._transfer,
            "drop": self._drop,
        }
        if name in actions:
            actions[name](*rest)
        elif name in ("knit", "tuck", "miss"):
            self._stitch(name, *rest, note=note)
        else:
            raise MachineError(f"unknown operation {name}")

    def _in(self, carrier: str) -> None:
        if carrier not in self.carriers or carrier in self.position:
            raise MachineError(f"in {carrier}: unknown, or in action")
        self.position[carrier] = None

    def _inhook(self, carrier: str) -> None:
        if self.hooked is not None:
            raise MachineError(f"inhook {carrier}: the hook holds {self.hooked}")
        self._in(carrier)
        self.hooked, self.hooked_at = carrier, None

    def _releasehook(self, carrier: str) -> None:
        if self.hooked != carrier or self.position[carrier] is None:
            raise MachineError(f"releasehook {carrier}: the hook holds {self.hooked}, or it has not knitted yet")
        self.hooked = self.hooked_at = None

    def _outhook(self, carrier: str) -> None:
        if carrier not in self.position or self.hooked is not None:
            raise MachineError(f"outhook {carrier}: not in action, or the hook holds {self.hooked}")
        del self.position[carrier]

    def _rack_to(self, text: str) -> None:
        after = int(text)
        if abs(after) > MOST_RACK:
            raise MachineError(f"rack {after}")
        self._note_order()
        self.rack = after
        self._note_order()

    def _note_order(self) -> None:
        """Record the left one of two loops on different beds; opposite loops keep their previous order."""
        loops = [(bed, needle, loop) for (bed, needle), held in self.needles.items() for loop in held]
        for at, ahead in [(needle, loop) for bed, needle, loop in loops if bed == "f"]:
            for across, behind in [(needle + self.rack, loop) for bed, needle, loop in loops if bed == "b"]:
                if at == across:
                    continue
                pair = min(ahead, behind), max(ahead, behind)
                left = ahead if at < across else behind
                if self.left.setdefault(pair, left) != left:
                    self.left[pair], self.in_front[pair] = left, ahead

    def _transfer(self, source: str, target: str) -> None:
        (bed, needle), (other, to) = _needle(source), _needle(target)
        front, back = (needle, to) if bed == "f" else (to, needle)
        if bed == other or front != back + self.rack:
            raise MachineError(f"xfer {source} {target} at rack {self.rack}: the needles do not face each other")
        moved = self.needles[bed, needle]
        if not moved:
            raise MachineError(f"xfer {source} {target}: the needle is empty")
        self.needles[bed, needle] = []
        self._put(other, to, moved)

    def _put(self, bed: str, needle: int, loops: list[int]) -> None:
        there = self.needles[bed, needle]
        self.needles[bed, needle] = [*there, *loops] if bed == "f" else [*loops, *there]

    def _drop(self, target: str) -> None:
        loops = self.needles.pop(_needle(target), [])
        if len(loops) != 1 or self.position:
            raise MachineError(f"drop {target}: holds {loops} while carriers {list(self.position)} are in action")
        self.dropped += loops

    def _stitch(self, name: str, direction: str, target: str, carrier: str, *, note: str) -> None:
        bed, needle = _needle(target)
        if carrier not in self.position:
            raise MachineError(f"{name} {target}: carrier {carrier} is not in action")
        at, sign = self.position[carrier], 1 if direction == "+" else -1
        if at is not None and (at - needle) * sign > 0:
            raise MachineError(f"{name} {direction} {target}: carrier {carrier} is at {at}")
        if self.rack:
            raise MachineError(f"{name} {target} at rack {self.rack}")
        if self.hooked == carrier and self.hooked_at is None:
            self.hooked_at = needle
            if direction == "+":
                raise MachineError(f"{name} + {target}: the hook leads a yarn leftwards")
        if self.hooked_at is not None and needle > self.hooked_at:
            raise MachineError(f"{name} {target}: blocked by the hook at {self.hooked_at}")
        self.position[carrier] = needle + 0.5 * sign
        through, loop = tuple(self.needles[bed, needle]), -1
        if name == "knit":
            if not through:
                raise MachineError(f"knit {target}: the needle is empty")
            self.needles[bed, needle] = []
        if name != "miss":
            loop, self.loops = self.loops, self.loops + 1
            self._put(bed, needle, [loop])
        self.made.append(Made(name, direction, bed, needle, carrier, note, () if name == "tuck" else through, loop))


def _needle(text: str) -> tuple[str, int]:
    return text[0], int(text[1:])
