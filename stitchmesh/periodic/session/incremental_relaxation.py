# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A swatch that takes changes while it relaxes: one change, or some iterations, at a time, in one thread.

Increments and iterations alternate. An increment brings all lengths nearer to the target (``target``); the yarns
then relax for some iterations before the next increment. After the last increment the yarns relax until they have
converged. If a relaxation fails, the swatch returns to the state before the last increment. Increments, changes and
assessments fall between assessment intervals. The division of intervals into frames therefore does not change a bit of
the result.

The size of a knit with friction follows from its path off the needles, and not from its state when a change arrives.
The yarns that move with the changes are then a preview without friction. Once the preview is near to rest (``NEAR``),
the knit is let go off the needles as ``swatch`` does it, with the same bits, and the result takes the place of the
preview. A change that arrives during this work ends it at once, and the preview goes on.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from stitchmesh.compute.device import device_named
from stitchmesh.errors import SolverError
from stitchmesh.linking.certificate import refuse_pull_through
from stitchmesh.periodic.relaxation.continuation import ITERATIONS
from stitchmesh.periodic.sampling.even_sampling import sample_evenly
from stitchmesh.periodic.sampling.sampling import with_contacts
from stitchmesh.periodic.session.frames import Frame
from stitchmesh.periodic.session.settings import SwatchSettings
from stitchmesh.periodic.session.target import (
    GeneratedRepeat,
    SwatchInProgress,
    Target,
    generate_repeat,
    increment,
    increments_left,
    make_target,
)
from stitchmesh.periodic.swatch import Swatch, scale_yarns, swatch
from stitchmesh.quality import Quality
from stitchmesh.time_limit import Interrupted, given_up_when
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.simulation import YarnSimulation
from stitchmesh.yarnrelax.stepwise_loop import INTERVAL, StepwiseLoop

NEAR, LONGEST_PREVIEW = 0.02, 1000
"""The preview is near enough to rest at this residual, or after this number of iterations since the last increment."""

logger = logging.getLogger(__name__)


