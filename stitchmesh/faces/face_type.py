# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Types of faces: a name, and a label for each side of the face."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cached_property

ENTERING, LEAVING, UNDIRECTED = -1, 1, 0
"""Directions of a side: what crosses it enters the face, leaves it, or has no direction."""
NOTHING = "x"
"""Kind of a side that nothing crosses."""
VARYING = "X"
"""Count of a label that stands for any count."""
_LABEL = re.compile(r"([+-]?)(.*?)([0-9]{1,6}|X)?")


@dataclass(frozen=True)
class SideLabel:
    """What crosses a side of a face."""

    direction: int
    """``ENTERING``, ``LEAVING`` or ``UNDIRECTED``."""
    kind: str
    """``l`` for loops, ``y`` for yarn, ``NOTHING``, or any other word."""
    count: int | None
    """Number of loops or yarns; None if it varies."""

    @classmethod
    def parse(cls, text: str) -> SideLabel:
        """Return the label of a text such as ``+y1``; a text without a number has the count 1."""
        match = _LABEL.fullmatch(text)
        assert match is not None  # The middle of the expression takes any text.
        sign, kind, count = match.groups()
        return cls({"-": ENTERING, "+": LEAVING, "": UNDIRECTED}[sign], kind, _count(count))

    @property
    def strands(self) -> int:
        """Number of loops or yarns, 1 if the number varies; 0 for a side that nothing crosses."""
        return 0 if self.kind == NOTHING else 1 if self.count is None else self.count


def _count(text: str | None) -> int | None:
    return None if text == VARYING else 1 if text is None else int(text)


@dataclass(frozen=True)
class FaceType:
    """A type of face; two types of the same name may have different labels."""

    name: str
    """Name without blanks, such as ``knit+``."""
    labels: tuple[str, ...]
    """Label of each side, counter-clockwise from the lower left, such as ``-l1``."""

    def __str__(self) -> str:
        """Return the words of the type in files: its name and its labels."""
        return " ".join([self.name, *self.labels])

    @cached_property
    def sides(self) -> tuple[SideLabel, ...]:
        """What crosses each side."""
        return tuple(SideLabel.parse(label) for label in self.labels)

    def stands_for(self, other: FaceType) -> bool:
        """Return whether the types are the same, where a varying count of either stands for any count."""
        if self.name != other.name or len(self.labels) != len(other.labels):
            return False
        return all(_agree(a, b) for a, b in zip(self.sides, other.sides, strict=True))


def _agree(a: SideLabel, b: SideLabel) -> bool:
    same = (a.direction, a.kind) == (b.direction, b.kind)
    return same and (a.count == b.count or a.count is None or b.count is None)
