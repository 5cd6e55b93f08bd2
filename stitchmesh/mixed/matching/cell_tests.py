# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The tests of ``loading_curve`` on a cell of crossing yarns.

Stretched and sheared cells are in equilibrium. A bent cell keeps the places of its nodes in the fabric, and its sizes
adapt to the tension with which it is laid out, so that the chords of yarn between nodes keep their strain. For straight
yarns this is the equilibrium too. The loops of a knit could turn towards their curl under nearly no moment; the
resistance is then that of a knit which its neighbourhood keeps flat.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.matching.cell_equilibrium import CellSolver, CellState
from stitchmesh.mixed.matching.cell_shape import CellShape
from stitchmesh.mixed.matching.loading_curve import BENDS, STRETCHES, TESTS, LoadingCurve
from stitchmesh.progress import Progress, no_progress

Numbers = NDArray[np.float64]
STAGE = "match"
"""Name of the stage in reports of progress."""
FREE = ("stretch_course", "stretch_wale", "skew")
"""Parameters of the shape that are free while a fabric is bent."""
DIRECTION = {"bend course": 0.0, "bend wale": np.pi / 2.0, "bend across": np.pi / 4.0}
"""Angle between the courses and the direction along which the fabric is curved [rad]."""


def run_tests(
    solver: CellSolver,
    strains: Iterable[float],
    curvatures: Iterable[float],
    progress: Progress = no_progress,
) -> tuple[LoadingCurve, ...]:
    """Run all tests.

    Args:
        solver: the cell.
        strains: strains of stretch tests and changes of angle of shear tests; 0 is added.
        curvatures: curvatures of bending tests [1/cm]; 0 is added.
        progress: called with the completed part and the name of each test before it runs.

    Raises:
        ParameterError: a number is not finite, a strain is -1 or less, or there are no strains or no curvatures.
        SolverError: a state finds no equilibrium.
    """
    stretched, bent = _with_zero("strains", strains), _with_zero("curvatures", curvatures)
    if stretched[0] <= -1.0:
        raise ParameterError(f"strains: got {stretched[0]:g}; expected numbers above -1")
    curves = []
    for number, test in enumerate(TESTS):
        progress(STAGE, number / len(TESTS), test)
        curves.append(_run(solver, test, bent if test in BENDS else stretched))
    return tuple(curves)


def _with_zero(name: str, values: Iterable[float]) -> Numbers:
    """Values in ascending order with 0 among them."""
    given = np.unique(np.array([0.0, *values], dtype=np.float64))
    if len(given) < 2 or not np.isfinite(given).all():
        raise ParameterError(
            f"{name}: got {given[given != 0.0].tolist()}; expected at least one finite number beside 0"
        )
    return given


def _run(solver: CellSolver, test: str, strains: Numbers) -> LoadingCurve:
    """One test; each state begins at the one nearer to strain 0."""
    zero = int(np.flatnonzero(strains == 0.0)[0])
    flat = solver.equilibrium(CellShape(direction=DIRECTION.get(test, 0.0)))
    states = {zero: flat}
    for order, back in ((range(zero + 1, len(strains)), -1), (range(zero - 1, -1, -1), 1)):
        for k in order:
            states[k] = _state(solver, test, float(strains[k]), states[k + back], flat.slopes[:3])
    values = np.array([_tensions(test, float(strains[k]), states[k].slopes) for k in range(len(strains))])
    return LoadingCurve.of(test, strains, values[:, 0], values[:, 1])


def _state(solver: CellSolver, test: str, strain: float, before: CellState, load: Numbers) -> CellState:
    """The equilibrium of a test at a strain."""
    if test in STRETCHES:
        course, wale = (strain if test in (axis, "both") else 0.0 for axis in ("course", "wale"))
        return solver.equilibrium(CellShape(1.0 + course, 1.0 + wale), before.moved)
    if test == "shear":
        return solver.equilibrium(
            CellShape(np.cos(strain / 2.0), np.cos(strain / 2.0), np.sin(strain / 2.0)), before.moved
        )
    return solver.equilibrium(replace(before.shape, curvature=strain), before.moved, free=FREE, load=load, held=True)


def _tensions(test: str, strain: float, slopes: Numbers) -> tuple[float, float]:
    """Tension and side tension of a state."""
    if test == "shear":
        along = np.array([-np.sin(strain / 2.0), -np.sin(strain / 2.0), np.cos(strain / 2.0)]) / 2.0
        return float(along @ slopes[:3]), 0.0
    if test in BENDS:
        return float(slopes[3]), 0.0
    return (slopes[1], slopes[0]) if test == "wale" else (slopes[0], slopes[1])
