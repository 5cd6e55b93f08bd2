# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Unstable balances: whether yarns without net forces are at a minimum of their energy, and the way down if not.

A symmetric fabric can balance at a saddle of its energy, and no force leads away from it. The exact Hessian H of a
periodic cell, of its control points and its free strains, is a sparse matrix (``assembled_hessian``). The yarns are at
a minimum if the factors of H + t I (``factored_matrix``) say that it has no negative eigenvalue, with

    t = SIGNIFICANT * median of the diagonal of H

Negative eigenvalues of H above -t are the roughness of sampled contacts and rounding. Otherwise the yarns move by the
part of a random vector x that lies in the eigenvectors v of the others,

    d = sum over k of  v_k (v_k . x)

which does not depend on the choice of eigenvectors of an eigenvalue that occurs twice. The move is scaled to ``MOVE``
radii at the control point that moves farthest and ``STRAIN`` of the cell, or to less where the step limit (``budget``)
asks for it: crowded yarns are closer to one another than such a move is long. It is rounded to ``GRID``
radii, so that another linear algebra gives the same bits. The yarns then relax again, until they are stable or their
energy falls by less than ``SMALLEST_FALL``: yarn that only slid along itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from stitchmesh.compute.asking import Asking, answered_alone, ask
from stitchmesh.compute.device import alone, device_named
from stitchmesh.lattice import Lattice, lattice_frame
from stitchmesh.mesh import FloatArray
from stitchmesh.quality import Quality
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.assembled_hessian import assembled_hessian
from stitchmesh.yarnrelax.collision.budget import STRAIN_UNIT
from stitchmesh.yarnrelax.energies.term import TermChoice
from stitchmesh.yarnrelax.hessian.factored_matrix import factored
from stitchmesh.yarnrelax.model.material import YarnMaterial
from stitchmesh.yarnrelax.observer import Progress
from stitchmesh.yarnrelax.relax import relax_yarns
from stitchmesh.yarnrelax.relaxation_result import Relaxation
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.solvers.cell_strain import RelaxCell

SIGNIFICANT = 5e-6
"""Magnitude of a negative eigenvalue that leads down, over the median of the diagonal. The median of all eigenvalues is
about a tenth of the latter in knits."""
MOVE, STRAIN = 0.2, 0.005
"""Largest move of a control point [radii], and largest strain of the cell."""
GRID = 1e-3
"""Distances to which moves are rounded [radii]."""
SMALLEST_FALL = 1e-4
"""Relative fall of the energy below which a further minimum is the same state."""
MOST_MOVES = 4
"""Largest number of moves from one balance to the next."""


@answered_alone
def relax_to_minimum(
    yarns: YarnSet, *, material: YarnMaterial, quality: Quality, device: str | None, cell: RelaxCell | None,
    terms: Sequence[TermChoice] = (), progress: Progress | Literal[False] | None = None,
) -> Asking[Relaxation]:  # fmt: skip
    """Relax yarns as ``relax_yarns``, and again after a move down where they come to rest at an unstable balance.

    The report and the history count the iterations and seconds of all relaxations, and so does the limit of iterations.

    Raises:
        SolverError: as for ``relax_yarns``.
    """
    shared: dict[str, Any] = {"material": material, "device": device, "cell": cell, "terms": terms}
    found: Relaxation = yield ask(relax_yarns, yarns, quality=quality, progress=progress, **shared)
    for _move in range(MOST_MOVES):
        left = replace(quality, max_iterations=quality.max_iterations - found.report["iterations"])
        examined = found.report["converged"] and left.max_iterations > 0
        down = (yield ask(leave_saddle, found.yarns, quality=quality, **shared)) if examined else None
        if down is None:
            break
        moved: Relaxation = yield ask(relax_yarns, down, quality=left, progress=progress, **shared)
        if moved.report["iterations"] == 0:  # a limit on the time: the state is that of as many iterations
            break
        before, found = found, continued(moved, found)
        if before.report["energy"] - found.report["energy"] < SMALLEST_FALL * abs(before.report["energy"]):
            break
    return found


