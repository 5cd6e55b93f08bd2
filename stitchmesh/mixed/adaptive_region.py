# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A region that grows and shrinks while the run goes on.

After every few steps of a motion, or equilibria of a static run, the errors of triangles in the present state are
indicated (``placement.changed_region``), and where it pays the run goes on with another region within the same number
of nodes. A static run then finds the equilibrium of the present loads again.

The state of a checkpoint includes the region, so that a run that is resumed changes it as one that never stopped.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.enrichment.region import YARNS
from stitchmesh.mixed.placement.changed_region import changed_triangles, present_errors
from stitchmesh.mixed.placement.chosen_region import NodeBudget
from stitchmesh.mixed.scene.scene_fabric import PreparedScene, check_simulated, with_region
from stitchmesh.mixed.simulation import Simulation

NUMBERS, TRIANGLES = "region numbers", "region triangles"
"""Names of the arrays of a checkpoint."""
WEIGHT = "weight"
"""How the names of the terms of gravity begin."""


class AdaptiveRegion:
    """Looks at a run from time to time, and changes its region."""

    def __init__(self, prepared: PreparedScene, budget: NodeBudget) -> None:
        """Begin a run.

        Args:
            prepared: the scene; ``region.changes_every`` says how often the region may change, never if it is None.
            budget: nodes that may be simulated.
        """
        self.every, self.budget = prepared.scene.region.changes_every, budget
        self.changes = 0
        """How often the region has changed."""
        self.energy_jump = 0.0
        """Largest change of kinetic and elastic energy of a run, without sign, when its region changed [erg].

        The weight is left out: its energy depends on where height is counted from, if masses change with the region."""
        self._looks, self._time = 0, 0.0

    def look(self, simulation: Simulation) -> bool:
        """Change the region of a run where it pays, and return whether it has changed; to be called after each step."""
        if self.every is None or simulation.time == self._time:
            return False  # an equilibrium that was found again after a change
        self._looks, self._time = self._looks + 1, simulation.time
        at_end = simulation.done and simulation.prepared.scene.mode == "dynamic"
        return not at_end and self._looks % self.every == 0 and self._change(simulation)

    def arrays(self, simulation: Simulation) -> dict[str, NDArray[Any]]:
        """Return the region of a run, and what the next changes depend on."""
        numbers = [self._looks, self._time, self.budget.nodes, self.changes, self.energy_jump]
        full = np.flatnonzero(simulation.prepared.region.triangle_kind == YARNS)
        return {NUMBERS: np.array(numbers, dtype=np.float64), TRIANGLES: full}

    def resume(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Restore the contents of ``arrays``; the run itself begins with ``resumed_region``."""
        looks, self._time, _nodes, changes, self.energy_jump = (float(number) for number in arrays[NUMBERS])
        self._looks, self.budget, self.changes = int(looks), resumed_budget(arrays), int(changes)

    def _change(self, simulation: Simulation) -> bool:
        new = self._wanted(simulation)
        if np.array_equal(new.region.triangle_kind, simulation.prepared.region.triangle_kind):
            return False
        try:
            check_simulated(new.held, new.region)
        except ParameterError:  # an attachment would hold nothing
            return False
        before = _energy(simulation)
        simulation.change_region(new.region)
        self.changes += 1
        self.energy_jump = max(self.energy_jump, abs(_energy(simulation) - before))
        return True

    def _wanted(self, simulation: Simulation) -> PreparedScene:
        """The scene with the region that pays most in the present state."""
        prepared = simulation.prepared
        fabric, region, section = prepared.fabric, prepared.region, prepared.scene.region
        vertices, nodes, _sliding = simulation.positions
        error = present_errors(fabric.cloth, region, fabric.cloth_material, vertices, nodes)
        error = section.placing_errors(fabric.cloth, error)
        present = np.flatnonzero(region.triangle_kind == YARNS)
        layout = fabric.cloth.triangles, fabric.yarns.triangle
        return with_region(prepared, changed_triangles(*layout, error, present, self.budget, rings=section.rings))


def _energy(simulation: Simulation) -> float:
    """Kinetic and elastic energy [erg]."""
    return sum(value for name, value in simulation.energies().items() if not name.startswith(WEIGHT))


def resumed_region(prepared: PreparedScene, arrays: Mapping[str, NDArray[Any]]) -> PreparedScene:
    """Return a scene with the region of a checkpoint."""
    return with_region(prepared, arrays[TRIANGLES])


def resumed_budget(arrays: Mapping[str, NDArray[Any]]) -> NodeBudget:
    """Return the nodes that the region of a checkpoint may have."""
    return NodeBudget(nodes=int(arrays[NUMBERS][2]))
