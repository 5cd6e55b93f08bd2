# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Which stitch a face takes when its sides change, and which stitches it can take at all.

The stitch stays what it was as far as it can: knit or purl by what most of its loops are, which of the outer loops
lies in front, how its loops are made. A new increase is ``ky``, ``py``, ``kyk`` or ``pyp``, a new decrease leans right
(``d12k``) or has the middle loop in front (``d213k``), a loop on no loop is a yarn-over.
"""

from __future__ import annotations

from stitchmesh.errors import ParameterError
from stitchmesh.mesh.stitch import CODES, SIDE_COUNTS, VOCABULARY, Stitch

NAMED = {**CODES, "cast-on": Stitch.CAST_ON, "draw-through": Stitch.DRAW_THROUGH}
"""Stitches by what an edit calls them."""


def stitch_named(code: str) -> Stitch:
    """The stitch of a code.

    Raises:
        ParameterError: there is none.
    """
    if code not in NAMED:
        raise ParameterError(f"stitch {code!r}: is unknown; expected one of {', '.join(NAMED)}")
    return NAMED[code]


def plain_stitch_named(code: str, what: str) -> Stitch:
    """The stitch of a code, if it makes one loop on one.

    Args:
        code: of the stitch.
        what: what it is to be repeated to, for the message.

    Raises:
        ParameterError: it makes or takes another number of loops, or there is none.
    """
    stitch = stitch_named(code)
    if SIDE_COUNTS.get(stitch) != (1, 1):
        raise ParameterError(f"stitch {code}: does not make one loop on one; expected such a stitch for {what}")
    return stitch


def fitting_stitch(like: Stitch, n_bottom: int, n_top: int, free: int = 0) -> Stitch | None:
    """The stitch most like another on a face with these sides, None where there is none.

    Args:
        like: what the face held.
        n_bottom: bottom sides.
        n_top: top sides.
        free: how many of its bottom sides lie on the border.
    """
    if n_top and free == n_bottom and (n_bottom or like in (Stitch.CAST_ON, Stitch.DRAW_THROUGH)):
        return Stitch.CAST_ON
    if n_bottom and not n_top and like in (Stitch.CAST_ON, Stitch.DRAW_THROUGH):
        return Stitch.DRAW_THROUGH
    if SIDE_COUNTS.get(like) == (n_bottom, n_top):
        return like
    return CODES.get(_decrease(like, n_bottom) if n_bottom > 1 and n_top == 1 else _increase(like, n_bottom, n_top))


def check_fit(name: str, stitch: Stitch, n_bottom: int, n_top: int, free: int) -> None:
    """Check that a face can hold a stitch.

    Args:
        name: how messages name the face.
        stitch: the stitch.
        n_bottom: bottom sides.
        n_top: top sides.
        free: how many of its bottom sides lie on the border.

    Raises:
        ParameterError: its sides are not as many, or it takes loops where there are none.
    """
    sides = f"{n_bottom} bottom and {n_top} top sides"
    if stitch == Stitch.CAST_ON:
        if free < n_bottom or not n_top:
            raise ParameterError(f"{name}: cast-on has loops on top and none below; the face has {sides}, {free} free")
        return
    if stitch == Stitch.DRAW_THROUGH:
        if n_top or not n_bottom or free:
            needs = "yarn drawn through has loops below and none on top"
            raise ParameterError(f"{name}: {needs}; the face has {sides}, {free} free")
        return
    if SIDE_COUNTS[stitch] != (n_bottom, n_top):
        needs = "{} and {}".format(*SIDE_COUNTS[stitch])
        raise ParameterError(f"{name}: {VOCABULARY[stitch].code} needs {needs}; the face has {sides}")
    if free:
        raise ParameterError(
            f"{name}: stands on the border with {free} of its {n_bottom} bottom sides, where there is no loop for "
            f"{VOCABULARY[stitch].code}; only cast-on fits there"
        )


def _plain(like: Stitch) -> str:
    made = VOCABULARY[like].made if like in VOCABULARY else "k"
    return "p" if made.count("p") > made.count("k") else "k"


def _increase(like: Stitch, n_bottom: int, n_top: int) -> str:
    """Code of one loop or more on one loop or none."""
    plain, made = _plain(like), VOCABULARY[like].made if like in VOCABULARY else ""
    if n_bottom == 0:
        return "y" * n_top
    if n_bottom > 1 or n_top not in (1, 2, 3):
        return ""
    if n_top == 1:
        return plain
    if n_top == 2:
        return made[:2] if len(made) == 3 else plain + "y"
    return made + made[0] if len(made) == 2 and not set(made) & set("ys") else f"{plain}y{plain}"


def _decrease(like: Stitch, n_bottom: int) -> str:
    """Code of several loops taken together."""
    order = VOCABULARY[like].order if like in VOCABULARY else ()
    if n_bottom == 2:
        right_in_front = len(order) == 3 and order.index(3) < order.index(1)
        return f"d{'21' if right_in_front else '12'}{_plain(like)}"
    return f"d213{_plain(like)}" if n_bottom == 3 else ""
