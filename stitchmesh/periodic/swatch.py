# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A swatch: one repeat of a knitted or woven pattern, relaxed on its lattice; the order of operations.

The yarn of a stitch is what is given, as on a knitting machine, and the size of the fabric follows. Yarn as thick as
loops can hold is drawn thinner at first and grows (``continuation``); ``gamma`` grows it further and scales all
back, so that the yarn keeps its radius and the fabric has 1 / gamma of its yarn (Leaf et al. 2018, section 6.2). Yarn
of stitches and parts of them is taken up by factors of rest lengths, in steps too (section 6.1).
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.io.history import HistoryEntry
from stitchmesh.lattice import Lattice
from stitchmesh.mesh import FloatArray, StitchMesh
from stitchmesh.patterns import Pattern
from stitchmesh.periodic.continuation import change_period, change_radius, change_rest_length, size_of
from stitchmesh.periodic.gauge import swatch_report
from stitchmesh.periodic.resolve_pattern import Source, resolve_pattern
from stitchmesh.periodic.slipped_loop_check import check_loops_begin
from stitchmesh.periodic.torus import torus_mesh
from stitchmesh.periodic.weave.jamming import jam_report
from stitchmesh.periodic.weave.weave import Weave
from stitchmesh.periodic.weave.yarns import weave_yarns
from stitchmesh.quality import Quality, quality_named
from stitchmesh.tessellate import COURSE_OVER_WALE_SPACING
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.rest_length import RestLengths, apply_rest_lengths, plain_stitches, segment_faces
from stitchmesh.yarngen import generate_yarns, in_heads
from stitchmesh.yarnrelax import REFERENCE_RADIUS, RelaxCell, YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.linking.certificate import refuse_pull_through

YARN_RADIUS = 0.125
"""Default radius of the yarn [cm], that of the published materials."""
COMPACT_LOOP = 16.67
"""Default loop length over the yarn's diameter: Peirce's compact loop."""
LOOP_OVER_WIDTH = 4.07
"""Yarn of a plain loop as it is drawn over the stitch's width, for yarn of an eighth of the width."""
THICKEST = 0.16
"""Largest radius over the stitch width at which yarn is drawn; thicker yarn grows from there."""
CLOSER = 1.5
"""Power of the looseness by which contacts are sampled more closely: what spheres that catch hold back is less the
further apart the bends of the yarn are, and so is what straightens them (docs/validation.md)."""
LOOSEST = 4.0
"""Looseness from which on contacts are sampled no more closely."""
GAMMAS = (0.1, 10.0)
"""Smallest and largest gamma."""
TAKE_UP = (0.1, 2.0)
"""Smallest and largest factor of a rest length (Leaf et al. 2018, section 7.2)."""
SIZES = (0.1, 10.0)
"""Smallest and largest period over that of the drawing."""
ROUNDING = 1e-12
"""Of a product of factors and a quotient of lengths."""


@dataclass(frozen=True, eq=False)
class Swatch:
    """A relaxed repeat."""

    yarns: YarnSet
    """Its yarns, on their lattice."""
    report: dict[str, Any]
    """Plain numbers: what ``gauge.swatch_report`` measures, of a weave ``jamming.jam_report``, and what ``relax_yarns``
    reports."""
    fabric: StitchMesh | None
    """The stitches of a knitted swatch, as they were drawn; None for a weave."""
    history: list[HistoryEntry]
    """What each assessment of the relaxation found."""

    @property
    def lattice(self) -> Lattice:
        """Its periods."""
        assert self.yarns.lattice is not None
        return self.yarns.lattice


@dataclass(frozen=True, kw_only=True)
class SwatchOptions:
    """What a swatch is made of.

    Raises:
        ParameterError: a length or gamma is not a positive number, or gamma is out of bounds.
    """

    yarn_radius: float = YARN_RADIUS
    """[cm]"""
    loop_length: float | None = None
    """Yarn of a plain stitch [cm]; ``COMPACT_LOOP`` yarn diameters where not given. Knitted swatches."""
    spacing: float | tuple[float, float] | None = None
    """Distance of neighbouring yarns of a weave [cm], or of its warps and of its wefts."""
    rest_lengths: RestLengths = field(default_factory=RestLengths)
    """Take-up: factors of stitches, rows, yarns and parts, which together are within ``TAKE_UP``."""
    gamma: float = 1.0
    """Yarn is taken up by this factor, the fabric made so much tighter."""
    period: tuple[float | None, float | None] = (None, None)
    """Width and height of the repeat [cm]; None leaves it to the drawing, or free where the cell relaxes."""
    columns: int = 1
    """Repeats of the pattern in the cell, side by side."""
    rows: int = 1
    """Repeats of the pattern in the cell, above one another."""

    def __post_init__(self) -> None:
        lengths = {"yarn radius": self.yarn_radius, "loop length": self.loop_length, "period width": self.period[0],
                   "period height": self.period[1]}  # fmt: skip
        for name, value in lengths.items():
            if value is not None and not (np.isfinite(value) and value > 0.0):
                raise ParameterError(f"{name}: got {value} cm; expected a positive number")
        if not (np.isfinite(self.gamma) and GAMMAS[0] <= self.gamma <= GAMMAS[1]):
            raise ParameterError(f"gamma: got {self.gamma}; expected {GAMMAS[0]:g} to {GAMMAS[1]:g}")
        if self.rest_lengths.loop_length is not None:
            raise ParameterError("rest lengths: got a loop length among them; give it to the swatch")


