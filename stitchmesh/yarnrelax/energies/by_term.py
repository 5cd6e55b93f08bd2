# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Forces and energies of each term separately, for assessments, reports and messages."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import Launcher, ZeroArray
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Scalar, Vec3, Vec4
from stitchmesh.compute.reduction import Sums, sums_over
from stitchmesh.yarnrelax.collision.narrow_phase import Candidates
from stitchmesh.yarnrelax.collision.step_limit import yarn_place
from stitchmesh.yarnrelax.energies.contact import contact_energy
from stitchmesh.yarnrelax.energies.evaluation import contact_launch, gather_launch, segment_launch
from stitchmesh.yarnrelax.energies.segment_forces import bend_energy, length_energy, natural_ends, stretch_energy
from stitchmesh.yarnrelax.energies.term import OnYarns
from stitchmesh.yarnrelax.model.cells import CONTACT
from stitchmesh.yarnrelax.model.constants import Model, YarnConstants
from stitchmesh.yarnrelax.model.lattice_images import sample_number
from stitchmesh.yarnrelax.model.spline import from_entry, segment_corners
from stitchmesh.yarnrelax.model.state import State

SEGMENT_TERMS = ("stretch", "length", "bend")
"""Energies of single segments, in the order of the columns of ``Model.stiffness``."""
BASE_TERMS = 4
"""The number of energies of every relaxation: stretch, length, bending and contact."""


@kernel
def segment_energies(
    # model
    model: YarnConstants,
    # state in
    points: wp.array[Vec3],
    # state out
    stretch: wp.array[Scalar],
    length: wp.array[Scalar],
    bend: wp.array[Scalar],
) -> None:
    """Energy [erg] of each segment by term."""
    s = wp.tid()
    q0, q1, q2, q3 = segment_corners(model, points, s)
    leg0, leg1, leg2 = q1 - q0, q2 - q1, q3 - q2
    rest_length = model.segment_rest_length[s]
    k = model.segment_stiffness[s] * rest_length
    natural = natural_ends(model, s)
    in_stretch, in_bend, long = rest_length - rest_length, rest_length - rest_length, rest_length - rest_length
    for g in range(model.quadrature_points):
        rule = model.rule[g]
        tangent = leg0 * rule[0] + leg1 * rule[1] + leg2 * rule[2]
        turn = (leg1 - leg0) * rule[3] + (leg2 - leg1) * rule[4]
        speed = wp.length(tangent)
        long += speed * rule[5]
        in_stretch += stretch_energy(speed, rest_length, k[0] * rule[5])
        curvature = wp.abs(natural[0] * rule[3] + natural[1] * rule[4])
        in_bend += bend_energy(tangent, turn, k[2] * rule[5], curvature)
    stretch[s] = in_stretch
    length[s] = length_energy(long, rest_length, k[1])
    bend[s] = in_bend


@kernel
def contact_energies(
    # model
    model: YarnConstants,
    # state in
    samples: wp.array[Vec4],
    candidate_count: wp.array[wp.int32],
    candidates: wp.array2d[wp.int32],
    # state out
    sample_energy: wp.array[Scalar],
) -> None:
    """Half of the energy of each pair [erg], at both of its samples."""
    p = wp.tid()
    here = samples[p]
    weight = model.sample_stiffness[p]
    energy = weight - weight
    for c in range(candidate_count[p]):
        entry = candidates[p, c]
        apart = from_entry(model.images, samples, p, here, entry)
        distance2 = apart[0] * apart[0] + apart[1] * apart[1] + apart[2] * apart[2]
        reach2 = apart[3] * apart[3]
        if distance2 < reach2:
            stiffness = weight * model.sample_weight[sample_number(model.images, entry)]
            energy += contact_energy(model.contact, p, distance2, reach2, stiffness)
    sample_energy[p] = energy * type(energy)(0.5)


def each_term(
    model: Model, state: State, candidates: Candidates, terms: Sequence[OnYarns], point_stiffness: wp.array[Any]
) -> Iterator[str]:
    """Leave the force of each term in ``state.force``, one after another; the samples must be placed."""
    launches = term_launches(model, state, candidates, terms, point_stiffness)
    for name, own in launches.items():
        for launch in own:
            launch.launch()
        yield name


