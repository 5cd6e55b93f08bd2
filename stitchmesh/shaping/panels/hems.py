# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The hems of a panel: the lines at which its rows begin or end, with the stitches of their parts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.mesh import FloatArray
from stitchmesh.shaping.panels.outline_pieces import BEGINS, OutlinePiece
from stitchmesh.shaping.panels.panel_time import PanelTime


@dataclass(frozen=True)
class HemPart:
    """Stitches along one piece of the outline at which rows begin or end."""

    piece: int
    """Number of the piece."""
    length: float
    """Its length [cm]."""
    count: int
    """Number of its stitches."""


@dataclass(frozen=True, eq=False)
class Hem:
    """A line at which rows begin or end."""

    points: FloatArray
    """Points along the line from left to right [cm], shape (n, 3)."""
    parts: tuple[HemPart, ...]
    """Its parts from left to right."""


def hems_of(found: PanelTime, pieces: list[OutlinePiece], width: float) -> list[Hem]:
    """Return the hems of a panel, with the number of stitches of each of their pieces.

    Args:
        found: the time of the panel.
        pieces: the outlines of all panels.
        width: width of a stitch [cm].
    """
    hems = []
    for run, end in zip(found.runs, found.ends.all, strict=True):
        order = 1 if pieces[run[0]].kind == BEGINS else -1
        parts = [HemPart(piece, pieces[piece].length, _count(pieces, piece, width)) for piece in run]
        hems.append(Hem(found.refined.surface.vertices[end.vertices][::order], tuple(parts[::order])))
    return hems


def _count(pieces: list[OutlinePiece], number: int, width: float) -> int:
    """Number of stitches along a piece; the same for the two pieces at a seam, from their mean length."""
    piece = pieces[number]
    length = piece.length if piece.partner < 0 else 0.5 * (piece.length + pieces[piece.partner].length)
    # Rounding is done on a rounded number, so that equal pieces have equal numbers.
    return max(1, int(np.floor(round(length / width, 6) + 0.5)))