class LiveSwatch:
    """A swatch that moves to the target of its settings.

    After an error the swatch keeps its state until the settings change.
    """

    generated: GeneratedRepeat
    """The repeat of the settings, as generated."""
    target: Target
    """The target of the settings."""
    sampled: Quality
    """The quality, with as many contact samples as the loops of the settings need."""
    first: GeneratedRepeat
    """The generated repeat from which the current yarns began."""
    state: SwatchInProgress
    """The current state."""
    previous: SwatchInProgress | None
    """The state before the last increment."""
    loop: StepwiseLoop | None
    """The current relaxation."""
    iterations_since_increment: int
    """Iterations since the last increment."""
    stopped: bool
    """Whether the user has stopped the relaxation, so that no frame follows the next one."""
    let_go: Swatch | None
    """The swatch that was let go off the needles; None before, and without friction."""
    stepped_back: bool
    """Whether the state is the one before an increment that failed."""
    finished: bool
    """Whether the target is reached and the relaxation has ended."""
    frame: Frame
    """The newest frame."""

    def __init__(
        self, settings: SwatchSettings, device: str | None, requested_at: float, *, stopped: bool = False,
        is_interrupted: Callable[[], bool] = lambda: False,
    ) -> None:  # fmt: skip
        """Generate the swatch; ``take`` describes the first arguments.

        Args:
            settings: the settings of the swatch.
            device: device of the kernels.
            requested_at: the time at which the user asked for the settings, by ``time.perf_counter`` [s].
            stopped: whether the user has stopped the relaxation.
            is_interrupted: called while the knit is let go; returns whether other work must be done first.

        Raises:
            StitchMeshError: the swatch of these settings cannot be generated.
        """
        self.device, self.stopped, self.is_interrupted = device, stopped, is_interrupted
        self.settings = settings
        self.generated = generate_repeat(settings)
        self.target = make_target(settings, self.generated)
        self.sampled = sampled_for(settings, self.generated, self.target)
        self.error: Exception | None = None
        self.iteration, self.requested_at, self.number = 0, requested_at, 0
        self._start_again()

    @property
    def idle(self) -> bool:
        """Whether there is nothing to do until the settings change."""
        return self.error is not None or self.finished

    def take(self, settings: SwatchSettings, requested_at: float, *, restart: bool = False) -> None:
        """Take other settings, and continue from the current state where this is possible.

        Args:
            settings: the new settings.
            requested_at: the time at which the user asked for the settings, by ``time.perf_counter`` [s].
            restart: whether to start from the generated yarns in any case.

        Raises:
            StitchMeshError: the swatch of these settings cannot be generated.
        """
        self.iteration, self.requested_at, self.settings = 0, requested_at, settings
        generated = generate_repeat(settings)
        target = make_target(settings, generated)
        sampled = sampled_for(settings, generated, target)
        continues = not restart and generated.has_same_yarns(self.first)
        before, enlargement = self.target, generated.width / self.generated.width
        needs_frame = self.error is not None or (continues and (target.colour != before.colour).any())
        relaxes_alike = (target.material, target.cell, target.terms, target.release, sampled) == (
            before.material,
            before.cell,
            before.terms,
            before.release,
            self.sampled,
        )
        self.generated, self.target, self.sampled, self.error = generated, target, sampled, None
        if not continues:
            return self._start_again()
        if not target.smallest.is_that_of(before.smallest):
            self.state = self.state.in_cell(before.smallest, target.smallest, generated.yarns)
            self.loop = self.previous = None
        if enlargement != 1.0:
            self.state = self.state.enlarged(enlargement)
            self.loop = self.previous = None
        if not relaxes_alike:
            self.loop = None
        is_there = relaxes_alike and enlargement == 1.0 and increments_left(self.state, target) == 0
        self.let_go = self.let_go if is_there else None
        self.finished = self.finished and is_there and not (self.loop is None and self.let_go is None)
        if needs_frame:
            self.frame = self._next_frame()

    def advance(self, most: int = INTERVAL) -> int:
        """Make the next increment if the yarns have relaxed enough, and iterate up to the next assessment at most.

        Args:
            most: largest number of iterations; a Newton step is not divided and may take more.

        Returns:
            The number of iterations.

        Raises:
            SolverError: the target cannot be reached; the state is the one before the last increment.
        """
        if self._is_to_be_let_go():
            self._let_go()
            return 0
        try:
            if self.loop is None or self.loop.is_between_intervals:
                self._prepare_interval()
            assert self.loop is not None
            made = self.loop.advance_partly(most)
        except SolverError as error:
            self._step_back(error)
            return 0
        self.iteration += made
        self.iterations_since_increment += made
        if self.loop.is_between_intervals:
            self._end_interval()
        return made

    def _prepare_interval(self) -> None:
        """Make the next increment if the yarns have relaxed enough, and start its relaxation.

        Raises:
            SolverError: the yarns of the new state are too close to one another.
        """
        if increments_left(self.state, self.target) and self._has_settled():
            self.previous, self.state = self.state, increment(self.state, self.target)
            self.iterations_since_increment, self.loop = 0, None
        if self.loop is None:
            self.loop = self._start_loop(self.state)

    def _end_interval(self) -> None:
        """Take the accepted state of the relaxation, and finish at the target."""
        assert self.loop is not None
        self.stepped_back = False
        self.state = replace(self.state, yarns=self.loop.simulation.good_yarns())
        if self.target.release is None and not increments_left(self.state, self.target) and self._has_ended():
            self._finish()

    def _has_ended(self) -> bool:
        """Whether the current relaxation is at rest, or does not get there."""
        assert self.loop is not None
        used_up = self.loop.iteration >= self.sampled.max_iterations or bool(self.loop.stalled[0])
        return used_up or self._is_at_rest()

    def _is_to_be_let_go(self) -> bool:
        """Whether the preview of a knit with friction is near enough to rest."""
        loop = self.loop
        if self.target.release is None or loop is None or not loop.is_between_intervals:
            return False
        is_near = loop.last[0].residual <= NEAR or self.iterations_since_increment >= LONGEST_PREVIEW
        return increments_left(self.state, self.target) == 0 and loop.iteration > 0 and (is_near or self._has_ended())

    def _let_go(self) -> None:
        """Let the knit go off the needles, as ``swatch`` does; nothing changes if other work must be done first.

        Raises:
            StitchMeshError: an error of ``swatch``.
        """
        try:
            with given_up_when(self.is_interrupted):
                made = swatch(self.generated.source, device=self.device, progress=False, **self.settings.arguments())
        except Interrupted:
            return
        self.iteration += made.report["iterations"]
        self.let_go, self.loop, self.previous, self.finished = made, None, None, True
        fabric = scale_yarns(made.yarns, self.state.scale)
        self.state = replace(self.state, yarns=sample_evenly(fabric, self.state.yarns))

    def publish(self) -> None:
        """Make a frame of the current state."""
        self.frame = self._next_frame()

    def halt(self, error: Exception) -> None:
        """Keep the current state because of an error."""
        self.error, self.loop, self.let_go, self.finished = error, None, None, False
        self.frame = self._next_frame()

    def _start_loop(self, state: SwatchInProgress) -> StepwiseLoop:
        """Start a relaxation of a state."""
        self.finished = False
        simulation = YarnSimulation.start(
            state.yarns,
            self.target.material,
            self.sampled,
            device_named(self.device),
            self.target.terms,
            cell=self.target.cell,
        )
        loop = StepwiseLoop(simulation, self.sampled.tolerance, self.sampled.largest_change)
        loop.start()
        return loop

    def _is_at_rest(self) -> bool:
        """Whether the current relaxation has converged."""
        return self.loop is not None and bool(self.loop.at_rest[0])

    def _has_settled(self) -> bool:
        """Whether the yarns have relaxed for as many iterations as they need between two increments."""
        stalled = self.loop is not None and bool(self.loop.stalled[0])
        return self.iterations_since_increment >= ITERATIONS or stalled or self._is_at_rest()

    def _finish(self) -> None:
        """Check that no yarn passed through another; if one did, start again from the generated yarns."""
        assert self.loop is not None
        try:
            refuse_pull_through(self.target.smallest.part_of(self.first.yarns), self.state.yarns, self.device)
        except SolverError:
            self._start_again()
            raise
        self.finished = True
        if not self._is_at_rest():
            last = self.loop.last[0]
            found = f"residual {last.residual:.2g} after {self.loop.iteration} iterations"
            logger.warning("swatch is not at rest: %s; %s", found, last.remedy(self.loop.tolerance))

    def _step_back(self, error: SolverError) -> None:
        """Return to the state before the last increment; if that has failed before, start from the generated yarns.

        Raises:
            SolverError: the target cannot be reached. The message of the relaxation gives advice for the start of a
                relaxation, so this error replaces it.
        """
        if self.stepped_back:
            return self._start_again()
        self.state, self.iterations_since_increment, self.stepped_back = self.previous or self.state, 0, True
        self.previous = self.loop = None
        cause = "yarns cannot be separated on the path to these sizes; take thinner or longer yarn, or a larger repeat"
        raise SolverError(f"{str(error).partition(':')[0]}: {cause}") from error

    def _start_again(self) -> None:
        """Start from the generated yarns."""
        self.first, self.state = self.generated, SwatchInProgress.start(self.generated, self.target)
        self.previous = self.loop = self.let_go = None
        self.iterations_since_increment, self.stepped_back, self.finished = 0, False, False
        self.frame = self._next_frame()

    def _yarns_now(self) -> YarnSet:
        """Return the yarns of the repeat in the fabric; within an assessment interval, these are not assessed yet."""
        now = self.state
        if self.loop is not None and not self.loop.is_between_intervals:
            now = replace(now, yarns=self.loop.simulation.current_yarns())
        return self.target.smallest.repeated(now.in_fabric, self.generated.yarns)

    def _next_frame(self) -> Frame:
        """Return the frame of the current state."""
        self.number += 1
        target, made = self.target, self.let_go
        report = self._measured() if made is None else {
            "residual": made.report["residual"], "energy": made.report["energy"], "at_rest": made.report["converged"],
        }  # fmt: skip
        report |= {
            "iteration": self.iteration,
            "gamma": self.state.gamma,
            "relaxation": "frictionless" if made is None else made.report["relaxation"],
            "preview": target.release is not None and made is None,
            "running": not (self.idle or self.stopped),
            "seconds": time.perf_counter() - self.requested_at,
        }
        yarns = self._yarns_now() if made is None else made.yarns
        yarns = replace(
            yarns, colour=target.colour, palette=target.palette,
            drawn_radius=yarns.radius * target.drawn_over_contact, mass_per_length=target.mass_per_length,
        )  # fmt: skip
        material = target.material.scaled(1.0 / target.gamma)
        return Frame(self.number, yarns, self.generated.fabric, report, material, self.error)

    def _measured(self) -> dict[str, Any]:
        """Return the residual and the energy of the present relaxation, and whether it has ended at rest."""
        if self.loop is None:
            return {"residual": None, "energy": None, "at_rest": False}
        last = self.loop.last[0]
        at_rest = self.finished and self._is_at_rest()
        return {"residual": last.residual, "energy": self.target.smallest.copies * last.energy, "at_rest": at_rest}


def sampled_for(settings: SwatchSettings, generated: GeneratedRepeat, target: Target) -> Quality:
    """Return the quality with which a repeat relaxes to a target."""
    return with_contacts(settings.sampled, settings.options, generated.fabric, target.smallest, target.cell)
