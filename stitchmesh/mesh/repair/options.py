# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What a repair may change."""

from __future__ import annotations

import math
from dataclasses import dataclass

from stitchmesh.errors import ParameterError, described


@dataclass(frozen=True)
class RepairOptions:
    """What a repair may change.

    Raises:
        ParameterError: a length is negative or not a number, or the weld distance is not finite.
    """

    weld_distance: float | None = None
    """Distance up to which border vertices become one [cm]; 0 for vertices at equal positions only. None stands for
    1e-6 of the diagonal of the bounding box, and at most 0.01 of the median length of an edge."""
    largest_hole: float = 0.0
    """Perimeter below which every hole is filled [cm]; openings of a garment must be longer. Without it, only holes of
    three sides whose perimeter is below 4 times the median length of an edge are filled."""

    def __post_init__(self) -> None:
        for name in ("weld_distance", "largest_hole"):
            value = getattr(self, name)
            if value is None and name == "weld_distance":
                continue
            if not isinstance(value, int | float) or not value >= 0.0:
                raise ParameterError(f"{name}: got {described(value)}; expected a length of at least 0 cm")
        if self.weld_distance == math.inf:
            raise ParameterError("weld_distance: got inf; expected a finite length, below half the length of an edge")