def swatch(
    pattern: str | Pattern | Weave,
    *,
    material: YarnMaterial | None = None,
    quality: str | Quality = "standard",
    device: str | None = None,
    relax_cell: bool | RelaxCell = False,
    progress: Callable[[HistoryEntry], None] | None = None,
    **options: Any,
) -> Swatch:
    """One repeat of a pattern, relaxed.

    Args:
        pattern: a pattern, a weave, the name of one of the library, or the path of a file of one.
        material: of the yarn; the material ``stitchmesh`` scaled to the yarn's radius where not given.
        quality: a preset or a ``Quality``.
        device: "cpu", "cuda:0" ...; the first GPU, else the CPU, where not given.
        relax_cell: whether the repeat finds its own width and height; or what it is free to do, such as to lean
            (``RelaxCell()``: ribs without friction do, to either side).
        progress: called every half second or so.
        options: fields of ``SwatchOptions``.

    Raises:
        FileError: the file cannot be read.
        ParameterError: an option is out of bounds, or asks for what the pattern does not have.
        PatternError: the pattern does not repeat, or the weave falls apart.
        SolverError: the yarns cannot come to rest.
    """
    chosen, quality = SwatchOptions(**options), quality_named(quality)
    if material is None:
        material = YarnMaterial.named("stitchmesh").scaled(chosen.yarn_radius / REFERENCE_RADIUS)
    began = time.perf_counter()
    source = resolve_pattern(pattern)
    fabric, first = draw_swatch(source, chosen, quality)
    quality = close_contacts(quality, chosen)
    # by the similarity the fabric is relaxed gamma times as large as it will be
    similar = material.scaled(chosen.gamma)
    thicker = chosen.gamma * (1.0 if fabric is None else chosen.yarn_radius / float(first.radius[0]))
    # wefts and warps lie straight enough to begin with as long at rest as they are drawn
    natural = first if fabric is not None else replace(first, rest_length=first.lengths)
    yarns = change_radius(natural, thicker, similar, quality, device)
    period = period_to_reach(first, chosen)
    cell = free_cell(relax_cell, chosen)
    yarns = change_rest_length(yarns, take_up_rest_lengths(first, fabric, chosen), similar, quality, device, cell)
    yarns = change_period(yarns, period, similar, quality, device)
    relaxed = relax_yarns(yarns, material=similar, quality=quality, device=device, cell=cell, progress=progress)
    refuse_pull_through(first, relaxed.yarns, device)
    result = scale_yarns(relaxed.yarns, 1.0 / chosen.gamma)
    measures = swatch_report(result, fabric, material, quality, relaxed.report["energy"], device)
    if isinstance(source, Weave):
        measures |= jam_report(source, result)
    seconds = {"seconds": time.perf_counter() - began, "solver_seconds": relaxed.report["seconds"]}
    return Swatch(result, measures | relaxed.report | seconds, fabric, relaxed.history)


