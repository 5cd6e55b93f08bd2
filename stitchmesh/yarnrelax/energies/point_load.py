# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Point load: a constant force on some control points, for example from a hand or a suspended weight.

The control points share the force evenly. It is a dead load (``simulation.dead_load``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.simulation.dead_load import DeadLoad
from stitchmesh.yarnrelax.energies.term import YarnChoice
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.point_selection import select_points


@dataclass(frozen=True, eq=False)
class PointLoad(YarnChoice):
    """A force on control points that are selected by number, by stitch face, or both.

    Raises:
        ParameterError: the force is not three finite numbers.
    """

    force: tuple[float, float, float]
    """The whole force [dyn]."""
    points: Sequence[int] | NDArray[np.integer[Any]] = ()
    """Numbers of control points."""
    faces: Sequence[int] | NDArray[np.integer[Any]] = ()
    """Stitch faces, all of whose control points are loaded (``YarnSet.face``)."""

    def __post_init__(self) -> None:
        if np.shape(self.force) != (3,) or not np.isfinite(self.force).all():
            raise ParameterError(f"point load: got force {self.force}; expected three finite numbers [dyn]")

    def on(self, model: Model) -> DeadLoad:
        """Return the load on a model's yarns.

        Raises:
            ParameterError: a control point or a stitch face does not exist, or nothing is selected.
        """
        loaded = select_points("point load", model.yarns, self.points, self.faces)
        share = np.zeros(model.point_count)
        share[loaded] = 1.0 / len(loaded)
        return DeadLoad("point load", model, self.force, [share])
