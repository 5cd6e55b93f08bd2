# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Hand knitting: the written instructions of a stitch mesh, row by row."""

from stitchmesh.hand_knitting.text import knitting_instructions

__all__ = ["knitting_instructions"]
