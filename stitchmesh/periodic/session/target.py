# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What a live swatch moves to, and whether it can from where it is.

Lengths are those that ``swatch`` relaxes with, gamma times as large as in the fabric. Where a change leaves the yarns
of the repeat as they are but for their lengths and colours, the state as it lies can move there; a drawing that merely
looks the same does not tell, but the same pattern does, and so do the same curves.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stitchmesh.mesh import FloatArray, IntArray, StitchMesh
from stitchmesh.periodic.continuation import size_of
from stitchmesh.periodic.resolve_pattern import Source, resolve_pattern
from stitchmesh.periodic.session.settings import SwatchSettings
from stitchmesh.periodic.swatch import draw_swatch, free_cell, period_to_reach, take_up_rest_lengths
from stitchmesh.quality import Quality
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial

SAME_PLACE = 1e-9
"""Distance of control points that are in one place [widths of the repeat]."""


@dataclass(frozen=True, eq=False)
class Drawing:
    """A repeat as it is drawn."""

    source: Source
    """What it is a repeat of."""
    tiles: tuple[int, int]
    """Repeats of the pattern in it, side by side and above one another."""
    fabric: StitchMesh | None
    """Its stitches, if it is knitted."""
    yarns: YarnSet
    """Its yarns, no thicker than loops can hold."""

    @property
    def width(self) -> float:
        """Of the repeat as drawn [cm]."""
        assert self.yarns.lattice is not None
        return size_of(self.yarns.lattice)[0]

    def has_yarns_of(self, other: Drawing) -> bool:
        """Whether its yarns run like those of another but for lengths and colours."""
        for name in ("start", "closed", "lattice_step", "row", "face", "part"):
            if not np.array_equal(getattr(self.yarns, name), getattr(other.yarns, name)):
                return False
        if (self.source, self.tiles) == (other.source, other.tiles):
            return True
        apart = self.yarns.points / self.width - other.yarns.points / other.width
        return bool(np.abs(apart).max() < SAME_PLACE)


@dataclass(frozen=True, eq=False)
class Target:
    """What yarns are to come to, gamma times as large as in the fabric."""

    radius: FloatArray
    """[cm], shape (Y,)."""
    rest_length: FloatArray
    """[cm], shape (S,)."""
    size: tuple[float | None, float | None]
    """Width and height of the repeat [cm], None where it is free."""
    lean: float | None
    """How far the wales lean along the courses over their height, None where they are free."""
    gamma: float
    """Take-up."""
    material: YarnMaterial
    """Of yarn gamma times as large."""
    cell: RelaxCell | None
    """What the periods are free to do."""
    colour: IntArray
    """Of each yarn, shape (Y,)."""


def drawing_of(wishes: SwatchSettings, quality: Quality) -> Drawing:
    """The repeat that is wished for, as it is drawn.

    Raises:
        StitchMeshError: as for ``swatch``.
    """
    source = resolve_pattern(wishes.pattern)
    fabric, yarns = draw_swatch(source, wishes.options, quality)
    return Drawing(source, (wishes.options.columns, wishes.options.rows), fabric, yarns)


def target_of(wishes: SwatchSettings, drawing: Drawing) -> Target:
    """What the drawing is to come to.

    Raises:
        ParameterError: an option asks for what the pattern does not have, or for a size out of all proportion.
    """
    options, yarns = wishes.options, drawing.yarns
    assert yarns.lattice is not None
    cell = free_cell(wishes.relax_cell, options)
    free = np.zeros(3, dtype=bool) if cell is None else cell.free
    size = [
        given if given is not None else None if freed else own
        for given, freed, own in zip(period_to_reach(yarns, options), free[:2], size_of(yarns.lattice), strict=True)
    ]
    full = 1.0 if drawing.fabric is None else options.yarn_radius / float(yarns.radius[0])
    return Target(
        radius=yarns.radius * full * options.gamma,
        rest_length=take_up_rest_lengths(yarns, drawing.fabric, options),
        size=(size[0], size[1]),
        lean=None if free[2] else lean_of(yarns),
        gamma=options.gamma,
        material=wishes.yarn_material.scaled(options.gamma),
        cell=cell,
        colour=yarns.colour,
    )


def lean_of(yarns: YarnSet) -> float:
    """How far the second period of a lattice reaches along the first, over how far it reaches across it."""
    assert yarns.lattice is not None
    width, height = size_of(yarns.lattice)
    first, second = yarns.lattice.periods
    return float(first @ second) / (width * height)