def draw_swatch(source: Source, options: SwatchOptions, quality: Quality) -> tuple[StitchMesh | None, YarnSet]:
    """The repeat as it is drawn, with yarn no thicker than loops can hold; and its stitches if it is knitted."""
    if isinstance(source, Weave):
        if options.loop_length is not None:
            raise ParameterError("loop length: got one for a weave, which has no loops; give spacing or rest lengths")
        if (options.columns, options.rows) != (1, 1):
            raise ParameterError("columns, rows: a weave's cell is one repeat; tile it when it is written")
        return None, weave_yarns(source, yarn_radius=options.yarn_radius, spacing=options.spacing, quality=quality)
    if options.spacing is not None:
        raise ParameterError("spacing: got one for a knitted swatch, whose loops decide it; give loop_length")
    loop_length = options.loop_length or 2 * COMPACT_LOOP * options.yarn_radius
    width = loop_length / LOOP_OVER_WIDTH
    fabric = torus_mesh(
        source, stitch_width=width, stitch_height=COURSE_OVER_WALE_SPACING * width, columns=options.columns,
        rows=options.rows,
    )  # fmt: skip
    check_loops_begin(fabric)
    yarns = generate_yarns(fabric, yarn_radius=min(options.yarn_radius, THICKEST * width), quality=quality)
    if not plain_stitches(fabric).any():  # none to measure; as wide as they are drawn, plain ones would be so long
        return fabric, even_rest_lengths(yarns, fabric)
    yarns = apply_rest_lengths(yarns, RestLengths(loop_length=loop_length), fabric=fabric)
    return fabric, even_rest_lengths(yarns, fabric)


def close_contacts(quality: Quality, options: SwatchOptions) -> Quality:
    """The quality with more contact samples where loops are looser than compact ones.

    Control points of a stitch are as many in long loops as in short ones, and so the spheres of a segment further
    apart; they catch on one another, and loops stay narrower than they are at rest.
    """
    loop = options.loop_length or 2 * COMPACT_LOOP * options.yarn_radius
    looseness = loop / (2 * COMPACT_LOOP * options.yarn_radius * options.gamma)
    closer = min(max(looseness, 1.0), LOOSEST) ** CLOSER
    return replace(quality, contact_samples=math.ceil(quality.contact_samples * closer * (1.0 - ROUNDING)))


def take_up_rest_lengths(drawn: YarnSet, fabric: StitchMesh | None, options: SwatchOptions) -> FloatArray:
    """Rest lengths that the take-up makes of those that yarns are drawn with [cm], shape (S,).

    Raises:
        ParameterError: what a factor is for is not there, or factors together are out of bounds.
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
    """Width and height that are asked for [cm], of a fabric gamma times as large as it will be; None where not given.

    Raises:
        ParameterError: one is out of all proportion to the repeat as it is drawn.
    """
    assert drawn.lattice is not None
    for name, size, own in zip(("width", "height"), options.period, size_of(drawn.lattice), strict=True):
        least, most = (factor * own / options.gamma for factor in SIZES)
        if size is not None and not least <= size <= most:
            raise ParameterError(f"period {name}: got {size:g} cm; expected {least:.3g} to {most:.3g} for this repeat")
    return [None if size is None else size * options.gamma for size in options.period]


def even_rest_lengths(yarns: YarnSet, fabric: StitchMesh) -> YarnSet:
    """Yarns whose segments are equally long at rest within each stitch, its own apart from the loop's below.

    Where all stitches are plain and alike, segments are equally long within each loop: by symmetry, and yarn can slide
    through its loops. A spline whose segments differ in length stretches here and there while its length is right,
    which costs energy.
    """
    below = fabric.side_face[fabric.twin[fabric.face_start[:-1]]]
    alike = plain_stitches(fabric).all() and len(np.unique([fabric.stitch, fabric.yarn], axis=1).T) == 1
    head_of = below if alike else fabric.face_count + np.arange(fabric.face_count)
    face = segment_faces(yarns)
    stitch = np.where(in_heads(yarns, fabric)[yarns.segment_points[:, 1]], head_of[face], face)
    _, run, count = np.unique(
        2 * fabric.face_count * yarns.segment_yarn + stitch, return_inverse=True, return_counts=True
    )
    return replace(yarns, rest_length=(np.bincount(run, yarns.rest_length) / count)[run])


def scale_yarns(yarns: YarnSet, factor: float) -> YarnSet:
    """Yarns on a lattice with every length so many times as large."""
    assert yarns.lattice is not None
    return replace(
        yarns, points=yarns.points * factor, radius=yarns.radius * factor, rest_length=yarns.rest_length * factor,
        natural_curvature=yarns.natural_curvature / factor, lattice=Lattice(yarns.lattice.periods * factor),
    )  # fmt: skip


def free_cell(relax_cell: bool | RelaxCell, options: SwatchOptions) -> RelaxCell | None:
    """What the periods are free to do: not those that are given, and pulls on a cell that is gamma times as large."""
    if relax_cell is False:
        return None
    cell = RelaxCell(shear=False) if relax_cell is True else relax_cell
    pulls = [
        None if pull is None or size is not None else pull / options.gamma
        for pull, size in zip((cell.course, cell.wale), options.period, strict=True)
    ]
    return replace(cell, course=pulls[0], wale=pulls[1])
