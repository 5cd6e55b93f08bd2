# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The size of a free fabric and its tensions at given strains, with their derivatives by the values of its yarn.

The free cell and each drawn cell are brought to rest in float64 (``rest_derivatives.polished``), and the derivatives
follow from the Hessian there, without further relaxations. Let X be the size of a cell in the direction of the pull, Y
the size across, and X0, Y0 these sizes of the free cell. At the strain e, X = (1 + e) X0, and Y is free, or Y = Y0. The
tension is T = F / Y0 with the force F on the border. Let S be the stiffness of the cell as a membrane by its strains,
R(p) the forces on the strains over the relative change of an input p while they are held, and x, y the relative changes
of X and Y over the one of p. The free size Y0 and the strain x = d ln X0 come from the free cell. Then

    y = (R_y - S_yx x) / S_yy           if Y is free, else d ln Y0
    dF = (S_xx x + S_xy y - R_x) / X
    dT = dF / Y0 - T d ln Y0

The inputs are those of ``rest_derivatives``. The values of a yarn are products of their powers: a core of another
diameter at the same transverse modulus has another k_contact, for example. The distance of the planes follows the yarn
as in a new swatch.

When the yarn changes, each cell starts from the same cell of the former yarn, scaled to the new loop length. All cells
then relax together (``relax_together``): on a GPU, in one batch.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from stitchmesh.compute.device import alone, device_named
from stitchmesh.compute.work_together import done_together
from stitchmesh.errors import StitchMeshError
from stitchmesh.io.measured_curves import MeasuredCurve
from stitchmesh.mesh import FloatArray
from stitchmesh.patterns import Pattern
from stitchmesh.periodic.fabric_shape import FlatFabric
from stitchmesh.periodic.fit_settings import VALUES
from stitchmesh.periodic.relaxation.continuation import change_radius, size_of
from stitchmesh.periodic.relaxation.drawn_cell import DrawnCell, relax_at
from stitchmesh.periodic.relaxation.prepared_swatch import PreparedSwatch, prepare_swatch
from stitchmesh.periodic.relaxation.support import planes
from stitchmesh.periodic.relaxation.way_to_rest import relax_with_digits
from stitchmesh.periodic.repeat.drawn_swatch import draw_swatch
from stitchmesh.periodic.sampling.sampling import GENERATED
from stitchmesh.periodic.swatch import relax_prepared, scale_yarns
from stitchmesh.periodic.swatch_options import SwatchOptions
from stitchmesh.quality import Quality
from stitchmesh.run import QUIET
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial
from stitchmesh.yarnrelax.cell_stress import cell_stress
from stitchmesh.yarnrelax.energies.confinement import Confinement
from stitchmesh.yarnrelax.energies.term import INPUTS, YarnChoice
from stitchmesh.yarnrelax.relaxation_inputs import RelaxationInputs
from stitchmesh.yarnrelax.rest_derivatives import RestDerivatives, polished, rest_derivatives
from stitchmesh.yarnrelax.together.relax_together import ways_together

STEP = 1e-4
"""Relative change of a length in the differences that give the derivatives of the distance of the planes."""


@dataclass(frozen=True, kw_only=True)
class KnittedYarn:
    """A yarn in its fabric, in CGS units."""

    material: YarnMaterial
    """Its material."""
    core_radius: float
    """Contact radius [cm]."""
    loop_length: float
    """Yarn in a plain stitch [cm]."""


@dataclass(frozen=True, eq=False)
class FabricResponse:
    """The size and the tensions of a fabric, and their derivatives by the logarithms of ``VALUES``."""

    yarn: KnittedYarn
    """The yarn."""
    prepared: PreparedSwatch
    """The fabric as it was first prepared."""
    quality: Quality
    """The resolution that the caller asked for."""
    free: YarnSet
    """The yarns of the free cell."""
    drawn: tuple[YarnSet, ...]
    """The yarns of each drawn cell, curve by curve."""
    size: FloatArray
    """Width and height of the repeat [cm], shape (2,)."""
    size_slopes: FloatArray
    """Relative change of width and height over the relative change of each value, shape (2, V)."""
    tension: FloatArray
    """Tension of each drawn cell [dyn/cm], shape (n,)."""
    tension_slopes: FloatArray
    """Change of the tensions over the relative change of each value [dyn/cm], shape (n, V)."""


@dataclass(frozen=True, eq=False)
class _Rest:
    """A cell at rest in float64, and its derivatives."""

    yarns: YarnSet
    found: RestDerivatives
    force: FloatArray
    """Forces on the borders along courses and wales [dyn], shape (2,)."""


