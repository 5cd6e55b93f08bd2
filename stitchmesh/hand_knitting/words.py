# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The abbreviations of stitches in knitting patterns, called words here.

A word describes a stitch for a knitter who looks at the row and works from right to left. In a row on the wrong side
it is the word of the stitch turned about its wale (``from_wrong_side``).
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.mesh.cable_groups import CableGroup
from stitchmesh.mesh.own_stitch import OwnStitch, StitchType
from stitchmesh.mesh.stitch import CODES, VOCABULARY, Stitch, from_wrong_side

NAMED = {
    Stitch.KNIT: "k",
    Stitch.PURL: "p",
    Stitch.YARN_OVER: "yo",
    Stitch.SLIP_BACK: "sl1 wyib",
    Stitch.SLIP_FRONT: "sl1 wyif",
    Stitch.WRAP: "w1",
    Stitch.PK: "kfb",
    Stitch.D12K: "k2tog",
    Stitch.D21K: "ssk",
    Stitch.D12P: "p2tog",
    Stitch.D21P: "ssp",
    Stitch.D123K: "k3tog",
    Stitch.D321K: "sssk",
    Stitch.D123P: "p3tog",
    Stitch.D321P: "sssp",
    Stitch.D231K: "s2kp",
    Stitch.D312K: "sk2p",
    Stitch.CAST_ON: "co",
    Stitch.DRAW_THROUGH: "dt",
    Stitch.BIND_OFF: "bo",
}
"""Abbreviations in common use, and ``w1``, ``co``, ``dt`` and ``bo`` for one loop each."""
PLAIN_NAMES = {
    Stitch.PANEL: "panel",
    Stitch.KNIT: "knit",
    Stitch.PURL: "purl",
    Stitch.CAST_ON: "cast-on",
    Stitch.DRAW_THROUGH: "draw-through",
    Stitch.BIND_OFF: "bind-off",
}
"""Names that stand alone in lists and messages, where ``k`` or ``co`` would be hard to read."""
STITCHES_BY_NAME: dict[str, Stitch] = {
    **{code: CODES[code] for code in ("k", "p")},
    **{word: stitch for stitch, word in NAMED.items() if " " not in word and stitch not in PLAIN_NAMES},
    **{PLAIN_NAMES[stitch]: stitch for stitch in (Stitch.CAST_ON, Stitch.DRAW_THROUGH)},
    **CODES,
}
"""Stitches by the names under which edits and selections take them: abbreviations, and codes of a chart."""
ONE_LOOP = frozenset({"k", "p"})
"""Words that are followed by a number: ``k3``, ``k1 tbl``."""

MADE_ONES = {-1: "m1l", 1: "m1r"}
"""Words of yarn-overs with a half turn."""
YARN_OVERS = {
    "yo": "yarn over",
    "m1l": "make 1 leaning left: a backward loop on the right needle, its right leg in front",
    "m1r": "make 1 leaning right: a backward loop on the right needle, its left leg in front",
}
"""Words of yarn-overs with their explanations in the legend."""
IN_ONE = {"k": "k1", "p": "p1", "y": "yo", "s": "keep"}
"""Word for each letter of ``Making.made``, inside the brackets of an increase."""

MEANINGS = {
    "k": "knit",
    "p": "purl",
    "sl1 wyib": "slip 1 purlwise with the yarn in back",
    "sl1 wyif": "slip 1 purlwise with the yarn in front",
    "kfb": "knit into the front of 1 st and then into its back",
    "w1": "slip 1 and wrap the yarn once around it",
}
"""Explanations of words in the legend that replace the instructions of the vocabulary."""


def stitch_word(stitch: StitchType, right_side: bool) -> str:
    """Return the word of a stitch for a knitter who looks at this side of the fabric.

    The word of a stitch of the user's own is its code on both sides.
    """
    if isinstance(stitch, OwnStitch):
        return stitch.code
    seen = stitch if right_side else from_wrong_side(stitch)
    if seen in NAMED:
        return NAMED[seen]
    making = VOCABULARY[seen]
    if making.n_bottom == 3:
        return f"{making.made}3tog-" + "".join(map(str, making.order))
    return "(" + ", ".join(IN_ONE[letter] for letter in reversed(making.made)) + ") in 1 st"


def stitch_name(stitch: StitchType) -> str:
    """Return the name of a stitch in lists, legends and messages, as seen from the right side."""
    plain = None if isinstance(stitch, OwnStitch) else PLAIN_NAMES.get(stitch)
    return plain or stitch_word(stitch, right_side=True)


def stitch_named(name: str) -> Stitch:
    """Return the stitch of a name in ``STITCHES_BY_NAME``.

    Raises:
        ParameterError: no stitch has the name.
    """
    if name not in STITCHES_BY_NAME:
        raise ParameterError(f"stitch {name[:40]!r}: is unknown; expected one of {', '.join(STITCHES_BY_NAME)}")
    return STITCHES_BY_NAME[name]


