# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Which terms a relaxation has, and their forces and energies on the device."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np
import warp as wp

from stitchmesh.compute.captured import ZeroArray
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.reduction import Sums
from stitchmesh.yarnrelax.collision.narrow_phase import Candidates
from stitchmesh.yarnrelax.energies.contact import contact_energies, contact_forces
from stitchmesh.yarnrelax.energies.gather import gather_forces
from stitchmesh.yarnrelax.energies.segment_forces import samples_and_segment_forces, segment_energies
from stitchmesh.yarnrelax.energies.term import Launcher, Term
from stitchmesh.yarnrelax.model.constants import CONTACT, Model
from stitchmesh.yarnrelax.model.state import State

BASE_TERMS = 4
"""Stretch, length, bending and contact."""


def force_launches(
    model: Model,
    state: State,
    candidates: Candidates,
    terms: Sequence[Term],
    point_stiffness: wp.array[Any],
    launcher: Launcher,
) -> list[Any]:
    """Place the samples, then leave the sum of all forces in ``state.force``."""
    launches = [_place_and_pull(model, state, (1.0, 1.0, 1.0), launcher)]
    launches.append(_contact(model, state, candidates, launcher))
    if terms:
        launches.append(launcher(clear, model.point_count, [], [state.external_force]))
        launches += [launch for term in terms for launch in term.forces(state, candidates, launcher)]
    launches.append(gather(model, state, point_stiffness, launcher))
    return launches


def gather(model: Model, state: State, point_stiffness: wp.array[Any], launcher: Launcher) -> Any:
    """Sum pulls, pushes and outer forces at the control points."""
    return launcher(gather_forces, model.point_count, [model.constants, point_stiffness, state.arrays], [])


def each_term(
    model: Model, state: State, candidates: Candidates, terms: Sequence[Term], point_stiffness: wp.array[Any]
) -> Iterator[str]:
    """Leave the force of one term after the other in ``state.force``; the samples must be placed."""
    launches = term_launches(model, state, candidates, terms, point_stiffness, model.prepare)
    for name, own in launches.items():
        for launch in own:
            launch.launch()
        yield name


def term_launches(
    model: Model,
    state: State,
    candidates: Candidates,
    terms: Sequence[Term],
    point_stiffness: wp.array[Any],
    launcher: Launcher,
) -> dict[str, list[Any]]:
    """Of each term what leaves its force in ``state.force``, in this order; the samples must be placed."""
    result: dict[str, list[Any]] = {}
    of_pairs = [state.sample_force, state.sample_virial, state.external_force]
    for place, name in enumerate(("stretch", "length", "bend")):
        if model.stiffness[:, place].any():
            result[name] = [] if result else _cleared(of_pairs)
            result[name].append(_place_and_pull(model, state, np.eye(3)[place], launcher))
            result[name].append(gather(model, state, point_stiffness, launcher))
    of_segments = [state.leg_force, state.segment_virial]
    if model.stiffness[:, CONTACT].any():
        result["contact"] = _cleared([*of_segments, state.external_force])
        result["contact"].append(_contact(model, state, candidates, launcher))
        result["contact"].append(gather(model, state, point_stiffness, launcher))
    for number, term in enumerate(terms):
        own = _cleared([*of_segments, *of_pairs])
        own += [*term.forces(state, candidates, launcher), gather(model, state, point_stiffness, launcher)]
        result[term.name if term.name not in result else f"{term.name} {number}"] = own
    return result


def energies(model: Model, state: State, candidates: Candidates, terms: Sequence[Term]) -> dict[str, float]:
    """Energy of each term [erg]; the samples must be placed."""
    sums = Sums(BASE_TERMS, model.largest_cell, model.cell_count, model.device)
    energy_launches(model, state, candidates, sums, model.launch)
    found = {name: float(parts.sum()) for name, parts in sums.read().items()}
    return found | {term.name: term.energy(state, candidates) for term in terms}


def energy_launches(model: Model, state: State, candidates: Candidates, sums: Sums, launcher: Launcher) -> list[Any]:
    """Ask for the energies of the terms that every relaxation has; the samples must be placed."""
    segments, contact = [model.empty(model.segment_count) for _ in range(3)], model.empty(model.sample_count)
    inputs = [model.constants, state.samples, candidates.count, candidates.lists]
    launches = [
        launcher(segment_energies, model.segment_count, [model.constants, state.points], segments),
        launcher(contact_energies, model.sample_count, inputs, [contact]),
    ]
    for name, part in zip(("stretch", "length", "bend"), segments, strict=True):
        launches.append(sums.add(name, part, model.cell_segments, launcher))
    return [*launches, sums.add("contact", contact, model.cell_samples, launcher)]


@kernel
def clear(
    # state out
    vectors: wp.array[Any],
) -> None:
    """Set an array to zero, in a launch like others."""
    i = wp.tid()
    vectors[i] = type(vectors[0])()


def _place_and_pull(model: Model, state: State, terms: Iterable[float], launcher: Launcher) -> Any:
    kernel = samples_and_segment_forces(model.quadrature_points, state.cell_relaxes)
    return launcher(kernel, model.segment_count, [model.constants, model.numbers(*terms), state.arrays], [])


def _contact(model: Model, state: State, candidates: Candidates, launcher: Launcher) -> Any:
    kernel = contact_forces(model.scalar, 4 if model.device.is_cuda else 1, state.cell_relaxes)
    return launcher(kernel, model.sample_count, [model.constants, candidates.count, candidates.lists, state.arrays], [])


def _cleared(arrays: Sequence[wp.array[Any]]) -> list[Any]:
    """Set arrays to zero."""
    return [ZeroArray(array) for array in arrays if len(array)]
