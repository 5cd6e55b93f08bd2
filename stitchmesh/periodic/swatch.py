# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Relaxation of a swatch, one repeat of a knitted or woven pattern on its lattice: the order of operations.

As on a knitting machine, the yarn length of a stitch is given and the size of the fabric follows. If the yarn is as
thick as the loops can hold, the loops are generated with thinner yarn, and the radius then grows in steps
(``continuation``). To apply ``gamma``, the radius grows further and the whole fabric is then scaled by 1 / gamma: the
yarn keeps its radius, and the fabric has 1 / gamma of its yarn length (Leaf et al. 2018, section 6.2). Take-up changes
the rest lengths of stitches and parts of stitches by factors, also in steps (section 6.1).
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from stitchmesh.budget.budget import Budget
from stitchmesh.budget.plan import limit_of
from stitchmesh.errors import ParameterError, check_kind
from stitchmesh.io.history import HistoryEntry
from stitchmesh.lattice import Lattice
from stitchmesh.mesh import FloatArray, StitchMesh
from stitchmesh.patterns import Pattern
from stitchmesh.periodic.contact_samples import with_contacts
from stitchmesh.periodic.continuation import change_period, change_radius, change_rest_length, size_of
from stitchmesh.periodic.even_sampling import even_lengths, sample_evenly
from stitchmesh.periodic.fabric_shape import FlatFabric
from stitchmesh.periodic.gauge import swatch_report
from stitchmesh.periodic.off_needles import Release, chosen_release, let_go, needle_size
from stitchmesh.periodic.repeat_checks import check_floats, check_loops_begin
from stitchmesh.periodic.resolve_pattern import Source, resolve_pattern
from stitchmesh.periodic.sampling import GENERATED, path_to
from stitchmesh.periodic.smallest_cell import SmallestCell
from stitchmesh.periodic.support import blocking, planes, refuse_tearing, remedy_of, tearing
from stitchmesh.periodic.swatch_budget import plan_swatch
from stitchmesh.periodic.swatch_options import TAKE_UP, KnitState, SwatchOptions
from stitchmesh.periodic.torus import torus_mesh
from stitchmesh.periodic.weave.jamming import jam_report
from stitchmesh.periodic.weave.weave import Weave
from stitchmesh.periodic.weave.yarns import weave_yarns
from stitchmesh.quality import DEFAULT_QUALITY, PRESETS, Quality, quality_named
from stitchmesh.tessellate import COURSE_OVER_WALE_SPACING
from stitchmesh.time_limit import limited_to
from stitchmesh.yarn import APPARENT_OVER_CONTACT, YarnSet
from stitchmesh.yarn.rest_length import RestLengths, apply_rest_lengths, carried_segments, plain_stitches, segment_faces
from stitchmesh.yarngen import belongs_to_loop_below, generate_yarns
from stitchmesh.yarnrelax import REFERENCE_RADIUS, RelaxCell, YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.convergence import rest_text
from stitchmesh.yarnrelax.energies.term import TermChoice
from stitchmesh.yarnrelax.linking.certificate import refuse_pull_through
from stitchmesh.yarnrelax.relaxation_result import Relaxation
from stitchmesh.yarnrelax.saddle import continued, relax_to_minimum

logger = logging.getLogger(__name__)

LOOP_OVER_WIDTH = 4.07
"""Yarn length of a generated plain loop over the stitch width, for a yarn radius of an eighth of the width."""
LARGEST_RADIUS_OVER_WIDTH = 0.16
"""Largest yarn radius over the stitch width for which loops are generated; thicker yarn grows from this radius."""
SIZES = (0.1, 10.0)
"""Smallest and largest period over the period of the generated repeat."""
ROUNDING = 1e-12
"""Relative rounding error of a product of factors or a quotient of lengths."""


@dataclass(frozen=True, eq=False)
class Swatch:
    """A relaxed repeat."""

    yarns: YarnSet
    """The relaxed yarns, on their lattice."""
    report: dict[str, Any]
    """Measurements as plain numbers: those of ``gauge.swatch_report``, for a weave those of ``jamming.jam_report``, its
    shape (``FabricShape.report``), and the report of ``relax_yarns``."""
    fabric: StitchMesh | None
    """The stitch mesh from which the yarns were generated; None for a weave."""
    history: list[HistoryEntry]
    """Entries of the history of the relaxation, one for each assessment."""

    def __repr__(self) -> str:
        """Return one line: stitches (of a weave: crossings), size, state of rest, and yarns."""
        counts = f"{self.report['wales']} x {self.report['courses']}"
        size = f"{self.report['width']:.3g} x {self.report['height']:.3g} cm"
        return f"Swatch({counts}, {size}, {rest_text(self.report)}, {self.yarns})"

    @property
    def lattice(self) -> Lattice:
        """The lattice of the relaxed repeat."""
        assert self.yarns.lattice is not None
        return self.yarns.lattice


