# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Bending and stretching under dead loads, compared with Euler's elastica.

A yarn with k_bend bends as a rod with flexural rigidity EI = 2 k_bend. The reference values are the elastica, solved to
six digits by shooting. The yarn is in equilibrium where its forces balance the loads. These tests find the equilibrium
with their own quasi-Newton method, which starts from the Hessian of the energy at the straight yarn; of the relaxer,
they use only the energies and the forces. Loads act on points of the curve through the spline basis. Each half of a
yarn of length 2 L is a cantilever of length L: the loads on both halves are equal, and the middle is supported.
``test_gravity`` has the heavy cantilever and the catenary.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.optimize import minimize

from stitchmesh.compute.device import device_named
from stitchmesh.compute.precision import scalar_named
from stitchmesh.yarn import YarnSet, basis
from stitchmesh.yarnrelax import YarnMaterial
from stitchmesh.yarnrelax.collision.narrow_phase import make_candidates
from stitchmesh.yarnrelax.energies import by_term, evaluation
from stitchmesh.yarnrelax.model.state import make_state
from stitchmesh.yarnrelax.model.upload import put_model

Response = Callable[[np.ndarray], tuple[float, np.ndarray]]
"""Energy [erg] and forces [dyn] at control points in the plane, shape (N, 2)."""

STIFF_LENGTH = 1e3
"""k_len for k_bend = 1 and segments of length 1: the strains P / (2 k_len) under loads of a few EI / L^2 are 1e-4."""
RADIUS = 0.5
"""The yarns touch nothing, so the radius affects only the number of contact samples: a thinner yarn gets more."""
HALF = 8
"""Segments of a cantilever. The error of cubic splines is (1 / HALF)^2 of the elastica's change in curvature."""


def straight_yarn(segments: int) -> YarnSet:
    points = np.zeros((segments + 3, 3))
    points[:, 0] = np.arange(segments + 3) - (segments + 2) / 2
    return YarnSet.from_curves([points], closed=[False], radius=RADIUS)


MATERIAL = YarnMaterial(STIFF_LENGTH, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)


def response(yarns: YarnSet) -> Response:
    """A function that returns energy and forces of a yarn without contacts; it reuses one model on the device."""
    model = put_model(
        yarns, MATERIAL, quadrature_points=5, contact_samples=1, scalar=scalar_named("float64"),
        device=device_named("cpu"),
    )  # fmt: skip
    state, no_candidates = make_state(model), make_candidates(model, 0.1)
    point_stiffness = model.empty(model.point_count)

    def respond(plane: np.ndarray) -> tuple[float, np.ndarray]:
        state.points.assign(model.to_device(np.column_stack([plane, np.zeros(len(plane))])))
        evaluation.force_launches(model, state, no_candidates, (), point_stiffness, model.launch)
        energy = sum(by_term.energies(model, state, no_candidates, ()).values())
        return energy, state.force.numpy()[:, :2] / model.unit

    return respond


def weights_at(yarns: YarnSet, segment: int, parameter: float) -> np.ndarray:
    """Spline weights of the control points for one point of the curve, shape (N,)."""
    weights = np.zeros(len(yarns.points))
    weights[yarns.segment_points[segment]] = basis(parameter)[0]
    return weights


def equilibrium(yarns: YarnSet, load: np.ndarray) -> np.ndarray:
    """Control points (x, y) at which the forces of the yarn balance a dead load [dyn], shape (N, 2)."""
    respond, count = response(yarns), len(yarns.points)

    def energy_and_gradient(flat: np.ndarray) -> tuple[float, np.ndarray]:
        stored, force = respond(flat.reshape(count, 2))
        return stored - float(load.ravel() @ flat), -force.ravel() - load.ravel()

    flat = yarns.points[:, :2].ravel()
    inverse = positive_inverse(hessian(lambda flat: energy_and_gradient(flat)[1], flat))
    options = {"hess_inv0": inverse, "gtol": 1e-5, "maxiter": 400}
    found = minimize(energy_and_gradient, flat, jac=True, method="BFGS", options=options)
    assert np.abs(found.jac).max() < 1e-3 * max(np.abs(load).max(), 1e-6), "the yarn is not in equilibrium"
    return found.x.reshape(count, 2)


def hessian(gradient: Callable[[np.ndarray], np.ndarray], flat: np.ndarray) -> np.ndarray:
    """Second derivatives of the energy by central differences of its gradient."""
    step = 1e-5 * np.eye(len(flat))
    columns = [(gradient(flat + each) - gradient(flat - each)) / 2e-5 for each in step]
    return (np.array(columns) + np.array(columns).T) / 2


def positive_inverse(matrix: np.ndarray) -> np.ndarray:
    """Inverse with all eigenvalues made positive; the initial inverse Hessian of a quasi-Newton method."""
    values, vectors = np.linalg.eigh(matrix)
    inverse = (vectors / np.maximum(np.abs(values), 1e-3)) @ vectors.T
    return (inverse + inverse.T) / 2


def drop(yarns: YarnSet, points: np.ndarray) -> float:
    """Mean height of the ends below the middle of a double cantilever, divided by the length of one half."""
    end = (weights_at(yarns, 0, 0.0) + weights_at(yarns, len(yarns.rest_length) - 1, 1.0)) / 2
    return float((weights_at(yarns, HALF, 0.0) - end) @ points[:, 1] / HALF)


def test_end_loaded_cantilever() -> None:
    """The drop over L of the elastica for P L^2 / EI = 5."""
    yarns = straight_yarn(2 * HALF)
    force = 5.0 * 2.0 / HALF**2
    last = len(yarns.rest_length) - 1
    load = np.zeros((len(yarns.points), 2))
    load[:, 1] = force * (2 * weights_at(yarns, HALF, 0.0) - weights_at(yarns, 0, 0.0) - weights_at(yarns, last, 1.0))
    assert drop(yarns, equilibrium(yarns, load)) == pytest.approx(0.713792, rel=0.01)


def test_euler_load_of_a_free_column() -> None:
    """A column compressed between two hinged ends becomes unstable at P = pi^2 EI / L^2 and not at smaller loads.

    The compressive force is a dead load along the column; the second derivatives of its potential are zero. The test
    compresses the straight rod until it carries P. The rod buckles where the smallest eigenvalue of the Hessian of its
    energy vanishes.
    """
    segments = 2 * HALF
    yarns = straight_yarn(segments)
    critical = np.pi**2 * 2.0 / segments**2
    below, above = (smallest_eigenvalue(yarns, share * critical) for share in (0.99, 1.01))
    assert below > 0.0 > above


def smallest_eigenvalue(yarns: YarnSet, compression: float) -> float:
    """Smallest eigenvalue of the Hessian for displacements across a compressed column whose ends stay on its axis.

    E_len = k_len (1 - lambda)^2 for a segment of length 1, so a compressive force P shortens each by P / (2 k_len).
    """
    count, respond = len(yarns.points), response(yarns)
    line = yarns.points * (1.0 - compression / (2 * STIFF_LENGTH))

    def across(height: np.ndarray) -> np.ndarray:
        return -respond(np.column_stack([line[:, 0], height]))[1][:, 1]

    curvature = hessian(across, np.zeros(count))
    held = np.stack([weights_at(yarns, 0, 0.0), weights_at(yarns, len(yarns.rest_length) - 1, 1.0)])
    free = np.linalg.svd(held)[2][2:].T
    return float(np.linalg.eigvalsh(free.T @ curvature @ free)[0])
