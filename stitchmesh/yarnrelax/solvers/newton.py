# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Newton's method, which ends a relaxation: each step minimises a model of the energy (``conjugate_gradients``).

L-BFGS brings yarns near to rest in cheap iterations, and then creeps along the soft directions of a fabric. Newton's
method sees these directions in the Hessian. The Hessian of Gauss and Newton is never negative, so each of its steps
lowers the energy, but near rest its steps fall only by a constant ratio. After each whole step, one that is shorter
than ``WHOLE`` times the limits of the moves, the share of the exact Hessian therefore grows. Where the mixed matrix
shows a direction of negative curvature, or the energy rises, the share falls again.

All moves of a cell are shortened by one factor, so that the step limit (``step_limit``) holds. Directions without much
stiffness, such as yarn that slides along itself, would otherwise hold up all others: at each control point whose moves
are longer than its limit, a multiple of its level of stiffness is added to H (Levenberg and Marquardt).

With the lengths s and s' of the last two whole steps, the change that is left is estimated as the sum of the steps that
would follow, s r / (1 - r) with r = s / s' (``RemainingChange``). Steps of which the work is less than the rounding of
the energy do not become shorter any more; for them r is at most ``SLOWEST``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import CapturedLaunches
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.thread_block import THREADS
from stitchmesh.time_limit import check_time
from stitchmesh.yarnrelax.collision.budget import STRAIN_UNIT, shortened
from stitchmesh.yarnrelax.hessian.hessian_product import Hessian
from stitchmesh.yarnrelax.model.constants import Model
from stitchmesh.yarnrelax.model.resting_cells import only_in
from stitchmesh.yarnrelax.model.spline import weight_row
from stitchmesh.yarnrelax.solvers.cell_strain import deformed, strains_of
from stitchmesh.yarnrelax.solvers.coarse_motions import suits_coarse_space
from stitchmesh.yarnrelax.solvers.coarse_space import CoarseSpace
from stitchmesh.yarnrelax.solvers.conjugate_gradients import (
    ACTIVE,
    CUT_SHORT,
    DONE,
    FACTOR,
    MOST,
    NEGATIVE,
    PRODUCTS,
    RATIO,
    SHORTEST_LIMIT,
    SQUARE,
    STEP_SCALE,
    STRAIN,
    WORK,
    EntryBlocks,
    advance_iterate,
    begin_cells,
    begin_directions,
    entry_blocks,
    find_direction,
    make_solve,
    start_solve,
    sum_curvature,
    sum_residuals,
)
from stitchmesh.yarnrelax.solvers.lbfgs_steps import CellRanges, cell_ranges
from stitchmesh.yarnrelax.solvers.preconditioner import inverse_block
from stitchmesh.yarnrelax.solvers.solver import SolverInputs
from stitchmesh.yarnrelax.solvers.spacing_change import SpacingChange

WHOLE = 0.25
"""Largest length of a step over the limits of the moves after which the share of the exact Hessian grows."""
FASTER, SLOWER = 1.0 / 3.0, 8.0
"""Factors of the share of the Hessian of Gauss and Newton after a whole step, and where the model was wrong."""
LEAST_SHARE = 0.02
"""Smallest share of the Hessian of Gauss and Newton: some directions, such as yarn that slides along itself, have no
stiffness of their own."""
LEAST_DAMPING = wp.constant(1e-6)
"""Smallest damping over the level of stiffness at a control point."""
LARGEST_GROWTH, LESS_DAMPING = wp.constant(64.0), wp.constant(4.0)
"""Largest growth of a damping in one step, and the factor by which it falls."""
TOO_LONG, SHORT = wp.constant(1.5), wp.constant(0.5)
"""Lengths of a move over its limit above which its damping grows, and below which it falls."""
RETURN = 3
"""Steps for which the share does not fall after the model was wrong."""
TRUSTED_SHARE = 0.34
"""Largest share of the Hessian of Gauss and Newton with which a change is estimated."""
SLOWEST = 0.9
"""Largest ratio of the lengths of two successive steps from which a change is estimated."""
MOST_PRODUCTS = 1000
"""Products with the Hessian in one step."""
LARGEST_PIECE = 1024
"""Control points of the largest piece without a lattice that Newton's method ends. The products of a step grow with the
piece, while a few stitches that slide reach the limits of moves and shorten it; larger pieces settle (``settling``)."""
PRODUCTS_AT_ONCE = {"cuda": 8, "cpu": 1}
"""Products of a graph. The host reads after each graph which cells are done."""


