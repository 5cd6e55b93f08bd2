# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Captured energies, forces and limits are those of the terms, follow the contents of vectors, and are forgotten."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from stitchmesh.mixed.dynamics.mixed_system import RepeatedLaunches
from stitchmesh.mixed.enrichment.region import region_around
from stitchmesh.simulation.captures import MOST, Captures
from tests.mixed.dynamics.scene import CPU, Scene, spring_scene
from tests.mixed.patch import square_patch

PATCH = square_patch(4, 3)


@dataclass
class Arrays:
    """Stands for a system whose arrays are replaced."""

    generation: int = 0


def scene() -> Scene:
    return spring_scene(PATCH, region_around(*PATCH.layout, PATCH.near((0.5, 0.5), 0.2)))


def test_energies_and_forces_are_those_of_the_terms_also_after_the_state_has_changed():
    system, state = scene().system, scene().at_rest()
    force, expected = system.zeros(), system.zeros()
    random = np.random.default_rng(1)
    for _ in range(3):
        state.values.assign(state.values.numpy() + random.normal(scale=0.05, size=len(state.values)))
        energies = system.energies(state)
        for term in system.terms:
            assert energies[term.name] == pytest.approx(term.energy(state), rel=1e-13)  # sums in another order
        system.set_forces(state, force)
        expected.values.zero_()
        for term in system.terms:
            term.forces(state, expected, system.launch)
        assert np.array_equal(force.values.numpy(), expected.values.numpy())


def test_a_sequence_is_made_once_for_the_same_vectors():
    arrays, made = Arrays(), []
    repeated = RepeatedLaunches(CPU, Captures(arrays, lambda owner: owner.generation))
    vector, other = scene().system.zeros(), scene().system.zeros()
    for given in (vector, other, vector, other):
        repeated.run("nothing", (given,), lambda _run, _sums: made.append(1) or [])
    assert len(made) == 2
    arrays.generation += 1
    repeated.run("nothing", (vector,), lambda _run, _sums: made.append(1) or [])
    assert len(made) == 3


def test_the_sequence_captured_first_is_forgotten_first():
    arrays, made = Arrays(), []
    repeated = RepeatedLaunches(CPU, Captures(arrays, lambda owner: owner.generation))
    for name in (*range(MOST + 1), MOST, 0):
        repeated.run(name, (), lambda _run, _sums: made.append(1) or [])
    assert len(made) == MOST + 2