def swatch(
    pattern: str | Pattern | Weave,
    *,
    material: YarnMaterial | None = None,
    quality: str | Quality = DEFAULT_QUALITY,
    device: str | None = None,
    relax_cell: bool | RelaxCell = False,
    relaxation: KnitState | None = None,
    friction: float | None = None,
    budget: Budget | None = None,
    progress: Callable[[HistoryEntry], None] | Literal[False] | None = None,
    **options: Any,
) -> Swatch:
    """Relax one repeat of a pattern.

    Args:
        pattern: a pattern or a weave, the name of one in the library, or the path of a file.
        material: material of the yarn; by default the material ``stitchmesh``, scaled to the radius of the yarn.
        quality: a preset or a ``Quality``.
        device: device of the kernels, for example ``cpu`` or ``cuda:0``; by default the first GPU, or the CPU if there
            is no GPU.
        relax_cell: whether the width and height of the repeat are relaxed, lying between two planes (``support``),
            or a ``RelaxCell`` with the degrees of freedom of a cell that lies on nothing. With ``RelaxCell()`` the
            cell can also shear; ribs without friction do so to one of the two sides.
        relaxation: ``dry``, ``wet`` or ``full``: the state of a knit that was let go off the needles with friction
            (``off_needles``); width and height are then free. By default there is no friction.
        friction: coefficient of friction between yarns, with a relaxation; ``YARN_FRICTION`` where not given.
        budget: limits on the time and on the error; measured tables then choose the quality, unless it is another than
            the default, and the report says what they chose (``budget.plan``).
        progress: function that is called about every half second; by default a line shows the progress on a terminal or
            in a notebook, and False shows nothing.
        options: fields of ``SwatchOptions``.

    Raises:
        FileError: the file cannot be read.
        ParameterError: an option is out of bounds, or does not apply to the pattern.
        PatternError: the pattern does not repeat, a float is too long, or the weave falls apart.
        SolverError: the yarns cannot be relaxed.
    """
    began = time.perf_counter()
    with limited_to(limit_of(budget)):
        plan = plan_swatch(pattern, budget, quality, device, relax_cell, relaxation, **options)
        prepared = prepare_swatch(
            pattern, material=material, quality=quality if plan is None else plan.quality, device=device,
            relax_cell=relax_cell, relaxation=relaxation, friction=friction, **options,
        )  # fmt: skip
        made = relax_prepared(prepared, prepared.yarns, progress)
    own = {"seconds": time.perf_counter() - began} | ({} if plan is None else {"budget": plan.report()})
    return replace(made, report=made.report | own)


