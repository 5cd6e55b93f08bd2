# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Hand knitting: the written instructions of a stitch mesh, row by row, and their reading."""

from stitchmesh.hand_knitting.parse import parse_instructions
from stitchmesh.hand_knitting.sizes import graded_instructions
from stitchmesh.hand_knitting.text import knitting_instructions
from stitchmesh.hand_knitting.written_pieces import WrittenPiece, written_pieces

__all__ = ["WrittenPiece", "graded_instructions", "knitting_instructions", "parse_instructions", "written_pieces"]