def first_response(
    pattern: Pattern, yarn: KnittedYarn, curves: Sequence[MeasuredCurve], quality: Quality, device: str | None
) -> FabricResponse:
    """Prepare a fabric, relax it, and draw it to the strains of each curve one after another.

    Args:
        pattern: the pattern.
        yarn: the yarn.
        curves: directions and strains; their tensions do not count.
        quality: resolution, as fine as tensions need.
        device: device of the kernels.

    Raises:
        ParameterError, PatternError: the pattern cannot be knitted with this yarn.
        SolverError: a cell does not come to rest.
    """
    prepared = prepare_swatch(
        pattern, material=yarn.material, quality=quality, device=device, relax_cell=True, relaxation="frictionless",
        yarn_radius=yarn.core_radius, loop_length=yarn.loop_length,
    )  # fmt: skip
    free = relax_prepared(prepared, prepared.yarns, QUIET).at_rest
    assert free is not None
    rest = _at_rest(free.yarns, prepared, yarn, prepared.terms)
    drawn = [partial(_drawn_one_after_another, rest.yarns, prepared, yarn, curve) for curve in curves]
    states = [state for states in _done(drawn) for state in states]
    return _response(prepared, quality, yarn, curves, rest, states, prepared.terms)


def new_response(before: FabricResponse, yarn: KnittedYarn, curves: Sequence[MeasuredCurve]) -> FabricResponse:
    """Prepare, relax and draw a fabric of a changed yarn from new, as ``first_response`` does.

    Raises:
        ParameterError, PatternError, SolverError: as for ``first_response``.
    """
    prepared = before.prepared
    assert isinstance(prepared.source, Pattern)
    return first_response(prepared.source, yarn, curves, before.quality, prepared.device)


def next_response(before: FabricResponse, yarn: KnittedYarn, curves: Sequence[MeasuredCurve]) -> FabricResponse:
    """Relax the cells of a fabric again with a changed yarn.

    Raises:
        SolverError: a cell does not come to rest.
    """
    prepared = before.prepared
    acting = _planes(prepared, yarn)
    (free,) = _done([partial(_relaxed_free, before, yarn, acting)])
    rest = _at_rest(free, prepared, yarn, acting)
    again, place = list[Callable[[], YarnSet]](), 0
    for curve in curves:
        drawn = _drawn_cell(rest.yarns, prepared, yarn, curve, acting)
        for strain in curve.strain.tolist():
            again.append(partial(_relaxed_drawn, before.drawn[place], before.yarn, yarn, drawn, strain))
            place += 1
    return _response(prepared, before.quality, yarn, curves, rest, _done(again), acting)


def _done(computations: Sequence[Callable[[], Any]]) -> list[Any]:
    """Return the results of computations whose relaxations are done together.

    Raises:
        StitchMeshError: the first error of a computation.
    """
    found = done_together(computations, ways_together())
    for each in found:
        if isinstance(each, StitchMeshError):
            raise each
    return found


def _drawn_cell(
    free: YarnSet, prepared: PreparedSwatch, yarn: KnittedYarn, curve: MeasuredCurve, acting: Sequence[YarnChoice]
) -> DrawnCell:  # fmt: skip
    return DrawnCell(
        free, curve.direction, curve.other, yarn.material, prepared.quality, acting, prepared.device, QUIET
    )  # fmt: skip


def _drawn_one_after_another(
    free: YarnSet, prepared: PreparedSwatch, yarn: KnittedYarn, curve: MeasuredCurve
) -> list[YarnSet]:
    """Return the yarns at the strains of a curve, each drawn from the one before it, as in a stretch test."""
    drawn, found = _drawn_cell(free, prepared, yarn, curve, prepared.terms), [free]
    for strain in curve.strain.tolist():
        found.append(relax_at(drawn, found[-1], strain).yarns)
    return found[1:]


def _changed(yarns: YarnSet, before: KnittedYarn, yarn: KnittedYarn, quality: Quality, device: str | None) -> YarnSet:
    """Return yarns with the lengths of another yarn, scaled to its loop length."""
    longer = yarn.loop_length / before.loop_length
    thicker = yarn.core_radius / before.core_radius / longer
    return change_radius(scale_yarns(yarns, longer), thicker, yarn.material, quality, device)


def _relaxed_free(before: FabricResponse, yarn: KnittedYarn, acting: Sequence[YarnChoice]) -> YarnSet:
    prepared = before.prepared
    yarns = _changed(before.free, before.yarn, yarn, prepared.quality, prepared.device)
    return relax_with_digits(
        yarns, prepared.quality, material=yarn.material, device=prepared.device, cell=prepared.cell, terms=acting,
        run=QUIET,
    ).yarns  # fmt: skip


def _relaxed_drawn(
    yarns: YarnSet, before: KnittedYarn, yarn: KnittedYarn, drawn: DrawnCell, strain: float
) -> YarnSet:
    return relax_at(drawn, _changed(yarns, before, yarn, drawn.quality, drawn.device), strain).yarns


