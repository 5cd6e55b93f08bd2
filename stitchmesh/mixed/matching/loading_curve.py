# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Tests of a fabric: what it resists at prescribed strains, shears and curvatures.

- ``course``, ``wale``: stretched along one axis to (1 + strain) times its size, while the other size keeps its value.
- ``both``: stretched along both axes.
- ``shear``: the angle between both axes changes by ``strain`` [rad], while lengths along them keep their values.
- ``bend course``, ``bend wale``, ``bend across``: rolled on a cylinder of curvature ``strain`` [1/cm], which is curved
  along the courses, along the wales, or at 45 degrees; sizes in the plane are free.

The tension is the derivative of the energy for each area of the flat fabric by the strain: dyn per cm of flat fabric
for a stretch, dyn/cm for shear, dyn for the moment for each cm of width. Under ``both`` it is the derivative by the
stretch along the courses. Values are plain arrays, so that any source can give them: the cells of crossing yarns here,
stretch tests of B-spline yarns (``sm.stretch_test`` with the other size held), or measurements.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.errors import ParameterError

Test = Literal["course", "wale", "both", "shear", "bend course", "bend wale", "bend across"]
TESTS: tuple[Test, ...] = get_args(Test)
STRETCHES: tuple[Test, ...] = ("course", "wale", "both")
BENDS: tuple[Test, ...] = ("bend course", "bend wale", "bend across")
Numbers = NDArray[np.float64]


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
        """The curve of lists of numbers; arguments as the fields, ``side`` zero if it is None."""
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
        """Tension and side tension at strain 0: the tension that the fabric is laid out with."""
        first = int(np.flatnonzero(self.strain == 0.0)[0])
        return float(self.tension[first]), float(self.side[first])

    @property
    def loaded(self) -> NDArray[np.bool_]:
        """Whether each strain is not 0, shape (K,)."""
        return self.strain != 0.0

    @property
    def rise(self) -> tuple[Numbers, Numbers]:
        """Tension and side tension beyond those at rest."""
        tension, side = self.at_rest
        return self.tension - tension, self.side - side
