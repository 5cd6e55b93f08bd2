# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The blocks of the preconditioner bound the curvature of the energy, term by term."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import block_diag, eigh

from stitchmesh.compute.device import device_named
from stitchmesh.quality import PRESETS
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial
from stitchmesh.yarnrelax.energies import evaluation
from stitchmesh.yarnrelax.simulation import YarnSimulation
from tests.yarnrelax.stockinette import flat_patch

MATERIAL = YarnMaterial.named("stitchmesh")
STIFFNESSES = {"stretch": "k_len", "length": "k_length", "bend": "k_bend", "contact": "k_contact"}
PATCH = flat_patch(2, 1)


def shaken(noise: float) -> YarnSet:
    """The patch whose points are displaced, which stretches and compresses its segments."""
    moved = np.random.default_rng(3).normal(scale=noise, size=PATCH.points.shape)
    return replace(PATCH, points=PATCH.points + moved)


STRAINED = shaken(0.03)
TAUT = replace(PATCH, rest_length=0.8 * PATCH.rest_length)
CURLED = replace(PATCH, natural_curvature=np.full(len(PATCH.points), 12.0))


def only(*terms: str) -> YarnMaterial:
    return replace(MATERIAL, **{name: 0.0 for term, name in STIFFNESSES.items() if term not in terms})


def started(yarns: YarnSet, material: YarnMaterial) -> YarnSimulation:
    quality = replace(PRESETS["draft"], precision="float64")
    simulation = YarnSimulation.start(yarns, material, quality, device_named("cpu"))
    force_at(simulation, simulation.state.points.numpy().copy())
    return simulation


def force_at(simulation: YarnSimulation, points: np.ndarray) -> np.ndarray:
    model, state = simulation.model, simulation.state
    state.points.assign(points)
    evaluation.force_launches(model, state, simulation.candidates, (), simulation.point_stiffness, model.launch)
    return state.force.numpy().copy()


def hessian(simulation: YarnSimulation) -> np.ndarray:
    """Second derivatives by central differences of the forces: truncation 1e-12, rounding 1e-10 of them."""
    start, step = simulation.state.points.numpy().copy(), 1e-6
    shifts = step * np.eye(start.size).reshape(-1, *start.shape)
    columns = [(force_at(simulation, start - s) - force_at(simulation, start + s)).ravel() / (2 * step) for s in shifts]
    force_at(simulation, start)
    return (np.array(columns) + np.array(columns).T) / 2


def blocks(simulation: YarnSimulation) -> np.ndarray:
    """The blocks whose inverses are the preconditioner, shape (N, 3, 3)."""
    launches = [launch for launch in simulation.iterations.launches if launch.kernel.key == "find_preconditioner"]
    launches[0].launch()
    rows = simulation.state.preconditioner.numpy()
    return np.linalg.inv(rows[:, [0, 3, 4, 3, 1, 5, 4, 5, 2]].reshape(-1, 3, 3))


def largest_ratio(curvature: np.ndarray, bound: np.ndarray) -> float:
    """Largest v.Hv / v.Bv. A millionth of the mean diagonal is added to B, because B can be singular."""
    whole = block_diag(*bound)
    least = 1e-6 * np.trace(whole) / len(whole) * np.eye(len(whole))
    return float(eigh(curvature, whole + least, eigvals_only=True)[-1])


@pytest.mark.parametrize(
    ("term", "bound"),
    [
        # The blocks use the mean direction of the yarn in each segment; here it changes by up to 1 rad in a segment.
        ("stretch", 1.3),
        ("length", 1.2),
        # A row sum counts each pair of samples from both samples. The negative curvature of a pair across its contact
        # normal is at most as large as its positive curvature along the normal.
        ("contact", 1.0),
    ],
)
def test_blocks_bound_the_curvature_of_each_term(term: str, bound: float) -> None:
    simulation = started(STRAINED, only(term))
    assert 0.1 < largest_ratio(hessian(simulation), blocks(simulation)) < bound


@pytest.mark.parametrize("yarns", [STRAINED, TAUT, CURLED], ids=["strained", "taut", "curled"])
def test_blocks_and_row_sums_bound_the_curvature_of_all_terms_together(yarns: YarnSet) -> None:
    """This includes bending. Its blocks neglect terms along the yarn, where stretch is hundreds of times stiffer."""
    simulation = started(yarns, MATERIAL)
    curvature = hessian(simulation)
    assert 0.5 < largest_ratio(curvature, blocks(simulation)) < 1.1
    rows = np.einsum("n,ij->nij", simulation.state.stiffness.numpy(), np.eye(3))
    # A plain step is 1.6 times the force over the row sum; it is stable if this ratio is below 2 / 1.6.
    assert 0.3 < largest_ratio(curvature, rows) < 1.0
