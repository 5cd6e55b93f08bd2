# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Which terms a relaxation has, and their forces and energies on the device."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import warp as wp

from stitchmesh.yarnrelax.candidates import Candidates
from stitchmesh.yarnrelax.contact import add_contact_forces, contact_energies, nearest_arcs, place_samples
from stitchmesh.yarnrelax.internal import internal_energies, internal_forces
from stitchmesh.yarnrelax.length import add_length_forces, length_energies
from stitchmesh.yarnrelax.model import Model
from stitchmesh.yarnrelax.motion import gather_forces
from stitchmesh.yarnrelax.reduction import minimum, ordered_sum
from stitchmesh.yarnrelax.state import State

Run = Callable[[wp.Kernel, int, list[Any], list[Any]], Any]
"""``Model.launch`` or ``Model.record``."""


def sample(model: Model, state: State, run: Run) -> Any:
    """Place the contact samples on the curves."""
    return run(place_samples, model.segment_count, [model.constants, state.points], [state.samples, state.sample_reach])


def internal(model: Model, state: State, run: Run, *, k_len: float, k_bend: float) -> Any:
    """Set the segments' forces to those of stretch and bending."""
    inputs = [model.constants, model.number(k_len), model.number(k_bend), state.points]
    return run(internal_forces, model.segment_count, inputs, [state.segment_force])


def length(model: Model, state: State, run: Run) -> Any:
    """Add the length penalty to the segments' forces."""
    return run(add_length_forces, model.segment_count, [model.constants, state.points], [state.segment_force])


def contact(model: Model, state: State, candidates: Candidates, run: Run, *, watch: float) -> Any:
    """Add contact to the segments' forces; clearances are exact where they are below ``watch`` [cm]."""
    inputs = [model.constants, model.number(watch), state.points, state.samples, state.sample_reach,
              candidates.count, candidates.lists]  # fmt: skip
    outputs = [state.segment_force, state.segment_stiffness, state.segment_clearance]
    return run(add_contact_forces, model.segment_count, inputs, outputs)


def gather(model: Model, state: State, run: Run) -> Any:
    """Sum the segments' forces at the control points."""
    return run(gather_forces, model.point_count, [model.constants, state.segment_force], [state.point_force])


def each_term(model: Model, state: State, candidates: Candidates) -> Iterator[str]:
    """Leave the force of one term after the other in ``state.point_force``; the samples must be placed."""
    material, run = model.material, model.launch
    for name, k_len, k_bend in (("stretch", material.k_len, 0.0), ("bend", 0.0, material.k_bend)):
        if k_len + k_bend > 0.0:
            internal(model, state, run, k_len=k_len, k_bend=k_bend)
            gather(model, state, run)
            yield name
    if material.k_length > 0.0:
        state.segment_force.zero_()
        length(model, state, run)
        gather(model, state, run)
        yield "length"
    if material.k_contact > 0.0:
        state.segment_force.zero_()
        contact(model, state, candidates, run, watch=0.0)
        gather(model, state, run)
        yield "contact"


def energies(model: Model, state: State, candidates: Candidates) -> dict[str, float]:
    """Energy of each term [erg]; the samples must be placed."""
    stretch, bend = model.empty(model.segment_count), model.empty(model.segment_count)
    inputs = [model.constants, state.points]
    model.launch(internal_energies, model.segment_count, inputs, [stretch, bend])
    result = {"stretch": ordered_sum(stretch), "length": 0.0, "bend": ordered_sum(bend)}
    if model.material.k_length > 0.0:
        model.launch(length_energies, model.segment_count, inputs, [stretch])
        result["length"] = ordered_sum(stretch)
    energy = model.empty(model.sample_count)
    inputs = [model.constants, state.samples, candidates.count, candidates.lists]
    model.launch(contact_energies, model.sample_count, inputs, [energy])
    result["contact"] = ordered_sum(energy)
    return result


def smallest_distance(model: Model, state: State, candidates: Candidates) -> float:
    """Smallest distance of yarns over their radius, 2 where none touch; as exact as the arcs' sag is small."""
    nearest = model.empty(model.sample_count)
    inputs = [model.constants, state.points, state.samples, candidates.count, candidates.lists]
    model.launch(nearest_arcs, model.sample_count, inputs, [nearest])
    return minimum(nearest)