def continued(relaxed: Relaxation, before: Relaxation) -> Relaxation:
    """Return a relaxation with the iterations, seconds and history of the one before it."""
    count, seconds = before.report["iterations"], before.report["seconds"]
    report = {"iterations": count + relaxed.report["iterations"], "seconds": seconds + relaxed.report["seconds"]}
    report["load_steps"] = relaxed.report["load_steps"] or before.report["load_steps"]
    history = list(before.history)
    for entry in relaxed.history:
        later = entry.copy()
        later["iteration"] += count
        later["seconds"] += seconds
        history.append(later)
    return Relaxation(relaxed.yarns, relaxed.report | report, history)


@alone()
def leave_saddle(
    yarns: YarnSet, *, material: YarnMaterial, quality: Quality, device: str | None, cell: RelaxCell | None,
    terms: Sequence[TermChoice] = (),
) -> YarnSet | None:  # fmt: skip
    """Return yarns at rest after a move down from an unstable balance; None if they are stable, or cannot be examined.

    Args:
        yarns: the yarns at rest, on a lattice.
        material: material of the yarns.
        quality: resolution with which they came to rest.
        device: device of the kernels.
        cell: degrees of freedom of the periods; None for constant ones.
        terms: further energies.
    """
    if yarns.lattice is None:
        return None
    simulation = YarnSimulation.start(yarns, material, quality, device_named(device), terms, cell=cell)
    if simulation.newton is None:
        return None
    allowed = simulation.state.budget.numpy().astype(np.float64)
    return moved_down(yarns, assembled_hessian(simulation), free_coordinates(yarns, cell), allowed)


def free_coordinates(yarns: YarnSet, cell: RelaxCell | None) -> NDArray[np.bool_]:
    """Return which coordinates of a cell are free: those of its control points, and then its strains, (N + 1, 3)."""
    free = np.ones((len(yarns.points) + 1, 3), dtype=bool)
    free[-1] = False if cell is None else cell.free
    return free


def moved_down(
    yarns: YarnSet, matrix: csc_array, free: NDArray[np.bool_], allowed: FloatArray
) -> YarnSet | None:  # fmt: skip
    """Return yarns after a move along the directions of an exact Hessian that lead down; None where none does.

    Args:
        yarns: the yarns, on a lattice.
        matrix: the Hessian, shape (3 E, 3 E), with the strains last if the periods may relax.
        free: which coordinates are free, shape (N + 1, 3); those beyond the matrix are held.
        allowed: as for ``moved``.
    """
    chosen = np.flatnonzero(free.ravel()[: matrix.shape[0]])
    own = csc_array(matrix[chosen][:, chosen])
    found = factored(own, SIGNIFICANT * float(np.median(own.diagonal())))
    if found.negative_count == 0:
        return None
    move = np.zeros(free.size)
    down = found.negative_eigenvectors()
    move[chosen] = down @ (down.T @ np.random.default_rng(0).normal(size=len(chosen)))
    return moved(yarns, move.reshape(free.shape), allowed)


def moved(yarns: YarnSet, move: FloatArray, allowed: FloatArray) -> YarnSet | None:
    """Return yarns on a lattice after a move; None where no move is allowed.

    Args:
        yarns: the yarns.
        move: direction of the move of control points and strains in units of the solver, shape (N + 1, 3).
        allowed: how far each control point may move, and the strains if they relax, in the same units, shape (E,).
    """
    assert yarns.lattice is not None
    farthest = float(np.linalg.norm(move[:-1], axis=1).max())
    largest = float(np.abs(move[-1]).max()) / float(STRAIN_UNIT)
    lengths = np.linalg.norm(move[: len(allowed)], axis=1)
    room = np.maximum(allowed - GRID, 0.0)  # rounding to the grid adds less than a step of the grid
    limits = np.divide(room, lengths, out=np.full(len(room), np.inf), where=lengths > 0.0)
    scale = min(MOVE / max(farthest, 1e-30), STRAIN / max(largest, 1e-30), float(limits.min()))
    steps = np.round(move * (scale / GRID)) * GRID
    if not steps.any():
        return None
    strain = steps[-1] / float(STRAIN_UNIT)
    e1, e2, _normal = lattice_frame(yarns.lattice.periods)
    matrix = np.eye(3) + strain[0] * np.outer(e1, e1) + strain[1] * np.outer(e2, e2) + strain[2] * np.outer(e2, e1)
    points = (yarns.points + steps[:-1] * float(yarns.radius.mean())) @ matrix
    return replace(yarns, points=points, lattice=Lattice(yarns.lattice.periods @ matrix))
