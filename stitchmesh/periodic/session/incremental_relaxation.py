# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A swatch that takes changes while it relaxes; one change or one burst of iterations at a time, in one thread."""

from __future__ import annotations

import logging
import time
from dataclasses import replace

from stitchmesh.errors import SolverError
from stitchmesh.periodic.continuation import ITERATIONS
from stitchmesh.periodic.session.frames import Frame
from stitchmesh.periodic.session.increments import SwatchInProgress, stepped, steps_left
from stitchmesh.periodic.session.session_descent import SwatchDescent
from stitchmesh.periodic.session.settings import SwatchSettings
from stitchmesh.periodic.session.target import Drawing, Target, drawing_of, target_of
from stitchmesh.periodic.swatch import close_contacts
from stitchmesh.quality import Quality
from stitchmesh.yarnrelax.linking.certificate import refuse_pull_through
from stitchmesh.yarnrelax.solvers.solver import ASSESSMENT_INTERVAL

NO_ROOM = "yarns cannot be parted on the way to these sizes; take thinner or longer yarn, or a larger repeat"
"""What keeps yarns that were drawn well from a rest."""

logger = logging.getLogger(__name__)


class LiveSwatch:
    """A swatch that moves to what is wished for; after an error it stays as it lies until wishes change."""

    drawing: Drawing
    """What is wished for, as it is drawn."""
    target: Target
    """And as it is to be."""
    close: Quality
    """With contacts as close as its loops ask for."""
    first: Drawing
    """From which the yarns began."""
    moving: SwatchInProgress
    """The yarns as they lie."""
    before: SwatchInProgress | None
    """As they lay before the last step."""
    descent: SwatchDescent | None
    """The relaxation that is under way."""
    settled: int
    """Iterations since the last step."""
    doubtful: bool
    """Whether the yarns lie so because there was no way on."""
    arrived: bool
    """Whether there is nothing left to do."""
    frame: Frame
    """The newest frame."""

    def __init__(self, wishes: SwatchSettings, quality: Quality, device: str | None, asked: float) -> None:
        """As it is drawn; arguments as for ``take``.

        Raises:
            StitchMeshError: the wishes cannot be drawn.
        """
        self.quality, self.device = quality, device
        self.drawing = drawing_of(wishes, quality)
        self.target, self.close = target_of(wishes, self.drawing), close_contacts(quality, wishes.options)
        self.error: Exception | None = None
        self.iteration, self.asked, self.number = 0, asked, 0
        self._draw_anew()

    @property
    def idle(self) -> bool:
        """Whether there is nothing to do until wishes change."""
        return self.error is not None or self.arrived

    def take(self, wishes: SwatchSettings, asked: float, *, anew: bool = False) -> None:
        """Aim at other wishes, from the state as it lies where that is possible.

        Args:
            wishes: what is to be.
            asked: when that was said (``time.perf_counter``) [s].
            anew: whether to begin as drawn all the same.

        Raises:
            StitchMeshError: the wishes cannot be drawn.
        """
        self.iteration, self.asked = 0, asked
        drawing = drawing_of(wishes, self.quality)
        target = target_of(wishes, drawing)
        goes_on = not anew and drawing.has_yarns_of(self.first)
        before, larger = self.target, drawing.width / self.drawing.width
        looks_other = self.error is not None or (goes_on and (target.colour != before.colour).any())
        self.drawing, self.target, self.error = drawing, target, None
        self.close = close_contacts(self.quality, wishes.options)
        if not goes_on:
            return self._draw_anew()
        if larger != 1.0:
            self.moving = self.moving.enlarged(larger)
            self.descent = self.before = None
        if (target.material, target.cell) != (before.material, before.cell):
            self.descent = None
        self.arrived = self.arrived and self.descent is not None and steps_left(self.moving, target) == 0
        if looks_other:
            self.frame = self._framed()

    def advance(self) -> None:
        """A step towards the target if one is due, and one burst of iterations.

        Raises:
            SolverError: there is no way on; the yarns lie as they did before the last step.
        """
        moving, due = self.moving, self.descent is None
        if steps_left(moving, self.target) and self._has_settled():
            self.before, moving, self.settled, due = moving, stepped(moving, self.target), 0, True
        try:
            self.descent = self._begun(moving) if due else self.descent
            assert self.descent is not None
            self.descent.advance()
        except SolverError as error:
            return self._go_back(error)
        self.doubtful = False
        self.settled += ASSESSMENT_INTERVAL
        self.iteration += ASSESSMENT_INTERVAL
        self.moving = replace(moving, yarns=self.descent.yarns)
        if not steps_left(self.moving, self.target) and (self.descent.at_rest or self.descent.used_up):
            self._arrive()
        self.frame = self._framed()

    def halt(self, error: Exception) -> None:
        """Stay as it lies because of an error."""
        self.error, self.descent, self.arrived = error, None, False
        self.frame = self._framed()

    def _begun(self, moving: SwatchInProgress) -> SwatchDescent:
        """The relaxation from a state."""
        target, self.arrived = self.target, False
        return SwatchDescent(moving.yarns, target.material, self.close, self.device, target.cell)

    def _has_settled(self) -> bool:
        """Whether the yarns have had the time that they need between two steps."""
        return self.settled >= ITERATIONS or (self.descent is not None and self.descent.at_rest)

    def _arrive(self) -> None:
        """Check that no yarn passed through another; a state where one did is drawn anew."""
        assert self.descent is not None
        try:
            refuse_pull_through(self.first.yarns, self.moving.yarns, self.device)
        except SolverError:
            self._draw_anew()
            raise
        self.arrived = True
        if not self.descent.at_rest:
            found = f"residual {self.descent.last.residual:.2g} after {self.descent.iterations} iterations"
            logger.warning("swatch is not at rest: %s; %s", found, self.descent.last.remedy)

    def _go_back(self, error: SolverError) -> None:
        """Take the state before the last step again; where that has led nowhere before, go on from the drawing.

        Raises:
            SolverError: what it is for, in place of what ends a relaxation from a start that is given.
        """
        if self.doubtful:
            return self._draw_anew()
        self.moving, self.settled, self.doubtful = self.before or self.moving, 0, True
        self.before = self.descent = None
        raise SolverError(f"{str(error).partition(':')[0]}: {NO_ROOM}") from error

    def _draw_anew(self) -> None:
        """Begin as drawn."""
        self.first, self.moving = self.drawing, SwatchInProgress.drawn(self.drawing, self.target)
        self.before = self.descent = None
        self.settled, self.doubtful, self.arrived = 0, False, False
        self.frame = self._framed()

    def _framed(self) -> Frame:
        """The next frame."""
        self.number += 1
        last = None if self.descent is None else self.descent.last
        report = {
            "iteration": self.iteration,
            "residual": None if last is None else last.residual,
            "energy": None if last is None else last.energy,
            "gamma": self.moving.gamma,
            "at_rest": self.arrived and self.descent is not None and self.descent.at_rest,
            "running": not self.idle,
            "seconds": time.perf_counter() - self.asked,
        }
        yarns = replace(self.moving.in_fabric, colour=self.target.colour)
        return Frame(self.number, yarns, self.drawing.fabric, report, self.error)
