# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The relaxation of yarns under their load: at once, or in steps if they cannot take it (``load_position``).

A relaxation starts where the yarns are, with the whole load. If rest lengths, stiffnesses or the radius are far from
the values that suit the start, the forces press yarns together before the fabric can follow, and nothing can move any
more (``step_limit``). The load is then applied in steps. At the share s of the load

    L(s) = L0^(1-s) L^s          rest length of each segment; L0 is its length at the start
    k(s) = k0^(1-s) k^s          bending and contact; at the start, bending is at most as stiff, and contact at least as
                                 stiff, as in yarn of the default material with the same resistance to stretching
    r(s) = r t^(1-s)             radius; t is 1, or less if the yarns start too close to each other; the stiffnesses
                                 are scaled with it
    P(s) = s P                   loads on the borders of a cell

Yarn that is thin for the length of its segments moves a part of its radius at a time, and takes long. A piece of such
yarn that is not near rest after ``TRIAL_ITERATIONS`` is relaxed with thicker yarn (t > 1) first.

``LoadPosition`` says which steps follow. If no step is left, the message says how much of the load the yarns took.

Each step is a relaxation of its own, with its own inputs. Iterations are counted through all steps. An
interval in which a step is refused counts as a whole one, so that no two states have the same count.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from stitchmesh.errors import OverloadError
from stitchmesh.lattice import Lattice
from stitchmesh.mesh import FloatArray
from stitchmesh.quality import Quality
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax.load_position import AT_ONCE, TRIAL_ITERATIONS, LoadPosition
from stitchmesh.yarnrelax.model.material import YarnMaterial
from stitchmesh.yarnrelax.newton import DESCENT
from stitchmesh.yarnrelax.relaxation_inputs import RelaxationInputs
from stitchmesh.yarnrelax.relaxation_loop import RelaxationLoop
from stitchmesh.yarnrelax.renewal import renew_at_rest
from stitchmesh.yarnrelax.solvers.cell_strain import RelaxCell
from stitchmesh.yarnrelax.solvers.solver import ASSESSMENT_INTERVAL

logger = logging.getLogger(__name__)

MOST_STRAIN = 100.0
"""Largest ratio, up or down, of a segment's length at the start to its rest length with which the path begins."""


