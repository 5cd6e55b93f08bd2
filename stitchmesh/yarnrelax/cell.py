# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A cell that relaxes: the periods of the lattice are unknowns, like the control points.

Let e1 be the direction of the courses (the first period), e2 the direction across them in the plane of the lattice. The
cell is deformed by

    F = I + a e1 e1^T + c e1 e2^T + b e2 e2^T

a stretches it along the courses, b along the wales, c shears it; the first period keeps its direction, so that the
cell cannot turn. Every place and both periods are multiplied by F, images keep their numbers. An element with places
x_k and forces f_k that sum to zero gives the energy a slope of minus its virial, sum of f_k x_k^T, so that the forces
on the strains are

    W_11, W_22, W_12       W = sum over legs of pull leg^T + sum over pairs in contact of f_pq (y_p - y_q)^T     [erg]

and none of it depends on which images the yarns are written in. A pull P1 along the courses and P2 along the wales
[dyn] on the borders of the cell are dead loads of energy - P1 |u| - P2 h, u the first period and h what the second
reaches across the courses. At rest W = -P |u|, and W over the area of the cell is its stress.

The strains of an iteration count from the cell as it lies: the cell is deformed by each move of theirs, and the control
points, with the places where they were listed, with it. They stand as one more entry after the control points,
(a, b, c) times ``STRAIN_UNIT``. Their stiffness is that of yarns which follow F, in which a segment that points along
t, or a pair in contact along t, is strained by m = (t1^2, t2^2, t1 t2):

    K = sum over segments of 2 (k_len + k_length) m m^T + sum over pairs of E'' d^2 m m^T

which only scales moves. While candidate lists last, two arcs D apart come nearer by the size of F - I times D beside
what their control points move; ``step_limit`` parts the clearance between the two.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.errors import ParameterError
from stitchmesh.lattice import lattice_frame
from stitchmesh.yarnrelax.block import THREADS, sum_rows, wait_for_block
from stitchmesh.yarnrelax.candidates import Candidates
from stitchmesh.yarnrelax.compliance import inverse_block
from stitchmesh.yarnrelax.model import Model
from stitchmesh.yarnrelax.recording import Zeroing
from stitchmesh.yarnrelax.state import STRAIN_UNIT, State
from stitchmesh.yarnrelax.term import Run

wp.set_module_options({"enable_backward": False})

PARTS = 9
"""Sums of a cell: the three forces, and the block of stiffness (aa, bb, cc, ab, ac, bc)."""
SAMPLES_PER_STRAND, FEWEST_STRANDS, MOST_STRANDS = 16, 256, 4096
"""Contact samples of the largest cell that a strand of a GPU takes, and the bounds of their number."""
HELD = wp.constant(wp.float64(1.0e20))
"""Stiffness of a strain that is held [erg]."""

Parts = wp.types.vector(length=PARTS, dtype=wp.float64)
Block = wp.types.vector(length=6, dtype=wp.float64)


@dataclass(frozen=True)
class RelaxCell:
    """What the periods of a cell are free to do.

    Raises:
        ParameterError: a pull is not finite.
    """

    course: float | None = 0.0
    """Pull along the courses on the whole cell [dyn]; None holds the first period."""
    wale: float | None = 0.0
    """Pull along the wales on the whole cell [dyn]; None holds how far the second period reaches across the courses."""
    shear: bool = True
    """Whether the wales may lean against the courses."""

    def __post_init__(self) -> None:
        for name, pull in (("course", self.course), ("wale", self.wale)):
            if pull is not None and not np.isfinite(pull):
                raise ParameterError(f"relax cell: got a pull of {pull} dyn along the {name}s; expected a number")

    @property
    def free(self) -> NDArray[np.bool_]:
        """Whether a, b and c are unknowns, shape (3,)."""
        return np.array([self.course is not None, self.wale is not None, self.shear])


@wp.kernel(module="unique")
def gather_strain_forces(
    # model
    model: Any,
    strands: int,
    cell_segments: wp.array[wp.int32],
    # state in
    segment_strain: wp.array[Any],
    sample_strain: wp.array[Any],
    # state out
    parts: wp.array3d[wp.float64],
) -> None:
    """A strand's share of the forces on a cell's strains and of their stiffness; so many strands a cell."""
    cell = wp.tid() // strands
    strand = wp.tid() - cell * strands
    first, last = cell_segments[cell], cell_segments[cell + 1]
    total = Parts()
    for s in range(first + strand, last, strands):
        for k in range(9):
            total[k] += wp.float64(segment_strain[s][k])
    for p in range(model.sample_start[first] + strand, model.sample_start[last], strands):
        for k in range(9):
            total[k] += wp.float64(sample_strain[p][k])
    for k in range(9):
        parts[cell, k, strand] = total[k]


