# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Load steps of many cells together (``load_steps``): all cells take the same step at the same time.

Each cell has loads of its own, but all have one coefficient of friction. A step ends when all cells are at rest in it;
cells that are at rest stay still until then.
"""

from __future__ import annotations

import time
from collections.abc import Hashable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stitchmesh.compute.asking import Ask
from stitchmesh.compute.device import device_named
from stitchmesh.errors import OverloadError, StitchMeshError
from stitchmesh.io.history import HistoryEntry
from stitchmesh.time_limit import OutOfTime
from stitchmesh.yarnrelax.energies.confinement import CellConfinements, Confinement
from stitchmesh.yarnrelax.energies.term import TermChoice
from stitchmesh.yarnrelax.linking.certificate import pull_throughs_together
from stitchmesh.yarnrelax.load_steps import LoadedCells, LoadStep, StepAtRest
from stitchmesh.yarnrelax.simulation import YarnSimulation

GIVEN = {"friction", "material", "quality", "cell", "device", "terms", "progress"}
"""Arguments of ``relax_through_steps`` that many cells may have together."""


def group_of_steps(ask: Ask, number: int) -> Hashable:
    """What cells have in common that take load steps together; the number of the call if it belongs to no group."""
    named, steps = ask.named, ask.positional[1]
    terms = named.get("terms", ())
    lies = len(terms) == 1 and isinstance(terms[0], Confinement)
    if not named.keys() <= GIVEN or not (lies or len(terms) == 0) or named["quality"].solver != "quasistatic":
        return number
    path = tuple((step.friction, step.stretch) for step in steps)
    return replace(named["quality"], contact_samples=0), named.get("device"), named["friction"], lies, path


def relax_group_through_steps(asks: Sequence[Ask]) -> list[list[StepAtRest] | StitchMeshError | None]:
    """Answer calls of ``relax_through_steps`` of one group; None for a cell that cannot go on together with others."""
    path, steps = _Path(asks), [ask.positional[1] for ask in asks]
    for number in range(len(steps[0])):
        path.take([own[number] for own in steps])
        if path.out_of_time:
            break
    failed = path.cells.loop.failed.tolist()
    given = [(ask.positional[0], own[-1].yarns) for ask, own in zip(asks, path.found, strict=True)]
    passes = pull_throughs_together(given, asks[0].named.get("device"))
    return [None if fails else error or own for fails, error, own in zip(failed, passes, path.found, strict=True)]


class _Path:
    """Cells on their way through the steps."""

    def __init__(self, asks: Sequence[Ask]) -> None:
        """Put the cells on the device."""
        first, self.began = asks[0].named, time.perf_counter()
        planes = tuple(ask.named["terms"][0] for ask in asks if ask.named.get("terms"))
        terms: list[TermChoice] = [first["friction"]]
        terms += [CellConfinements(planes, (None,) * len(planes))] if planes else []
        simulation = YarnSimulation(
            [(ask.positional[0], ask.named["material"]) for ask in asks], first["quality"],
            device_named(first.get("device")), terms, cells=[ask.named["cell"] for ask in asks],
            samples=[ask.named["quality"].contact_samples for ask in asks],
        )  # fmt: skip
        self.cells = LoadedCells(simulation, first["quality"])
        self.found: list[list[StepAtRest]] = [[] for _ask in asks]
        """The steps of each cell that have ended."""
        self.history: list[list[HistoryEntry]] = [[] for _ask in asks]
        """The result of each assessment of each cell in the present step."""
        self.out_of_time = False

    def take(self, steps: Sequence[LoadStep]) -> None:
        """Take the next step of each cell."""
        loop, first = self.cells.loop, steps[0]
        before = loop.iterations.copy()
        self.cells.load(np.array([[step.course, step.wale] for step in steps]), first.friction, first.stretch)
        self.cells.begin()
        self.history = [[] for _cell in self.found]
        noted = before.copy()
        try:
            self.cells.relax(before, lambda: self._note(noted))
        except OverloadError:  # The only cell, whose error the loop keeps.
            pass
        except OutOfTime:
            self.out_of_time = True
        self._end(loop.iterations - before)

    def _note(self, noted: NDArray[np.int64]) -> None:
        """Note the assessments of the cells that have iterated since they were last noted."""
        loop, seconds = self.cells.loop, time.perf_counter() - self.began
        for cell in np.flatnonzero(loop.iterations > noted).tolist():
            last = loop.last[cell]
            entry = HistoryEntry(
                iteration=int(loop.iterations[cell]), seconds=seconds, residual=last.residual, energies=last.energies
            )
            self.history[cell].append(entry)
        noted[:] = loop.iterations

    def _end(self, iterations: NDArray[np.int64]) -> None:
        """Keep the states in which the step has ended, after some iterations of each cell."""
        loop, seconds = self.cells.loop, time.perf_counter() - self.began
        simulation = loop.simulation
        yarns, nearest = simulation.good_cells(), simulation.smallest_distances()
        forces, device = self.cells.border_forces(), str(simulation.model.device)
        for cell, own in enumerate(self.found):
            last, rests = loop.last[cell], bool(loop.at_rest[cell])
            own.append(StepAtRest(
                yarns[cell], last.energies, last.residual, rests, int(iterations[cell]), float(nearest[cell]),
                (float(forces[cell, 0]), float(forces[cell, 1])), device, seconds, self.history[cell],
                loop.remaining[cell], out_of_time=self.out_of_time and not rests,
            ))  # fmt: skip