@dataclass(frozen=True, eq=False)
class LoadPath:
    """The inputs that the caller asked for, and the way to them."""

    asked: RelaxationInputs

    def inputs_at(self, position: LoadPosition) -> RelaxationInputs:
        """Return the inputs of a step, with its start."""
        asked, share = self.asked, position.share
        quality = asked.quality
        if position.finer > 1:
            quality = replace(quality, contact_samples=position.finer * quality.contact_samples)
        yarns, points = asked.yarns, asked.points
        if position.periods is not None and asked.cell is not None:
            yarns = replace(yarns, lattice=Lattice(position.periods))
        if position.points is not None:
            points = position.points
        if position.is_whole:
            return replace(asked, yarns=yarns, quality=quality, points=points)
        rest_length = _between(self._first_lengths(), yarns.rest_length, share)
        yarns = replace(yarns, rest_length=rest_length, radius=yarns.radius * position.thin ** (1.0 - share))
        material, cell = self._material_at(share, position.thin), _loaded(asked.cell, share)
        return replace(asked, yarns=yarns, material=material, quality=quality, points=points, cell=cell)

    @property
    def slenderness(self) -> float:
        """Median length of a segment over the radius."""
        yarns = self.asked.yarns
        return float(np.median(yarns.rest_length / yarns.radius[yarns.segment_yarn]))

    @property
    def is_slender(self) -> bool:
        """Whether the yarn is so thin that thicker yarn comes to rest in fewer iterations.

        This holds for pieces. Thicker yarn would lead a relaxing cell to other strains, so that nothing would be
        gained.
        """
        return self.asked.cell is None and self.slenderness > 20.0

    def thick_start(self, iterations: int) -> LoadPosition:
        """Return the position at share 0, with segments that are 3 radii long, after a trial of ``iterations``."""
        reason = f"the yarn is thin, its segments are {self.slenderness:.3g} radii long"
        return LoadPosition(share=0.0, thin=self.slenderness / 3.0, reason=reason, iterations=iterations)

    def with_asked_inputs(self, yarns: YarnSet) -> YarnSet:
        """Return the yarns of a step with the rest lengths and radii that the caller asked for."""
        asked = self.asked.yarns
        return replace(asked, points=yarns.points, lattice=yarns.lattice)

    def refusal(self, error: OverloadError, position: LoadPosition) -> OverloadError:
        """Return the error if no step is left: the reason, the reached share of the load, and what would help."""
        if position.reached is None or position.points is None:
            return OverloadError(position.reason or str(error))
        head, stretched = str(error).split(";")[0], self._strain_at(position)
        load = f"{position.reached:.2g} of the load ({self._changes(position)})"
        took = f"the yarns took {load} in {position.steps} steps, stretched by {100 * stretched:.2g} %"
        # wool yarn breaks at a strain of 25 to 35 %
        remedy = "the yarn cannot be that short, give longer" if stretched > 0.3 else "take thinner or longer"
        remedy = "take a smaller load, thicker" if self._pulls else remedy
        return OverloadError(f"{head}; {took}; {remedy} yarn, a smaller k_bend or a larger k_contact (--stiffness)")

    @property
    def _pulls(self) -> bool:
        """Whether loads act on the borders of a cell."""
        cell = self.asked.cell
        return cell is not None and bool(cell.course or cell.wale)

    def _first_lengths(self) -> FloatArray:
        """Return the rest lengths at share 0 [cm], shape (S,)."""
        asked = self.asked
        start = asked.yarns if asked.points is None else replace(asked.yarns, points=asked.points)
        rest = asked.yarns.rest_length
        return np.clip(start.lengths, rest / MOST_STRAIN, rest * MOST_STRAIN)

    def _first_material(self) -> YarnMaterial:
        """Return the stiffnesses at share 0."""
        own = self.asked.material
        usual = YarnMaterial.named().of_radius(float(self.asked.yarns.radius.mean()))
        level = own.axial_stiffness / usual.axial_stiffness
        k_bend, k_contact = min(own.k_bend, level * usual.k_bend), max(own.k_contact, level * usual.k_contact)
        return replace(own, k_bend=k_bend, k_contact=k_contact)

    def _material_at(self, share: float, thin: float) -> YarnMaterial:
        first, last = self._first_material(), self.asked.material
        found = {name: _between(getattr(first, name), getattr(last, name), share) for name in ("k_bend", "k_contact")}
        return replace(last, **found).scaled(thin ** (1.0 - share))

    def _strain_at(self, position: LoadPosition) -> float:
        """Return the largest magnitude of the strain at the share that was reached."""
        at = replace(position, share=position.reached if position.reached is not None else 1.0)
        inputs = self.inputs_at(at)
        assert inputs.points is not None
        return float(np.abs(replace(inputs.yarns, points=inputs.points).strain).max())

    def _changes(self, position: LoadPosition) -> str:
        """Return, in words, the inputs that differ between the two ends of the path."""
        rest_length = float(np.median(self.asked.yarns.rest_length / self._first_lengths()))
        first, last = self._first_material(), self.asked.material
        factors = {"rest lengths": rest_length, "radius": 1.0 / position.thin}
        factors |= {name: _ratio(getattr(last, name), getattr(first, name)) for name in ("k_bend", "k_contact")}
        named = [f"{name} x {factor:.2g}" for name, factor in factors.items() if abs(factor - 1.0) > 0.02]
        if self._pulls:
            named.append("the loads on the cell")
        return ", ".join(named) or "rest lengths of single segments"


def _between(first: Any, last: Any, share: float) -> Any:
    """Return the geometric mean of two positive numbers, or of two arrays entry by entry, weighted by the share."""
    if np.all(first == last):
        return last
    return first ** (1.0 - share) * last**share


def _ratio(last: float, first: float) -> float:
    return last / first if first > 0.0 else 1.0


def _loaded(cell: RelaxCell | None, share: float) -> RelaxCell | None:
    """Return the cell with a share of its loads."""
    if cell is None:
        return None
    course, wale = (None if load is None else share * load for load in (cell.course, cell.wale))
    return replace(cell, course=course, wale=wale)


