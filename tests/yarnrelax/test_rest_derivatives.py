# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Derivatives of a cell at rest: factors of inputs are changed inputs, and closed forms of a straight yarn."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.compute.device import device_named
from stitchmesh.errors import ParameterError, SolverError
from stitchmesh.lattice import Lattice
from stitchmesh.quality import PRESETS
from stitchmesh.simulation.dead_load import Gravity
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial
from stitchmesh.yarnrelax.energies.confinement import Confinement
from stitchmesh.yarnrelax.energies.term import INPUTS
from stitchmesh.yarnrelax.relaxation_inputs import RelaxationInputs
from stitchmesh.yarnrelax.rest_derivatives import ForcesByInput, polished, rest_derivatives
from tests.yarnrelax.stockinette import periodic_patch, periodic_set

LEAF = YarnMaterial.named("leaf")
DOUBLE = replace(PRESETS["draft"], precision="float64")
HELD = RelaxCell(None, None, shear=False)
LENGTH, SEGMENTS = 2.0, 16


def inputs_of(yarns: YarnSet, cell: RelaxCell, *, planes: float | None = None, material: YarnMaterial = LEAF):
    terms = [] if planes is None else [Confinement(planes)]
    return RelaxationInputs(yarns, material, DOUBLE, device_named("cpu"), terms, cell=cell)


def straight_yarn(stretch: float) -> YarnSet:
    """A straight yarn along the courses of a cell in which it touches nothing."""
    points = np.zeros((SEGMENTS, 3))
    points[:, 0] = np.arange(SEGMENTS) * stretch * LENGTH / SEGMENTS
    lattice = Lattice(np.array([[stretch * LENGTH, 0.0, 0.0], [0.3, 1.0, 0.0]]))
    none, step = np.zeros(SEGMENTS, dtype=np.int64), np.array([[1, 0]])
    yarns = periodic_set(points, np.array([0, SEGMENTS]), step, lattice, 0.05, none, none)
    return replace(yarns, rest_length=np.full(SEGMENTS, LENGTH / SEGMENTS))


def changed(inputs: RelaxationInputs, name: str, factor: float) -> RelaxationInputs:
    yarns, material = inputs.yarns, inputs.material
    if name == "loop_length":
        return replace(inputs, yarns=replace(yarns, rest_length=factor * yarns.rest_length))
    if name == "radius":
        return replace(inputs, yarns=yarns.with_radius(factor * yarns.radius))
    if name == "planes":
        planes = [Confinement(factor * term.half_thickness) for term in inputs.terms if isinstance(term, Confinement)]
        return replace(inputs, terms=planes)
    return replace(inputs, material=replace(material, **{name: factor * getattr(material, name)}))


@pytest.mark.parametrize("name", INPUTS)
def test_forces_with_a_factor_of_an_input_are_those_of_the_changed_input(name: str) -> None:
    yarns = periodic_patch(2, 1)
    crowded = replace(yarns, rest_length=0.97 * yarns.rest_length).with_radius(1.05 * yarns.radius)
    inputs = inputs_of(crowded, RelaxCell(20.0, 10.0), planes=0.04)
    simulation = inputs.start()
    before = ForcesByInput(simulation).at(name, 1.0)
    found = ForcesByInput(simulation).at(name, 1.01)
    other = changed(inputs, name, 1.01).start()
    expected = ForcesByInput(other).now()
    count = 3 * simulation.model.point_count
    expected[:count] *= simulation.model.unit / other.model.unit  # erg over the unit of the other model
    size = np.abs(expected).max()
    np.testing.assert_allclose(found, expected, atol=1e-12 * size)  # rounding of sums
    assert np.abs(found - before).max() > 1e-6 * size  # those of planes are small
    np.testing.assert_array_equal(ForcesByInput(simulation).at(name, 1.0), before)


def test_a_straight_yarn_is_stretched_by_a_load_as_its_segments_are() -> None:
    """The energy is EA L / 2 (l / L - 1)^2 - P l, so that l = L (1 + e) with e = P / EA."""
    stretch, total = 0.05, LEAF.k_len + LEAF.k_length
    load = LEAF.axial_stiffness * stretch
    loop = polished(inputs_of(straight_yarn(1.0), RelaxCell(load, None, shear=False)))
    found, lattice = rest_derivatives(loop.simulation), loop.simulation.good_yarns().lattice
    assert lattice is not None and lattice.periods[0, 0] == pytest.approx(LENGTH * (1.0 + stretch), rel=1e-9)
    by_stiffness = -stretch / (1.0 + stretch) / total
    expected = dict.fromkeys(INPUTS, 0.0) | {
        "loop_length": 1.0,
        "k_len": by_stiffness * LEAF.k_len,
        "k_length": by_stiffness * LEAF.k_length,
    }
    for name, strains in found.strains.items():  # rounding over the step of the differences
        np.testing.assert_allclose(strains, [expected[name], 0.0, 0.0], atol=1e-8)
    # by the strain of the stretched cell; loads are linear in it, and the yarn resists in no other way
    along = LEAF.axial_stiffness * LENGTH * (1.0 + stretch) ** 2
    np.testing.assert_allclose(found.stiffness, np.diag([along, 0.0, 0.0]), atol=1e-8 * along)
    assert found.negative_eigenvalues == 0


@pytest.mark.parametrize(("short", "modes"), [(0.999, 0), (0.97, 2)])
def test_a_straight_yarn_buckles_in_as_many_ways_as_euler_says(short: float, modes: int) -> None:
    """A wave of wave number q grows where the yarn pushes with more than EI q^2, to two sides and in two phases.

    With the stretch s the force is EA (1 - s), and EI is 2 k_bend / s, because |y'| is s times
    the rest length and its place is stretched too.
    """
    inputs = inputs_of(straight_yarn(short), HELD)
    push = LEAF.axial_stiffness * (1.0 - short)
    wave = 2.0 * np.pi * np.arange(1, SEGMENTS // 2) / (short * LENGTH)
    assert np.count_nonzero(push > 2.0 * LEAF.k_bend / short * wave**2) == modes
    simulation = inputs.start()
    assert np.abs(simulation.state.force.numpy()).max() < 1e-9
    found = rest_derivatives(simulation)
    assert found.negative_eigenvalues == 4 * modes
    assert all(not strains.any() for strains in found.strains.values())


def test_yarns_that_are_not_at_rest_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("stitchmesh.yarnrelax.rest_derivatives.MOST_ITERATIONS", 20)
    with pytest.raises(SolverError, match=r"come to a residual of .*; expected 1e-07; relax them with another quality"):
        polished(inputs_of(periodic_patch(1, 1), RelaxCell()))


def test_a_term_without_derivatives_is_refused() -> None:
    inputs = replace(inputs_of(periodic_patch(1, 1), RelaxCell()), terms=[Gravity()])
    with pytest.raises(ParameterError, match="got the term gravity, which has none; leave it out"):
        ForcesByInput(inputs.start())
