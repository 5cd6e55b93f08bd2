# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The stitches that shape a fabric: increases and decreases, as a knitter chooses them.

In a decrease, the loop that continues the wale is in front: ``k2tog`` leans to the right, ``ssk`` to the left. The two
ends of a row mirror each other, so that decreases lean in pairs, along the edges of the narrowing fabric.

An increase has four forms:

- ``m1``: make one. The new loop is a yarn-over with crossed legs, which closes (``StitchMesh.twist``). A knitter makes
  it as a backward loop on the needle, or lifts the bar between two stitches in the next row and knits it through its
  back loop: both ways put the same yarn through the same loops. Left of the stitch the right leg of the loop is in
  front (m1l), right of the stitch the left leg (m1r), so that increases mirror each other too.
- ``kfb``: knit front and back, knit and purl into one loop. The second loop goes through the back of the loop below,
  which is turned by half a turn there. It therefore goes through this loop the other way, as a purl does, and has the
  bump of a purl. The bump is always on the left of the knit loop, at both edges, as a knitter makes it.
- ``lifted``: the loop below stays on the needle beside the new loop, and the next row works both.
- ``yo``: a yarn-over, whose legs do not cross. It leaves a hole.

An increase by two loops is make one on both sides. There are two exceptions: the form ``yo`` works knit, yarn over and
knit into one loop, and the form ``kfb`` knit, purl and knit.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.mesh.stitch import VOCABULARY, Stitch
from stitchmesh.mesh.stitch_mesh import StitchMesh

Increase = Literal["m1", "kfb", "lifted", "yo"]
"""How increases are made."""
DEFAULT_INCREASE: Increase = "m1"
Keeps = Literal["left", "middle", "right"]
"""The loop of a shaping stitch that continues the wale; the others begin or end there."""

_SHAPING = {
    (1, 2): {"left": Stitch.KY, "middle": Stitch.KY, "right": Stitch.YK},
    (1, 3): {"left": Stitch.YKY, "middle": Stitch.YKY, "right": Stitch.YKY},
    (2, 1): {"left": Stitch.D12K, "middle": Stitch.D12K, "right": Stitch.D21K},
    (3, 1): {"left": Stitch.D123K, "middle": Stitch.D213K, "right": Stitch.D321K},
}
"""Shaping stitches by the numbers of loops below and above, and by the loop that continues the wale."""
_FORMS: dict[Increase, tuple[Stitch, Stitch, Stitch]] = {
    "m1": (Stitch.KY, Stitch.YK, Stitch.YKY),
    "kfb": (Stitch.PK, Stitch.PK, Stitch.KPK),
    "lifted": (Stitch.KS, Stitch.SK, Stitch.YKY),
    "yo": (Stitch.KY, Stitch.YK, Stitch.KYK),
}
"""Stitches of each form: with a new loop on the right, with a new loop on the left, and with two new loops."""


def shaping_stitch(below: int, above: int, *, keeps: Keeps) -> Stitch:
    """Return the stitch of a new face with given numbers of loops, at most 3; at least one of them is 1."""
    return Stitch.KNIT if below == above == 1 else _SHAPING[below, above][keeps]


def closing_half_turns(stitch: Stitch) -> tuple[int, ...]:
    """Return the half turn of each loop of an increase, from left to right, with which its outer yarn-overs close."""
    made = VOCABULARY[stitch].made
    left, right = len(made) - len(made.lstrip("y")), len(made.rstrip("y"))
    is_increase = len(made) > 1 and "s" not in made
    return tuple(is_increase * ((place >= right) - (place < left)) for place in range(len(made)))


def check_increase(increase: str) -> None:
    """Check that there is a form of increases of that name.

    Raises:
        ParameterError: there is no such form of increases.
    """
    if increase not in _FORMS:
        raise ParameterError(f"increase: got {increase!r}; expected one of {', '.join(_FORMS)}")


def with_increases(fabric: StitchMesh, increase: Increase = DEFAULT_INCREASE) -> StitchMesh:
    """Return a fabric whose increases are all made in one form.

    Args:
        fabric: a stitch mesh. Its increases are the stitches of the forms of the module docstring.
        increase: ``m1``, ``kfb``, ``lifted`` or ``yo``.

    Raises:
        ParameterError: there is no such form.
    """
    check_increase(increase)
    stitch, twist = fabric.stitch.copy(), fabric.twist.copy()
    for place, chosen in enumerate(_FORMS[increase]):
        faces = np.flatnonzero(np.isin(fabric.stitch, [form[place] for form in _FORMS.values()]))
        stitch[faces] = chosen
        for loop, turn in enumerate(closing_half_turns(chosen)):
            twist[fabric.left_wale[faces] - 1 - loop] = 0 if increase == "yo" else turn
    return replace(fabric, stitch=stitch, twist=twist)


def stitch_counts(fabric: StitchMesh) -> dict[str, int]:
    """Faces, increases and decreases of a stitch mesh."""
    more, fewer = fabric.n_top > fabric.n_bottom, fabric.n_top < fabric.n_bottom
    shaped = (fabric.n_top > 0) & (fabric.n_bottom > 0)
    return {
        "faces": fabric.face_count,
        "increases": int((more & shaped).sum()),
        "decreases": int((fewer & shaped).sum()),
    }
