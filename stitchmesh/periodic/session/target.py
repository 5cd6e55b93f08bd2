# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The target of a live swatch, and whether the swatch can reach it from its current state.

All lengths are gamma times the lengths in the fabric, as in ``swatch``. A change of the settings may leave the yarns of
the repeat as they are except for their lengths and colours. The current state can then move to the new target. The
yarns are the same if the pattern is the same, or if the generated curves are the same.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from stitchmesh.lattice import Lattice
from stitchmesh.mesh import FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.palette import Palette
from stitchmesh.periodic.fabric_shape import FlatFabric
from stitchmesh.periodic.relaxation.continuation import size_of
from stitchmesh.periodic.relaxation.off_needles import Release
from stitchmesh.periodic.relaxation.prepared_swatch import (
    free_cell,
    period_to_reach,
    smallest_cell,
    take_up_rest_lengths,
)
from stitchmesh.periodic.relaxation.support import planes
from stitchmesh.periodic.repeat.drawn_swatch import draw_swatch
from stitchmesh.periodic.repeat.smallest_cell import SmallestCell
from stitchmesh.periodic.resolve_pattern import Source, resolve_pattern
from stitchmesh.periodic.sampling.even_sampling import even_lengths, sample_evenly
from stitchmesh.periodic.sampling.sampling import GENERATED
from stitchmesh.periodic.session.settings import SwatchSettings
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial
from stitchmesh.yarnrelax.energies.term import TermChoice


@dataclass(frozen=True, eq=False)
class GeneratedRepeat:
    """A repeat as it is generated, before any relaxation."""

    source: Source
    """The pattern or weave of the repeat."""
    tiles: tuple[int, int]
    """Number of repeats of the pattern side by side, and above one another."""
    fabric: StitchMesh | None
    """The stitches of a knit; None for a weave."""
    curves: YarnSet
    """The yarns as they are generated, with at most the largest radius for which loops are generated."""
    yarns: YarnSet
    """The same curves with the control points of the quality."""

    @property
    def width(self) -> float:
        """Width of the generated repeat [cm]."""
        assert self.yarns.lattice is not None
        return size_of(self.yarns.lattice)[0]

    def has_same_yarns(self, other: GeneratedRepeat) -> bool:
        """Return whether two repeats have the same yarns, except for their lengths and colours."""
        for name in ("start", "closed", "lattice_step", "row", "face", "part"):
            if not np.array_equal(getattr(self.yarns, name), getattr(other.yarns, name)):
                return False
        if (self.source, self.tiles) == (other.source, other.tiles):
            return True
        apart = self.yarns.points / self.width - other.yarns.points / other.width
        # Largest distance of control points that count as the same point [widths of the repeat]
        return bool(np.abs(apart).max() < 1e-9)


@dataclass(frozen=True, eq=False)
class Target:
    """The values that a live swatch moves to; lengths are gamma times the lengths in the fabric."""

    smallest: SmallestCell
    """The cell that relaxes; its images make the repeat."""
    radius: FloatArray
    """Radius of each yarn of that cell [cm], shape (Y,)."""
    rest_length: FloatArray
    """Rest length of each segment of that cell [cm], shape (S,)."""
    size: tuple[float | None, float | None]
    """Width and height of that cell [cm]; None for a free size."""
    lean: float | None
    """Displacement of the wales along the courses over the height of the repeat; None if it is free."""
    gamma: float
    """Take-up."""
    material: YarnMaterial
    """Material of the yarn, scaled by gamma."""
    cell: RelaxCell | None
    """The free changes of the periods; None for constant periods."""
    terms: tuple[TermChoice, ...]
    """The planes between which the cell lies; empty if it lies on nothing."""
    release: Release | None
    """How the knit is let go off the needles, once it has come near to rest without friction; None without friction."""
    colour: IntArray
    """Colour number of each yarn of the repeat."""
    palette: Palette
    """Colour of each colour number (sRGB), shape (P, 3)."""
    drawn_over_contact: FloatArray
    """Apparent radius over contact radius of each yarn of the repeat."""
    mass_per_length: FloatArray
    """Mass per length that each yarn of the repeat states in the fabric [g/cm]; not a number if it states none."""


def generate_repeat(settings: SwatchSettings) -> GeneratedRepeat:
    """Generate the repeat of the settings.

    Raises:
        StitchMeshError: an error of ``swatch``.
    """
    source = resolve_pattern(settings.pattern)
    fabric, generated = draw_swatch(source, settings.options, GENERATED)
    yarns = sample_evenly(generated, draw_swatch(source, settings.options, settings.sampled)[1])
    return GeneratedRepeat(source, (settings.options.columns, settings.options.rows), fabric, generated, yarns)


def make_target(settings: SwatchSettings, generated: GeneratedRepeat) -> Target:
    """Return the values that the generated repeat moves to.

    Raises:
        ParameterError: an option does not apply to the pattern, or a size is out of bounds.
    """
    options, yarns = settings.options, generated.yarns
    assert yarns.lattice is not None
    material = settings.yarn_material
    cell, release = free_cell(options, yarns, material), settings.release(generated.source)
    free = np.zeros(3, dtype=bool) if cell is None else cell.free
    size = [
        given if given is not None else None if freed else own
        for given, freed, own in zip(period_to_reach(yarns, options), free[:2], size_of(yarns.lattice), strict=True)
    ]
    flat = FlatFabric.of(generated.curves, generated.fabric, generated.source)
    wanted = take_up_rest_lengths(generated.curves, generated.fabric, options)
    full = 1.0 if generated.fabric is None else options.yarn_radius / float(yarns.radius[0])
    radius = yarns.radius * full * options.gamma
    terms = tuple(planes(options, flat, radius))
    lengths = even_lengths(yarns, wanted, generated.curves.segment_start)
    lies_alike = bool(terms) and generated.fabric is not None and release is None
    own = smallest_cell(generated.curves, yarns, lengths, options, lies_alike=lies_alike)
    width, height = own.period_of(size)
    return Target(
        smallest=own,
        radius=radius[own.kept],
        rest_length=own.part_of(replace(yarns, rest_length=lengths)).rest_length,
        size=(width, height),
        lean=None if free[2] else lean_of(yarns.lattice),
        gamma=options.gamma,
        material=material.scaled(options.gamma),
        cell=None if cell is None else own.cell_of(cell),
        terms=terms,
        release=release,
        colour=yarns.colour,
        palette=yarns.palette,
        drawn_over_contact=yarns.drawn_radius / yarns.radius,
        mass_per_length=options.stated_masses(yarns.radius * full),
    )


def lean_of(lattice: Lattice) -> float:
    """Displacement of the second period along the first period, over the height of the lattice."""
    width, height = size_of(lattice)
    first, second = lattice.periods
    return float(first @ second) / (width * height)
