# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns: curves, rest lengths, radii, colours, and tiles of a periodic set of yarns."""

from stitchmesh.yarn.yarn_set import (
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
    "FLOATING",
    "GAUSS_POINTS",
    "UNKNOWN_FACE",
    "YarnSet",
    "basis",
    "basis_derivative",
    "segment_lengths",
    "segment_points",
]
