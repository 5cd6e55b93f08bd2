# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Load steps of many cells together (``load_steps``).

Each cell has its own loads, and goes on to its next step once it is at rest. All cells have one coefficient of
friction. Before a step that changes the coefficient, or that draws the cells, they therefore wait for each other.
"""

from __future__ import annotations

import time
from collections.abc import Hashable, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from stitchmesh.compute.device import device_named
from stitchmesh.compute.shared_work import Call
from stitchmesh.errors import OverloadError, StitchMeshError
from stitchmesh.io.history import HistoryEntry
from stitchmesh.linking.certificate import pull_throughs_together
from stitchmesh.run import SHOWN
from stitchmesh.time_limit import OutOfTime
from stitchmesh.yarnrelax.energies.confinement import CellConfinements, Confinement
from stitchmesh.yarnrelax.energies.term import YarnChoice
from stitchmesh.yarnrelax.load_steps import LoadedCells, LoadStep, StepAtRest, friction_and_others
from stitchmesh.yarnrelax.simulation import YarnSimulation

IN_CELLS = {"yarns", "steps", "terms", "material", "quality", "cell", "device", "run"}
"""Arguments of ``relax_through_steps`` that many cells may have together."""


def group_of_steps(call: Call, number: int) -> Hashable:
    """Return what the cells of a group of calls have in common; the number of the call if it belongs to no group."""
    given = call.arguments
    friction, others = friction_and_others(given["terms"])
    lies = len(others) == 1 and isinstance(others[0], Confinement)
    suits = given.keys() <= IN_CELLS and given["quality"].solver == "quasistatic" and given.get("run", SHOWN).only_shows
    if not suits or not (lies or len(others) == 0):
        return number
    path = tuple((step.friction, step.stretch) for step in given["steps"])
    return replace(given["quality"], contact_samples=0), given.get("device"), friction, lies, path


def relax_group_through_steps(calls: Sequence[Call]) -> list[list[StepAtRest] | StitchMeshError | None]:
    """Do calls of ``relax_through_steps`` of one group; None for a cell that cannot continue together with others."""
    path = _Path(calls)
    steps = [call.arguments["steps"] for call in calls]
    for first, last in pairwise(_waits(steps[0])):
        path.take([own[first:last] for own in steps])
        if path.out_of_time:
            break
    failed = path.cells.loop.failed.tolist()
    given = [(call.arguments["yarns"], own[-1].yarns) for call, own in zip(calls, path.found, strict=True)]
    passes = pull_throughs_together(given, calls[0].arguments.get("device"))
    return [None if fails else error or own for fails, error, own in zip(failed, passes, path.found, strict=True)]


def _waits(steps: Sequence[LoadStep]) -> list[int]:
    """Return the numbers of the steps before which cells wait for each other, and the number of steps."""
    waits = [number for number, step in enumerate(steps)
             if number == 0 or step.stretch != (1.0, 1.0) or step.friction != steps[number - 1].friction]  # fmt: skip
    return [*waits, len(steps)]


class _Path:
    """Cells on their way through the steps."""

    def __init__(self, calls: Sequence[Call]) -> None:
        """Put the cells on the device."""
        self.began = time.perf_counter()
        each = [call.arguments for call in calls]
        first = each[0]
        others = [friction_and_others(given["terms"])[1] for given in each]
        planes = tuple(term for own in others for term in own if isinstance(term, Confinement))
        terms: list[YarnChoice] = [friction_and_others(first["terms"])[0]]
        terms += [CellConfinements(planes)] if planes else []
        simulation = YarnSimulation(
            [(given["yarns"], given["material"]) for given in each], first["quality"],
            device_named(first.get("device")), terms, cells=[given["cell"] for given in each],
            samples=[given["quality"].contact_samples for given in each],
        )  # fmt: skip
        self.cells = LoadedCells(simulation, first["quality"])
        self.found: list[list[StepAtRest]] = [[] for _call in calls]
        """The steps of each cell that have ended."""
        self.history: list[list[HistoryEntry]] = [[] for _call in calls]
        """The figures of each cell's assessments in its present step."""
        self.before = self.cells.loop.iterations.copy()
        """Iterations of each cell before its present step, shape (C,)."""
        self.out_of_time = False

    def take(self, steps: Sequence[Sequence[LoadStep]]) -> None:
        """Take the next steps of each cell; the first step draws the cells and sets the friction of all."""
        loop = self.cells.loop
        first = steps[0][0]
        number = np.zeros(len(steps), dtype=np.int64)
        active = np.ones(len(steps), dtype=bool)
        self.cells.load(_loads(steps, number), first.friction, first.stretch)
        self._begin(active)
        noted = loop.iterations.copy()
        try:
            while active.any():
                left = self.cells.unfinished(active)
                if (ended := active & ~left).any():
                    self._end(ended)
                    number[ended] += 1
                    active &= (number < len(steps[0])) & ~loop.failed
                    self.cells.load(_loads(steps, number), first.friction, (1.0, 1.0))
                    self._begin(ended & active)
                    left |= ended & active
                if left.any():
                    loop.advance(left)
                    self._note(noted)
        except OverloadError:  # The only cell, whose error the loop keeps.
            self._end(active)
        except OutOfTime:
            self.out_of_time = True
            self._end(active)

    def _begin(self, cells: NDArray[np.bool_]) -> None:
        """Begin a step of some cells."""
        if cells.any():
            before = self.cells.loop.iterations
            self.cells.begin(cells)
            self.cells.set_limits(cells, before)
            self.before = np.where(cells, before, self.before)

    def _note(self, noted: NDArray[np.int64]) -> None:
        """Note the assessments of the cells that have iterated since they were last noted."""
        loop = self.cells.loop
        seconds = time.perf_counter() - self.began
        for cell in np.flatnonzero(loop.iterations > noted).tolist():
            last = loop.last[cell]
            entry = HistoryEntry(
                iteration=int(loop.iterations[cell]), seconds=seconds, residual=last.residual, energies=last.energies
            )
            self.history[cell].append(entry)
        noted[:] = loop.iterations

    def _end(self, cells: NDArray[np.bool_]) -> None:
        """Keep the states in which the present steps of some cells have ended."""
        loop = self.cells.loop
        simulation = loop.simulation
        seconds = time.perf_counter() - self.began
        yarns = simulation.good_cells(cells)
        nearest = simulation.smallest_distances()
        forces = self.cells.border_forces()
        device = str(simulation.model.device)
        for cell, own in zip(np.flatnonzero(cells).tolist(), yarns, strict=True):
            last = loop.last[cell]
            count = int(loop.iterations[cell] - self.before[cell])
            self.found[cell].append(StepAtRest(
                own, last.energies, last.residual, bool(loop.at_rest[cell]), count, float(nearest[cell]),
                (float(forces[cell, 0]), float(forces[cell, 1])), device, seconds, self.history[cell],
                loop.remaining[cell], out_of_time=self.out_of_time,
            ))  # fmt: skip
            self.history[cell] = []


def _loads(steps: Sequence[Sequence[LoadStep]], number: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the loads of each cell in its present step, or of its last step after it [dyn], shape (C, 2)."""
    present = [own[min(count, len(own) - 1)] for own, count in zip(steps, number.tolist(), strict=True)]
    return np.array([[step.course, step.wale] for step in present])
