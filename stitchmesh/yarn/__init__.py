# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns: curves, rest lengths, radii, colours, and tiles of a periodic set of yarns."""

from stitchmesh.yarn.yarn_set import (
    APPARENT_OVER_CONTACT,
    FLOATING,
    GAUSS_POINTS,
    UNKNOWN_FACE,
    YarnSet,
    basis,
    basis_derivative,
    segment_lengths,
    segment_points,
)

__all__ = [
    "APPARENT_OVER_CONTACT",
    "FLOATING",
    "GAUSS_POINTS",
    "UNKNOWN_FACE",
    "YarnSet",
    "basis",
    "basis_derivative",
    "segment_lengths",
    "segment_points",
]
