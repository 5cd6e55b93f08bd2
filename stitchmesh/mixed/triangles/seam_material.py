# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The material of the rods along the seams: seam allowances and sewing thread (C 6.1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.errors import ParameterError


@dataclass(frozen=True)
class SeamMaterial:
    """A material of rods along seams.

    Raises:
        ParameterError: a number is negative or not finite, or the rod has neither stiffness.
    """

    stretch: float
    """Axial stiffness: tension over strain [dyn]."""
    bending: float
    """Bending stiffness: moment over curvature [dyn cm^2]."""
    density: float = 0.0
    """Mass per length [g / cm]."""

    def __post_init__(self) -> None:
        for name in ("stretch", "bending", "density"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value >= 0.0):
                raise ParameterError(f"seam material: {name} is {value}; expected a number that is not negative")
        if self.stretch == 0.0 and self.bending == 0.0:
            raise ParameterError("seam material: stretch and bending are 0; expected one of them; leave the rods out")
