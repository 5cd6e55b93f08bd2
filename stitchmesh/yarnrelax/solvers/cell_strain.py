# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A relaxing cell: the periods of the lattice are unknowns, like the control points.

Let e1 be the direction of the courses (the first period), and e2 the direction across them in the plane of the lattice.
The cell is deformed by

    F = I + a e1 e1^T + c e1 e2^T + b e2 e2^T

Here a stretches the cell along the courses, b along the wales, and c shears it. The first period keeps its direction,
so that the cell cannot rotate. Every place and both periods are multiplied by F, and images keep their numbers. An
element with places x_k and forces f_k that sum to zero contributes minus its virial, sum of f_k x_k^T, to the slope of
the energy, so that the forces on the strains are

    W_11, W_22, W_12       W = sum over legs of force leg^T + sum over pairs in contact of f_pq (y_p - y_q)^T    [erg]

These forces do not depend on the images in which the yarns are written. A load P1 along the courses and P2 along the
wales [dyn] on the borders of the cell is a dead load of energy - P1 |u| - P2 h, with u the first period and h the
extent of the second period across the courses. At rest W = -P |u|, and W over the area of the cell is its stress.

The strains of an iteration are relative to the current cell: each move of the strains deforms the cell, the control
points and their listed places. The strains are one more entry after the control points, (a, b, c) times
``STRAIN_UNIT``. Their stiffness is the stiffness of yarns that follow F. There, a segment that points along t, or a
pair in contact along t, has the strain m = (t1^2, t2^2, t1 t2):

    K = sum over segments of 2 (k_len + k_length) (l / l0) m m^T + sum over pairs of E'' d^2 m m^T

K only scales moves. While candidate lists last, two arcs at the distance D approach by the size of F - I times D, in
addition to the moves of their control points; ``step_limit`` divides the clearance between the strain and the points.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import warp as wp
from numpy.typing import NDArray

from stitchmesh.compute.captured import Launcher, ZeroArray
from stitchmesh.compute.kernel import kernel
from stitchmesh.compute.kernel_variants import named_type
from stitchmesh.compute.precision import Scalar, ScalarType, Vec3, Vec6, Vec9, vector
from stitchmesh.compute.thread_block import THREADS, VirialSums, sum_over_block
from stitchmesh.errors import ParameterError
from stitchmesh.lattice import lattice_frame
from stitchmesh.yarnrelax.collision.narrow_phase import Candidates
from stitchmesh.yarnrelax.collision.step_limit import STRAIN_UNIT
from stitchmesh.yarnrelax.model.constants import Model, YarnConstants
from stitchmesh.yarnrelax.model.state import State
from stitchmesh.yarnrelax.solvers.preconditioner import inverse_block

PARTS = 9
"""Sums of a cell: the three forces, and the block of stiffness (aa, bb, cc, ab, ac, bc)."""
HELD = wp.constant(wp.float64(1.0e20))
"""Stiffness of a held strain [erg]."""

SAMPLES_PER_BLOCK = 4 * THREADS
"""Contact samples of a cell for each block that sums over it."""
Block = wp.types.vector(length=6, dtype=wp.float64)


@dataclass(frozen=True)
class RelaxCell:
    """The changes that the periods of a cell are free to make, and the loads on its borders.

    Raises:
        ParameterError: a load is not finite.
    """

    course: float | None = 0.0
    """Load along the courses on the whole cell [dyn]; None keeps the length of the first period."""
    wale: float | None = 0.0
    """Load along the wales on the whole cell [dyn]; None keeps the extent of the second period across the courses."""
    shear: bool = True
    """Whether the angle between wales and courses may change."""

    def __post_init__(self) -> None:
        for name, load in (("course", self.course), ("wale", self.wale)):
            if load is not None and not np.isfinite(load):
                raise ParameterError(f"relax cell: got a load of {load} dyn along the {name}s; expected a number")

    @property
    def free(self) -> NDArray[np.bool_]:
        """Whether a, b and c are unknowns, shape (3,)."""
        return np.array([self.course is not None, self.wale is not None, self.shear])


StrainArrays: TypeAlias = Any
"""The struct of the strains of cells, in either precision."""

