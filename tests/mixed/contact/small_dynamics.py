# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Implicit Euler for a few vertices on the host, for the tests of contact."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse.linalg import LinearOperator, cg

from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mixed.mixed_vector import MixedVector
from stitchmesh.mixed.term import Term
from tests.mixed.contact.sheets import Sheets, forces_of, launcher, state_of

ROUNDS = 60
"""Most iterations of a step."""


class Springs(Term):
    """Springs along all sides of the triangles, on the host: the simplest cloth."""

    name = "springs"

    def __init__(self, cloth: Sheets, stiffness: float) -> None:
        sides = np.concatenate([cloth.triangles[:, [k, (k + 1) % 3]] for k in range(3)])
        self.ends: IntArray = np.unique(np.sort(sides, axis=1), axis=0)
        self.length = np.linalg.norm(np.diff(cloth.vertices[self.ends], axis=1)[:, 0], axis=1)
        self.stiffness = stiffness

    def energy(self, state: MixedVector) -> float:
        _apart, length = self._apart(state)
        return 0.5 * self.stiffness * float(((length - self.length) ** 2).sum())

    def forces(self, state: MixedVector, force: MixedVector, launcher: Any) -> list[Any]:
        apart, length = self._apart(state)
        self._add(apart * (self.stiffness * (1.0 - self.length / length))[:, None], force)
        return []

    def linearize(self, state: MixedVector, launcher: Any) -> list[Any]:
        apart, length = self._apart(state)
        self.direction = apart / length[:, None]
        return []

    def products(self, direction: MixedVector, product: MixedVector, launcher: Any) -> list[Any]:
        change, _ = self._apart(direction)
        along = np.einsum("ed,ed->e", self.direction, change) * self.stiffness
        self._add(-self.direction * along[:, None], product)
        return []

    def _apart(self, state: MixedVector) -> tuple[FloatArray, FloatArray]:
        v = state.numpy()[0]
        apart = v[self.ends[:, 1]] - v[self.ends[:, 0]]
        return apart, np.linalg.norm(apart, axis=1)

    def _add(self, pull: FloatArray, target: MixedVector) -> None:
        v = target.numpy()[0]
        np.add.at(v, self.ends[:, 0], pull)
        np.add.at(v, self.ends[:, 1], -pull)
        target.values.assign(v.ravel())


@dataclass
class Motion:
    """Vertices in motion."""

    vertices: FloatArray
    velocity: FloatArray
    mass: FloatArray
    gravity: FloatArray
    terms: Sequence[Term]
    time: float = 0.0

    def run(self, steps: int, time_step: float) -> None:
        """Several steps of implicit Euler."""
        for _ in range(steps):
            self.step(time_step)

    def step(self, h: float) -> None:
        """One step: a minimum of the kinetic and potential energy."""
        start = state_of(self.vertices)
        for term in self.terms:
            term.begin_step(start, self.time, h)
        aim = self.vertices + h * self.velocity + h * h * self.gravity
        end = self._minimum(aim, self.mass[:, None] / (h * h))
        self.time += h
        for term in self.terms:
            term.end_step(state_of(end), self.time, h)
        self.vertices, self.velocity = end, (end - self.vertices) / h

    def _minimum(self, aim: FloatArray, inertia: FloatArray) -> FloatArray:
        x = self.vertices.copy()
        enough = 1e-9 * float(np.abs(inertia).max())  # 1e-9 cm of every vertex
        for _ in range(ROUNDS):
            state = state_of(x)
            slope = inertia * (x - aim) - sum(forces_of(term, state) for term in self.terms)
            if np.abs(slope).max() < enough:
                return x
            direction = self._direction(state, slope, inertia)
            move = state_of(direction)
            part = min(1.0, *(term.step_limit(state, move) for term in self.terms))
            x = self._searched(x, direction, part, aim, inertia)
        return x

    def _direction(self, state: MixedVector, slope: FloatArray, inertia: FloatArray) -> FloatArray:
        for term in self.terms:
            term.exact = 0.0
            term.linearize(state, launcher())

        def times(flat: FloatArray) -> FloatArray:
            product, direction = state.like(), state_of(flat.reshape(-1, 3))
            for term in self.terms:
                term.products(direction, product, launcher())
            return (product.numpy()[0] + inertia * flat.reshape(-1, 3)).ravel()

        operator = LinearOperator((slope.size, slope.size), matvec=times, dtype=np.float64)
        return cg(operator, -slope.ravel(), rtol=1e-8, maxiter=500)[0].reshape(-1, 3)

    def _searched(
        self, x: FloatArray, direction: FloatArray, part: float, aim: FloatArray, inertia: FloatArray
    ) -> FloatArray:
        def total(at: FloatArray) -> float:
            own = 0.5 * float((inertia * (at - aim) ** 2).sum())
            return own + sum(term.energy(state_of(at)) for term in self.terms)

        before = total(x)
        while part > 1e-6 and total(x + part * direction) > before + 1e-12 * abs(before):
            part *= 0.5
        return x + part * direction
