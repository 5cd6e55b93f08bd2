# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Which terms a relaxation has, and their forces and energies on the device."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import warp as wp

from stitchmesh.yarnrelax.candidates import Candidates
from stitchmesh.yarnrelax.contact import contact_energies, contact_forces
from stitchmesh.yarnrelax.gather import gather_forces
from stitchmesh.yarnrelax.internal import internal_energies, place_and_pull
from stitchmesh.yarnrelax.model import CONTACT, Model
from stitchmesh.yarnrelax.reduction import Sums
from stitchmesh.yarnrelax.samples import place_samples
from stitchmesh.yarnrelax.state import State
from stitchmesh.yarnrelax.term import Run, Term

BASE_TERMS = 4
"""Stretch, length, bending and contact."""


def sample(model: Model, state: State) -> None:
    """Place the contact samples on the curves."""
    model.launch(place_samples, model.segment_count, [model.constants, state.points], [state.samples])


def all_forces(
    model: Model,
    state: State,
    candidates: Candidates,
    terms: Sequence[Term],
    point_stiffness: wp.array[Any],
    run: Run,
) -> list[Any]:
    """Place the samples, then leave the sum of all forces in ``state.point_force``."""
    inputs = [model.constants, model.numbers(1.0, 1.0, 1.0), state.points]
    outputs = [state.samples, state.segment_pull, state.segment_block]
    launches = [run(place_and_pull(model.quadrature_points), model.segment_count, inputs, outputs)]
    launches.append(_contact(model, state, candidates, run))
    if terms:
        launches.append(run(clear, model.point_count, [], [state.outer_force]))
        launches += [launch for term in terms for launch in term.forces(state, candidates, run)]
    launches.append(gather(model, state, point_stiffness, run))
    return launches


def gather(model: Model, state: State, point_stiffness: wp.array[Any], run: Run) -> Any:
    """Sum pulls, pushes and outer forces at the control points."""
    inputs = [model.constants, point_stiffness, state.segment_pull, state.sample_force, state.outer_force]
    return run(gather_forces, model.point_count, inputs, [state.point_force, state.stiffness])


def each_term(
    model: Model, state: State, candidates: Candidates, terms: Sequence[Term], point_stiffness: wp.array[Any]
) -> Iterator[str]:
    """Leave the force of one term after the other in ``state.point_force``; the samples must be placed."""
    kernel = place_and_pull(model.quadrature_points)
    _clear_forces(state)
    for place, name in enumerate(("stretch", "length", "bend")):
        if model.stiffness[:, place].any():
            inputs = [model.constants, model.numbers(*np.eye(3)[place]), state.points]
            model.launch(kernel, model.segment_count, inputs, [state.samples, state.segment_pull, state.segment_block])
            gather(model, state, point_stiffness, model.launch)
            yield name
    state.segment_pull.zero_()
    if model.stiffness[:, CONTACT].any():
        _contact(model, state, candidates, model.launch)
        gather(model, state, point_stiffness, model.launch)
        yield "contact"
    for term in terms:
        _clear_forces(state)
        term.forces(state, candidates, model.launch)
        gather(model, state, point_stiffness, model.launch)
        yield term.name


def energies(model: Model, state: State, candidates: Candidates, terms: Sequence[Term]) -> dict[str, float]:
    """Energy of each term [erg]; the samples must be placed."""
    sums = Sums(BASE_TERMS, model.largest_cell, model.cell_count, model.device)
    sum_energies(model, state, candidates, sums)
    found = {name: float(parts.sum()) for name, parts in sums.read().items()}
    return found | {term.name: term.energy(state, candidates) for term in terms}


def sum_energies(model: Model, state: State, candidates: Candidates, sums: Sums) -> None:
    """Ask for the energies of the terms that every relaxation has."""
    stretch, length, bend = (model.empty(model.segment_count) for _ in range(3))
    inputs = [model.constants, state.points]
    model.launch(internal_energies, model.segment_count, inputs, [stretch, length, bend])
    contact = model.empty(model.sample_count)
    inputs = [model.constants, state.samples, candidates.count, candidates.lists]
    model.launch(contact_energies, model.sample_count, inputs, [contact])
    for name, part in (("stretch", stretch), ("length", length), ("bend", bend)):
        sums.add(name, part, model.cell_segments)
    sums.add("contact", contact, model.cell_samples)


@wp.kernel(module="unique")
def clear(
    # state out
    vectors: wp.array[Any],
) -> None:
    """Set an array to zero, in a recorded launch."""
    i = wp.tid()
    vectors[i] = type(vectors[0])()


def _contact(model: Model, state: State, candidates: Candidates, run: Run) -> Any:
    inputs = [model.constants, state.samples, candidates.count, candidates.lists]
    kernel = contact_forces(model.scalar, 4 if model.device.is_cuda else 1)
    return run(kernel, model.sample_count, inputs, [state.sample_force, state.sample_block])


def _clear_forces(state: State) -> None:
    state.segment_pull.zero_()
    state.sample_force.zero_()
    state.outer_force.zero_()