@wp.func
def add_cell_virial(
    total: Vec9, model: YarnConstants, first: int, last: int, lane: int, threads: int, segment_virial: wp.array[Vec9],
    sample_virial: wp.array[Vec9]
) -> Any:  # fmt: skip
    """Add the virial of every ``threads``-th segment and sample of a cell."""
    for s in range(first + lane, last, threads):
        for k in range(9):
            total[k] += wp.float64(segment_virial[s][k])
    for p in range(model.sample_start[first] + lane, model.sample_start[last], threads):
        for k in range(9):
            total[k] += wp.float64(sample_virial[p][k])
    return total


@kernel(tile=THREADS)
def gather_strain_forces(
    # model
    model: YarnConstants,
    blocks: int,
    cell_segments: wp.array[wp.int32],
    # state in
    segment_virial: wp.array[Vec9],
    sample_virial: wp.array[Vec9],
    # state out
    parts: wp.array3d[wp.float64],
) -> None:
    """Partial sums of the forces on a cell's strains and of their stiffness; the largest cell has ``blocks`` blocks.

    The number of blocks that sum over a cell does not depend on the other cells.
    """
    number, lane = wp.tid()
    threads = wp.block_dim()
    cell = number // blocks
    block = number - cell * blocks
    first, last = cell_segments[cell], cell_segments[cell + 1]
    samples = model.sample_start[last] - model.sample_start[first]
    own = wp.clamp(samples // wp.static(SAMPLES_PER_BLOCK), 1, blocks)
    total = VirialSums()
    if block < own:
        total = add_cell_virial(
            total, model, first, last, block * threads + lane, own * threads, segment_virial, sample_virial
        )
    sum_over_block(total, parts[cell, block])


@wp.func
def sum_of_blocks(parts: wp.array2d[wp.float64], lane: int, threads: int, totals: wp.array[wp.float64]) -> None:
    """Sum the partial sums of one cell; all threads of a block take part."""
    total = VirialSums()
    for block in range(lane, parts.shape[0], threads):
        for k in range(9):
            total[k] += parts[block, k]
    sum_over_block(total, totals)


@wp.func
def put_strain_force(
    cell: int, entry: int, strains: StrainArrays, force: wp.array[Vec3], stiffness: wp.array[Scalar],
    preconditioner: wp.array[Vec6]
) -> None:  # fmt: skip
    """Write the force on the strains of a cell and their preconditioner, from ``strains.totals``."""
    one = wp.float64(1.0)
    e1, e2 = strains.frame[2 * cell], strains.frame[2 * cell + 1]
    may, totals = strains.free[cell], strains.totals[cell]
    first = totals[0] + strains.loads[cell, 0] * wp.float64(wp.dot(strains.periods[2 * cell], e1))
    second = totals[1] + strains.loads[cell, 1] * wp.float64(wp.dot(strains.periods[2 * cell + 1], e2))
    per_unit = wp.float64(strains.per_unit)
    force[entry] = type(e1)(
        type(e1[0])(first * may[0] * per_unit),
        type(e1[0])(second * may[1] * per_unit),
        type(e1[0])(totals[2] * may[2] * per_unit),
    )
    stiffness[entry] = type(e1[0])(1.0e30)  # plain moves are for control points only
    square = per_unit * per_unit
    # parallel yarns that do not touch have no stiffness in the other directions
    spare = (totals[3] + totals[4] + totals[5]) * wp.float64(1.0e-3) + wp.float64(1.0e-30)
    held = (wp.vec3d(one, one, one) - may) * HELD + wp.vec3d(spare, spare, spare)
    block = inverse_block(Block(
        (totals[3] + held[0]) * square, (totals[4] + held[1]) * square, (totals[5] + held[2]) * square,
        totals[6] * may[0] * may[1] * square, totals[7] * may[0] * may[2] * square,
        totals[8] * may[1] * may[2] * square,
    ))  # fmt: skip
    give = preconditioner[entry]
    for k in range(6):
        give[k] = type(e1[0])(block[k])
    preconditioner[entry] = give


@kernel(tile=THREADS)
def put_strain_forces(
    # model
    first_entry: int,
    # state in and out
    strains: StrainArrays,
    # state out
    force: wp.array[Vec3],
    stiffness: wp.array[Scalar],
    preconditioner: wp.array[Vec6],
) -> None:
    """The forces on the strains of each cell and their preconditioner; one block for each cell."""
    cell, lane = wp.tid()
    sum_of_blocks(strains.parts[cell], lane, wp.block_dim(), strains.totals[cell])
    if lane == 0:
        put_strain_force(cell, first_entry + cell, strains, force, stiffness, preconditioner)


@wp.func
def deformed(place: Vec3, e1: Vec3, e2: Vec3, strain: Vec3) -> Any:
    """A place after a further strain (a, b, c) of its cell."""
    first, second = wp.dot(place, e1), wp.dot(place, e2)
    return place + e1 * (strain[0] * first + strain[2] * second) + e2 * (strain[1] * second)


@kernel
def add_strain_effort(
    # model
    free: wp.array[wp.vec3d],
    # state in
    totals: wp.array2d[wp.float64],
    # state out
    net: wp.array[wp.vec3d],
    effort: wp.array[wp.float64],
) -> None:
    """Add a term's force on the free strains of each cell, and its magnitude."""
    cell = wp.tid()
    force = wp.cw_mul(wp.vec3d(totals[cell, 0], totals[cell, 1], totals[cell, 2]), free[cell])
    net[cell] += force
    effort[cell] += wp.length(force)


@kernel(tile=THREADS)
def sum_parts(
    # state in
    parts: wp.array3d[wp.float64],
    # state out
    totals: wp.array2d[wp.float64],
) -> None:
    """Sum the partial sums of each cell; one block for each cell."""
    cell, lane = wp.tid()
    sum_of_blocks(parts[cell], lane, wp.block_dim(), totals[cell])


@functools.cache
def strains_struct(scalar: ScalarType) -> Any:
    """Return the struct of the strains of cells in one precision; ``count`` is 0 if no cell relaxes."""
    threes, doubles = wp.array(dtype=vector(3, scalar)), wp.float64
    annotations = {
        "count": wp.int32,
        "per_unit": scalar,
        "frame": threes,
        "loads": wp.array2d(dtype=doubles),
        "free": wp.array(dtype=wp.vec3d),
        "periods": threes,
        "listed_centre": threes,
        "parts": wp.array3d(dtype=doubles),
        "totals": wp.array2d(dtype=doubles),
    }
    return wp.struct(type(f"CellStrains_{scalar.__name__}", (), {"__annotations__": annotations}))


named_type("StrainArrays", lambda form: [strains_struct(form.scalar)])


class CellStrain:
    """The strains of a model's cells, on its device."""

    def __init__(self, model: Model, choices: Sequence[RelaxCell]) -> None:
        """Begin with zero strains of the current cells; there is one choice for each cell.

        Raises:
            ParameterError: the yarns have no lattice.
        """
        if not model.on_lattice:
            raise ParameterError("relax cell: the yarns repeat on no lattice; give them one, or leave it out")
        self.model, self.choices = model, tuple(choices)
        periods = np.stack([cell.yarns.lattice.periods for cell in model.cells if cell.yarns.lattice])
        self.host_frame = lattice_frame(periods)[:, :2]
        self.host_free = np.array([choice.free for choice in choices], dtype=np.float64)
        self.free = wp.array(self.host_free, dtype=wp.vec3d, device=model.device)
        self.host_loads = np.array([[choice.course or 0.0, choice.wale or 0.0] for choice in choices])
        self.loads = wp.array(self.host_loads * model.units[:, None], dtype=wp.float64, device=model.device)
        self.blocks = self._blocks()
        self.parts = wp.zeros((model.cell_count, self.blocks, PARTS), dtype=wp.float64, device=model.device)
        self.totals = wp.zeros((model.cell_count, PARTS), dtype=wp.float64, device=model.device)
        self.net = wp.zeros(model.cell_count, dtype=wp.vec3d, device=model.device)
        self.effort = wp.zeros(model.cell_count, dtype=wp.float64, device=model.device)

    def _blocks(self) -> int:
        """Return the number of blocks that sum over each cell; it suits the largest cell. Cores of a CPU share them."""
        return int(np.clip(self.model.largest_cell // SAMPLES_PER_BLOCK, 1, 64))

    @property
    def periods(self) -> wp.array[Any]:
        """The current periods [units], shape (2 C, 3)."""
        return self.model.constants.images.periods

    @property
    def frame(self) -> wp.array[Any]:
        """Directions along the courses and across them, shape (2 C, 3)."""
        return self.model.constants.images.frame

    def set_loads(self, loads: NDArray[np.float64]) -> None:
        """Change the loads on the borders of each cell along courses and wales [dyn], shape (C, 2)."""
        self.host_loads = loads
        self.loads.assign(loads * self.model.units[:, None])

    def struct(self, candidates: Candidates) -> Any:
        """Return the struct that kernels receive."""
        struct = strains_struct(self.model.scalar)()
        struct.count, struct.per_unit = self.model.cell_count, self.model.number(1.0 / STRAIN_UNIT)
        struct.listed_centre = candidates.near.listed_centre
        for name in ("frame", "loads", "free", "periods", "parts", "totals"):
            setattr(struct, name, getattr(self, name))
        return struct

    def gather_launch(self, state: State, launcher: Launcher) -> Any:
        """Return the launch that sums the forces on the strains, block by block."""
        inputs = [self.model.constants, self.blocks, self.model.cell_segments, state.segment_virial,
                  state.sample_virial]  # fmt: skip
        return launcher(
            gather_strain_forces, self.model.cell_count * self.blocks, inputs, [self.parts]
        )

    def force_launches(self, state: State, candidates: Candidates, launcher: Launcher) -> list[Any]:
        """Return the launches that leave the forces on the strains, and their preconditioners, in their entries."""
        outputs = [self.struct(candidates), state.force, state.stiffness, state.preconditioner]
        cells = self.model.cell_count
        put = launcher(put_strain_forces, cells, [self.model.point_count, *outputs], [])
        return [self.gather_launch(state, launcher), put]

    def clear_launches(self) -> list[Any]:
        """Return the launches that set the sums over terms to zero."""
        return [ZeroArray(self.net), ZeroArray(self.effort)]

    def sum_launches(self, state: State, launcher: Launcher) -> list[Any]:
        """Return the launches that leave the forces on the strains, from a state's virials, in ``totals`` [erg]."""
        cells = self.model.cell_count
        return [
            self.gather_launch(state, launcher),
            launcher(sum_parts, cells, [self.parts], [self.totals]),
        ]

    def add_launches(self, state: State, launcher: Launcher) -> list[Any]:
        """Return the launches that add the forces of one term on the strains, from the virials of this term."""
        add = launcher(add_strain_effort, self.model.cell_count, [self.free, self.totals], [self.net, self.effort])
        return [*self.sum_launches(state, launcher), add]

    def residuals(self) -> NDArray[np.float64]:
        """Magnitude of the sum of all forces on the strains, with the loads, over the sum of magnitudes, shape (C,)."""
        loads = self._on_borders() * self.host_free
        left = np.linalg.norm(self.net.numpy() + loads, axis=1)
        whole = self.effort.numpy() + np.linalg.norm(loads, axis=1)
        return np.where(whole > 0.0, left / np.where(whole > 0.0, whole, 1.0), 0.0)

    def tension_energies(self) -> NDArray[np.float64]:
        """Potential energy of the loads on each cell [erg], shape (C,)."""
        return -self._on_borders().sum(axis=1)

    def _on_borders(self) -> NDArray[np.float64]:
        """Forces of the loads on the strains [erg], shape (C, 3)."""
        periods = self.periods.numpy().astype(np.float64).reshape(-1, 2, 3) * self.model.units[:, None, None]
        sizes = np.einsum("ckd,ckd->ck", periods, self.host_frame)
        return np.column_stack([self.host_loads * sizes, np.zeros(len(sizes))])


def strains_of(model: Model, strain: CellStrain | None, candidates: Candidates) -> Any:
    """Return the struct that kernels receive; its ``count`` is 0 if no cell relaxes."""
    return strains_struct(model.scalar)() if strain is None else strain.struct(candidates)
