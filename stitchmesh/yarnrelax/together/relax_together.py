# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Relaxations that many computations ask for (``asking_together``), done together in batches of cells.

A batch has one precision, one tolerance and one rule of quadrature. Its cells come to the states that ``relax_yarns``
finds within the tolerance, but with other roundings: candidate lists and Newton steps serve all cells of a batch, so
that the bits depend on which cells are in it. What cells of a batch cannot do is done alone: yarns without a lattice,
another solver, further terms, and yarns that cannot take their load at once (``load_path``).
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Hashable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from stitchmesh.compute.asking import Ask, Begun
from stitchmesh.compute.asking_together import Together
from stitchmesh.compute.device import alone, device_named
from stitchmesh.errors import StitchMeshError
from stitchmesh.time_limit import seconds_left
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.cell_stress import CellStress, cell_stress, cell_stresses
from stitchmesh.yarnrelax.convergence import rest_text
from stitchmesh.yarnrelax.energies.confinement import Confinement
from stitchmesh.yarnrelax.linking.certificate import pull_throughs_together, refuse_pull_through
from stitchmesh.yarnrelax.load_steps import StepAtRest, relax_through_steps
from stitchmesh.yarnrelax.relax import relax_yarns
from stitchmesh.yarnrelax.relax_partly import relax_partly
from stitchmesh.yarnrelax.relaxation_result import Relaxation
from stitchmesh.yarnrelax.together.begun_cell import BegunCell
from stitchmesh.yarnrelax.together.cell_batch import CellBatch, RelaxedCell, relax_batch, relax_batch_partly
from stitchmesh.yarnrelax.together.steps_together import group_of_steps, relax_group_through_steps

IN_CELLS = {"material", "quality", "device", "cell", "terms", "progress", "iterations"}
"""Arguments of relaxations that cells of a batch have."""

logger = logging.getLogger(__name__)


def ways_together() -> dict[Callable[..., Any], Together]:
    """How calls are answered together, the shortest work first."""
    return {
        cell_stress: cell_stresses_together,
        refuse_pull_through: refuse_pull_through_together,
        relax_partly: relax_partly_together,
        relax_yarns: relax_together,
        relax_through_steps: relax_through_steps_together,
    }


@alone()
def relax_together(asks: Sequence[Ask]) -> list[Relaxation | StitchMeshError | Begun]:
    """Answer calls of ``relax_yarns``: those of one quality in one batch of cells each, of which the last are left."""
    return _in_groups(asks, _relax_group)


@alone()
def relax_partly_together(asks: Sequence[Ask]) -> list[YarnSet | StitchMeshError]:
    """Answer calls of ``relax_partly``: those of one quality and as many iterations in one batch of cells each."""
    return _in_groups(asks, _relax_group_partly)


@alone()
def relax_through_steps_together(asks: Sequence[Ask]) -> list[list[StepAtRest] | StitchMeshError]:
    """Answer calls of ``relax_through_steps``: those of one quality, friction and path in one batch of cells each."""
    return _in_groups(asks, _relax_group_through_steps, group_of_steps)


def _relax_group_through_steps(asks: Sequence[Ask]) -> list[list[StepAtRest] | StitchMeshError]:
    found = relax_group_through_steps(asks)
    return [_alone(ask) if own is None else own for ask, own in zip(asks, found, strict=True)]


def _in_groups(asks: Sequence[Ask], relax: Any, group_of: Callable[[Ask, int], Hashable] | None = None) -> list[Any]:
    """Answer the calls of each group together, and those of a group of their own alone."""
    groups: dict[Hashable, list[int]] = {}
    for number, ask in enumerate(asks):
        groups.setdefault((group_of or _group_of)(ask, number), []).append(number)
    answers: dict[int, Any] = {}
    for numbers in groups.values():
        answers |= zip(numbers, _in_halves([asks[number] for number in numbers], relax), strict=True)
    return [answers[number] for number in range(len(asks))]


def _in_halves(asks: Sequence[Ask], relax: Any) -> list[Any]:
    """Answer calls together; where one is refused, or all need too much memory, in halves down to single ones."""
    if len(asks) == 1 and not isinstance(asks[0], Begun):
        return [_alone(asks[0])]
    try:
        found: list[Any] = relax(asks)
    except StitchMeshError as error:
        if len(asks) == 1:
            return [error]
        middle = len(asks) // 2
        return _in_halves(asks[:middle], relax) + _in_halves(asks[middle:], relax)
    return found


def _group_of(ask: Ask, number: int) -> Hashable:
    """What cells of a batch have in common; the number of the call if it belongs to no batch."""
    yarns, named = ask.positional[0], ask.named
    terms = named.get("terms", ())
    lies = len(terms) == 1 and isinstance(terms[0], Confinement)
    suits = named.keys() <= IN_CELLS and yarns.lattice is not None and named["quality"].solver == "quasistatic"
    if not suits or not (lies or len(terms) == 0):
        return number
    quality = replace(named["quality"], max_iterations=0, contact_samples=0)
    return quality, named.get("device"), named.get("cell") is None, lies, named.get("iterations")


