# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How much yarn of each colour a knitter needs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from stitchmesh.hand_knitting.words import colour_letter
from stitchmesh.mesh.palette import Palette, colour_text, colours_of
from stitchmesh.yarn import YarnSet


@dataclass(frozen=True)
class YarnAmount:
    """The yarn of one colour."""

    letter: str
    """Name of the yarn in charts and rows."""
    colour: str
    """Colour as ``#rrggbb``."""
    metres: float
    grams: float


def yarn_amounts(lengths: Mapping[int, float], palette: Palette, grams_per_metre: float) -> tuple[YarnAmount, ...]:
    """Return the yarn of each number, in order.

    Args:
        lengths: length of each yarn number [cm].
        palette: colours of the numbers.
        grams_per_metre: weight of a length of the yarn [g/m].
    """
    amounts = []
    for number, length in sorted(lengths.items()):
        colour, metres = colour_text(colours_of([number], palette)[0]), length / 100.0
        amounts.append(YarnAmount(colour_letter(number), colour, metres, metres * grams_per_metre))
    return tuple(amounts)


def yarn_lengths(yarns: YarnSet, *, at_rest: bool = False) -> dict[int, float]:
    """Return the length of each yarn number [cm], as the yarns lie or at rest."""
    of_segment, lengths = yarns.colour[yarns.segment_yarn], yarns.rest_length if at_rest else yarns.lengths
    return {int(number): float(lengths[of_segment == number].sum()) for number in np.unique(yarns.colour)}