@dataclass(frozen=True)
class RemainingChange:
    """Estimate of the change that is left between a state and rest."""

    spacing: float
    """Largest relative change of the periods of the cell. Of a piece that Newton's method ends, the rms relative change
    of distances between neighbouring stitches; of other pieces, that of their mean along the yarns or across them."""
    energy: float
    """Relative change of the energy."""
    rms_radii: float
    """The rms displacement of the control points in yarn radii; of the stitches where Newton's method does not end."""


@kernel
def find_point_blocks(
    # model
    model: Any,
    further: wp.array[Any],
    # state in
    leg_hessian: wp.array2d[Any],
    sample_block: wp.array[Any],
    # state in and out
    solve: Any,
    # state out
    preconditioner: wp.array[Any],
) -> None:
    """The inverse of the damped block of the matrix of Gauss and Newton at each control point, and its level."""
    i = wp.tid()
    slots = model.point_segments[i]
    total = leg_hessian[0, 0] - leg_hessian[0, 0]
    block = type(preconditioner[0])()
    for slot in range(4):
        s = slots[slot]
        if s >= 0:
            if slot == 0:
                total += leg_hessian[0, s]
            if slot == 1:
                total += leg_hessian[0, s] + leg_hessian[3, s] - leg_hessian[1, s] - wp.transpose(leg_hessian[1, s])
            if slot == 2:
                total += leg_hessian[3, s] + leg_hessian[5, s] - leg_hessian[4, s] - wp.transpose(leg_hessian[4, s])
            if slot == 3:
                total += leg_hessian[5, s]
            first = model.sample_start[s]
            count = model.sample_start[s + 1] - first
            row = weight_row(model, count, 0)
            for k in range(count):
                weight = model.sample_basis[row + k][slot]
                block += sample_block[first + k] * (weight * weight)
    kind = further[i] * type(further[i])(1.0)
    block += type(block)(total[0, 0], total[1, 1], total[2, 2], total[0, 1], total[0, 2], total[1, 2])
    level = kind + (block[0] + block[1] + block[2]) / type(kind)(3.0)
    more = kind + level * (solve.damping[i] + type(kind)(1.0e-6))
    block += type(block)(more, more, more, kind - kind, kind - kind, kind - kind)
    solve.level[i] = level
    preconditioner[i] = inverse_block(block)


@wp.func
def next_damping(damping: Any, reach: Any) -> Any:
    """The damping after a move that was ``reach`` times as long as its limit."""
    least, one = type(reach)(LEAST_DAMPING), type(reach)(1.0)
    result = damping * one
    if reach > type(reach)(TOO_LONG):
        result = wp.max(damping, least) * wp.min(reach * reach, type(reach)(LARGEST_GROWTH))
    elif reach < type(reach)(SHORT):
        result = wp.where(damping > least, damping / type(reach)(LESS_DAMPING), least - least)
    return wp.min(result, one)


@kernel
def propose_steps(
    # model
    blocks: EntryBlocks,
    # state in and out
    solve: Any,
) -> None:
    """The step of each entry, no longer than its limit, and its damping in the next step."""
    block, lane = wp.tid()
    factor = solve.record[blocks.cell[block], FACTOR] * solve.record[blocks.cell[block], ACTIVE]
    for i in range(blocks.first[block] + lane, blocks.last[block], wp.block_dim()):
        x = solve.x[i]
        solve.step[i] = shortened(x * type(x[0])(factor), solve.limit[i])
        if factor != wp.float64(0.0):
            floor = type(x[0])(SHORTEST_LIMIT) * type(x[0])(solve.record[blocks.cell[block], STEP_SCALE])
            solve.damping[i] = next_damping(solve.damping[i], wp.length(x) / wp.max(solve.limit[i], floor))


@kernel
def apply_steps(
    # model
    cells: CellRanges,
    blocks: EntryBlocks,
    # state in and out
    strains: Any,
    solve: Any,
    points: wp.array[Any],
    listed_points: wp.array[Any],
) -> None:
    """Move all entries, and deform the control points and their listed places as the strains of their cells changed.

    The first control points of a cell also deform what stands once for each segment and for each period of the cell.
    """
    block, lane = wp.tid()
    cell = blocks.cell[block]
    for i in range(blocks.first[block] + lane, blocks.last[block], wp.block_dim()):
        points[i] = points[i] + solve.step[i]
        if strains.count > 0 and i < cells.point_count:
            e1, e2 = strains.frame[2 * cell], strains.frame[2 * cell + 1]
            more = solve.step[cells.point_count + cell] * strains.per_unit
            points[i] = deformed(points[i], e1, e2, more)
            listed_points[i] = deformed(listed_points[i], e1, e2, more)
            number = i - cells.points[cell]
            s = cells.segments[cell] + number
            if s < cells.segments[cell + 1]:
                strains.listed_centre[s] = deformed(strains.listed_centre[s], e1, e2, more)
            if number < 2:
                strains.periods[2 * cell + number] = deformed(strains.periods[2 * cell + number], e1, e2, more)


