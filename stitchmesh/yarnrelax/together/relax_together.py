# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Relaxations that many computations wait for (``work_together``), done together in batches of cells.

A batch has one precision, one tolerance and one quadrature rule. Its cells come to the states that ``relax_yarns``
finds. The bits of a cell depend on no other cell of its batch: its candidate lists, its Newton steps and its sums are
its own, and it goes from batch to batch with all its memory (``carried_cells``). Larger cells, which a GPU does not
factor as dense matrices (``dense_cells``), are factored in groups; only for them the bits depend on the others. Some
relaxations cannot be part of a batch and are done alone: yarns without a lattice, another solver, further terms, and
yarns that cannot take their load at once (``loading``).

On a CPU only short work is done together. A launch costs little there, and launches also pass over cells at rest.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Hashable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from stitchmesh.compute.device import alone, device_named
from stitchmesh.compute.shared_work import Call
from stitchmesh.compute.work_together import Begun, Together
from stitchmesh.errors import SolverError, StitchMeshError
from stitchmesh.linking.certificate import pull_throughs_together, refuse_pull_through
from stitchmesh.run import SHOWN
from stitchmesh.time_limit import seconds_left
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.cell_stress import CellStress, cell_stress, cell_stresses
from stitchmesh.yarnrelax.convergence import rest_text
from stitchmesh.yarnrelax.energies.confinement import Confinement
from stitchmesh.yarnrelax.hessian.dense_cells import LARGEST_DENSE
from stitchmesh.yarnrelax.load_steps import StepAtRest, relax_through_steps
from stitchmesh.yarnrelax.model.upload import sample_counts
from stitchmesh.yarnrelax.relax import relax_partly, relax_yarns
from stitchmesh.yarnrelax.relaxation_result import Relaxation
from stitchmesh.yarnrelax.solvers.lbfgs_fused import MOST_POINTS, threads_of_cell
from stitchmesh.yarnrelax.together.cell_batch import (
    BegunCell,
    CellBatch,
    RelaxedCell,
    relax_batch,
    relax_batch_partly,
)
from stitchmesh.yarnrelax.together.steps_together import group_of_steps, relax_group_through_steps

IN_CELLS = {"yarns", "material", "quality", "device", "cell", "terms", "run", "iterations"}
"""Arguments of a relaxation that can be part of a batch."""

logger = logging.getLogger(__name__)


def ways_together() -> dict[Callable[..., Any], Together]:
    """Return the functions that do the work of calls together, the shortest work first."""
    return {
        cell_stress: cell_stresses_together,
        refuse_pull_through: refuse_pull_through_together,
        relax_partly: relax_partly_together,
        relax_yarns: relax_together,
        relax_through_steps: relax_through_steps_together,
    }


@alone()
def cell_stresses_together(calls: Sequence[Call]) -> list[CellStress | StitchMeshError]:
    """Do calls of ``cell_stress``; calls with the same quality and device are done together, twisted yarns alone."""

    def quality_of(call: Call, number: int) -> Hashable:
        given = call.arguments
        return given["quadrature_points"], given["device"], None if given.get("twist") is None else number

    def stresses(group: Sequence[Call]) -> list[CellStress]:
        each = [call.arguments for call in group]
        cells = [(given["yarns"], given["material"]) for given in each]
        samples = [given["contact_samples"] for given in each]
        return cell_stresses(cells, each[0]["quadrature_points"], samples, each[0]["device"], each[0].get("twist"))

    return _in_groups(calls, stresses, quality_of)


@alone()
def refuse_pull_through_together(calls: Sequence[Call]) -> list[StitchMeshError | None]:
    """Do calls of ``refuse_pull_through``; calls with the same device share launches."""

    def device_of(call: Call, _number: int) -> Hashable:
        return call.arguments.get("device")

    def errors(group: Sequence[Call]) -> list[SolverError | None]:
        pairs = [(call.arguments["drawn"], call.arguments["relaxed"]) for call in group]
        return pull_throughs_together(pairs, group[0].arguments.get("device"))

    return _in_groups(calls, errors, device_of)


@alone()
def relax_partly_together(calls: Sequence[Call]) -> list[YarnSet | StitchMeshError]:
    """Do calls of ``relax_partly``; calls with the same quality and number of iterations share a batch."""
    return _in_groups(calls, partial(_in_halves, _relax_group_partly), _group_of)


@alone()
def relax_together(calls: Sequence[Call]) -> list[Relaxation | StitchMeshError | Begun]:
    """Do calls of ``relax_yarns``; calls with the same quality share a batch, whose last cells are left."""
    return _in_groups(calls, partial(_in_halves, _relax_group), _on_a_gpu(_group_of))


@alone()
def relax_through_steps_together(calls: Sequence[Call]) -> list[list[StepAtRest] | StitchMeshError]:
    """Do calls of ``relax_through_steps``; calls with the same quality, friction and path share a batch."""
    return _in_groups(calls, partial(_in_halves, _relax_group_through_steps), _on_a_gpu(group_of_steps))


def _on_a_gpu(group_of: Callable[[Call, int], Hashable]) -> Callable[[Call, int], Hashable]:
    """Return a function that groups calls on a GPU; each call on a CPU is a group of its own."""

    def group(call: Call, number: int) -> Hashable:
        return group_of(call, number) if device_named(call.arguments.get("device")).is_cuda else number

    return group


