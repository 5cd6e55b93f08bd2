# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What a swatch is made of: the options of ``swatch`` and of ``stretch``, with their defaults and bounds."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.yarn.rest_length import RestLengths

YARN_RADIUS = 0.125
"""Default radius of the yarn [cm], that of the published materials."""
COMPACT_LOOP = 16.67
"""Default loop length over the yarn's diameter: Peirce's compact loop."""
SPACING = 2.4
"""Distance of neighbouring yarns of one layer where none is given [yarn diameters]; a plain weave crimps by 9.5 %."""
GAMMAS = (0.1, 10.0)
"""Smallest and largest gamma."""
TAKE_UP = (0.1, 2.0)
"""Smallest and largest factor of a rest length (Leaf et al. 2018, section 7.2)."""
STRETCH_STEPS = 9
"""States of a stretch curve."""


@dataclass(frozen=True, kw_only=True)
class SwatchOptions:
    """What a swatch is made of.

    Raises:
        ParameterError: a length or gamma is not a positive number, or gamma is out of bounds.
    """

    yarn_radius: float = YARN_RADIUS
    """[cm]"""
    loop_length: float | None = None
    """Yarn of a plain stitch [cm]; ``COMPACT_LOOP`` yarn diameters where not given. Knitted swatches."""
    spacing: float | tuple[float, float] | None = None
    """Distance of neighbouring yarns of a weave [cm], or of its warps and of its wefts."""
    rest_lengths: RestLengths = field(default_factory=RestLengths)
    """Take-up: factors of stitches, rows, yarns and parts, which together are within ``TAKE_UP``."""
    gamma: float = 1.0
    """Yarn is taken up by this factor, the fabric made so much tighter."""
    period: tuple[float | None, float | None] = (None, None)
    """Width and height of the repeat [cm]; None leaves it to the drawing, or free where the cell relaxes."""
    columns: int = 1
    """Repeats of the pattern in the cell, side by side."""
    rows: int = 1
    """Repeats of the pattern in the cell, above one another."""

    def __post_init__(self) -> None:
        lengths = {"yarn radius": self.yarn_radius, "loop length": self.loop_length, "period width": self.period[0],
                   "period height": self.period[1]}  # fmt: skip
        for name, value in lengths.items():
            if value is not None and not (np.isfinite(value) and value > 0.0):
                raise ParameterError(f"{name}: got {value} cm; expected a positive number")
        if not (np.isfinite(self.gamma) and GAMMAS[0] <= self.gamma <= GAMMAS[1]):
            raise ParameterError(f"gamma: got {self.gamma}; expected {GAMMAS[0]:g} to {GAMMAS[1]:g}")
        if self.rest_lengths.loop_length is not None:
            raise ParameterError("rest lengths: got a loop length among them; give it to the swatch")
