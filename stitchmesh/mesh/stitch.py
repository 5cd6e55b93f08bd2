# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The stitches that a face of a stitch mesh can hold (Yuksel et al. 2012, section 4.2 and table 1).

A stitch is worked on the loops below it and makes the loops on top of it. Its code lists what the stitch makes, seen
from the right side of the fabric and from left to right. Each ``k`` (knit), ``p`` (purl) and ``y`` (yarn-over) makes a
loop; ``s`` slips a loop, so that the loop below becomes the loop on top. The code of a decrease starts with ``d`` and
the loops that it is worked through, numbered from the left and listed from front to back: ``d213k`` is one knit loop
through three loops, of which the middle one is in front.

A loop on top may be twisted. A twist is not a separate stitch but a mark (``StitchMesh.twist``), written ``k+1``.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum


class Stitch(IntEnum):
    """Type code of a stitch face; ``PANEL`` marks a face of a coarse mesh that is not divided into stitches yet."""

    PANEL = 0
    KNIT = 1
    PURL = 2
    CAST_ON = 3
    """Twisted yarn-overs without loops below: the first row, and new loops at the end of a short row."""
    BIND_OFF = 4
    """Stitch that secures the loops of the last row; the yarn generation makes it."""
    DRAW_THROUGH = 5
    """Face without a top side: the wales end here, and the yarn of the row runs through the loops below."""
    KY = 6
    YK = 7
    KYK = 8
    D12K = 9
    D21K = 10
    D213K = 11
    YARN_OVER = 12
    """A loop without a loop below it, between two stitches."""
    SLIP_BACK = 13
    SLIP_FRONT = 14
    WRAP = 15
    """A slipped loop around which the yarn of the row is wrapped once."""
    KP = 16
    PK = 17
    PY = 18
    YP = 19
    KPK = 20
    YKY = 21
    KPY = 22
    YKP = 23
    PKP = 24
    PYP = 25
    YPY = 26
    PKY = 27
    YPK = 28
    D12P = 29
    D21P = 30
    D123K = 31
    D132K = 32
    D231K = 33
    D312K = 34
    D321K = 35
    D123P = 36
    D132P = 37
    D213P = 38
    D231P = 39
    D312P = 40
    D321P = 41
    SK = 42
    KS = 43
    SP = 44
    PS = 45
    SY = 46
    YS = 47


@dataclass(frozen=True)
class Making:
    """How a stitch is made."""

    code: str
    """Code of the stitch in a chart (module docstring)."""
    order: tuple[int, ...]
    """Loops below, listed from front to back and numbered from 1 at the left; one for each bottom side of the face."""
    made: str
    """Kind of each loop on top, from left to right: ``k``, ``p``, ``y``, or ``s`` for the slipped loop below."""
    instruction: str
    """Instruction for a hand knitter who faces the right side."""

    @property
    def n_bottom(self) -> int:
        """Number of bottom sides of its face."""
        return len(self.order)

    @property
    def n_top(self) -> int:
        """Number of top sides of its face."""
        return len(self.made)


