# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What a hand knitter reads: a stitch mesh in words, row by row."""

from stitchmesh.hand_knitting.text import knitting_instructions

__all__ = ["knitting_instructions"]
