# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A repeat before it comes to rest.

Its yarns already have the radii, the lengths and the size that the options ask for.

If the yarn is thicker than the loops can hold, the loops are generated with thinner yarn, and the radius then grows in
steps (``continuation``). To apply ``gamma``, the radius grows further, and the whole fabric is scaled by 1 / gamma once
it is at rest: the yarn keeps its radius, and the fabric has 1 / gamma of its yarn length (Leaf et al. 2018, section
6.2). Take-up multiplies the rest lengths of stitches and parts of stitches by factors, also in steps (section 6.1).

``CellAtRest`` keeps the smallest cell at rest and all that acted on it. Later questions about this state use it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from stitchmesh.compute.device import device_named
from stitchmesh.errors import ParameterError, check_kind
from stitchmesh.io.yarn_files import yarn_of
from stitchmesh.memory_need import BASE_MEMORY, BYTES_PER_KEPT_POINT, check_memory, check_relaxation_memory
from stitchmesh.mesh import FloatArray, StitchMesh
from stitchmesh.patterns import Pattern
from stitchmesh.periodic.fabric_shape import FlatFabric
from stitchmesh.periodic.relaxation.continuation import change_period, change_radius, change_rest_length, size_of
from stitchmesh.periodic.relaxation.off_needles import Release, chosen_release
from stitchmesh.periodic.relaxation.spirality import sheared_by_torque, torque, well_balanced
from stitchmesh.periodic.relaxation.support import blocking, planes
from stitchmesh.periodic.repeat.drawn_swatch import draw_swatch
from stitchmesh.periodic.repeat.smallest_cell import SmallestCell
from stitchmesh.periodic.resolve_pattern import Source, resolve_pattern, stitches_of
from stitchmesh.periodic.sampling.even_sampling import even_lengths, sample_evenly
from stitchmesh.periodic.sampling.sampling import GENERATED, is_small, path_to, released, with_contacts
from stitchmesh.periodic.swatch_options import TAKE_UP, SwatchOptions
from stitchmesh.periodic.weave.weave import Weave
from stitchmesh.quality import PRESETS, Quality, quality_named
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.rest_length import apply_rest_lengths
from stitchmesh.yarn.stitch_size import stitch_size
from stitchmesh.yarn.yarn_presets import Yarn
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial
from stitchmesh.yarnrelax.energies.term import YarnChoice
from stitchmesh.yarnrelax.relaxation_inputs import RelaxationInputs

SIZES = (0.1, 10.0)
"""Smallest and largest period over the period of the generated repeat."""
ROUNDING = 1e-12
"""Relative rounding error of a product of factors or a quotient of lengths."""


@dataclass(frozen=True, eq=False)
class PreparedSwatch:
    """A repeat whose yarns have their radii, lengths and given size, before it comes to rest.

    Its lengths are gamma times the lengths in the fabric, and ``similar`` is the material for them. Its yarns are those
    of the smallest cell.
    """

    source: Source
    """The pattern or the weave."""
    options: SwatchOptions
    """The options of the swatch."""
    material: YarnMaterial
    """Material of the yarn."""
    path: tuple[Quality, ...]
    """Resolutions through which the repeat comes to rest."""
    device: str | None
    """Device of the kernels."""
    fabric: StitchMesh | None
    """The stitch mesh; None for a weave."""
    smallest: SmallestCell
    """The cell that comes to rest; its images make the repeat."""
    repeat: YarnSet
    """The yarns of the whole repeat as they are generated, with the first resolution of the path."""
    drawn: YarnSet
    """The generated yarns of the smallest cell, with control points at equal distances if there is no friction."""
    yarns: YarnSet
    """The yarns from which the relaxation starts, with the first resolution of the path."""
    cell: RelaxCell | None
    """The free changes of the periods and their loads; None for constant periods."""
    flat: FlatFabric
    """The fabric as it lies flat."""
    terms: Sequence[YarnChoice]
    """The planes between which the repeat lies, if it lies on something, and what else acts on it."""
    release: Release | None
    """How the knit is let go off the needles; None without friction."""
    made_of: Yarn | None
    """The yarn, if one is given."""
    has_states: bool
    """Whether ``lowest_rest`` searches for the lowest of several states of rest."""

    @property
    def quality(self) -> Quality:
        """Resolution of the relaxed repeat."""
        return self.path[-1]

    @property
    def most_iterations(self) -> float:
        """The largest number of iterations of all relaxations together; infinite with the limit of a preset."""
        limit = self.quality.max_iterations
        return math.inf if limit in {preset.max_iterations for preset in PRESETS.values()} else limit

    @property
    def similar(self) -> YarnMaterial:
        """The material scaled by gamma."""
        return self.material.scaled(self.options.gamma)

    def drawn_with(self, quality: Quality) -> YarnSet:
        """The yarns of the whole repeat as they are generated with a resolution of the path."""
        return self.repeat if quality is self.path[0] else draw_swatch(self.source, self.options, quality)[1]