@dataclass(frozen=True, eq=False)
class PreparedSwatch:
    """A repeat whose yarns have their radii, lengths and given size, before it comes to rest.

    Lengths are gamma times those of the fabric, and ``similar`` is the material that belongs to them. The yarns are
    those of the smallest cell.
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
    """The cell that comes to rest, of which the repeat is made."""
    drawn: YarnSet
    """The yarns as they are generated, with the first resolution of the path."""
    yarns: YarnSet
    """The yarns from which the relaxation starts, with the first resolution of the path."""
    cell: RelaxCell | None
    """The free changes of the periods and their loads; None for constant periods."""
    flat: FlatFabric
    """The fabric as it lies flat."""
    terms: Sequence[TermChoice]
    """What the repeat lies on."""
    release: Release | None
    """How the knit is let go off the needles; None without friction."""

    @property
    def quality(self) -> Quality:
        """Resolution of the relaxed repeat."""
        return self.path[-1]

    @property
    def similar(self) -> YarnMaterial:
        """The material scaled by gamma."""
        return self.material.scaled(self.options.gamma)

    def drawn_with(self, quality: Quality) -> YarnSet:
        """The yarns of the whole repeat as they are generated with a resolution."""
        return draw_swatch(self.source, self.options, quality)[1]


def prepare_swatch(
    pattern: str | Pattern | Weave,
    *,
    material: YarnMaterial | None,
    quality: str | Quality,
    device: str | None,
    relax_cell: bool | RelaxCell,
    relaxation: KnitState | None = None,
    friction: float | None = None,
    smallest: bool = True,
    **options: Any,
) -> PreparedSwatch:
    """Generate a repeat, and change its radii, lengths and size to those asked for; arguments as for ``swatch``.

    Whether a free repeat comes to rest in its smallest cell is given by ``smallest``.
    """
    chosen, quality = SwatchOptions(**options), quality_named(quality)
    release = chosen_release(relaxation, friction, relax_cell, chosen)
    relax_cell = relax_cell or release is not None
    if material is None:
        material = YarnMaterial.named().scaled(chosen.yarn_radius / REFERENCE_RADIUS)
    check_kind("swatch, material", material, YarnMaterial)
    source = resolve_pattern(pattern)
    if release is not None and isinstance(source, Weave):
        raise ParameterError("relaxation: got one for a weave, which comes off no needles; leave it out")
    fabric, generated = draw_swatch(source, chosen, GENERATED)
    cell, flat = free_cell(relax_cell, chosen, generated, material), FlatFabric.of(generated, fabric, source)
    steps = path_to(quality, cell if release is None else None)
    first = draw_swatch(source, chosen, steps[0])[1]
    # friction holds the yarn of a stitch in its place
    wanted = take_up_rest_lengths(first if release is not None else generated, fabric, chosen)
    if release is None:
        first, wanted = sample_evenly(generated, first), even_lengths(first, wanted, generated.segment_start)
    # the fabric is relaxed at gamma times its final size, and scaled at the end
    similar = material.scaled(chosen.gamma)
    thicker = chosen.gamma * (1.0 if fabric is None else chosen.yarn_radius / float(first.radius[0]))
    # wefts and warps are nearly straight, so their relaxation starts with their generated lengths as rest lengths
    straight = even_lengths(first, generated.lengths, generated.segment_start)
    natural = first if fabric is not None else replace(first, rest_length=straight)
    period = period_to_reach(first, chosen)
    terms = planes(relax_cell, chosen, flat, natural.radius * thicker)
    lies_alike = smallest and bool(terms) and fabric is not None and release is None
    own = smallest_cell(generated, first, wanted, chosen, lies_alike=lies_alike)
    path = tuple(with_contacts(step, chosen, fabric, own, cell if release is None else None) for step in steps)
    quality = path[0]
    cell = None if cell is None else own.cell_of(cell)
    yarns = change_radius(own.part_of(natural), thicker, similar, quality, device)
    lengths = own.part_of(replace(first, rest_length=wanted)).rest_length
    yarns = change_rest_length(yarns, lengths, similar, quality, device, cell, terms)
    yarns = change_period(yarns, own.period_of(period), similar, quality, device)
    drawn = own.part_of(first)
    return PreparedSwatch(
        source, chosen, material, path, device, fabric, own, drawn, yarns, cell, flat, terms, release
    )


def smallest_cell(
    generated: YarnSet, first: YarnSet, wanted: FloatArray, options: SwatchOptions, *, lies_alike: bool
) -> SmallestCell:
    """Return the cell that comes to rest: the whole repeat if its stitches may lie differently.

    Args:
        generated: the yarns as generated with ``GENERATED``.
        first: the same yarns with other control points.
        wanted: rest lengths of the segments of these [cm].
        options: options of the swatch; several repeats in one cell may lie differently.
        lies_alike: whether stitches that are alike in the pattern lie alike.
    """
    if not lies_alike or (options.columns, options.rows) != (1, 1):
        return SmallestCell.whole(generated.yarn_count)
    return SmallestCell.of(generated, np.add.reduceat(wanted, first.segment_start[:-1]))


def relax_prepared(
    prepared: PreparedSwatch, yarns: YarnSet, progress: Callable[[HistoryEntry], None] | Literal[False] | None
) -> Swatch:
    """Relax a prepared repeat, starting from the prepared yarns or from the same yarns at other places, and measure it.

    Raises:
        ParameterError: the tension of a blocked swatch is too large.
        SolverError: the yarns cannot be relaxed, or a yarn passed through another one.
    """
    chosen, device = prepared.options, prepared.device
    with tearing(chosen):
        if prepared.release is not None and prepared.fabric is not None:
            needles = needle_size(prepared.fabric, chosen.plain_loop * chosen.gamma)
            relaxed = let_go(
                yarns, needles, prepared.release, prepared.similar, prepared.quality, device, prepared.terms, progress
            )
        else:
            relaxed = relax_along(prepared, yarns, progress)
    own = prepared.smallest
    drawn = prepared.drawn if len(prepared.path) == 1 else sample_evenly(prepared.drawn, relaxed.yarns)
    refuse_pull_through(drawn, relaxed.yarns, device)
    refuse_tearing(relaxed.report["max_strain"], chosen)
    if own.copies > 1:
        like = prepared.drawn_with(prepared.quality)
        drawn, relaxed = own.repeated(drawn, like), whole_repeat(relaxed, own, like)
    result = scale_yarns(relaxed.yarns, 1.0 / chosen.gamma)
    measures = swatch_report(
        result, prepared.fabric, prepared.material, prepared.quality, relaxed.report["energy"], device
    )
    if isinstance(prepared.source, Weave):
        measures |= jam_report(prepared.source, result)
    flat = replace(FlatFabric.of(drawn, prepared.fabric, prepared.source), diameters=prepared.flat.diameters)
    shape = flat.shape_of(result)
    if shape.name != "flat":
        logger.warning("%s; %s", shape.text, remedy_of(prepared.cell, lies=bool(prepared.terms)))
    report = measures | shape.report() | relaxed.report | {"solver_seconds": relaxed.report["seconds"]}
    return Swatch(result, report, prepared.fabric, relaxed.history)


def whole_repeat(relaxed: Relaxation, smallest: SmallestCell, like: YarnSet) -> Relaxation:
    """Return the relaxation of a repeat from that of its smallest cell: its yarns, and the energies of all of them."""
    copies = smallest.copies
    history = [
        entry | {"energies": {name: copies * energy for name, energy in entry["energies"].items()}}
        for entry in relaxed.history
    ]
    report = {
        "energy": copies * relaxed.report["energy"],
        "energies": {name: copies * energy for name, energy in relaxed.report["energies"].items()},
    }
    return Relaxation(smallest.repeated(relaxed.yarns, like), relaxed.report | report, history)


def relax_along(
    prepared: PreparedSwatch, yarns: YarnSet, progress: Callable[[HistoryEntry], None] | Literal[False] | None
) -> Relaxation:
    """Relax yarns through the resolutions of their path; iterations, seconds and history are those of all.

    A limit of iterations that is that of a preset holds for each resolution, any other one for all of them together.

    Raises:
        SolverError: the yarns cannot be relaxed, or a yarn passed through another one.
    """
    relax = relax_yarns if prepared.cell is None else relax_to_minimum
    found, most = None, iterations_of(prepared.path)
    for step in prepared.path:
        done = 0 if found is None else found.report["iterations"]
        quality = replace(step, max_iterations=max(min(step.max_iterations, most - done), 0))
        if found is not None:
            yarns = sample_evenly(found.yarns, prepared.smallest.part_of(prepared.drawn_with(quality)))
        relaxed = relax(
            yarns, material=prepared.similar, quality=quality, device=prepared.device, cell=prepared.cell,
            terms=prepared.terms, progress=progress,
        )  # fmt: skip
        found = relaxed if found is None else continued(relaxed, found)
    assert found is not None
    return found


def iterations_of(path: Sequence[Quality]) -> int:
    """Return the largest number of iterations of all resolutions of a path together."""
    is_preset = path[-1].max_iterations in {preset.max_iterations for preset in PRESETS.values()}
    return sum(step.max_iterations for step in path) if is_preset else path[-1].max_iterations


def draw_swatch(source: Source, options: SwatchOptions, quality: Quality) -> tuple[StitchMesh | None, YarnSet]:
    """Generate the yarns of a repeat, with a radius that the loops can hold; return the stitch mesh (if any) first.

    Raises:
        ParameterError: an option does not apply to the pattern.
        PatternError: the pattern does not repeat, a loop is slipped in every row, or a float is too long.
    """
    drawn = options.drawn_over_contact(APPARENT_OVER_CONTACT if isinstance(source, Pattern) else 1.0)
    if isinstance(source, Weave):
        if options.loop_length is not None:
            raise ParameterError("loop length: got one for a weave, which has no loops; give spacing or rest lengths")
        if (options.columns, options.rows) != (1, 1):
            raise ParameterError("columns, rows: the cell of a weave is one repeat; tile the weave when it is written")
        woven = weave_yarns(source, yarn_radius=options.yarn_radius, spacing=options.spacing, quality=quality)
        return None, replace(woven, drawn_radius=drawn * woven.radius)
    if options.spacing is not None:
        raise ParameterError("spacing: got one for a knitted swatch, whose spacing follows from loop_length; give that")
    loop_length = options.plain_loop
    width = loop_length / LOOP_OVER_WIDTH
    fabric = torus_mesh(
        source, stitch_width=width, stitch_height=COURSE_OVER_WALE_SPACING * width, columns=options.columns,
        rows=options.rows,
    )  # fmt: skip
    check_loops_begin(fabric)
    check_floats(fabric, options.longest_float)
    radius = min(options.yarn_radius, LARGEST_RADIUS_OVER_WIDTH * width)
    yarns = generate_yarns(
        fabric, yarn_radius=radius, drawn_radius=drawn * radius, quality=quality, longest_float=options.longest_float
    )
    if not plain_stitches(fabric).any():
        # no plain stitch can be measured; a plain stitch generated at this width would have the loop length
        return fabric, even_rest_lengths(yarns, fabric)
    yarns = apply_rest_lengths(yarns, RestLengths(loop_length=loop_length), fabric=fabric)
    return fabric, even_rest_lengths(yarns, fabric)


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
    """Return the given width and height [cm] of the fabric that is gamma times as large; None where not given.

    Raises:
        ParameterError: a size is far from the size of the generated repeat (``SIZES``).
    """
    assert drawn.lattice is not None
    for name, size, own in zip(("width", "height"), options.period, size_of(drawn.lattice), strict=True):
        least, most = (factor * own / options.gamma for factor in SIZES)
        if size is not None and not least <= size <= most:
            raise ParameterError(f"period {name}: got {size:g} cm; expected {least:.3g} to {most:.3g} for this repeat")
    return [None if size is None else size * options.gamma for size in options.period]


def even_rest_lengths(yarns: YarnSet, fabric: StitchMesh) -> YarnSet:
    """Distribute the rest length evenly over the segments of each stitch.

    The loop below a stitch is treated as a separate part. If all stitches are plain and equal, the rest length is
    distributed within each loop instead: this follows from symmetry, and yarn can slide through its loops. Without an
    even distribution, a spline stretches locally even if its total length is right, and this costs energy.
    """
    below = fabric.side_face[fabric.twin[fabric.face_start[:-1]]]
    alike = plain_stitches(fabric).all() and len(np.unique([fabric.stitch, fabric.yarn], axis=1).T) == 1
    head_of = below if alike else fabric.face_count + np.arange(fabric.face_count)
    face = segment_faces(yarns)
    stitch = np.where(belongs_to_loop_below(yarns, fabric)[yarns.segment_points[:, 1]], head_of[face], face)
    stitch = np.where(carried_segments(yarns), 2 * fabric.face_count + face, stitch)
    _, run, count = np.unique(
        3 * fabric.face_count * yarns.segment_yarn + stitch, return_inverse=True, return_counts=True
    )
    return replace(yarns, rest_length=(np.bincount(run, yarns.rest_length) / count)[run])


def scale_yarns(yarns: YarnSet, factor: float) -> YarnSet:
    """Multiply all lengths of yarns on a lattice by a factor."""
    assert yarns.lattice is not None
    return replace(
        yarns.with_radius(yarns.radius * factor), points=yarns.points * factor,
        rest_length=yarns.rest_length * factor, natural_curvature=yarns.natural_curvature / factor,
        lattice=Lattice(yarns.lattice.periods * factor),
    )  # fmt: skip


def free_cell(
    relax_cell: bool | RelaxCell, options: SwatchOptions, drawn: YarnSet, material: YarnMaterial
) -> RelaxCell | None:
    """Return the degrees of freedom of the cell and its loads, or None for a fixed cell.

    A size that is given stays fixed. Pulls are divided by gamma, because the relaxed cell is gamma times as large.

    Raises:
        ParameterError: a blocked swatch has a given ``RelaxCell``, or would tear.
    """
    if options.blocked is not None:
        if isinstance(relax_cell, RelaxCell):
            raise ParameterError("blocked: got a RelaxCell beside it; give its loads, or relax_cell=True")
        relax_cell = blocking(drawn, options, material)
    if relax_cell is False:
        return None
    cell = RelaxCell(shear=False) if relax_cell is True else relax_cell
    pulls = [
        None if pull is None or size is not None else pull / options.gamma
        for pull, size in zip((cell.course, cell.wale), options.period, strict=True)
    ]
    return replace(cell, course=pulls[0], wale=pulls[1])