class Loading:
    """A relaxation along a path of loads."""

    def __init__(self, path: LoadPath, position: LoadPosition = AT_ONCE, *, in_steps: bool = True) -> None:
        """Start the step ``position``, or the next step that the yarns can start.

        Args:
            path: the inputs of all steps.
            position: the step to try first.
            in_steps: whether a load that is too large is applied in steps.

        Raises:
            SolverError: the yarns are too close to each other at every step.
        """
        self.path, self.position, self.in_steps = path, position, in_steps
        self.loop = self._begin()

    @property
    def quality(self) -> Quality:
        """The quality that the caller asked for."""
        return self.path.asked.quality

    @property
    def at_rest(self) -> bool:
        """Whether the yarns are at rest under their whole load."""
        return self.position.is_whole and bool(self.loop.at_rest[0])

    def good_yarns(self) -> YarnSet:
        """Return the last accepted state of the yarns, with the rest lengths and radii that the caller asked for."""
        yarns = self.loop.simulation.good_yarns()
        return yarns if self.position.is_whole else self.path.with_asked_inputs(yarns)

    def run(self, note: Callable[[], None]) -> None:
        """Iterate through the steps until the yarns are at rest, or have done ``Quality.max_iterations``.

        Raises:
            SolverError: the yarns cannot take the load.
        """
        while True:
            try:
                _run_to_rest(self.loop, int(min(self.quality.max_iterations, self._step_end)), note)
                if not self._step_is_done:
                    if not self.position.is_first:
                        count, why = self.position.steps, self.position.why
                        logger.debug("the load was applied in %d steps, because at once: %s", count, why)
                    return
                if self.position.is_whole:
                    self.position = self.path.thick_start(self.loop.iteration)
                else:
                    self.position = self.position.after_step(self.loop.simulation.good_yarns(), self.loop.iteration)
            except OverloadError as error:
                after = self.loop.iteration + int(ASSESSMENT_INTERVAL)
                self._refuse(error, min(after, self.quality.max_iterations), began=True)
            self.loop = self._begin()

    @property
    def _is_trial(self) -> bool:
        """Whether the whole load acts on thin yarn as a trial; if that is slow, thicker yarn is relaxed first."""
        return self.in_steps and self.position.is_first and self.path.is_slender

    @property
    def _step_end(self) -> float:
        """Number of iterations after which another step follows the present one."""
        if self._is_trial and not self.loop.ending[0]:
            return TRIAL_ITERATIONS
        return np.inf if self.position.is_whole else self.position.iterations + self.position.most_iterations

    @property
    def _step_is_done(self) -> bool:
        """Whether another step follows."""
        ended = bool((self.loop.at_rest | self.loop.stalled)[0])
        return self.loop.iteration >= self._step_end or (not self.position.is_whole and ended)

    def _begin(self) -> RelaxationLoop:
        """Start the present step, or the next one that the yarns can start."""
        quality = self.quality
        while True:
            position = self.position
            try:
                simulation = self.path.inputs_at(position).start()
                tolerance = quality.tolerance if position.is_whole else DESCENT
                return RelaxationLoop(
                    simulation, tolerance, quality.largest_change, position.iterations, quality.max_iterations,
                    by_newton=position.is_whole or position.thin > 1.0,
                )  # fmt: skip
            except OverloadError as error:
                self._refuse(error, position.iterations, began=False)

    def _refuse(self, error: OverloadError, iterations: int, *, began: bool) -> None:
        """Go on to the next step after a refusal.

        Raises:
            SolverError: no step is left.
        """
        following = self.position.after_refusal(str(error), iterations, began=began) if self.in_steps else None
        if following is None:
            raise self.path.refusal(error, self.position) from error
        self.position = following


def _run_to_rest(loop: RelaxationLoop, most: int, note: Callable[[], None]) -> None:
    """Iterate until the yarns are at rest, and still are so after the renewal of terms that lag."""
    loop.run(most, note)
    while renew_at_rest(loop).any() and not loop.at_rest[0]:
        loop.run(most, note)
