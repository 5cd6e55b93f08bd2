# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Types of faces: a name, and a label for each side of the face.

The module also holds the names of stitches as types of faces.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cached_property

from stitchmesh.mesh.stitch import VOCABULARY, Stitch

ENTERING, LEAVING, UNDIRECTED = -1, 1, 0
"""Directions of a side: the loops or yarns that cross it enter the face, leave it, or have no direction."""
NOTHING = "x"
"""Kind of a side that nothing crosses."""
VARYING = "X"
"""Count of a label that stands for any count."""
_LABEL = re.compile(r"([+-]?)(.*?)([0-9]{1,6}|X)?")
FACE_NAMES: dict[Stitch, str] = {
    **{stitch: f"make-{making.code}+" for stitch, making in VOCABULARY.items() if making.n_top > 1},
    **{stitch: f"decrease-{making.code[1:]}+" for stitch, making in VOCABULARY.items() if making.n_bottom > 1},
    Stitch.PANEL: "panel+",
    Stitch.CAST_ON: "tuck-twist+",
    Stitch.BIND_OFF: "bind-off+",
    Stitch.DRAW_THROUGH: "draw-through+",
    Stitch.KNIT: "knit+",
    Stitch.PURL: "purl+",
    Stitch.YARN_OVER: "tuck+",
    Stitch.SLIP_BACK: "slip-back+",
    Stitch.SLIP_FRONT: "slip-front+",
    Stitch.WRAP: "slip-wrap+",
    Stitch.KY: "make-right-tuck+",
    Stitch.YK: "make-left-tuck+",
    Stitch.KS: "make-left-split+",
    Stitch.SK: "make-right-split+",
    Stitch.D12K: "decrease-right+",
    Stitch.D21K: "decrease-left+",
}  # fmt: skip
"""Name of the face of each stitch; the ending ``+`` means that the row runs from left to right."""

KNITOUT_NAMES = {"knit-to-left": Stitch.KNIT, "knit-to-right": Stitch.KNIT,
                 "purl-to-left": Stitch.PURL, "purl-to-right": Stitch.PURL}  # fmt: skip
"""Stitches of names in the library ``knitout.sf``."""

STITCHES_OF_NAMES = {
    **{name: stitch for stitch, name in FACE_NAMES.items()},
    **{name[:-1] + "-": stitch for stitch, name in FACE_NAMES.items()},
    **KNITOUT_NAMES,
}
"""Stitch of each name of a face that is a stitch."""

LOOP, YARN = "l", "y"
"""Kinds of the sides of a stitch: loops below and on top, and the yarn of the row at its ends."""
EMPTY_BELOW = frozenset({Stitch.CAST_ON})
"""Stitches whose lower sides no loop crosses; these sides have the label ``l0``."""
EMPTY_ABOVE = frozenset({Stitch.DRAW_THROUGH, Stitch.BIND_OFF})
"""Stitches whose upper sides no loop crosses; these sides have the label ``l0``."""


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


def stitch_of(kind: FaceType) -> Stitch | None:
    """Return the stitch that a type of face stands for; None if it stands for none.

    The sides of a stitch are loops in, yarn, loops out, yarn. Each of them has one strand, except the lower sides of a
    cast-on and the upper sides of a bind-off.
    """
    stitch = STITCHES_OF_NAMES.get(kind.name)
    if stitch is None or not is_framed(kind):
        return None
    below = {side.count for side in kind.sides if side.direction == ENTERING and side.kind == LOOP}
    above = {side.count for side in kind.sides if side.direction == LEAVING and side.kind == LOOP}
    yarn = {side.count for side in kind.sides if side.kind == YARN}
    fits = yarn <= {1, None} and _fits(below, stitch in EMPTY_BELOW) and _fits(above, stitch in EMPTY_ABOVE)
    return stitch if fits else None


def is_foreign(kind: FaceType) -> bool:
    """Return whether the name of a type is no stitch, or its counts of loops or yarns differ from the stitch."""
    return kind.name not in STITCHES_OF_NAMES or (is_framed(kind) and stitch_of(kind) is None)


def is_framed(kind: FaceType) -> bool:
    """Return whether the sides of a type are loops in, yarn, loops out, and yarn that does not run against the first.

    Yarn without a direction runs either way.
    """
    frame = [(side.kind, side.direction) for side in kind.sides]
    below = next((k for k, side in enumerate(frame) if side != (LOOP, ENTERING)), len(frame))
    above = frame[below + 1 : -1]
    ends = [*frame[below : below + 1], *frame[-1:]] if below < len(frame) - 1 else []
    if [kind for kind, _ in ends] != [YARN, YARN]:
        return False
    (_, right), (_, left) = ends
    opposite = right != left or right == UNDIRECTED
    return opposite and all(side == (LOOP, LEAVING) for side in above)


def _fits(counts: set[int | None], may_be_empty: bool) -> bool:
    return counts <= ({0, 1, None} if may_be_empty else {1, None})