def prepare_swatch(
    pattern: str | Pattern | Weave,
    *,
    material: YarnMaterial | None,
    quality: str | Quality,
    device: str | None,
    smallest: bool = True,
    yarn: str | Yarn | None = None,
    **options: Any,
) -> PreparedSwatch:
    """Generate a repeat, and change its radii, lengths and size to those of the options; arguments as for ``swatch``.

    ``smallest`` says whether a free repeat comes to rest in its smallest cell.
    """
    source = resolve_pattern(pattern)
    made_of = yarn_of(yarn) if isinstance(yarn, str) else yarn
    if made_of is not None:
        options = sizes_of_yarn(made_of, woven=isinstance(source, Weave), given=options)
    chosen = SwatchOptions(**options)
    quality = well_balanced(quality_named(quality), chosen)
    if material is not None:
        check_kind("swatch, material", material, YarnMaterial)
    elif made_of is not None:
        material = YarnMaterial.of_yarn(made_of).of_radius(chosen.yarn_radius, made_of.core_radius)
    material = chosen.yarn_material(material)
    release = chosen_release(chosen, woven=isinstance(source, Weave))
    check_repeat_memory(source, chosen, quality, device, free=chosen.freedom is not False)
    fabric, generated = draw_swatch(source, chosen, GENERATED)
    flat = FlatFabric.of(generated, fabric, source)
    cell = free_cell(chosen, generated, material)
    steps = path_to(quality, cell) if release is None else (released(quality),)
    repeat = first = draw_swatch(source, chosen, steps[0])[1]
    # friction holds the yarn of a stitch in its place
    wanted = take_up_rest_lengths(first if release is not None else generated, fabric, chosen)
    if release is None:
        wanted = even_lengths(first, wanted, generated.segment_start)
        first = sample_evenly(generated, first)
    # the fabric is relaxed at gamma times its final size, and scaled at the end
    similar = material.scaled(chosen.gamma)
    thicker = chosen.gamma * (1.0 if fabric is None else chosen.yarn_radius / float(first.radius[0]))
    # wefts and warps are nearly straight, so their relaxation starts with their generated lengths as rest lengths
    natural = first
    if fabric is None:
        natural = replace(first, rest_length=even_lengths(first, generated.lengths, generated.segment_start))
    period = period_to_reach(first, chosen)
    between = planes(chosen, flat, natural.radius * thicker)
    acting = [*between, *torque(chosen, material, chosen.gamma), *chosen.terms]
    alone = (chosen.columns, chosen.rows) == (1, 1)
    lies_alike = smallest and alone and bool(between) and fabric is not None and release is None
    own = smallest_cell(generated, first, wanted, chosen, lies_alike=lies_alike)
    path = tuple(with_contacts(step, chosen, fabric, own, cell if release is None else None) for step in steps)
    cell = None if cell is None else own.cell_of(cell)
    yarns = change_radius(own.part_of(natural), thicker, similar, path[0], device)
    lengths = own.part_of(replace(first, rest_length=wanted)).rest_length
    yarns = change_rest_length(yarns, lengths, similar, path[0], device, cell, acting)
    yarns = change_period(yarns, own.period_of(period), similar, path[0], device)
    return PreparedSwatch(
        source, chosen, material, path, device, fabric, own, repeat, own.part_of(first), yarns, cell, flat, acting,
        release, made_of, has_states=lies_alike and is_small(fabric, own),
    )  # fmt: skip