def _alone(ask: Ask) -> Any:
    try:
        return ask.answer()
    except StitchMeshError as error:
        return error


def _batch(asks: Sequence[Ask]) -> CellBatch:
    """The batch of a group of calls."""
    begun = [ask.state if isinstance(ask, Begun) else None for ask in asks]
    given = [(ask.positional[0] if own is None else own.yarns, ask.named["material"])
             for ask, own in zip(asks, begun, strict=True)]  # fmt: skip
    free = [ask.named["cell"] for ask in asks if ask.named.get("cell") is not None]
    terms = [ask.named.get("terms", ()) for ask in asks]
    first = asks[0].named
    return CellBatch(
        given, free or None, [own[0] for own in terms] if terms[0] else None, first["quality"],
        device_named(first.get("device")), np.array([ask.named["quality"].max_iterations for ask in asks]),
        [ask.named["quality"].contact_samples for ask in asks], begun,
    )  # fmt: skip


def _relax_group(asks: Sequence[Ask]) -> list[Relaxation | StitchMeshError | Begun]:
    began, device = time.perf_counter(), asks[0].named.get("device")
    cells, _launched = relax_batch(_batch(asks), None, others_follow=True)
    out_of_time, seconds = seconds_left() <= 0.0, time.perf_counter() - began
    ended = [(ask.positional[0], cell.yarns) for ask, cell in zip(asks, cells, strict=True)
             if isinstance(cell, RelaxedCell)]  # fmt: skip
    passes = iter(pull_throughs_together(ended, device))
    answers = list[Relaxation | StitchMeshError | Begun]()
    for ask, cell in zip(asks, cells, strict=True):
        if isinstance(cell, BegunCell):
            answers.append(Begun(ask.function, ask.positional, ask.named, cell))
            continue
        error, before = next(passes), ask.state.seconds if isinstance(ask, Begun) else 0.0
        if cell.report["error"]:
            answers.append(_alone(ask))
        else:
            answers.append(error or _relaxation(ask, cell, before + seconds, device, out_of_time=out_of_time))
    return answers


def _relaxation(ask: Ask, cell: RelaxedCell, seconds: float, device: str | None, *, out_of_time: bool) -> Relaxation:
    """The relaxation of a cell of a batch."""
    own = cell.report
    if not own["converged"]:
        logger.warning("yarns are not at rest: %s", rest_text(own))
    names = ("iterations", "converged", "residual", "hidden_by_rounding", "remaining_change", "energy", "energies",
             "max_strain", "min_distance_over_radius")  # fmt: skip
    report = {
        "seconds": seconds, **{name: own[name] for name in names}, "stopped": False,
        "out_of_time": out_of_time and not own["converged"], "pull_throughs": 0, "certificate": "unchanged",
        "load_steps": None, "solver": ask.named["quality"].solver, "device": str(device_named(device)),
    }  # fmt: skip
    return Relaxation(cell.yarns, report, cell.history)


def _relax_group_partly(asks: Sequence[Ask]) -> list[YarnSet | StitchMeshError]:
    found = relax_batch_partly(_batch(asks), asks[0].named["iterations"])
    return [_alone(ask) if isinstance(each, str) else each for ask, each in zip(asks, found, strict=True)]


@alone()
def cell_stresses_together(asks: Sequence[Ask]) -> list[CellStress | StitchMeshError]:
    """Answer calls of ``cell_stress``: those of one quality together."""
    groups: dict[Hashable, list[int]] = {}
    for number, ask in enumerate(asks):
        groups.setdefault((ask.named["quadrature_points"], ask.named["device"]), []).append(number)
    answers: dict[int, CellStress | StitchMeshError] = {}
    for numbers in groups.values():
        named, samples = asks[numbers[0]].named, [asks[number].named["contact_samples"] for number in numbers]
        given = [(asks[number].positional[0], asks[number].positional[1]) for number in numbers]
        found = cell_stresses(given, named["quadrature_points"], samples, named["device"])
        answers |= zip(numbers, found, strict=True)
    return [answers[number] for number in range(len(asks))]


@alone()
def refuse_pull_through_together(asks: Sequence[Ask]) -> list[StitchMeshError | None]:
    """Answer calls of ``refuse_pull_through``: those of one device in the same launches."""
    devices: dict[str | None, list[int]] = {}
    for number, ask in enumerate(asks):
        devices.setdefault(ask.positional[2], []).append(number)
    answers: dict[int, StitchMeshError | None] = {}
    for device, numbers in devices.items():
        pairs = [(asks[number].positional[0], asks[number].positional[1]) for number in numbers]
        answers |= zip(numbers, pull_throughs_together(pairs, device), strict=True)
    return [answers[number] for number in range(len(asks))]
