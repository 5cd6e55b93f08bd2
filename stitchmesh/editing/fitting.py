# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The choice of a stitch for a face with new sides, and the check that a stitch fits a face.

The new stitch is as similar to the old stitch as possible: it is knit or purl like most of the loops, keeps the outer
loop that lies in front, and makes its loops in the same way. A new increase is ``ky``, ``py``, ``yky`` or ``ypy``, and
its yarn-overs are made ones (``stitchmesh.mesh.shaping_stitches``). A new decrease leans to the right (``d12k``) or has
the middle loop in front (``d213k``). A stitch that takes no loop is a yarn-over.
"""

from __future__ import annotations

from stitchmesh.errors import ParameterError
from stitchmesh.hand_knitting.words import stitch_name, stitch_named
from stitchmesh.mesh.stitch import CODES, SIDE_COUNTS, VOCABULARY, Stitch


def plain_stitch_named(code: str, purpose: str) -> Stitch:
    """Return the stitch with a code; it must have one loop below and one above.

    Args:
        code: code of the stitch.
        purpose: the rows or columns that the stitch will form, for the message.

    Raises:
        ParameterError: the code is unknown, or the stitch has another number of loops.
    """
    stitch = stitch_named(code)
    if SIDE_COUNTS.get(stitch) != (1, 1):
        raise ParameterError(f"stitch {code}: does not make one loop on one; expected such a stitch for {purpose}")
    return stitch


def fitting_stitch(old: Stitch, n_bottom: int, n_top: int, free: int = 0) -> Stitch | None:
    """Return the stitch that fits a face and is most similar to the old one; None if no stitch fits.

    Args:
        old: the previous stitch of the face.
        n_bottom: number of bottom sides.
        n_top: number of top sides.
        free: number of bottom sides on the border.
    """
    if n_top and free == n_bottom and (n_bottom or old in (Stitch.CAST_ON, Stitch.DRAW_THROUGH)):
        return Stitch.CAST_ON
    if n_bottom and not n_top and old in (Stitch.CAST_ON, Stitch.DRAW_THROUGH):
        return Stitch.DRAW_THROUGH
    if SIDE_COUNTS.get(old) == (n_bottom, n_top):
        return old
    return CODES.get(_decrease(old, n_bottom) if n_bottom > 1 and n_top == 1 else _increase(old, n_bottom, n_top))


def check_fit(name: str, stitch: Stitch, n_bottom: int, n_top: int, free: int) -> None:
    """Check that a stitch fits a face.

    Args:
        name: the name of the face in messages.
        stitch: the stitch.
        n_bottom: number of bottom sides.
        n_top: number of top sides.
        free: number of bottom sides on the border.

    Raises:
        ParameterError: the stitch has another number of sides, or works loops at a border, where there are none.
    """
    sides = f"{n_bottom} bottom and {n_top} top sides"
    if stitch == Stitch.CAST_ON:
        if free < n_bottom or not n_top:
            raise ParameterError(f"{name}: cast-on has loops on top and none below; the face has {sides}, {free} free")
        return
    if stitch == Stitch.DRAW_THROUGH:
        if n_top or not n_bottom or free:
            needs = "a drawn-through stitch has loops below and none on top"
            raise ParameterError(f"{name}: {needs}; the face has {sides}, {free} free")
        return
    if SIDE_COUNTS[stitch] != (n_bottom, n_top):
        needs = "{} and {}".format(*SIDE_COUNTS[stitch])
        raise ParameterError(f"{name}: {stitch_name(stitch)} needs {needs}; the face has {sides}")
    if free:
        raise ParameterError(
            f"{name}: lies on the border with {free} of its {n_bottom} bottom sides, where there is no loop for "
            f"{stitch_name(stitch)}; only cast-on fits there"
        )


def _plain(old: Stitch) -> str:
    made = VOCABULARY[old].made if old in VOCABULARY else "k"
    return "p" if made.count("p") > made.count("k") else "k"


def _increase(old: Stitch, n_bottom: int, n_top: int) -> str:
    """Return the code of a stitch that takes at most one loop and makes one or more."""
    plain, made = _plain(old), VOCABULARY[old].made if old in VOCABULARY else ""
    if n_bottom == 0:
        return "y" * n_top
    if n_bottom > 1 or n_top not in (1, 2, 3):
        return ""
    if n_top == 1:
        return plain
    if n_top == 2:
        return made[:2] if len(made) == 3 else plain + "y"
    return made + made[0] if len(made) == 2 and not set(made) & set("ys") else f"y{plain}y"


def _decrease(old: Stitch, n_bottom: int) -> str:
    """Return the code of a stitch that works several loops together."""
    order = VOCABULARY[old].order if old in VOCABULARY else ()
    if n_bottom == 2:
        right_in_front = len(order) == 3 and order.index(3) < order.index(1)
        return f"d{'21' if right_in_front else '12'}{_plain(old)}"
    return f"d213{_plain(old)}" if n_bottom == 3 else ""
