# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""One iteration of the relaxation: which kernels run, in which order, and how it recovers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import CapturedLaunches
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.precision import scalar_named
from stitchmesh.errors import SolverError
from stitchmesh.lattice import Lattice
from stitchmesh.mesh import FloatArray
from stitchmesh.quality import Quality
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.collision.broad_phase import NOTHING_LISTED
from stitchmesh.yarnrelax.collision.captured_search import CapturedSearch
from stitchmesh.yarnrelax.collision.narrow_phase import Candidates, find_candidates, make_candidates
from stitchmesh.yarnrelax.collision.step_limit import limit_steps, smallest_distances, yarn_place
from stitchmesh.yarnrelax.convergence import Assessment, Assessor, rounding_force
from stitchmesh.yarnrelax.energies import evaluation
from stitchmesh.yarnrelax.energies.term import Constraint, ConstraintChoice, Term, TermChoice
from stitchmesh.yarnrelax.model.constants import Model, put_cells
from stitchmesh.yarnrelax.model.contact_samples import place_contact_samples
from stitchmesh.yarnrelax.model.image_table import renew_images
from stitchmesh.yarnrelax.model.material import YarnMaterial
from stitchmesh.yarnrelax.model.state import State, make_state
from stitchmesh.yarnrelax.solvers import solver_named
from stitchmesh.yarnrelax.solvers.cell_strain import CellStrain, RelaxCell
from stitchmesh.yarnrelax.solvers.lbfgs_steps import PERIOD
from stitchmesh.yarnrelax.solvers.solver import Solver, SolverInputs
from stitchmesh.yarnrelax.solvers.stiffness_bounds import stiffness_row_sums

WIDEST_MARGIN, NARROWEST_MARGIN = 0.6, 0.3
"""Reach of the candidate lists beyond contact in mean radii: at the start, and when all is slow."""
MARGIN_CHANGE = 1.5
"""Factor by which the margin narrows or widens."""
SHORT_LIFE, LONG_LIFE = 10, 40
"""Iterations; lists that are worn sooner get a wider margin, lists that last longer a narrower one."""
BURST = {"cpu": 1, "cuda": 5}
"""Iterations between two looks at how far control points have moved; a look costs a GPU as much as an iteration."""
SMALLEST_CAUTION = 5e-5
"""Scale of steps at which backing off gives up."""
PART_THEM = "move the yarns apart, or control points that lie in one place"
"""What helps where an energy is too steep to be relaxed."""
RECOVERY = 1.2
"""Growth of the scale of steps after each good assessment."""


@kernel
def copy_where(
    # state in
    chosen: wp.array[wp.int32],
    source: wp.array[Any],
    # state out
    target: wp.array[Any],
) -> None:
    """Copy what is chosen."""
    i = wp.tid()
    if chosen[i] != 0:
        target[i] = source[i]