VOCABULARY: dict[Stitch, Making] = {
    Stitch.KNIT: Making("k", (1,), "k", "knit"),
    Stitch.PURL: Making("p", (1,), "p", "purl"),
    Stitch.YARN_OVER: Making("y", (), "y", "yarn over"),
    Stitch.SLIP_BACK: Making("b", (1,), "s", "slip with the yarn behind"),
    Stitch.SLIP_FRONT: Making("f", (1,), "s", "slip with the yarn in front"),
    Stitch.WRAP: Making("x", (1,), "s", "slip, and wrap the yarn once around the loop"),
    Stitch.KP: Making("kp", (1,), "kp", "purl and knit into one loop"),
    Stitch.PK: Making("pk", (1,), "pk", "knit and purl into one loop"),
    Stitch.KY: Making("ky", (1,), "ky", "yarn over, then knit, on one loop"),
    Stitch.YK: Making("yk", (1,), "yk", "knit, then yarn over, on one loop"),
    Stitch.PY: Making("py", (1,), "py", "yarn over, then purl, on one loop"),
    Stitch.YP: Making("yp", (1,), "yp", "purl, then yarn over, on one loop"),
    Stitch.KPK: Making("kpk", (1,), "kpk", "knit, purl and knit into one loop"),
    Stitch.KYK: Making("kyk", (1,), "kyk", "knit, yarn over and knit into one loop"),
    Stitch.YKY: Making("yky", (1,), "yky", "yarn over, knit and yarn over on one loop"),
    Stitch.KPY: Making("kpy", (1,), "kpy", "yarn over, purl and knit on one loop"),
    Stitch.YKP: Making("ykp", (1,), "ykp", "purl, knit and yarn over on one loop"),
    Stitch.PKP: Making("pkp", (1,), "pkp", "purl, knit and purl into one loop"),
    Stitch.PYP: Making("pyp", (1,), "pyp", "purl, yarn over and purl into one loop"),
    Stitch.YPY: Making("ypy", (1,), "ypy", "yarn over, purl and yarn over on one loop"),
    Stitch.PKY: Making("pky", (1,), "pky", "yarn over, knit and purl on one loop"),
    Stitch.YPK: Making("ypk", (1,), "ypk", "knit, purl and yarn over on one loop"),
    Stitch.D12K: Making("d12k", (1, 2), "k", "knit two together, leaning right (k2tog)"),
    Stitch.D21K: Making("d21k", (2, 1), "k", "knit two together, leaning left (ssk)"),
    Stitch.D12P: Making("d12p", (1, 2), "p", "purl two together (p2tog)"),
    Stitch.D21P: Making("d21p", (2, 1), "p", "purl two together through the back (ssp)"),
    Stitch.D123K: Making("d123k", (1, 2, 3), "k", "knit three together, leaning right (k3tog)"),
    Stitch.D132K: Making("d132k", (1, 3, 2), "k", "knit three together, left, right, middle from the front"),
    Stitch.D213K: Making("d213k", (2, 1, 3), "k", "knit three together, middle, left, right from the front"),
    Stitch.D231K: Making("d231k", (2, 3, 1), "k", "slip two together, knit, pass the slipped ones over (s2kp)"),
    Stitch.D312K: Making("d312k", (3, 1, 2), "k", "slip, knit two together, pass the slipped one over (sk2p)"),
    Stitch.D321K: Making("d321k", (3, 2, 1), "k", "knit three together, leaning left (sssk)"),
    Stitch.D123P: Making("d123p", (1, 2, 3), "p", "purl three together (p3tog)"),
    Stitch.D132P: Making("d132p", (1, 3, 2), "p", "purl three together, left, right, middle from the front"),
    Stitch.D213P: Making("d213p", (2, 1, 3), "p", "purl three together, middle, left, right from the front"),
    Stitch.D231P: Making("d231p", (2, 3, 1), "p", "purl three together, middle, right, left from the front"),
    Stitch.D312P: Making("d312p", (3, 1, 2), "p", "purl three together, right, left, middle from the front"),
    Stitch.D321P: Making("d321p", (3, 2, 1), "p", "purl three together through the back (sssp)"),
    Stitch.SK: Making("sk", (1,), "sk", "knit into the loop and keep it, the kept loop on the left"),
    Stitch.KS: Making("ks", (1,), "ks", "knit into the loop and keep it, the kept loop on the right"),
    Stitch.SP: Making("sp", (1,), "sp", "purl into the loop and keep it, the kept loop on the left"),
    Stitch.PS: Making("ps", (1,), "ps", "purl into the loop and keep it, the kept loop on the right"),
    Stitch.SY: Making("sy", (1,), "sy", "slip with a yarn-over on its right: a tuck, worked together next row"),
    Stitch.YS: Making("ys", (1,), "ys", "slip with a yarn-over on its left: a tuck, worked together next row"),
}
"""How each stitch with a fixed number of sides is made; faces of cast-on, bind-off and draw-through have any number."""

CODES: dict[str, Stitch] = {making.code: stitch for stitch, making in VOCABULARY.items()}
"""The stitch of each code."""

SIDE_COUNTS: dict[Stitch, tuple[int, int]] = {
    Stitch.BIND_OFF: (1, 1),
    **{stitch: (making.n_bottom, making.n_top) for stitch, making in VOCABULARY.items()},
}
"""Number of bottom and of top sides of each stitch; a stitch that is not listed may have any number."""

_BY_MAKING = {(making.order, making.made): stitch for stitch, making in VOCABULARY.items() if making.made != "s"}
_SLIP_TURNED = {Stitch.SLIP_BACK: Stitch.SLIP_FRONT, Stitch.SLIP_FRONT: Stitch.SLIP_BACK}
_KNIT_TURNED = str.maketrans("kp", "pk")


def mirrored(stitch: Stitch) -> Stitch:
    """Return the stitch with left and right exchanged."""
    if stitch not in VOCABULARY or VOCABULARY[stitch].made == "s":
        return stitch
    making = VOCABULARY[stitch]
    order = tuple(making.n_bottom + 1 - loop for loop in making.order)
    return _BY_MAKING[order, making.made[::-1]]


def turned_over(stitch: Stitch) -> Stitch:
    """Return the stitch with front and back exchanged: knit becomes purl, and a loop in front becomes a loop behind."""
    if stitch not in VOCABULARY or VOCABULARY[stitch].made == "s":
        return _SLIP_TURNED.get(stitch, stitch)
    making = VOCABULARY[stitch]
    return _BY_MAKING[making.order[::-1], making.made.translate(_KNIT_TURNED)]


def from_wrong_side(stitch: Stitch) -> Stitch:
    """Return the stitch as seen from the right side if the given stitch is worked on the wrong side.

    The stitch is turned by half a turn about its wale, which exchanges left and right, and front and back.
    """
    return mirrored(turned_over(stitch))
