# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stitches of the user's own: a code, what the stitch makes, and a drawing of its yarn.

Such a stitch is a value. A pattern holds it in its cells, and a stitch mesh in ``StitchMesh.own_stitches``, where the
type codes from ``FIRST_OWN`` name the stitches in their order.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from functools import cached_property

from stitchmesh.errors import ParameterError, PatternError
from stitchmesh.mesh.stitch import Making, Stitch

FIRST_OWN = 64
"""Type code of the first stitch of the user's own in a stitch mesh; codes below it belong to ``Stitch``."""
MAKES = re.compile(r"(?:d(?P<order>[123]{1,3}))?(?P<made>[kpy]{1,4})")

Waypoint = tuple[float, float, float]
"""x in stitch widths, distance from the bottom over the height of the face, and height in yarn radii."""


@dataclass(frozen=True)
class DrawnPart:
    """One piece of yarn of a drawing."""

    start: str
    """Where it begins: ``left wale``, ``right wale``, ``bottom 2 left`` or ``top 1 right``, loops from the left."""
    end: str
    """Where it ends."""
    head: bool
    """Whether it is yarn of the loop below and not of the row."""
    through: tuple[Waypoint, ...]
    """Points between its ends."""


@dataclass(frozen=True)
class OwnStitch:
    """A stitch of the user's own.

    Raises:
        ParameterError: the code is no word of 2 to 16 small letters, or the stitch cannot make what ``makes`` says.
    """

    code: str
    """Word of the stitch in patterns, such as ``daisy``."""
    makes: str
    """What it makes, in the codes of ``stitch``: ``d123kyk`` works three loops together and makes three from them."""
    parts: tuple[DrawnPart, ...] = field(repr=False)
    """Its yarn, seen from the right side."""
    instruction: str = ""
    """Instruction for a hand knitter."""

    def __post_init__(self) -> None:
        if not re.fullmatch(r"[a-z]{2,16}", self.code):
            raise ParameterError(f"stitch {self.code!r}: got this code; expected 2 to 16 letters a to z")
        match = MAKES.fullmatch(self.makes)
        order = (match["order"] or "") if match else ""
        if not match or sorted(order) != [str(place) for place in range(1, len(order) + 1)]:
            expected = "d with the loops below from front to back, if there are several, then k, p or y for each loop"
            raise ParameterError(f"stitch {self.code!r}: makes {self.makes!r}; expected {expected}, such as d123kyk")

    @property
    def name(self) -> str:
        """Name of the stitch, which is its code."""
        return self.code

    @cached_property
    def making(self) -> Making:
        """How the stitch is made."""
        match = MAKES.fullmatch(self.makes)
        assert match is not None
        alone = () if self.makes == "y" else (1,)
        order = tuple(map(int, match["order"])) if match["order"] else alone
        return Making(self.code, order, match["made"], self.instruction or f"work {self.code}")


StitchType = Stitch | OwnStitch
"""A built-in stitch, or one of the user's own."""


def built_in(stitch: StitchType) -> Stitch:
    """Return a built-in stitch as it is.

    Raises:
        PatternError: the stitch is one of the user's own, which is drawn from the right side only.
    """
    if isinstance(stitch, OwnStitch):
        raise PatternError(f"stitch {stitch.code!r}: is drawn as seen from the right side only, so it is not turned")
    return stitch
