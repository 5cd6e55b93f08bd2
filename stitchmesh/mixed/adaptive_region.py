# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A region that grows and shrinks while the run goes on.

A run looks at its region after every few steps of a motion, or after every few equilibria of a static run: it computes
the errors of the triangles in the present state. Where a change pays, the run goes on with another region within the
same number of nodes. A static run then finds the equilibrium of the present loads again.

A checkpoint includes the region, so a resumed run changes it as a run without an interruption does.

In the region itself the triangles carry no error, because the yarns carry what triangles cannot. The error that the
triangles would have without yarns follows from the yarns there. Yarn nodes at the root mean square distance d from the
triangles, in waves whose half length is the size h of a triangle, take up the compression e = (pi d / h)^2 / 2.
Triangles would have to store it as 1/2 Y e^2 (``detail_errors``). h^2 is twice the area of the triangle.

A region changes only if this is worth it. Triangles that have yarns now count ``KEPT`` times as much as others, and the
new region is taken only if it removes ``WORTH`` times as much error as the present one would; otherwise the present
region stays as it is. Changes cost a new factorisation and a jump of the state, and a region that follows every
fluctuation would pay them at each step.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.mixed.cloth.cloth import Cloth
from stitchmesh.mixed.enrichment.region import TRIANGLES, YARNS, Region
from stitchmesh.mixed.placement.chosen_region import NodeBudget, choose_triangles, simulated_nodes
from stitchmesh.mixed.placement.error_indicator import indicate_errors
from stitchmesh.mixed.region_change import place_hidden_vertices
from stitchmesh.mixed.scene.scene_fabric import PreparedScene, check_simulated, with_region
from stitchmesh.mixed.simulation import Simulation
from stitchmesh.mixed.triangles.cloth_material import ClothMaterial

Integers = NDArray[np.int64]
Numbers = NDArray[np.float64]
KEPT = 2.0
"""Factor of the error of triangles that have yarns."""
WORTH = 1.1
"""The error that a new region must remove, as a multiple of the error that the present region removes."""
SAVED_NUMBERS = "region numbers"
SAVED_TRIANGLES = "region triangles"
"""Names of the arrays of a checkpoint."""


def changed_triangles(
    triangles: ArrayLike,
    node_triangle: ArrayLike,
    error: ArrayLike,
    present: ArrayLike,
    budget: NodeBudget,
    *,
    rings: int = 1,
    kept: float = KEPT,
    worth: float = WORTH,
) -> Integers:
    """The full-yarn triangles with which a run goes on, ascending. If no change pays, they are the present ones.

    Args:
        triangles: vertices of each triangle, shape (T, 3).
        node_triangle: triangle of each yarn node of the layout, shape (N,).
        error: indicated error of each triangle, shape (T,); inside the present region it includes ``detail_errors``.
        present: numbers of the full-yarn triangles of the present region.
        budget: nodes that may be simulated.
        rings: width of the hybrid region in rings of triangles.
        kept: factor of the error of triangles that have yarns, at least 1.
        worth: the error that a new region must remove, as a multiple of the error that the present region removes, at
            least 1.

    Raises:
        ParameterError: as ``choose_triangles``, or a factor is less than 1.
    """
    if not (kept >= 1.0 and worth >= 1.0):
        raise ParameterError(f"region: got the factors {kept:g} and {worth:g}; expected numbers of at least 1")
    now = np.unique(np.asarray(present, dtype=np.int64))
    values = np.array(error, dtype=np.float64)
    preferred = values.copy()
    preferred[now] *= kept
    new = choose_triangles(triangles, node_triangle, preferred, budget, rings=rings)
    fits = simulated_nodes(triangles, node_triangle, now, rings=rings) <= budget.nodes
    if fits and values[new].sum() <= worth * values[now].sum():
        return now
    return new


def present_errors(cloth: Cloth, region: Region, material: ClothMaterial, vertices: Numbers, nodes: Numbers) -> Numbers:
    """The error that triangles alone would have in the present state of a run [erg], shape (T,).

    Outside the region this is ``indicate_errors``. Inside, where the yarns place the vertices, it is the larger of the
    indicator and ``detail_errors``. The arguments are the same as for ``detail_errors``.
    """
    placed = place_hidden_vertices(region, vertices, nodes)
    indicated = indicate_errors(cloth, placed, material).total
    return np.maximum(indicated, detail_errors(cloth, region, material, placed, nodes))


def detail_errors(cloth: Cloth, region: Region, material: ClothMaterial, vertices: Numbers, nodes: Numbers) -> Numbers:
    """The error that triangles would have where yarns are simulated now [erg], shape (T,); zero elsewhere.

    Args:
        cloth: the cloth.
        region: the present region.
        material: material of the triangles.
        vertices: positions of the vertices [cm], shape (V, 3).
        nodes: positions of the simulated nodes [cm], shape (n, 3).
    """
    simulated = region.nodes
    home = region.node_triangle[simulated]
    corners = np.asarray(vertices, dtype=np.float64)[region.triangles[home]]
    base = np.einsum("nk,nkd->nd", region.node_weight[simulated], corners)
    count = np.bincount(home, minlength=len(region.triangles))
    square = np.bincount(home, ((nodes - base) ** 2).sum(axis=1), minlength=len(region.triangles))
    strain = np.pi**2 * (square / np.maximum(count, 1)) / (2.0 * 2.0 * cloth.rest_area)
    moduli = material.moduli()
    stiffness = float(np.sqrt(moduli[0, 0] * moduli[1, 1]))
    return np.where(region.triangle_kind == TRIANGLES, 0.0, cloth.rest_area * stiffness * strain**2 / 2.0)


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
        """The largest change of the kinetic and elastic energy of a run at a change of its region, without sign [erg].

        The energy of weight is left out, because it depends on the height of the origin if masses change with the
        region."""
        self._looks, self._time = 0, 0.0

    def look(self, simulation: Simulation) -> bool:
        """Change the region where it pays, and return whether it has changed; a run calls this after each step."""
        if self.every is None or simulation.time == self._time:
            return False  # an equilibrium that was found again after a change
        self._looks, self._time = self._looks + 1, simulation.time
        at_end = simulation.done and simulation.prepared.scene.mode == "dynamic"
        return not at_end and self._looks % self.every == 0 and self._change(simulation)

    def arrays(self, simulation: Simulation) -> dict[str, NDArray[Any]]:
        """Return the region of a run, and what the next changes depend on."""
        numbers = [self._looks, self._time, self.budget.nodes, self.changes, self.energy_jump]
        full = np.flatnonzero(simulation.prepared.region.triangle_kind == YARNS)
        return {SAVED_NUMBERS: np.array(numbers, dtype=np.float64), SAVED_TRIANGLES: full}

    def resume(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Restore the contents of ``arrays``; the run itself begins with ``resumed_region``."""
        looks, self._time, _nodes, changes, self.energy_jump = (float(number) for number in arrays[SAVED_NUMBERS])
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
        """The scene with the region that removes most error in the present state."""
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
    loads = {term.name for term in simulation.system.terms if term.is_load}
    return sum(value for name, value in simulation.energies().items() if name not in loads)


def resumed_region(prepared: PreparedScene, arrays: Mapping[str, NDArray[Any]]) -> PreparedScene:
    """Return a scene with the region of a checkpoint."""
    return with_region(prepared, arrays[SAVED_TRIANGLES])


def resumed_budget(arrays: Mapping[str, NDArray[Any]]) -> NodeBudget:
    """Return the nodes that the region of a checkpoint may have."""
    return NodeBudget(nodes=int(arrays[SAVED_NUMBERS][2]))