def without_yarn_overs(stitch: StitchType) -> tuple[int, StitchType | None, int]:
    """Return the number of yarn-overs on the left of a stitch, the stitch without them, and their number on the right.

    The stitch is None if it consists of yarn-overs only. Tucks stay whole, and so do stitches of the user's own.
    """
    if isinstance(stitch, OwnStitch) or stitch not in VOCABULARY or "s" in VOCABULARY[stitch].made:
        return 0, stitch, 0
    made = VOCABULARY[stitch].made
    inner = made.strip("y")
    left = made.find(inner)
    right = len(made) - left - len(inner)
    if left + right == 0:
        return 0, stitch, 0
    return left, CODES[inner] if inner else None, right


def stitch_meaning(stitch: StitchType, right_side: bool) -> str:
    """Return the explanation of ``stitch_word`` for the legend."""
    if isinstance(stitch, OwnStitch):
        return stitch.making.instruction + ("" if right_side else ", as seen from the right side")
    word = stitch_word(stitch, right_side)
    if word in MEANINGS:
        return MEANINGS[word]
    seen = stitch if right_side else from_wrong_side(stitch)
    return VOCABULARY[seen].instruction.partition(" (")[0]


def word_with_twists(word: str, twists: Sequence[int]) -> str:
    """Return the word of a stitch together with the twists of the loops that it is worked through.

    Args:
        word: word of the stitch (``stitch_word``).
        twists: twist of each loop below (``StitchMesh.twist``), in working order.
    """
    suffix = twist_words(twists)
    return f"{word}1{suffix}" if suffix and word in ONE_LOOP else word + suffix


def twist_words(twists: Sequence[int]) -> str:
    """Return the words that follow a stitch if loops below it are twisted, else an empty string.

    The words are the same on the right and on the wrong side. Work through the back loop always brings the right leg
    of the loop to the front (twist -1). For the opposite twist the loop must first be turned on the needle.

    Args:
        twists: twist of each loop below, in working order.
    """
    if list(twists) == [-1]:
        return " tbl"
    turns = [f"{'L' if twist > 0 else 'R'}{place}" for place, twist in enumerate(twists, start=1) if twist]
    return " turning " + " ".join(turns) if turns else ""


def cable_word(group: CableGroup, right_side: bool) -> str:
    """Return the instruction to cross the loops of a group before they are worked.

    The crossing of two bundles is written ``cross 2/3 front``: the next 2 loops are held in front while the 3 loops
    after them are worked. For any other crossing the word lists the loops, numbered in working order, in their new
    order and from front to back.
    """
    step = -1 if right_side else 1
    count = len(group.destination)
    place = group.destination[::step] if step > 0 else count - 1 - group.destination[::-1]
    front = group.layer[::step] * (1 if right_side else -1)
    first = int(place.argmin())
    swapped = np.concatenate([np.arange(count - first, count), np.arange(count - first)])
    flat = len(set(front[:first])) == 1 and len(set(front[first:])) == 1
    if np.array_equal(place, swapped) and flat:
        return f"cross {first}/{count - first} {'front' if front[0] > front[-1] else 'back'}"
    order = "-".join(str(loop + 1) for loop in np.argsort(place))
    depth = "-".join(str(loop + 1) for loop in np.argsort(-front, kind="stable"))
    return f"cross to {order} front to back {depth}"


def cable_meanings(rows: str) -> list[str]:
    """Return the explanations of all crossings in the text of some rows, the short words first.

    Each crossing of ``cable_word`` has its own explanation. So has each short word such as ``c4f``, which crosses two
    equal bundles that are knit.
    """
    short = sorted({(int(count), side) for count, side in re.findall(r"\bc(\d+)([fb])\b", rows)})
    bundles = sorted(set(re.findall(r"\bcross (\d+)/(\d+) (front|back)\b", rows)))
    orders = sorted(set(re.findall(r"\bcross to ([\d-]+) front to back ([\d-]+)", rows)))
    lines = []
    for count, side in short:
        half, where = _sts(count // 2), "front" if side == "f" else "back"
        meaning = f"hold the next {half} in {where}, knit the following {half}, then the {half} held"
        lines.append(f"c{count}{side}: {meaning}")
    for first, second, side in bundles:
        held, then = _sts(int(first)), f"work the following {_sts(int(second))}"
        meaning = f"hold the next {held} in {side}, {then}, then the {held} held, as the next words say"
        lines.append(f"cross {first}/{second} {side}: {meaning}")
    for order, depth in orders:
        foremost, _, behind = depth.partition("-")
        place = f"st {foremost} in front, behind it {behind.replace('-', ', behind it ')}"
        meaning = f"bring sts 1 to {order.count('-') + 1} into the order {order}, {place}"
        lines.append(f"cross to {order} front to back {depth}: {meaning}; work them as the next words say")
    return lines


def _sts(count: int) -> str:
    return "st" if count == 1 else f"{count} sts"


def colour_letter(yarn: int) -> str:
    """Return the name of a yarn: A to Z, then Y27 and so on."""
    return chr(ord("A") + yarn) if yarn < 26 else f"Y{yarn + 1}"