@kernel
def note_strains(
    # model
    first_entry: int,
    per_unit: wp.float64,
    # state in
    step: wp.array[Any],
    # state in and out
    record: wp.array2d[wp.float64],
) -> None:
    """Note the largest change of the strains of each cell."""
    cell = wp.tid()
    if first_entry < step.shape[0]:
        strain = step[first_entry + cell]
        largest = wp.max(wp.abs(strain[0]), wp.max(wp.abs(strain[1]), wp.abs(strain[2])))
        record[cell, STRAIN] = wp.float64(largest) * per_unit


class Newton:
    """Newton's method on a device."""

    def __init__(self, model: Model, further: NDArray[np.float64], strains: int = 0) -> None:
        """Allocate the vectors.

        Args:
            model: whose yarns are to come to rest.
            further: row sums of the stiffness of further terms, shape (N,).
            strains: how many cells relax, all or none.
        """
        self.model, self.strains = model, strains
        self.further = model.upload(np.maximum(further, np.finfo(np.float32).tiny))
        self.cells, self.blocks = cell_ranges(model), entry_blocks(model, strains)
        self.threads = THREADS if model.device.is_cuda else 1
        self.solve = make_solve(model, strains, self.blocks)
        self.coarse = CoarseSpace(model, strains) if suits_coarse_space(model) else None
        self.share = np.ones(model.cell_count)
        """Share of the Hessian of Gauss and Newton in the next step of each cell, shape (C,)."""
        self.length = np.zeros(model.cell_count)
        """Length of the last step of each cell, 0 where it was no whole step [units], shape (C,)."""
        self.ratio = np.ones(model.cell_count)
        """Length of the last step of each cell over the one before, shape (C,)."""
        self.wait = np.zeros(model.cell_count, dtype=np.int32)
        """Steps for which each cell keeps the Hessian of Gauss and Newton, shape (C,)."""
        self._spacing: dict[int, SpacingChange] = {}
        self._moved: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None
        self._last: NDArray[np.float64] | None = None
        self.discard_launches()

    def discard_launches(self) -> None:
        """Forget all captured launches: an array that they name was replaced."""
        self._hessian: Hessian | None = None

    @property
    def record(self) -> NDArray[np.float64]:
        """The record of the last step of each cell (``conjugate_gradients``), read once after each step."""
        if self._last is None:
            self._last = self.solve.record.numpy().copy()
        return self._last

    @property
    def cut_short(self) -> NDArray[np.bool_]:
        """Whether the last step of each cell was ended by a limit of its products that was asked for, shape (C,)."""
        return (self.record[:, DONE] == float(CUT_SHORT)) & (self.record[:, MOST] < MOST_PRODUCTS)

    def step(
        self, inputs: SolverInputs, forces: list[Any], cells: NDArray[np.bool_], step_scale: NDArray[np.float64],
        most: NDArray[np.int64] | None = None,
    ) -> NDArray[np.int64]:  # fmt: skip
        """Do one step of some cells.

        Args:
            inputs: the yarns; their candidate lists are up to date.
            forces: the launches that find the forces.
            cells: the cells that move, shape (C,).
            step_scale: scale of the limits of moves, shape (C,).
            most: largest number of products for each cell, shape (C,); ``MOST_PRODUCTS`` where it is larger.

        Returns:
            The number of products with the Hessian for each cell, 0 where it did not move, shape (C,).
        """
        if self._hessian is None:
            self._prepare(inputs, forces)
        assert self._hessian is not None
        record = self.record.copy()
        record[:, ACTIVE], record[:, STEP_SCALE] = cells, step_scale
        record[:, MOST] = MOST_PRODUCTS if most is None else np.minimum(most, MOST_PRODUCTS)
        self.solve.record.assign(record)
        with only_in(self.model, cells):
            self._minimise(self._hessian, cells)
        self._moved, self._last = None, None
        self._note(self.record, cells)
        return np.where(self.record[:, FACTOR] > 0.0, self.record[:, PRODUCTS], 0.0).astype(np.int64)

    def _minimise(self, hessian: Hessian, cells: NDArray[np.bool_]) -> None:
        """Find the minimum of the model of some cells, and move there; conjugate gradients mark the cells that end."""
        hessian.exact.zero_()
        self._begin.launch()
        if self.coarse is not None:
            self.coarse.invert(cells)
        if (self.share[cells] < 1.0).any():
            hessian.exact.assign(1.0 - self.share)
            self._find.launch()
        self._start.launch()
        while True:
            check_time()
            self._iterate.launch()
            if (self.solve.record.numpy()[:, DONE] > 0.0).all():
                break
        self._finish.launch()

    def restart(self, cells: NDArray[np.bool_]) -> None:
        """Trust the model of some cells less: their last step was not accepted."""
        self.share[cells] = np.minimum(self.share * SLOWER, 1.0)[cells]
        self.wait[cells], self.length[cells], self.ratio[cells] = RETURN, 0.0, 1.0

    def remaining_change(self, cell: int, size: float) -> RemainingChange | None:
        """Estimate of the change that is left, or None where there is none yet.

        Args:
            cell: the cell.
            size: sum of the magnitudes of its energies [erg].
        """
        record = self.record[cell]
        epsilon = np.finfo(np.float32 if self.model.scalar is wp.float32 else np.float64).eps
        is_rounding = self.length[cell] > 0.0 and record[WORK] < epsilon * size  # such steps do not become shorter
        ratio = min(float(self.ratio[cell]), SLOWEST) if is_rounding else float(self.ratio[cell])
        if ratio > SLOWEST or self.share[cell] > TRUSTED_SHARE:
            return None
        left = ratio / (1.0 - ratio)
        first, last = self.model.point_start[cell : cell + 2]
        rms = float(np.sqrt(record[SQUARE] / (last - first)))
        energy = float(0.5 * record[WORK] / size) if size > 0.0 else 0.0
        spacing = float(record[STRAIN]) if self.strains else self._spacing_change(cell)
        return RemainingChange(spacing * left, energy * left * left, rms * left)

    def _spacing_change(self, cell: int) -> float:
        """Change of the spacing of a cell, or of the only piece, by the last step."""
        own = slice(*self.model.point_start[cell : cell + 2])
        if self._moved is None:  # one transfer for all cells
            self._moved = self._points.numpy().astype(np.float64), self.solve.step.numpy().astype(np.float64)
        points, step = (array[own] for array in self._moved)
        if cell not in self._spacing:
            self._spacing[cell] = SpacingChange(self.model.cells[cell].yarns)
        return self._spacing[cell].of(points - step, step)

    def learned(self) -> list[dict[str, NDArray[Any]]]:
        """What persists from one step to the next, of each cell: as in ``arrays``, the damping with the strain last."""
        damping, table, record = self.solve.damping.numpy(), self._trust(), self.record
        start, points = self.model.point_start, self.model.point_count
        of_strain = 1 if self.strains else 0
        return [
            {"record": record[cell], "trust": table[cell],
             "damping": np.concatenate([damping[start[cell] : start[cell + 1]],
                                        damping[points + cell : points + cell + of_strain]])}
            for cell in range(len(table))
        ]  # fmt: skip

    def teach(self, cells: NDArray[np.int64], learned: Sequence[Mapping[str, NDArray[Any]]]) -> None:
        """Continue some cells, whose numbers are given, with what persisted of each (``learned``)."""
        table, record, damping = self._trust(), self.record.copy(), self.solve.damping.numpy()
        start, points = self.model.point_start, self.model.point_count
        for cell, own in zip(cells.tolist(), learned, strict=True):
            table[cell], record[cell] = own["trust"], own["record"]
            count = int(start[cell + 1] - start[cell])
            damping[start[cell] : start[cell + 1]] = own["damping"][:count]
            if self.strains:
                damping[points + cell] = own["damping"][count]
        self.resume({"trust": table, "record": record, "damping": damping})

    def _trust(self) -> NDArray[np.float64]:
        """Share, wait, length and ratio of each cell, shape (C, 4)."""
        return np.column_stack([self.share, self.wait, self.length, self.ratio])

    def arrays(self) -> dict[str, wp.array[Any]]:
        """What persists from one step to the next: share, wait, length and ratio of each cell, (C, 4), and more."""
        trust = wp.array(self._trust(), dtype=wp.float64, device=self.model.device)
        return {"record": self.solve.record, "damping": self.solve.damping, "trust": trust}

    def resume(self, arrays: dict[str, NDArray[Any]]) -> None:
        """Restore the contents of ``arrays``."""
        self.solve.record.assign(arrays["record"])
        self._last = None
        self.solve.damping.assign(arrays["damping"])
        self.share, wait, self.length, self.ratio = arrays["trust"].T.copy()
        self.wait = wait.astype(np.int32)

    def _prepare(self, inputs: SolverInputs, forces: list[Any]) -> None:
        """Capture the launches of a step for the current arrays."""
        model, state, device = inputs.model, inputs.state, inputs.model.device
        launcher, solve, blocks = model.prepare, self.solve, self.blocks
        self._hessian = hessian = Hessian(model, state, inputs.candidates, inputs.strain, inputs.terms)
        count, cells, resting = len(blocks.cell), model.cell_count, model.resting
        self._points = state.points
        ball, give = [state.points, state.listed_points, state.budget], [state.force, state.preconditioner]

        def tiled(kernel: wp.Kernel, *arguments: Any) -> Any:
            return launcher(kernel, count, list(arguments), [], tile=self.threads)

        def filtered(array: wp.array[Any]) -> list[Any]:
            return [launch for constraint in inputs.constraints for launch in constraint.filter_forces(array, launcher)]

        begin = list(forces)
        if inputs.strain is not None:
            begin += inputs.strain.force_launches(state, inputs.candidates, launcher)
        begin += hessian.find_launches(launcher)
        begin.append(launcher(find_point_blocks, model.point_count,
                              [model.constants, self.further, hessian.leg_hessian, state.sample_block],
                              [solve, state.preconditioner]))  # fmt: skip
        precondition: list[Any] = []
        if self.coarse is not None:
            self.coarse.prepare(hessian, state.points, solve.level, solve.damping)
            precondition += self.coarse.apply_launches(state.points, solve.r, solve.z, launcher)
        precondition += [*filtered(solve.z), tiled(sum_residuals, blocks, resting, solve)]
        start = [
            tiled(start_solve, blocks, model.number(inputs.step_fraction), *ball, *give, solve),
            *precondition,
            launcher(begin_cells, cells, [blocks, solve], [resting]),
            tiled(begin_directions, blocks, solve),
        ]
        iterate = [
            *hessian.product_launches(solve.p, solve.product, launcher),
            *filtered(solve.product),
            tiled(sum_curvature, blocks, solve),
            tiled(advance_iterate, model.point_count, blocks, *give, solve),
            *precondition,
            tiled(find_direction, self.cells, blocks, solve, resting),
        ]
        finish = [tiled(propose_steps, blocks, solve)]
        for constraint in inputs.constraints:
            finish += constraint.filter_steps(state, solve.step, solve.limit, launcher)
        strains = strains_of(model, inputs.strain, inputs.candidates)
        finish += [
            tiled(apply_steps, self.cells, blocks, strains, solve, *ball[:2]),
            launcher(note_strains, cells,
                     [model.point_count, wp.float64(1.0 / STRAIN_UNIT), solve.step, solve.record], []),
        ]  # fmt: skip
        times = PRODUCTS_AT_ONCE["cuda" if device.is_cuda else "cpu"]
        self._begin, self._start = CapturedLaunches(begin, device), CapturedLaunches(start, device)
        self._find = CapturedLaunches(hessian.find_launches(launcher), device)
        self._iterate = CapturedLaunches(iterate, device, times=times)
        self._finish = CapturedLaunches(finish, device)

    def _note(self, record: NDArray[np.float64], cells: NDArray[np.bool_]) -> None:
        """Note the step of the cells that moved, and how far the model of their next step can be trusted."""
        negative = record[:, NEGATIVE] > 0.0
        whole = (record[:, RATIO] < WHOLE) & ~negative & ~self.cut_short
        length = np.where(whole, np.sqrt(record[:, SQUARE]), 0.0)
        ratio = np.divide(length, self.length, out=np.ones_like(length), where=(self.length > 0.0) & whole)
        falls = whole & (self.wait == 0)
        share = np.where(negative, np.minimum(self.share * SLOWER, 1.0),
                         np.where(falls, np.maximum(self.share * FASTER, LEAST_SHARE), self.share))  # fmt: skip
        wait = np.where(negative, RETURN, np.maximum(self.wait - 1, 0))
        self.ratio[cells], self.length[cells] = ratio[cells], length[cells]
        self.share[cells], self.wait[cells] = share[cells], wait[cells]


def suits_newton(model: Model) -> bool:
    """Whether Newton's method ends the relaxation of these yarns.

    It does not for pieces with open yarns: nothing but friction holds their ends, and at rest such a piece has
    unravelled.
    """
    return model.on_lattice or (model.point_count <= LARGEST_PIECE and bool(model.yarns.closed.all()))