@wp.func
def put_strain_force(
    cell: int,
    entry: int,
    strain_unit: wp.float64,
    frame: wp.array[Any],
    pulls: wp.array2d[wp.float64],
    free: wp.array[wp.vec3d],
    periods: wp.array[Any],
    totals: wp.array[wp.float64],
    point_force: wp.array[Any],
    stiffness: wp.array[Any],
    compliance: wp.array[Any],
) -> None:
    """Force on the strains of a cell and how they give way."""
    one = wp.float64(1.0)
    e1, e2 = frame[2 * cell], frame[2 * cell + 1]
    may = free[cell]
    first = totals[0] + pulls[cell, 0] * wp.float64(wp.dot(periods[2 * cell], e1))
    second = totals[1] + pulls[cell, 1] * wp.float64(wp.dot(periods[2 * cell + 1], e2))
    per_unit = one / strain_unit
    point_force[entry] = type(e1)(
        type(e1[0])(first * may[0] * per_unit),
        type(e1[0])(second * may[1] * per_unit),
        type(e1[0])(totals[2] * may[2] * per_unit),
    )
    stiffness[entry] = type(e1[0])(1.0e30)  # plain moves are the control points' alone
    if compliance.shape[0] > 0:
        square = per_unit * per_unit
        # yarns that do not touch and run along one direction do not hold the others
        spare = (totals[3] + totals[4] + totals[5]) * wp.float64(1.0e-3) + wp.float64(1.0e-30)
        held = (wp.vec3d(one, one, one) - may) * HELD + wp.vec3d(spare, spare, spare)
        block = inverse_block(Block(
            (totals[3] + held[0]) * square, (totals[4] + held[1]) * square, (totals[5] + held[2]) * square,
            totals[6] * may[0] * may[1] * square, totals[7] * may[0] * may[2] * square,
            totals[8] * may[1] * may[2] * square,
        ))  # fmt: skip
        give = compliance[entry]
        for k in range(6):
            give[k] = type(e1[0])(block[k])
        compliance[entry] = give


@wp.func
def deformed(place: Any, e1: Any, e2: Any, strain: Any) -> Any:
    """A place in a cell that is strained further by (a, b, c)."""
    first, second = wp.dot(place, e1), wp.dot(place, e2)
    return place + e1 * (strain[0] * first + strain[2] * second) + e2 * (strain[1] * second)


@wp.kernel(module="unique")
def sum_strain_forces(
    # model
    point_count: int,
    strain_unit: wp.float64,
    frame: wp.array[Any],
    pulls: wp.array2d[wp.float64],
    free: wp.array[wp.vec3d],
    # state in
    periods: wp.array[Any],
    parts: wp.array3d[wp.float64],
    # state out
    totals: wp.array2d[wp.float64],
    point_force: wp.array[Any],
    stiffness: wp.array[Any],
    compliance: wp.array[Any],
) -> None:
    """Sum what the strands of each cell gathered; a block a cell."""
    cell, lane = wp.tid()
    sum_rows(parts[cell], 9, lane, wp.block_dim(), totals[cell])
    wait_for_block()
    if lane == 0:
        put_strain_force(
            cell, point_count + cell, strain_unit, frame, pulls, free, periods, totals[cell], point_force, stiffness,
            compliance,
        )  # fmt: skip


@wp.kernel(module="unique")
def add_strain_effort(
    # model
    free: wp.array[wp.vec3d],
    # state in
    totals: wp.array2d[wp.float64],
    # state out
    net: wp.array[wp.vec3d],
    effort: wp.array[wp.float64],
) -> None:
    """Add a term's force on the strains of each cell that are free, and its size."""
    cell = wp.tid()
    force = wp.cw_mul(wp.vec3d(totals[cell, 0], totals[cell, 1], totals[cell, 2]), free[cell])
    net[cell] += force
    effort[cell] += wp.length(force)


@wp.kernel(module="unique")
def sum_parts(
    # state in
    parts: wp.array3d[wp.float64],
    # state out
    totals: wp.array2d[wp.float64],
) -> None:
    """Sum what the strands of each cell gathered; a block a cell."""
    cell, lane = wp.tid()
    sum_rows(parts[cell], 9, lane, wp.block_dim(), totals[cell])


@wp.kernel(module="unique")
def deform_cell(
    # model
    frame: wp.array[Any],
    per_unit: Any,
    point_count: int,
    segment_count: int,
    # state in
    step: wp.array[Any],
    # state out
    points: wp.array[Any],
    listed_points: wp.array[Any],
    listed_centre: wp.array[Any],
    periods: wp.array[Any],
) -> None:
    """Deform the only cell by the last move of its strains; a thread for each place."""
    i = wp.tid()
    e1, e2 = frame[0], frame[1]
    strain = step[point_count] * per_unit
    if i < point_count:
        points[i] = deformed(points[i], e1, e2, strain)
        listed_points[i] = deformed(listed_points[i], e1, e2, strain)
    if i < segment_count:
        listed_centre[i] = deformed(listed_centre[i], e1, e2, strain)
    if i < 2:
        periods[i] = deformed(periods[i], e1, e2, strain)


