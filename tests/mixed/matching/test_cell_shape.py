# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Shapes of a periodic fabric: flat, stretched, rolled."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.mixed.matching.cell_equilibrium import (
    PARAMETERS,
    CellShape,
    place_nodes,
    shape_derivatives,
    turned_back,
)

RANDOM = np.random.default_rng(4)
FLAT, MOVED = RANDOM.normal(size=(7, 2)), 0.1 * RANDOM.normal(size=(7, 3))
ROLLED = CellShape(1.1, 0.9, 0.05, 0.6, 0.4)


def test_a_flat_shape_is_affine() -> None:
    shape = CellShape(1.2, 0.8, 0.1)
    expected = np.column_stack([FLAT @ [[1.2, 0.1], [0.1, 0.8]], np.zeros(7)]) + MOVED
    assert np.abs(place_nodes(shape, FLAT, MOVED) - expected).max() < 1e-15  # rounding of sums of numbers near 1


@pytest.mark.parametrize("direction", [0.0, 0.7, np.pi / 2.0])
def test_a_roll_keeps_lengths_and_has_its_radius(direction: float) -> None:
    shape = CellShape(curvature=0.5, direction=direction)
    along = np.array([np.cos(direction), np.sin(direction)])
    places = place_nodes(shape, np.linspace(0.0, 3.0, 2000)[:, None] * along, np.zeros((2000, 3)))
    length = np.linalg.norm(np.diff(places, axis=0), axis=1).sum()
    assert abs(length - 3.0) < 1e-6  # chords of 1.5 mm on a radius of 2 cm are short by 2e-8 of their length
    assert np.abs(np.linalg.norm(places - [0.0, 0.0, 2.0], axis=1) - 2.0).max() < 1e-14


def test_displacements_turn_with_the_roll() -> None:
    shape = CellShape(curvature=0.5)
    up = place_nodes(shape, FLAT, np.tile([0.0, 0.0, 0.3], (7, 1)))
    distance = np.linalg.norm(up[:, [0, 2]] - [0.0, 2.0], axis=1)
    assert np.abs(distance - 1.7).max() < 1e-14  # rounding


def test_derivatives_are_those_of_differences() -> None:
    found, step = shape_derivatives(ROLLED, FLAT, MOVED), 1e-6
    for k, name in enumerate(PARAMETERS):
        after, before = (place_nodes(ROLLED.changed(name, sign * step), FLAT, MOVED) for sign in (1.0, -1.0))
        # error of the differences: step^2 times third derivatives, and 1e-16 / step of rounding
        assert np.abs((after - before) / (2.0 * step) - found[k]).max() < 1e-8


def test_forces_turn_back_as_displacements_turn() -> None:
    push, change = RANDOM.normal(size=(7, 3)), RANDOM.normal(size=(7, 3))
    moved = place_nodes(ROLLED, FLAT, MOVED + change) - place_nodes(ROLLED, FLAT, MOVED)
    assert abs((push * moved).sum() - (turned_back(ROLLED, FLAT, push) * change).sum()) < 1e-13  # rounding