def sizes_of_yarn(yarn: Yarn, *, woven: bool, given: Mapping[str, Any]) -> dict[str, Any]:
    """Return options of a swatch with the sizes and the mass of a yarn; sizes that are given stay.

    A yarn sets the loop length of a knit by its gauge. It sets no loop length of a weave, whose yarns are drawn with
    their radius.
    """
    names = ("yarn_radius", "drawn_radius", "loop_length", "mass_per_length")
    found = stitch_size(yarn, **{name: given.get(name) for name in names})
    of_knits = () if woven else ("drawn_radius", "loop_length")
    return dict(given) | {name: getattr(found, name) for name in ("yarn_radius", "mass_per_length", *of_knits)}


def check_repeat_memory(
    source: Source, options: SwatchOptions, quality: Quality, device: str | None, *, free: bool
) -> None:
    """Refuse a repeat that does not fit into the memory, before it is made.

    Args:
        source: the pattern or the weave.
        options: options of the swatch.
        quality: the quality.
        device: Warp's name of the device; None for the preferred device.
        free: whether the size of the repeat relaxes too.

    Raises:
        ParameterError: the repeat needs more memory than there is (``check_memory``).
    """
    stitches = stitches_of(source) * options.columns * options.rows
    points = stitches * quality.control_points_per_stitch * (quality.refinement if free else 1.0)
    asked = f"a cell of {options.columns} x {options.rows} repeats with {stitches:,} stitches"
    check_relaxation_memory(asked, points, quality, device)


def check_kept_states(what: str, states: int, yarns: YarnSet) -> None:
    """Refuse more states of one repeat than fit into the memory; all are kept until the last of them is at rest.

    Args:
        what: the command, for the message.
        states: number of states.
        yarns: the yarns of one state.

    Raises:
        ParameterError: the states need more memory than there is (``check_memory``).
    """
    needed = BASE_MEMORY + BYTES_PER_KEPT_POINT * len(yarns.points) * states
    check_memory(f"{what} with {states:,} states of {len(yarns.points)} control points", needed, "fewer of them")


def smallest_cell(
    generated: YarnSet, first: YarnSet, wanted: FloatArray, options: SwatchOptions, *, lies_alike: bool
) -> SmallestCell:
    """Return the cell that comes to rest: the whole repeat if stitches that are alike may lie differently.

    Args:
        generated: the yarns as generated with ``GENERATED``.
        first: the same yarns with other control points.
        wanted: rest lengths of the segments of ``first`` [cm].
        options: options of the swatch; several repeats in one cell may lie differently.
        lies_alike: whether stitches that are alike in the pattern lie alike.
    """
    if not lies_alike or (options.columns, options.rows) != (1, 1):
        return SmallestCell.whole(generated.yarn_count)
    return SmallestCell.of(generated, np.add.reduceat(wanted, first.segment_start[:-1]))


