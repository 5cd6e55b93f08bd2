# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns on a device: the arrays of a relaxation and its captured launches.

``YarnSimulation`` decides nothing. ``RelaxationLoop`` decides when there are new candidate lists, and whether a state
is accepted.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import CapturedLaunches
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import Vec3, scalar_named
from stitchmesh.errors import OverloadError
from stitchmesh.lattice import Lattice
from stitchmesh.mesh import FloatArray
from stitchmesh.quality import Quality
from stitchmesh.simulation.captures import Captures
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.assessment import Assessments
from stitchmesh.yarnrelax.collision.captured_search import ContactSearch
from stitchmesh.yarnrelax.collision.narrow_phase import WIDEST_MARGIN, make_candidates
from stitchmesh.yarnrelax.collision.step_limit import smallest_distances
from stitchmesh.yarnrelax.convergence import Assessor, precision_of, rounding_force
from stitchmesh.yarnrelax.energies.by_term import largest_force
from stitchmesh.yarnrelax.energies.evaluation import force_launches
from stitchmesh.yarnrelax.energies.term import ConstraintChoice, YarnChoice, YarnTerm
from stitchmesh.yarnrelax.model.material import YarnMaterial
from stitchmesh.yarnrelax.model.spline import place_contact_samples
from stitchmesh.yarnrelax.model.state import make_state
from stitchmesh.yarnrelax.model.upload import put_cells
from stitchmesh.yarnrelax.solvers import solver_named
from stitchmesh.yarnrelax.solvers.cell_strain import CellStrain, RelaxCell
from stitchmesh.yarnrelax.solvers.preconditioner import stiffness_row_sums
from stitchmesh.yarnrelax.solvers.solver import ASSESSMENT_INTERVAL, SolverInputs

GRAPH_ITERATIONS = {"cpu": 1, "cuda": 5}
"""Iterations of a graph. The host reads the progress after each graph, which takes a GPU as long as an iteration."""


@kernel
def copy_where(
    # state in
    chosen: wp.array[wp.int32],
    source: wp.array[Vec3],
    # state out
    target: wp.array[Vec3],
) -> None:
    """Copy the chosen elements."""
    i = wp.tid()
    if chosen[i] != 0:
        target[i] = source[i]


