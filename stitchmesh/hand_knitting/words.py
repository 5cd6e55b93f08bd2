# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The words of stitches, as knitting patterns abbreviate them.

A word says what is done by a knitter who faces the row and works from right to left. On the wrong side that is the
stitch turned about its wale (``from_wrong_side``).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stitchmesh.mesh.cable_groups import CableGroup
from stitchmesh.mesh.stitch import VOCABULARY, Stitch, from_wrong_side

NAMED = {
    Stitch.KNIT: "k",
    Stitch.PURL: "p",
    Stitch.YARN_OVER: "yo",
    Stitch.SLIP_BACK: "sl1 wyib",
    Stitch.SLIP_FRONT: "sl1 wyif",
    Stitch.WRAP: "w1",
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
"""Abbreviations in common use, and ``w1``, ``co``, ``dt``, ``bo`` for one loop each."""
ONE_LOOP = frozenset({"k", "p"})
"""Words that a number follows: ``k3``, ``k1 tbl``."""

IN_ONE = {"k": "k1", "p": "p1", "y": "yo", "s": "keep"}
"""What each letter of an increase says inside its brackets."""

MEANINGS = {
    "k": "knit",
    "p": "purl",
    "yo": "yarn over",
    "sl1 wyib": "slip 1 purlwise with the yarn in back",
    "sl1 wyif": "slip 1 purlwise with the yarn in front",
    "w1": "slip 1 and wrap the yarn once around it",
}
"""What stands in the legend where the vocabulary's own words need the number of loops."""


def stitch_word(stitch: Stitch, right_side: bool) -> str:
    """The word of a stitch that a knitter uses who faces this side of the fabric."""
    seen = stitch if right_side else from_wrong_side(stitch)
    if seen in NAMED:
        return NAMED[seen]
    making = VOCABULARY[seen]
    if making.n_bottom == 3:
        return f"{making.made}3tog-" + "".join(map(str, making.order))
    return "(" + ", ".join(IN_ONE[letter] for letter in reversed(making.made)) + ") in 1 st"


def stitch_meaning(stitch: Stitch, right_side: bool) -> str:
    """What the legend says of ``stitch_word``."""
    word = stitch_word(stitch, right_side)
    if word in MEANINGS:
        return MEANINGS[word]
    seen = stitch if right_side else from_wrong_side(stitch)
    return VOCABULARY[seen].instruction.partition(" (")[0]


def word_on_twisted(word: str, twists: Sequence[int]) -> str:
    """The word of a stitch with what is done to its loops first.

    Args:
        word: what ``stitch_word`` gave.
        twists: of its loops, in working order.
    """
    told = twist_words(twists)
    return f"{word}1{told}" if told and word in ONE_LOOP else word + told


def twist_words(twists: Sequence[int]) -> str:
    """What is said after a stitch whose loops, in working order, are twisted: the same seen from either side.

    Knitting through the back loop brings the loop's right leg in front (-1), by hand always; the other turn needs the
    loop to be turned on the needle first.
    """
    if list(twists) == [-1]:
        return " tbl"
    told = [f"{'L' if twist > 0 else 'R'}{place}" for place, twist in enumerate(twists, start=1) if twist]
    return " turning " + " ".join(told) if told else ""


def cable_word(group: CableGroup, right_side: bool) -> str:
    """How the loops of a group are crossed before they are worked.

    Two bundles that change places are ``cross 2/3 front``: the next 2 are held in front while the 3 after them are
    worked. Any other crossing lists where the loops come to lie and, front to back, which is where, in working order.
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


def colour_letter(yarn: int) -> str:
    """A to Z, then Y27 and so on."""
    return chr(ord("A") + yarn) if yarn < 26 else f"Y{yarn + 1}"