def _in_groups(
    calls: Sequence[Call], do: Callable[[Sequence[Call]], Sequence[Any]], group_of: Callable[[Call, int], Hashable]
) -> list[Any]:
    """Do the calls of each group together."""
    groups: dict[Hashable, list[int]] = {}
    for number, call in enumerate(calls):
        groups.setdefault(group_of(call, number), []).append(number)
    results: dict[int, Any] = {}
    for numbers in groups.values():
        results |= zip(numbers, do([calls[number] for number in numbers]), strict=True)
    return [results[number] for number in range(len(calls))]


def _in_halves(relax: Callable[[Sequence[Call]], list[Any]], calls: Sequence[Call]) -> list[Any]:
    """Do calls together; if one is refused, or all need too much memory, do them in halves, down to single calls."""
    if len(calls) == 1 and not isinstance(calls[0], Begun):
        return [_alone(calls[0])]
    try:
        return relax(calls)
    except StitchMeshError as error:
        if len(calls) == 1:
            return [error]
        middle = len(calls) // 2
        return _in_halves(relax, calls[:middle]) + _in_halves(relax, calls[middle:])


def _group_of(call: Call, number: int) -> Hashable:
    """Return what the cells of a batch have in common; the number of the call if it belongs to no batch."""
    given = call.arguments
    terms = given.get("terms", ())
    lies = len(terms) == 1 and isinstance(terms[0], Confinement)
    suits = given.keys() <= IN_CELLS and given["quality"].solver == "quasistatic" and given.get("run", SHOWN).only_shows
    if not suits or not (lies or len(terms) == 0) or given["yarns"].lattice is None:
        return number
    quality = replace(given["quality"], max_iterations=0, contact_samples=0)
    yarns, is_free = given["yarns"], given.get("cell") is not None
    # What decides the order of sums is the same in all cells of a batch, so that no cell depends on the others.
    threads = None if lies else _threads_of(yarns, given["quality"].contact_samples)
    is_small = 3 * (len(yarns.points) + is_free) <= LARGEST_DENSE
    return quality, given.get("device"), is_free, lies, threads, is_small, given.get("iterations")


def _threads_of(yarns: YarnSet, contact_samples: int) -> int | None:
    """Return the threads of the block that iterates a cell without planes; None if the cell is too large for one."""
    if len(yarns.points) > MOST_POINTS:
        return None
    return threads_of_cell(int(sample_counts(yarns, contact_samples).sum()), len(yarns.rest_length))


def _alone(call: Call) -> Any:
    try:
        return call.do()
    except StitchMeshError as error:
        return error


def _batch(calls: Sequence[Call]) -> CellBatch:
    """Return the batch of a group of calls."""
    each = [call.arguments for call in calls]
    first = each[0]
    begun = [call.state if isinstance(call, Begun) else None for call in calls]
    free = [given["cell"] for given in each if given.get("cell") is not None]
    planes = [given["terms"][0] for given in each if given.get("terms")]
    return CellBatch(
        [(given["yarns"], given["material"]) for given in each],
        free or None, planes or None, first["quality"], device_named(first.get("device")),
        np.array([given["quality"].max_iterations for given in each]),
        [given["quality"].contact_samples for given in each], begun,
    )  # fmt: skip


def _relax_group_partly(calls: Sequence[Call]) -> list[YarnSet | StitchMeshError]:
    found = relax_batch_partly(_batch(calls), calls[0].arguments["iterations"])
    return [_alone(call) if isinstance(own, str) else own for call, own in zip(calls, found, strict=True)]


def _relax_group_through_steps(calls: Sequence[Call]) -> list[list[StepAtRest] | StitchMeshError]:
    found = relax_group_through_steps(calls)
    return [_alone(call) if own is None else own for call, own in zip(calls, found, strict=True)]


def _relax_group(calls: Sequence[Call]) -> list[Relaxation | StitchMeshError | Begun]:
    began = time.perf_counter()
    device = calls[0].arguments.get("device")
    cells, _launched = relax_batch(_batch(calls), None, others_follow=True)
    out_of_time = seconds_left() <= 0.0
    seconds = time.perf_counter() - began
    ended = [(call.arguments["yarns"], cell.yarns) for call, cell in zip(calls, cells, strict=True)
             if isinstance(cell, RelaxedCell)]  # fmt: skip
    passes = iter(pull_throughs_together(ended, device))
    results = list[Relaxation | StitchMeshError | Begun]()
    for call, cell in zip(calls, cells, strict=True):
        if isinstance(cell, BegunCell):
            results.append(Begun(call.function, call.arguments, cell))
            continue
        error = next(passes)
        before = call.state.seconds if isinstance(call, Begun) else 0.0
        if cell.report["error"]:
            results.append(_alone(call))
        else:
            results.append(error or _relaxation(call, cell, before + seconds, out_of_time=out_of_time))
    return results


def _relaxation(call: Call, cell: RelaxedCell, seconds: float, *, out_of_time: bool) -> Relaxation:
    """Return the relaxation of a cell of a batch."""
    own = cell.report
    if not own["converged"]:
        logger.warning("yarns are not at rest: %s", rest_text(own))
    names = ("iterations", "converged", "residual", "hidden_by_rounding", "remaining_change", "energy", "energies",
             "max_strain", "min_distance_over_radius")  # fmt: skip
    report = {
        "seconds": seconds, **{name: own[name] for name in names}, "stopped": False,
        "out_of_time": out_of_time and not own["converged"], "pull_throughs": 0, "certificate": "unchanged",
        "load_steps": None, "solver": call.arguments["quality"].solver,
        "device": str(device_named(call.arguments.get("device"))),
    }  # fmt: skip
    return Relaxation(cell.yarns, report, cell.history)
