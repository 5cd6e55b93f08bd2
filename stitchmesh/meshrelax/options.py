# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The options of mesh relaxation, with their defaults and bounds."""

from __future__ import annotations

from dataclasses import dataclass

from stitchmesh.settings import check_settings, setting

ASPECT = 0.77
"""Course spacing divided by wale spacing of relaxed plain knit."""
STITCH_WIDTH = 0.8
"""Rest width of plain knit without a surface [cm]; only the size of the fabric depends on it."""
ALPHA = 0.9
"""Part of the surface that unstressed stitches cover. With 1, rows in narrow places would be compressed until they
buckle sideways."""

LEAST_ALPHA = 1e-4
"""Smallest part of the surface; unstressed stitches are then a hundredth as wide as their place."""


@dataclass(frozen=True, kw_only=True)
class MeshRelaxOptions:
    """How the stitches of a fabric are equalized on their surface.

    Raises:
        ParameterError: a number is out of bounds.
    """

    aspect: float | None = setting(
        None, "height of an unstressed stitch divided by its width", positive=True, form="R", example=ASPECT,
        unset=f"that of the stitches, {ASPECT} if it is not known",
    )  # fmt: skip
    alpha: float = setting(
        ALPHA, "part of the surface that unstressed stitches cover, above 0 and at most 1; less gives crowded rows "
        "more room", form="PART",
        least=LEAST_ALPHA, most=1.0, expected=f"a part of the area, {LEAST_ALPHA:g} to 1",
    )  # fmt: skip
    area_force: bool = setting(
        True, "let crowded stitches resist a loss of area; without it, compressed openwork may fold over"
    )

    def __post_init__(self) -> None:
        check_settings(self)


DEFAULT_OPTIONS = MeshRelaxOptions()
