# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The tests of ``loading_curve`` on a cell of crossing yarns.

Stretched and sheared cells are in equilibrium. A bent cell keeps the places of its nodes in the fabric. Its sizes adapt
so that its tension stays as laid out, and the chords of yarn between nodes keep their strain. For straight yarns this
is the equilibrium too. The loops of a knit could turn towards their curl under nearly no moment; the test therefore
gives the resistance of a knit whose neighbourhood keeps it flat.

The tests measure the resistance of a fabric at prescribed strains, shears and curvatures:

- ``course``, ``wale``: stretched along one axis to (1 + strain) times its size, while the other size keeps its value.
- ``both``: stretched along both axes.
- ``shear``: the angle between both axes changes by ``strain`` [rad], while lengths along them keep their values.
- ``bend course``, ``bend wale``, ``bend across``: rolled on a cylinder of curvature ``strain`` [1/cm], which is curved
  along the courses, along the wales, or at 45 degrees; sizes in the plane are free.

The tension is the derivative of the energy per area of the flat fabric by the strain: dyn per cm of flat fabric for a
stretch, dyn/cm for shear, and for bending the moment per cm of width, in dyn. Under ``both`` it is the derivative by
the stretch along the courses. Values are plain arrays, so they can come from any source: the cells of crossing yarns
here, stretch tests of B-spline yarns (``sm.stretch_test`` with the other size held), or measurements.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.matching.cell_equilibrium import CellShape, CellSolver, CellState
from stitchmesh.progress import Progress, no_progress

Test = Literal["course", "wale", "both", "shear", "bend course", "bend wale", "bend across"]
TESTS: tuple[Test, ...] = get_args(Test)
STRETCHES: tuple[Test, ...] = ("course", "wale", "both")
BENDS: tuple[Test, ...] = ("bend course", "bend wale", "bend across")
Numbers = NDArray[np.float64]
STAGE = "match"
"""Name of the stage in reports of progress."""
DIRECTION = {"bend course": 0.0, "bend wale": np.pi / 2.0, "bend across": np.pi / 4.0}
"""Angle between the courses and the direction along which the fabric is curved [rad]."""


@dataclass(frozen=True, eq=False)
class LoadingCurve:
    """A test at K strains, ascending; arrays are read-only.

    Raises:
        ParameterError: the test is unknown, shapes do not agree, numbers are not finite, strains do not increase, or
            none is 0.
    """

    test: Test
    """Name of the test."""
    strain: Numbers
    """Strain, change of angle [rad] or curvature [1/cm], one of them 0; shape (K,)."""
    tension: Numbers
    """Derivative of the energy by the strain [dyn/cm], or moment [dyn]; shape (K,)."""
    side: Numbers
    """Tension along the other axis [dyn/cm]: along the wales for ``course`` and ``both``, along the courses for
    ``wale``, zero for other tests; shape (K,)."""

    @staticmethod
    def of(test: str, strain: ArrayLike, tension: ArrayLike, side: ArrayLike | None = None) -> LoadingCurve:
        """The curve of lists of numbers; the arguments are the fields, and ``side`` is zero if it is None."""
        strains = np.array(strain, dtype=np.float64)
        sides = np.zeros(strains.shape) if side is None else np.array(side, dtype=np.float64)
        return LoadingCurve(test, strains, np.array(tension, dtype=np.float64), sides)  # type: ignore[arg-type]

    def __post_init__(self) -> None:
        if self.test not in TESTS:
            raise ParameterError(f"loading curve: test: got {self.test!r}; expected one of {', '.join(TESTS)}")
        place = f"loading curve {self.test!r}"
        shapes = {array.shape for array in (self.strain, self.tension, self.side)}
        if len(shapes) > 1 or self.strain.ndim != 1:
            raise ParameterError(f"{place}: got arrays of shapes {sorted(shapes)}; expected one shape (K,)")
        if not np.isfinite([self.strain, self.tension, self.side]).all():
            raise ParameterError(f"{place}: got a number that is not finite; expected finite strains and tensions")
        if not (np.diff(self.strain) > 0.0).all() or not (self.strain == 0.0).any() or len(self.strain) < 2:
            raise ParameterError(f"{place}: got strains {self.strain.tolist()}; expected them ascending, one of them 0")
        for array in (self.strain, self.tension, self.side):
            array.flags.writeable = False

    @property
    def at_rest(self) -> tuple[float, float]:
        """Tension and side tension at strain 0, with which the fabric is laid out."""
        first = int(np.flatnonzero(self.strain == 0.0)[0])
        return float(self.tension[first]), float(self.side[first])

    @property
    def loaded(self) -> NDArray[np.bool_]:
        """Whether each strain is not 0, shape (K,)."""
        return self.strain != 0.0

    @property
    def rise(self) -> tuple[Numbers, Numbers]:
        """Tension and side tension beyond their values at rest."""
        tension, side = self.at_rest
        return self.tension - tension, self.side - side


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
    """One test; the search for each state begins at the neighbouring state that is nearer to strain 0."""
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
    in_plane = ("stretch_course", "stretch_wale", "skew")
    return solver.equilibrium(
        replace(before.shape, curvature=strain), before.moved, free=in_plane, load=load, held=True
    )


def _tensions(test: str, strain: float, slopes: Numbers) -> tuple[float, float]:
    """Tension and side tension of a state."""
    if test == "shear":
        along = np.array([-np.sin(strain / 2.0), -np.sin(strain / 2.0), np.cos(strain / 2.0)]) / 2.0
        return float(along @ slopes[:3]), 0.0
    if test in BENDS:
        return float(slopes[3]), 0.0
    return (slopes[1], slopes[0]) if test == "wale" else (slopes[0], slopes[1])
