# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The target of a live swatch, the way to it, and whether the swatch can reach it from its current state.

All lengths are gamma times the lengths in the fabric, as in ``swatch``. A change of the settings may leave the yarns of
the repeat as they are except for their lengths and colours. The current state can then move to the new target. The
yarns are the same if the pattern is the same, or if the generated curves are the same.

The swatch moves in equal increments, so small that yarns can part between two of them. Each increment changes all
lengths by the same part of their total change on a logarithmic scale. A length that is constant in the fabric, such as
the yarn radius while gamma changes, therefore stays constant. The increments have the limits of ``continuation``. No
increment moves a yarn through another: rest lengths and radii move nothing, and an affine deformation of the whole
lattice keeps separate yarns separate.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from stitchmesh.lattice import Lattice, lattice_frame
from stitchmesh.mesh import FloatArray, IntArray, StitchMesh
from stitchmesh.mesh.palette import Palette
from stitchmesh.periodic.fabric_shape import FlatFabric
from stitchmesh.periodic.relaxation.continuation import GROWTH, LENGTHENING, STRETCH, size_of, stretch_cell
from stitchmesh.periodic.relaxation.off_needles import Release
from stitchmesh.periodic.relaxation.prepared_swatch import (
    free_cell,
    period_to_reach,
    smallest_cell,
    take_up_rest_lengths,
)
from stitchmesh.periodic.relaxation.spirality import torque
from stitchmesh.periodic.relaxation.support import planes
from stitchmesh.periodic.repeat.drawn_swatch import draw_swatch
from stitchmesh.periodic.repeat.smallest_cell import SmallestCell
from stitchmesh.periodic.resolve_pattern import Source, resolve_pattern
from stitchmesh.periodic.sampling.even_sampling import even_lengths, sample_evenly
from stitchmesh.periodic.sampling.sampling import GENERATED
from stitchmesh.periodic.session.settings import SwatchSettings
from stitchmesh.periodic.swatch import scale_yarns
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial
from stitchmesh.yarnrelax.energies.term import YarnChoice


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
    terms: tuple[YarnChoice, ...]
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
    between = planes(options, flat, radius)
    lengths = even_lengths(yarns, wanted, generated.curves.segment_start)
    lies_alike = bool(between) and generated.fabric is not None and release is None
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
        terms=(*between, *torque(options, material, options.gamma), *options.terms),
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


@dataclass(frozen=True, eq=False)
class SwatchInProgress:
    """The smallest cell of a repeat, which moves to a target."""

    yarns: YarnSet
    """The yarns of that cell in their current state, ``scale`` times as large as in the fabric."""
    scale: float
    """Size of the yarns over their size in the fabric; it equals the gamma of the target once the target is reached."""
    gamma: float
    """Take-up of the current state."""

    @classmethod
    def start(cls, generated: GeneratedRepeat, target: Target) -> SwatchInProgress:
        """Return a generated repeat at the scale at which its yarn has the same radius as in the fabric."""
        yarns = generated.yarns
        if generated.fabric is None:
            # generated wefts and warps are nearly straight, so their rest lengths can equal their lengths at the start
            curves = generated.curves
            yarns = replace(yarns, rest_length=even_lengths(yarns, curves.lengths, curves.segment_start))
        yarns = target.smallest.part_of(yarns)
        reached = target.gamma * float(yarns.radius[0] / target.radius[0])
        return cls(yarns, reached, reached)

    def in_cell(self, before: SmallestCell, after: SmallestCell, like: YarnSet) -> SwatchInProgress:
        """Return the same fabric in another cell; ``like`` holds the yarns of the whole repeat, at any places."""
        return replace(self, yarns=after.part_of(before.repeated(self.yarns, like)))

    def enlarged(self, factor: float) -> SwatchInProgress:
        """Return the same fabric at a scale that is larger by a factor."""
        return replace(self, yarns=scale_yarns(self.yarns, factor), scale=self.scale * factor)

    @property
    def in_fabric(self) -> YarnSet:
        """The yarns at their size in the fabric."""
        return scale_yarns(self.yarns, 1.0 / self.scale)


def increments_left(state: SwatchInProgress, target: Target) -> int:
    """Number of increments to the target; 0 at the target."""
    yarns = state.yarns
    assert yarns.lattice is not None
    lean = lean_of(target.smallest.whole_lattice(yarns.lattice))
    sides = zip(target.size, size_of(yarns.lattice), strict=True)
    # Largest change of the lean in one increment (``Target.lean``)
    counts = [
        _increment_count(target.radius / yarns.radius, GROWTH),
        _increment_count(np.array([target.gamma / state.scale, target.gamma / state.gamma]), GROWTH),
        _increment_count(np.array([1.0 if size is None else size / now for size, now in sides]), STRETCH),
        _increment_count(target.rest_length / yarns.rest_length, LENGTHENING),
        0.0 if target.lean is None else abs(target.lean - lean) / 0.1,
    ]
    # Part of an increment that counts as zero; single precision on the device rounds a period by a tenth of this part.
    return math.ceil(max(counts) - 1e-5)


def increment(state: SwatchInProgress, target: Target) -> SwatchInProgress:
    """Return the state after one increment towards a target that is not reached yet."""
    part = 1.0 / increments_left(state, target)
    yarns = state.yarns
    assert yarns.lattice is not None
    lean = lean_of(target.smallest.whole_lattice(yarns.lattice))
    sides = zip(target.size, size_of(yarns.lattice), strict=True)
    along, across = (1.0 if size is None else (size / now) ** part for size, now in sides)
    yarns = replace(
        stretch_cell(yarns, along, across).with_radius(yarns.radius * (target.radius / yarns.radius) ** part),
        rest_length=yarns.rest_length * (target.rest_length / yarns.rest_length) ** part,
    )
    if target.lean is not None:
        yarns = _shear_cell(yarns, part * (target.lean - lean))
    scale, gamma = (reached * (target.gamma / reached) ** part for reached in (state.scale, state.gamma))
    return SwatchInProgress(yarns, scale, gamma)


def _increment_count(factors: FloatArray, largest: float) -> float:
    """Return how many increments of the largest factor, or of its inverse, make the most extreme factor."""
    return float(np.abs(np.log(factors)).max()) / math.log(largest)


def _shear_cell(yarns: YarnSet, change: float) -> YarnSet:
    """Return yarns and their lattice, sheared along the courses."""
    assert yarns.lattice is not None
    first, second, _normal = lattice_frame(yarns.lattice.periods)
    matrix = np.eye(3) + change * np.outer(second, first)
    return replace(yarns, points=yarns.points @ matrix, lattice=Lattice(yarns.lattice.periods @ matrix))