@dataclass(eq=False)
class YarnSimulation:
    """The arrays of a relaxation and the launches that repeat."""

    model: Model
    state: State
    candidates: Candidates
    terms: Sequence[Term]
    constraints: Sequence[Constraint]
    solver: Solver
    point_stiffness: wp.array[Any]
    """Row sums of stiffness that do not change, shape (N,)."""
    good_points: wp.array[Any]
    """Control points of the last state that was found good, shape (N, 3)."""
    step_fraction: float
    rounding: NDArray[np.float64]
    """Force that the rounding of coordinates makes [erg / unit], shape (C,)."""
    step_scale: NDArray[np.float64]
    """Scale of the steps of each cell, shape (C,)."""
    strain: CellStrain | None = None
    """The strains of a cell that relaxes."""
    good_periods: wp.array[Any] | None = None
    """Periods of the last good state on a lattice, shape (2, 3)."""
    age: int = 0
    """Iterations since the candidate lists were made."""
    failed: dict[int, str] = field(default_factory=dict)
    """What is wrong with cells that cannot go on."""
    recording: CapturedLaunches | None = None
    """The launches of a burst."""
    burst: int = 1
    """Iterations of a burst: those between two looks at how far control points have moved."""
    listing: CapturedSearch | None = None
    """Makes candidate lists quickly, where there is nothing odd about them."""
    assessor: Assessor | None = None
    """Made anew when arrays are."""

    @classmethod
    def start(
        cls,
        yarns: YarnSet,
        material: YarnMaterial,
        quality: Quality,
        device: wp.Device,
        terms: Sequence[TermChoice] = (),
        constraints: Sequence[ConstraintChoice] = (),
        points: FloatArray | None = None,
        cell: RelaxCell | None = None,
    ) -> YarnSimulation:
        """Send yarns to the device and get ready to iterate; from ``points`` [cm] where given, not the yarns' own."""
        cells = None if cell is None else [cell]
        return cls.start_cells([(yarns, material)], quality, device, terms, constraints, points, cells)

    @classmethod
    def start_cells(
        cls,
        given: Sequence[tuple[YarnSet, YarnMaterial]],
        quality: Quality,
        device: wp.Device,
        terms: Sequence[TermChoice] = (),
        constraints: Sequence[ConstraintChoice] = (),
        points: FloatArray | None = None,
        cells: Sequence[RelaxCell] | None = None,
    ) -> YarnSimulation:
        """Likewise for several cells that know nothing of one another; without terms or constraints."""
        model = put_cells(
            given,
            quadrature_points=quality.quadrature_points,
            contact_samples=quality.contact_samples,
            scalar=scalar_named(quality.precision),
            device=device,
        )
        chosen = [term.on(model) for term in terms]
        further = sum((term.stiffness() for term in chosen), start=np.zeros(model.point_count))
        stiffness = further + stiffness_row_sums(model)
        strains = 0 if cells is None else model.cell_count
        solver = solver_named(quality.solver)(model, further, strains, alone=not (terms or constraints))
        state = make_state(model, points, outer=bool(chosen), blocks=solver.needs_blocks, strains=strains)
        iteration = cls(
            model,
            state,
            make_candidates(model, WIDEST_MARGIN),
            chosen,
            [constraint.on(model) for constraint in constraints],
            solver,
            model.upload(np.maximum(stiffness, np.finfo(np.float32).tiny)),
            wp.clone(state.points),
            quality.step_fraction,
            rounding_force(model, stiffness),
            np.ones(model.cell_count),
            None if cells is None else CellStrain(model, cells),
            wp.clone(model.constants.images.periods) if model.on_lattice else None,
        )
        iteration.list_candidates()
        for term in chosen:
            term.renew(state, iteration.candidates)
        iteration._record()
        return iteration

    def run(self, count: int, cells: NDArray[np.bool_] | None = None) -> None:
        """Iterate ``count`` times, making new candidate lists where control points have moved far; only some cells."""
        wanted = np.full(self.model.cell_count, count)
        if cells is not None:
            wanted[~cells] = 0
        self.solver.begin(wanted)
        while self.solver.left > 0:
            assert self.recording is not None
            self.recording.launch()
            needs_new_lists = self.solver.needs_new_lists(self.scene, self.burst)
            self.age += self.solver.advanced
            if (
                (needs_new_lists or self.age > LONG_LIFE)
                and self._fit_margin(needs_new_lists)
                and self.list_candidates()
            ):
                self._record()

    def renew(self) -> bool:
        """Bring what lags behind up to date; whether there is such a thing."""
        lagging = [term for term in self.terms if term.lags]
        if lagging:
            self.list_candidates()
            for term in lagging:
                term.renew(self.state, self.candidates)
            self._record()
        return bool(lagging)

    def assess(self) -> Assessment:
        """Residual and energies of the first cell, or of the only piece, as it is."""
        return self.assess_cells()[0]

    def assess_cells(self, cells: NDArray[np.bool_] | None = None) -> list[Assessment]:
        """Residual and energies of each cell as it is; of ``cells`` only, or of all, with what rounding does."""
        if self.assessor is None:
            self.assessor = Assessor(
                self.model, self.state, self.candidates, self.terms, self.constraints, self.point_stiffness,
                rounding=self.rounding, strain=self.strain,
            )  # fmt: skip
        return self.assessor.assess(cells)

    def keep(self, cells: NDArray[np.bool_] | None = None) -> None:
        """Call the state of some cells good, or of all, and let them grow eager again."""
        kept = self._chosen(cells)
        self._copy(kept, self.state.points, self.good_points)
        if self.good_periods is not None:
            self._copy_periods(kept, self.model.constants.images.periods, self.good_periods)
        if (self.step_scale[kept] < 1.0).any():
            self.step_scale[kept] = np.minimum(self.step_scale[kept] * RECOVERY, 1.0)
            self.solver.set_step_scale(self.step_scale)

    def step_back(self, cells: NDArray[np.bool_] | None = None) -> None:
        """Take some cells, or all, back to their last good state, at rest and half as eager.

        Raises:
            SolverError: of a single piece it has been tried often enough.
        """
        back = self._chosen(cells)
        for cell in np.flatnonzero(back & (self.step_scale < SMALLEST_CAUTION)).tolist():
            self.failed[cell] = f"{self.blame(cell)}: its energy grows at the smallest steps; {PART_THEM}"
        self.raise_if_alone()
        self._go_back(back)
        self.step_scale[back] /= 2
        self.solver.restart(self.step_scale, back)
        if self.list_candidates():
            self._record()

    def _chosen(self, cells: NDArray[np.bool_] | None) -> NDArray[np.bool_]:
        return np.ones(self.model.cell_count, dtype=bool) if cells is None else cells

    def raise_if_alone(self) -> None:
        """Raise a ``SolverError`` that says what is stuck, if no other cell could go on."""
        if self.failed and self.model.cell_count == 1:
            raise SolverError(self.failed[0])

    def _copy(self, cells: NDArray[np.bool_], source: wp.array[Any], target: wp.array[Any]) -> None:
        """Copy the entries of some cells."""
        if cells.all():
            wp.copy(target, source)
            return
        counts = np.diff(self.model.point_start)
        strains = [cells] if len(source) > self.model.point_count else []
        self._copy_where(np.concatenate([np.repeat(cells, counts), *strains]), source, target)

    def _copy_periods(self, cells: NDArray[np.bool_], source: wp.array[Any], target: wp.array[Any]) -> None:
        """Copy the periods of some cells."""
        self._copy_where(np.repeat(cells, 2), source, target)

    def _copy_where(self, chosen: NDArray[np.bool_], source: wp.array[Any], target: wp.array[Any]) -> None:
        self.model.launch(copy_where, len(chosen), [self.model.integers(chosen), source], [target])

    def arrays(self) -> dict[str, wp.array[Any]]:
        """All on the device that decides how the iterations go on, by name; candidate lists follow from it."""
        state = self.state
        own = {"points": state.points, "listed_points": state.listed_points, "good_points": self.good_points}
        if self.good_periods is not None:
            own |= {"periods": self.model.constants.images.periods, "good_periods": self.good_periods}
        carried = {f"solver.{name}": array for name, array in self.solver.arrays().items()}
        for number, term in enumerate(self.terms):
            carried |= {f"{term.name} {number}.{name}": array for name, array in term.arrays().items()}
        return own | carried

    def resume(
        self, arrays: Mapping[str, NDArray[Any]], *, margin: float, age: int, step_scale: NDArray[np.float64]
    ) -> None:
        """Go on from where another was that started alike; the arrays stay where recorded launches look for them."""
        self.candidates.margin = margin
        self.state.points.assign(arrays["listed_points"])
        self.list_candidates()
        own = {name: array for name, array in self.arrays().items() if "." not in name or name.startswith("solver.")}
        for name, array in own.items():
            array.assign(arrays[name])
        for number, term in enumerate(self.terms):
            start = f"{term.name} {number}."
            term.resume({name.removeprefix(start): array for name, array in arrays.items() if name.startswith(start)})
        self.age, self.step_scale = age, step_scale
        self._record()

    def good_yarns(self, cell: int = 0) -> YarnSet:
        """The yarns of a cell, or of the only piece, in the last good state."""
        return self.good_cells()[cell]

    def good_cells(self) -> list[YarnSet]:
        """The yarns of each cell in the last good state."""
        return self._yarns_at(self.good_points, self.good_periods)

    def smallest_distance(self, cell: int = 0) -> float:
        """Smallest distance of yarns of a cell in its last good state over their radius, 2 where none touch."""
        return float(self.smallest_distances()[cell])

    def smallest_distances(self) -> NDArray[np.float64]:
        """The same of all cells, shape (C,)."""
        self._go_back(self._chosen(None))
        self.list_candidates()
        return smallest_distances(self.model, self.state, self.candidates)

    @property
    def launches(self) -> list[Any]:
        """The launches of one iteration, in their order."""
        return [] if self.recording is None else self.recording.launches

    @property
    def scene(self) -> SolverInputs:
        """What the solver works on."""
        return SolverInputs(self.model, self.state, self.candidates, self.constraints, self.step_fraction, self.strain)

    @property
    def noise(self) -> NDArray[np.float64]:
        """Energy that rounding forces do over a radius at every control point of each cell [erg], shape (C,)."""
        return self.rounding * np.diff(self.model.point_start)

    def blame(self, cell: int = 0) -> str:
        """The energy with the largest force of all in a cell, or in the only piece, and where it acts."""
        first, last = self.model.point_start[cell : cell + 2]
        largest, energy, point = -1.0, "", 0
        place_contact_samples(self.model, self.state, self.model.launch)
        for term in evaluation.each_term(self.model, self.state, self.candidates, self.terms, self.point_stiffness):
            force = np.linalg.norm(self.state.force.numpy()[first:last].astype(np.float64), axis=1)
            force = np.where(np.isfinite(force), force, np.inf)
            if force.max() > largest:
                largest, energy, point = float(force.max()), term, int(first + force.argmax())
        return f"{energy} energy of {yarn_place(self.model.yarns, point)}"

    def _fit_margin(self, needs_new_lists: bool) -> bool:
        """Widen the margin of lists that do not last, narrow that of lists that do; whether to make new lists."""
        margin = self.candidates.margin
        if self.age <= SHORT_LIFE:
            self.candidates.margin = min(margin * MARGIN_CHANGE, WIDEST_MARGIN)
        elif self.age > LONG_LIFE:
            self.candidates.margin = max(margin / MARGIN_CHANGE, NARROWEST_MARGIN)
        return needs_new_lists or self.candidates.margin != margin

    def list_candidates(self) -> bool:
        """Make new candidate lists and budgets; whether launches have to be recorded again."""
        self.age = 0
        if self.listing is not None and self.listing.fits() and self.listing.launch():
            return False
        known = self.listing.table if self.listing is not None and self.listing.holds else None
        renewed = self.model.on_lattice and renew_images(
            self.model, self.state.points, anyway=self.listing is not None and known is None
        )
        if renewed or self.strain is not None:  # cells that deform bring yarns nearer than their drift tells
            self.candidates.near.reach = NOTHING_LISTED
        place_contact_samples(self.model, self.state, self.model.launch)
        wp.copy(self.state.listed_points, self.state.points)
        grown = find_candidates(self.model, self.state.samples, self.candidates)
        self.failed |= limit_steps(self.model, self.state, self.candidates)
        self.raise_if_alone()
        if self.model.on_lattice and not self.failed:
            self.listing = CapturedSearch(self.model, self.state, self.candidates, None if renewed else known)
        return grown or renewed

    def _yarns_at(self, points: wp.array[Any], periods: wp.array[Any] | None) -> list[YarnSet]:
        """The yarns of each cell at some control points, on lattices of some periods if on any."""
        start, places = self.model.point_start, self.model.from_device(points)
        members = self.model.members
        moved = [replace(member.yarns, points=places[start[k] : start[k + 1]]) for k, member in enumerate(members)]
        if self.strain is None or periods is None:
            return moved
        now = periods.numpy().astype(np.float64).reshape(-1, 2, 3)
        lattices = [Lattice(now[k] * member.unit) for k, member in enumerate(members)]
        return [replace(yarns, lattice=lattice) for yarns, lattice in zip(moved, lattices, strict=True)]

    def _go_back(self, cells: NDArray[np.bool_]) -> None:
        """Take the last good state of some cells again."""
        self._copy(cells, self.good_points, self.state.points)
        if self.good_periods is not None:
            self._copy_periods(cells, self.good_periods, self.model.constants.images.periods)
            self.candidates.near.reach = NOTHING_LISTED

    def _record(self) -> None:
        """Prepare the launches of an iteration, in their order."""
        self.assessor = None
        model, state, prepare = self.model, self.state, self.model.prepare
        whole = self.solver.burst(self.scene, self.point_stiffness, prepare)
        if whole is not None:
            self.burst, self.recording = int(PERIOD), CapturedLaunches([whole], model.device)
            return
        launches = evaluation.force_launches(model, state, self.candidates, self.terms, self.point_stiffness, prepare)
        for constraint in self.constraints:
            launches += constraint.filter_forces(state.force, prepare)
        launches += self.solver.launches(self.scene, prepare)
        self.burst = BURST["cuda" if model.device.is_cuda else "cpu"]
        self.recording = CapturedLaunches(launches, model.device, times=self.burst)
