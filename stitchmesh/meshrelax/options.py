# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The options of mesh relaxation, with their defaults and bounds."""

from __future__ import annotations

from dataclasses import dataclass

from stitchmesh.errors import ParameterError, check_positive

ASPECT = 0.77
"""Course spacing divided by wale spacing of relaxed plain knit."""
STITCH_WIDTH = 0.8
"""Rest width of plain knit without a surface [cm], on which only the size of the fabric depends."""
ALPHA = 0.9
"""Part of the surface that unstressed stitches cover; with 1, rows in narrow places are compressed until they buckle
sideways."""

LEAST_ALPHA = 1e-4
"""Smallest part; unstressed stitches are then a hundredth as wide as their place."""


@dataclass(frozen=True, kw_only=True)
class MeshRelaxOptions:
    """How the stitches of a fabric are equalized on their surface.

    Raises:
        ParameterError: a number is out of bounds.
    """

    aspect: float | None = None
    """Rest length of a wale edge divided by the rest length of a course edge; None for the height of the stitches
    divided by their width as the fabric was tessellated, ``ASPECT`` if that is not known."""
    alpha: float = ALPHA
    """Part of the area of the surface that unstressed stitches cover, in (0, 1]."""
    area_force: bool = True
    """Whether stitches that are smaller than at rest resist a further loss of area."""

    def __post_init__(self) -> None:
        if self.aspect is not None:
            check_positive("aspect", self.aspect, "(course spacing over wale spacing)")
        if not LEAST_ALPHA <= self.alpha <= 1.0:
            raise ParameterError(f"alpha: got {self.alpha}; expected a part of the area, {LEAST_ALPHA:g} to 1")


DEFAULT_OPTIONS = MeshRelaxOptions()