def take_up_rest_lengths(drawn: YarnSet, fabric: StitchMesh | None, options: SwatchOptions) -> FloatArray:
    """Return the rest lengths after take-up [cm], shape (S,).

    Args:
        drawn: the generated yarns.
        fabric: the stitch mesh of the yarns; None for a weave.
        options: options of the swatch.

    Raises:
        ParameterError: a factor applies to something that the fabric does not have, or the product of the factors is
            out of bounds.
    """
    if fabric is None and options.rest_lengths.need_fabric:
        raise ParameterError("rest lengths: got factors of stitches for a weave; use warp=F, weft=F or yarn:N=F")
    changed = apply_rest_lengths(drawn, options.rest_lengths, fabric=fabric).rest_length
    factor = changed / drawn.rest_length
    least, most = TAKE_UP[0] * (1.0 - ROUNDING), TAKE_UP[1] * (1.0 + ROUNDING)
    for extreme in (factor.argmin(), factor.argmax()):
        if not least <= factor[extreme] <= most:
            found = f"rest lengths of yarn {drawn.segment_yarn[extreme]}: got a factor of {factor[extreme]:.4g}"
            raise ParameterError(f"{found}; expected {TAKE_UP[0]:g} to {TAKE_UP[1]:g}")
    return changed


def period_to_reach(drawn: YarnSet, options: SwatchOptions) -> list[float | None]:
    """Return the width and height [cm] that the options give, at gamma times their size; None where not given.

    Raises:
        ParameterError: a size is far from the size of the generated repeat (``SIZES``).
    """
    assert drawn.lattice is not None
    for name, size, own in zip(("width", "height"), options.period, size_of(drawn.lattice), strict=True):
        least, most = (factor * own / options.gamma for factor in SIZES)
        if size is not None and not least <= size <= most:
            raise ParameterError(f"period {name}: got {size:g} cm; expected {least:.3g} to {most:.3g} for this repeat")
    return [None if size is None else size * options.gamma for size in options.period]


def free_cell(options: SwatchOptions, drawn: YarnSet, material: YarnMaterial) -> RelaxCell | None:
    """Return the degrees of freedom of the cell and its loads, or None for a fixed cell.

    A size that is given stays fixed. Pulls are divided by gamma, because the relaxed cell is gamma times as large.

    Raises:
        ParameterError: a blocked swatch has a given ``RelaxCell``, or would tear.
    """
    free = options.freedom
    if options.blocked is not None:
        if isinstance(free, RelaxCell):
            raise ParameterError("blocked: got a RelaxCell beside it; give its loads, or relax_cell=True")
        free = blocking(drawn, options, material)
    if free is False:
        return None
    cell = sheared_by_torque(options) if free is True else free
    pulls = [
        None if pull is None or size is not None else pull / options.gamma
        for pull, size in zip((cell.course, cell.wale), options.period, strict=True)
    ]
    return replace(cell, course=pulls[0], wale=pulls[1])


@dataclass(frozen=True, eq=False)
class CellAtRest:
    """A cell at rest.

    Its lengths are gamma times the lengths in the fabric, and its material is scaled in the same way.
    """

    yarns: YarnSet
    """The relaxed yarns of the cell, on its lattice."""
    material: YarnMaterial
    """Material of the yarns at this size."""
    quality: Quality
    """Resolution of the relaxation."""
    cell: RelaxCell | None
    """The free changes of the periods and their loads; None for constant periods."""
    terms: Sequence[YarnChoice]
    """The planes between which the cell lies; empty if it lies on nothing."""
    device: str | None
    """Device of the kernels."""
    gamma: float = 1.0
    """The lengths of the cell over the lengths in the fabric."""
    rubs: bool = False
    """Whether friction between the yarns held the cell on its way to rest."""

    @classmethod
    def of(cls, prepared: PreparedSwatch, yarns: YarnSet) -> CellAtRest:
        """Return the cell of a prepared repeat, whose smallest cell came to rest with these yarns."""
        return cls(
            yarns, prepared.similar, prepared.quality, prepared.cell, prepared.terms, prepared.device,
            prepared.options.gamma, prepared.release is not None,
        )  # fmt: skip

    @property
    def inputs(self) -> RelaxationInputs:
        """The inputs of a relaxation that goes on from this state."""
        return RelaxationInputs(
            self.yarns, self.material, self.quality, device_named(self.device), self.terms, cell=self.cell
        )  # fmt: skip