def largest_force(
    model: Model,
    state: State,
    candidates: Candidates,
    terms: Sequence[OnYarns],
    point_stiffness: wp.array[Any],
    cell: int,
) -> str:
    """Return the energy with the largest force in a cell, and the place of the force; the samples must be placed."""
    first, last = model.point_start[cell : cell + 2]
    largest, energy, point = -1.0, "", 0
    for term in each_term(model, state, candidates, terms, point_stiffness):
        force = np.linalg.norm(state.force.numpy()[first:last].astype(np.float64), axis=1)
        force = np.where(np.isfinite(force), force, np.inf)
        if force.max() > largest:
            largest, energy, point = float(force.max()), term, int(first + force.argmax())
    return f"{energy} energy of {yarn_place(model.yarns, point)}"


def term_launches(
    model: Model,
    state: State,
    candidates: Candidates,
    terms: Sequence[OnYarns],
    point_stiffness: wp.array[Any],
) -> dict[str, list[Any]]:
    """Return, for each term, the prepared launches that leave its force in ``state.force``; samples must be placed."""
    result: dict[str, list[Any]] = {}
    launcher = model.prepare
    gather = gather_launch(model, state, point_stiffness, launcher)
    of_pairs = [state.sample_force, state.sample_virial, state.external_force]
    for place, name in enumerate(SEGMENT_TERMS):
        if model.stiffness[:, place].any():
            result[name] = [] if result else _cleared(of_pairs)
            result[name] += [segment_launch(model, state, np.eye(3)[place], launcher), gather]
    of_segments = [state.leg_force, state.segment_virial]
    if model.stiffness[:, CONTACT].any():
        result["contact"] = _cleared([*of_segments, state.external_force])
        result["contact"] += [contact_launch(model, state, candidates, launcher), gather]
    for number, term in enumerate(terms):
        own = [*_cleared([*of_segments, *of_pairs]), *term.forces(state, state.forces, launcher), gather]
        result[term.name if term.name not in result else f"{term.name} {number}"] = own
    return result


def energies(model: Model, state: State, candidates: Candidates, terms: Sequence[OnYarns]) -> dict[str, float]:
    """Return the energy of each term [erg]; the samples must be placed."""
    sums = Sums(BASE_TERMS, model.largest_cell, model.cell_count, model.device)
    energy_launches(model, state, candidates, sums, model.launch)
    found = {name: float(parts.sum()) for name, parts in sums.read().items()}
    return found | {term.name: term.energy(state) for term in terms}


def cell_energies(model: Model, state: State, term: OnYarns) -> NDArray[np.float64]:
    """Return the energy of a term in each cell [erg], shape (C,); the samples must be placed.

    A term that several cells may have has an energy at each control point or at each contact sample.
    """
    if model.cell_count == 1:
        return np.array([term.energy(state)])
    _launches, energies = term.element_energies(state, model.launch)
    start = model.cell_points if len(energies) == model.point_count else model.cell_samples
    return sums_over(energies, start, model.largest_cell)


def energy_launches(model: Model, state: State, candidates: Candidates, sums: Sums, launcher: Launcher) -> list[Any]:
    """Return the launches that sum the energies of the base terms (``BASE_TERMS``); the samples must be placed."""
    segments, contact = [model.empty(model.segment_count) for _ in SEGMENT_TERMS], model.empty(model.sample_count)
    inputs = [model.constants, state.samples, candidates.count, candidates.lists]
    launches = [
        launcher(segment_energies, model.segment_count, [model.constants, state.points], segments),
        launcher(contact_energies, model.sample_count, inputs, [contact]),
    ]
    for name, part in zip(SEGMENT_TERMS, segments, strict=True):
        launches.append(sums.add(name, part, model.cell_segments, launcher))
    return [*launches, sums.add("contact", contact, model.cell_samples, launcher)]


def _cleared(arrays: Sequence[wp.array[Any]]) -> list[Any]:
    """Return the launches that set arrays to zero."""
    return [ZeroArray(array) for array in arrays if len(array)]