class YarnSimulation:
    """The arrays of a relaxation of one piece or of several cells, and the launches that are repeated."""

    @classmethod
    def start(
        cls,
        yarns: YarnSet,
        material: YarnMaterial,
        quality: Quality,
        device: wp.Device,
        terms: Sequence[YarnChoice] = (),
        constraints: Sequence[ConstraintChoice] = (),
        points: FloatArray | None = None,
        cell: RelaxCell | None = None,
    ) -> YarnSimulation:
        """Return a simulation of one piece or one cell, which starts at ``points`` [cm] or at the yarns' own points."""
        cells = None if cell is None else [cell]
        return cls([(yarns, material)], quality, device, terms, constraints, points, cells)

    def __init__(
        self,
        given: Sequence[tuple[YarnSet, YarnMaterial]],
        quality: Quality,
        device: wp.Device,
        terms: Sequence[YarnChoice] = (),
        constraints: Sequence[ConstraintChoice] = (),
        points: FloatArray | None = None,
        cells: Sequence[RelaxCell] | None = None,
        samples: Sequence[int] | None = None,
    ) -> None:
        """Send the yarns of one piece, or of independent cells, to the device, and make candidate lists.

        ``samples`` gives each cell its own number of contact samples; by default all cells have the number of the
        quality.

        Raises:
            OverloadError: the yarns of the only piece are too close to each other.
        """
        self.model = model = put_cells(
            given,
            quadrature_points=quality.quadrature_points,
            contact_samples=samples or quality.contact_samples,
            scalar=scalar_named(quality.precision),
            device=device,
        )
        self.terms = [term.on(model) for term in terms]
        self.yarn_terms = [term for term in self.terms if isinstance(term, YarnTerm)]
        """The terms that have a Hessian or that lag; the force of the others is constant."""
        further = sum((term.stiffness() for term in self.yarn_terms), start=np.zeros(model.point_count))
        stiffness = further + stiffness_row_sums(model)
        strains = 0 if cells is None else model.cell_count
        self.solver = solver_named(quality.solver)(model, further, strains, alone=not (terms or constraints))
        blocks = self.solver.needs_blocks
        self.is_quasistatic = quality.solver == "quasistatic"
        self.state = make_state(model, points, external=bool(self.terms), blocks=blocks, strains=strains)
        self.candidates = make_candidates(model, WIDEST_MARGIN)
        self.constraints = [constraint.on(model) for constraint in constraints]
        self.point_stiffness = model.upload(np.maximum(stiffness, np.finfo(np.float32).tiny))
        """Constant row sums of stiffness, shape (N,)."""
        self.good_points = wp.clone(self.state.points)
        """Control points of the last accepted state, shape (N, 3)."""
        self.step_fraction = quality.step_fraction
        self.rounding = rounding_force(model, stiffness)
        """Force that the rounding of coordinates causes [erg / unit], shape (C,)."""
        self.strain = None if cells is None else CellStrain(model, cells)
        self.good_periods = wp.clone(model.constants.images.periods) if model.on_lattice else None
        """Periods of the last accepted state on a lattice, shape (2 C, 3)."""
        self.search = ContactSearch(model, self.state, self.candidates)
        self._captures = Captures(self, YarnSimulation._generations)
        self.too_close = self.search_contacts()
        """A message for each cell whose yarns are too close at the start; it names the place."""
        for term in self.yarn_terms:
            term.renew(self.state, self.candidates)

    @property
    def inputs(self) -> SolverInputs:
        """The inputs of the solver."""
        return SolverInputs(self.model, self.state, self.candidates, self.constraints, self.step_fraction, self.strain,
                            self.terms)  # fmt: skip

    @property
    def precision(self) -> float:
        """Size of the last digit of 1."""
        return precision_of(self.model)

    @property
    def noise(self) -> NDArray[np.float64]:
        """Work of the rounding forces over a radius at every control point of each cell [erg], shape (C,)."""
        return self.rounding * np.diff(self.model.point_start)

    def _generations(self) -> tuple[int, ...]:
        """The generations of the arrays that captured launches name."""
        return (self.search.generation, *(term.generation for term in self.terms))

    def captured(self, name: str, launches: Callable[[], list[Any]], of: object = None) -> CapturedLaunches:
        """Return the launches captured under a name; capture them again if ``of`` is another object than before."""
        return self._captures.get(name, lambda: CapturedLaunches(launches(), self.model.device), (of,))

    @property
    def iterations(self) -> CapturedLaunches:
        """The captured launches of ``graph_iterations`` iterations."""
        return self._captures.get("iterations", self._capture_iterations)

    def _capture_iterations(self) -> CapturedLaunches:
        model, launcher = self.model, self.model.prepare
        if (fused := self.solver.fused_launch(self.inputs, self.point_stiffness, launcher)) is not None:
            self.graph_iterations = int(ASSESSMENT_INTERVAL)
            return CapturedLaunches([fused], model.device)
        times = self.graph_iterations = GRAPH_ITERATIONS["cuda" if model.device.is_cuda else "cpu"]
        return CapturedLaunches(self.iteration_launches(), model.device, times=times)

    def iteration_launches(self) -> list[Any]:
        """Return the prepared launches of one iteration, in their order: forces, constraints, solver."""
        return self.balance_launches() + self.solver.launches(self.inputs, self.model.prepare)

    def balance_launches(self) -> list[Any]:
        """Return the prepared launches that find the forces less the reactions of constraints."""
        model, state, launcher = self.model, self.state, self.model.prepare
        launches = force_launches(model, state, self.candidates, self.terms, self.point_stiffness, launcher)
        for constraint in self.constraints:
            launches += constraint.filter_forces(state.force, launcher)
        return launches

    def iterate(self, most: int | None = None) -> int:
        """Launch iterations; return their number, which is at most ``most`` unless the solver stops by itself."""
        launches, count = self.iterations, self.graph_iterations
        if most is not None and most < count and not self.solver.stops_by_itself:
            launches, count = CapturedLaunches(self.iteration_launches(), self.model.device, times=most), most
        launches.launch()
        return count

    def search_contacts(
        self, margins: NDArray[np.float64] | float | None = None, cells: NDArray[np.bool_] | None = None
    ) -> dict[int, str]:
        """Make candidate lists and step budgets for the current state.

        Args:
            margins: new margins of each cell, shape (C,), or of all [units]; None for the last ones.
            cells: the cells that get lists, shape (C,); all by default.

        Returns:
            A message for each of these cells whose yarns are too close to continue.

        Raises:
            OverloadError: the yarns of the only piece are too close.
            SolverError: the lists do not fit the memory.
        """
        if margins is not None:
            self.candidates.set_margins(margins)
        self.search.run(cells)
        too_close = self.search.too_close(cells)
        if too_close and self.model.cell_count == 1:
            raise OverloadError(too_close[0])
        return too_close

    @property
    def assessor(self) -> Assessor:
        """The captured launches of an assessment."""
        return self._captures.get(
            "assessment",
            lambda: Assessor(
                self.model, self.state, self.candidates, self.terms, self.constraints, self.point_stiffness,
                rounding=self.rounding, strain=self.strain,
            ),
        )  # fmt: skip

    def assess_cells(self, cells: NDArray[np.bool_] | None = None) -> Assessments:
        """Return residual and energies of each cell; only those of ``cells``, if given, are of the current state."""
        return self.assessor.assess(cells)

    def accept(self, cells: NDArray[np.bool_]) -> None:
        """Store the current state of some cells as their last accepted state."""
        self._copy(cells, self.state.points, self.good_points)
        if self.good_periods is not None:
            self._copy_where(np.repeat(cells, 2), self.model.constants.images.periods, self.good_periods)

    def restore(self, cells: NDArray[np.bool_] | None = None) -> None:
        """Return some cells, or all, to their last accepted state; candidate lists and budgets are then out of date."""
        chosen = np.ones(self.model.cell_count, dtype=bool) if cells is None else cells
        self._copy(chosen, self.good_points, self.state.points)
        if self.good_periods is not None:
            self._copy_where(np.repeat(chosen, 2), self.good_periods, self.model.constants.images.periods)
            self.candidates.near.invalidate(chosen)

    def good_yarns(self, cell: int = 0) -> YarnSet:
        """Return the yarns of a cell, or of the only piece, in the last accepted state."""
        return self.good_cells(np.arange(self.model.cell_count) == cell)[0]

    def good_cells(self, cells: NDArray[np.bool_] | None = None) -> list[YarnSet]:
        """Return the yarns of some cells, shape (C,), or of all, in the last accepted state."""
        return self._cells_at(self.good_points, self.good_periods, cells)

    def current_yarns(self) -> YarnSet:
        """Return the yarns of the only cell or piece in the current state, which is not assessed yet."""
        periods = self.model.constants.images.periods if self.model.on_lattice else None
        return self._cells_at(self.state.points, periods)[0]

    def _cells_at(
        self, points: wp.array[Any], periods: wp.array[Any] | None, cells: NDArray[np.bool_] | None = None
    ) -> list[YarnSet]:  # fmt: skip
        start, places = self.model.point_start, self.model.from_device(points)
        numbers = range(self.model.cell_count) if cells is None else np.flatnonzero(cells).tolist()
        own = [(self.model.cells[k], places[start[k] : start[k + 1]]) for k in numbers]
        if self.strain is None or periods is None:
            return [replace(cell.yarns, points=place) for cell, place in own]
        each = periods.numpy().astype(np.float64).reshape(-1, 2, 3)
        return [replace(cell.yarns, points=place, lattice=Lattice(each[k] * cell.unit))
                for k, (cell, place) in zip(numbers, own, strict=True)]  # fmt: skip

    def smallest_distances(self, cells: NDArray[np.bool_] | None = None) -> NDArray[np.float64]:
        """Return the smallest distance of yarns over their radius in the last accepted state, at most 2, shape (C,).

        With ``cells``, only the distances in these cells belong to that state.
        """
        self.restore(cells)
        self.search_contacts(cells=cells)
        return smallest_distances(self.model, self.state, self.candidates)

    def largest_force(self, cell: int = 0) -> str:
        """Return the energy with the largest force in a cell, or in the only piece, and the place of the force."""
        place_contact_samples(self.model, self.state, self.model.launch)
        return largest_force(self.model, self.state, self.candidates, self.terms, self.point_stiffness, cell)

    def _copy(self, cells: NDArray[np.bool_], source: wp.array[Any], target: wp.array[Any]) -> None:
        """Copy the entries of some cells."""
        if cells.all():
            wp.copy(target, source)
            return
        strains = [cells] if len(source) > self.model.point_count else []
        chosen = np.concatenate([np.repeat(cells, np.diff(self.model.point_start)), *strains])
        self._copy_where(chosen, source, target)

    def _copy_where(self, chosen: NDArray[np.bool_], source: wp.array[Any], target: wp.array[Any]) -> None:
        self.model.launch(copy_where, len(chosen), [self.model.integers(chosen), source], [target])