@alone()
def _at_rest(
    yarns: YarnSet, prepared: PreparedSwatch, yarn: KnittedYarn, acting: Sequence[YarnChoice],
    drawn: DrawnCell | None = None,
) -> _Rest:  # fmt: skip
    """Bring a cell to rest in float64, and differentiate it; ``drawn`` is None for the free cell."""
    quality, cell = prepared.quality, prepared.cell if drawn is None else drawn.cell
    loop = polished(RelaxationInputs(
        yarns, yarn.material, quality, device_named(prepared.device), acting, cell=cell
    ))  # fmt: skip
    settled = loop.simulation.good_yarns()
    assert settled.lattice is not None
    stress = cell_stress(
        settled, yarn.material, quadrature_points=quality.quadrature_points, contact_samples=quality.contact_samples,
        device=prepared.device,
    )  # fmt: skip
    width, height = size_of(settled.lattice)
    force = np.array([stress.course * height, stress.wale * width])
    return _Rest(settled, rest_derivatives(loop.simulation), force)


def _response(
    prepared: PreparedSwatch, quality: Quality, yarn: KnittedYarn, curves: Sequence[MeasuredCurve], free: _Rest,
    states: Sequence[YarnSet], acting: Sequence[YarnChoice],
) -> FabricResponse:  # fmt: skip
    """Differentiate the cells at rest."""
    powers = _powers(prepared, yarn, acting)
    assert free.yarns.lattice is not None
    size0 = np.array(size_of(free.yarns.lattice))
    size_slopes = np.column_stack([free.found.strains[name][:2] for name in INPUTS])
    tension, slopes, drawn = [], [], []
    waiting = iter(states)
    for curve in curves:
        cell = _drawn_cell(free.yarns, prepared, yarn, curve, acting)
        for _strain in curve.strain:
            rest = _at_rest(next(waiting), prepared, yarn, acting, cell)
            along = ("course", "wale").index(curve.direction)
            own, own_slopes = _tension(rest, along, curve.other == "free", size0, size_slopes)
            tension.append(own)
            slopes.append(own_slopes)
            drawn.append(rest.yarns)
    copies = np.array([1.0, prepared.smallest.copies])
    tension_slopes = np.reshape(slopes, (len(tension), len(INPUTS))) @ powers
    return FabricResponse(
        yarn, prepared, quality, free.yarns, tuple(drawn), copies * size0, size_slopes @ powers, np.array(tension),
        tension_slopes,
    )  # fmt: skip


def _tension(
    rest: _Rest, along: int, is_free: bool, size0: FloatArray, size_slopes: FloatArray
) -> tuple[float, FloatArray]:
    """Return the tension of a drawn cell, and its derivatives by ``INPUTS``, shape (I,); formulas above."""
    assert rest.yarns.lattice is not None
    across, stiffness = 1 - along, rest.found.stiffness
    reaction = np.column_stack([rest.found.reactions[name] for name in INPUTS])
    own = size_slopes[along]
    other = size_slopes[across]
    if is_free:
        other = (reaction[across] - stiffness[across, along] * own) / stiffness[across, across]
    change = stiffness[along, along] * own + stiffness[along, across] * other - reaction[along]
    force_slopes = change / size_of(rest.yarns.lattice)[along]
    tension = float(rest.force[along] / size0[across])
    return tension, force_slopes / size0[across] - tension * size_slopes[across]


def _powers(prepared: PreparedSwatch, yarn: KnittedYarn, acting: Sequence[YarnChoice]) -> FloatArray:
    """Return the relative change of each of ``INPUTS`` over the one of each of ``VALUES``, shape (I, V)."""
    powers: dict[str, Mapping[str, float]] = {
        "bending_rigidity": {"k_bend": 1.0},
        "axial_stiffness": {"k_len": 1.0, "k_length": 1.0},
        "transverse_modulus": {"k_contact": 1.0},
        "core_diameter": {"radius": 1.0, "k_contact": 1.0},
        "loop_length": {"loop_length": 1.0},
    }
    found = np.array([[powers[value].get(name, 0.0) for value in VALUES] for name in INPUTS])
    if not acting:
        return found
    for value, name in (("core_diameter", "core_radius"), ("loop_length", "loop_length")):
        sides = [replace(yarn, **{name: getattr(yarn, name) * factor}) for factor in (1.0 + STEP, 1.0 - STEP)]
        more, less = (
            term.half_thickness for side in sides for term in _planes(prepared, side) if isinstance(term, Confinement)
        )
        found[INPUTS.index("planes"), VALUES.index(value)] = math.log(more / less) / (2.0 * STEP)
    return found


def _planes(prepared: PreparedSwatch, yarn: KnittedYarn) -> list[YarnChoice]:
    """Return the planes between which a fabric of this yarn lies; its loops are only drawn."""
    options: SwatchOptions = replace(prepared.options, yarn_radius=yarn.core_radius, loop_length=yarn.loop_length)
    fabric, generated = draw_swatch(prepared.source, options, GENERATED)
    flat = FlatFabric.of(generated, fabric, prepared.source)
    return planes(options, flat, np.array([yarn.core_radius]))