class CellStrain:
    """The strains of a model's cells, on its device."""

    def __init__(self, model: Model, choices: Sequence[RelaxCell]) -> None:
        """At rest relative to the cells as they lie; one choice for each.

        Raises:
            ParameterError: the yarns have no lattice.
        """
        if not model.on_lattice:
            raise ParameterError("relax cell: the yarns repeat on no lattice; give them one, or leave it out")
        self.model, self.choices = model, tuple(choices)
        periods = np.stack([member.yarns.lattice.periods for member in model.members if member.yarns.lattice])
        self.host_frame = lattice_frame(periods)[:, :2]
        self.host_free = np.array([choice.free for choice in choices], dtype=np.float64)
        self.free = wp.array(self.host_free, dtype=wp.vec3d, device=model.device)
        self.host_pulls = np.array([[choice.course or 0.0, choice.wale or 0.0] for choice in choices])
        self.pulls = wp.array(self.host_pulls * model.units[:, None], dtype=wp.float64, device=model.device)
        self.strands = self._strands()
        self.parts = wp.zeros((model.cell_count, PARTS, self.strands), dtype=wp.float64, device=model.device)
        self.totals = wp.zeros((model.cell_count, PARTS), dtype=wp.float64, device=model.device)
        self.net = wp.zeros(model.cell_count, dtype=wp.vec3d, device=model.device)
        self.effort = wp.zeros(model.cell_count, dtype=wp.float64, device=model.device)

    def _strands(self) -> int:
        """Strands of each cell: one on a CPU, as many as suit the largest cell on a GPU."""
        if not self.model.device.is_cuda:
            return 1
        wanted = 1 << (self.model.largest_cell // SAMPLES_PER_STRAND).bit_length()
        return int(np.clip(wanted, FEWEST_STRANDS, MOST_STRANDS))

    @property
    def periods(self) -> wp.array[Any]:
        """The periods as they are [units], shape (2 C, 3)."""
        return self.model.constants.images.periods

    @property
    def frame(self) -> wp.array[Any]:
        """Directions along the courses and across them, shape (2 C, 3)."""
        return self.model.constants.images.frame

    @property
    def numbers(self) -> list[Any]:
        """What kernels need to know."""
        return [self.model.point_count, wp.float64(STRAIN_UNIT), self.frame, self.pulls, self.free]

    def gather_launch(self, state: State, run: Run) -> Any:
        """Gather the forces on the strains strand by strand."""
        inputs = [self.model.constants, self.strands, self.model.cell_segments, state.segment_strain,
                  state.sample_strain]  # fmt: skip
        return run(gather_strain_forces, self.model.cell_count * self.strands, inputs, [self.parts])

    def force_launches(self, state: State, run: Run) -> list[Any]:
        """Leave the forces on the strains after those on the control points."""
        outputs = [self.totals, state.point_force, state.stiffness, state.compliance]
        inputs = [*self.numbers, self.periods, self.parts]
        return [
            self.gather_launch(state, run),
            run(sum_strain_forces, self.model.cell_count, inputs, outputs, tile=THREADS),
        ]

    def deform_launch(self, state: State, candidates: Candidates, step: wp.array[Any], run: Run) -> Any:
        """Deform the only cell by its part of a move."""
        sizes = [self.model.point_count, self.model.segment_count]
        inputs = [self.frame, self.model.number(1.0 / STRAIN_UNIT), *sizes, step]
        outputs = [state.points, state.listed_points, candidates.near.listed_centre, self.periods]
        return run(deform_cell, max(*sizes, 2), inputs, outputs)

    def clear_launches(self) -> list[Any]:
        """Forget what terms exert."""
        return [Zeroing(self.net), Zeroing(self.effort)]

    def effort_launches(self, state: State, run: Run) -> list[Any]:
        """Add what one term exerts on the strains, whose shares are fresh."""
        cells = self.model.cell_count
        return [
            self.gather_launch(state, run),
            run(sum_parts, cells, [self.parts], [self.totals], tile=THREADS),
            run(add_strain_effort, cells, [self.free, self.totals], [self.net, self.effort]),
        ]

    def residuals(self) -> NDArray[np.float64]:
        """Size of the sum of all forces on the strains, pulls included, over the sum of their sizes, shape (C,)."""
        pulls = self._on_borders() * self.host_free
        left = np.linalg.norm(self.net.numpy() + pulls, axis=1)
        whole = self.effort.numpy() + np.linalg.norm(pulls, axis=1)
        return np.where(whole > 0.0, left / np.where(whole > 0.0, whole, 1.0), 0.0)

    def tension_energies(self) -> NDArray[np.float64]:
        """Potential energy of the pulls on each cell [erg], shape (C,)."""
        return -self._on_borders().sum(axis=1)

    def _on_borders(self) -> NDArray[np.float64]:
        """Forces of the pulls on the strains [erg], shape (C, 3)."""
        periods = self.periods.numpy().astype(np.float64).reshape(-1, 2, 3) * self.model.units[:, None, None]
        sizes = np.einsum("ckd,ckd->ck", periods, self.host_frame)
        return np.column_stack([self.host_pulls * sizes, np.zeros(len(sizes))])
