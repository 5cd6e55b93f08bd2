# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""One iteration of the relaxation: which kernels run, in which order, and how it recovers."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import warp as wp

from stitchmesh.errors import SolverError
from stitchmesh.mesh import StitchMesh
from stitchmesh.quality import Quality
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import forces
from stitchmesh.yarnrelax.borders import hold_borders
from stitchmesh.yarnrelax.candidates import Candidates, find_candidates, make_candidates
from stitchmesh.yarnrelax.convergence import Assessment, assess, rounding_force
from stitchmesh.yarnrelax.damping import EAGERNESS, LARGEST_EAGERNESS, update_pace
from stitchmesh.yarnrelax.material import YarnMaterial
from stitchmesh.yarnrelax.model import Model, put_model
from stitchmesh.yarnrelax.motion import move_points, propose_steps
from stitchmesh.yarnrelax.precision import scalar_named
from stitchmesh.yarnrelax.reduction import STRANDS, minimum, strand_sums
from stitchmesh.yarnrelax.shape import Shape, put_shape, shape_forces, shape_stiffness
from stitchmesh.yarnrelax.state import State, make_state
from stitchmesh.yarnrelax.step_limit import SAFETY, check_clearance, samples_needed, yarn_place
from stitchmesh.yarnrelax.stiffness import internal_stiffness

WIDEST_MARGIN, NARROWEST_MARGIN = 0.6, 0.3
"""Reach of the candidate lists beyond contact, over the smallest radius: at the start, and when all is slow."""
MARGIN_CHANGE = 1.5
"""Factor by which the margin narrows or widens."""
SHORT_LIFE, LONG_LIFE = 2, 8
"""Bursts; lists that are worn sooner get a wider margin, lists that last longer a narrower one."""
BURST = 5
"""Iterations between two looks at how far control points have moved."""
WORN = 0.3
"""Part of the travel that is left when the candidate lists are made again."""
SMALLEST_EAGERNESS = 1e-4
"""Eagerness at which backing off gives up."""
RECOVERY = 1.2
"""Growth of the eagerness after each good assessment."""


@dataclass(eq=False)
class Iteration:
    """The arrays of a relaxation and the launches that repeat."""

    model: Model
    state: State
    candidates: Candidates
    shape: Shape | None
    point_stiffness: wp.array[Any]
    step_fraction: float
    watch: float
    """Clearance above which the step limit does not bind [cm]."""
    rounding: float
    """Force that the rounding of coordinates makes [dyn]."""
    eagerness: float = LARGEST_EAGERNESS
    bursts: int = 0
    """Bursts since the candidate lists were made."""
    launches: list[wp.Launch] = field(default_factory=list)
    graph: Any = None

    @classmethod
    def start(
        cls, yarns: YarnSet, material: YarnMaterial, quality: Quality, device: wp.Device, fabric: StitchMesh | None
    ) -> Iteration:
        """Send yarns to the device and get ready to iterate."""
        model = put_model(
            yarns,
            material,
            quadrature_points=quality.quadrature_points,
            contact_samples=samples_needed(yarns, quality.contact_samples),
            scalar=scalar_named(quality.precision),
            device=device,
        )
        shape = None if fabric is None else put_shape(model, fabric)
        stiffness = internal_stiffness(model)
        if shape is not None:
            stiffness = stiffness + shape_stiffness(model, shape)
        iteration = cls(
            model,
            make_state(model),
            make_candidates(model, WIDEST_MARGIN * float(yarns.radius.min())),
            shape,
            model.upload(np.maximum(stiffness, np.finfo(np.float32).tiny)),
            quality.step_fraction,
            quality.step_fraction * float(yarns.radius.max()) / SAFETY,
            rounding_force(model, stiffness),
        )
        iteration._list_candidates()
        iteration._record()
        return iteration

    def run(self, count: int) -> None:
        """Iterate ``count`` times, making new candidate lists where control points have moved far."""
        for _ in range(0, count, BURST):
            if self.graph is not None:
                wp.capture_launch(self.graph)
            else:
                self._launch_burst()
            self.bursts += 1
            worn = minimum(self.state.room) < WORN * self.candidates.margin / 2
            if (worn or self.bursts > LONG_LIFE) and self._fit_margin(worn) and self._list_candidates():
                self._record()

    def assess(self) -> Assessment:
        """Residual and energies of the state as it is.

        Raises:
            SolverError: the step limit has no room left.
        """
        self.look_around()
        check_clearance(self.model, self.state)
        return assess(self.model, self.state, self.candidates, self.shape, rounding=self.rounding)

    def look_around(self) -> None:
        """Compute the clearance of each segment as it lies now."""
        forces.sample(self.model, self.state, self.model.launch)
        forces.contact(self.model, self.state, self.candidates, self.model.launch, watch=self.watch)

    def keep(self) -> None:
        """Call the state good, and grow eager again."""
        wp.copy(self.state.good_points, self.state.points)
        if self.eagerness < LARGEST_EAGERNESS:
            self._set_eagerness(min(self.eagerness * RECOVERY, LARGEST_EAGERNESS))

    def back_off(self) -> None:
        """Go back to the last good state, at rest and half as eager.

        Raises:
            SolverError: it has been tried often enough.
        """
        if self.eagerness < SMALLEST_EAGERNESS:
            raise SolverError(f"{self.blame()}: its energy grows at the smallest steps; move the yarns apart")
        wp.copy(self.state.points, self.state.good_points)
        self.state.step.zero_()
        self.state.pace.zero_()
        self._set_eagerness(self.eagerness / 2)
        if self._list_candidates():
            self._record()

    def good_yarns(self) -> YarnSet:
        """The yarns in the last good state."""
        points = self.state.good_points.numpy().astype(np.float64) + self.model.origin
        return replace(self.model.yarns, points=points)

    def smallest_distance(self) -> float:
        """Smallest distance of yarns in the last good state over their radius, 2 where none touch."""
        wp.copy(self.state.points, self.state.good_points)
        self._list_candidates()
        return forces.smallest_distance(self.model, self.state, self.candidates)

    @property
    def noise(self) -> float:
        """Energy that rounding forces do over a radius at every control point [erg]."""
        return self.rounding * float(self.model.yarns.radius.mean()) * self.model.point_count

    def blame(self) -> str:
        """The energy with the largest force of all, and where it acts."""
        largest, energy, point = -1.0, "", 0
        for term in forces.each_term(self.model, self.state, self.candidates):
            force = np.linalg.norm(self.state.point_force.numpy().astype(np.float64), axis=1)
            force = np.where(np.isfinite(force), force, np.inf)
            if force.max() > largest:
                largest, energy, point = float(force.max()), term, int(force.argmax())
        return f"{energy} energy of {yarn_place(self.model.yarns, point)}"

    def _fit_margin(self, worn: bool) -> bool:
        """Widen the margin of lists that do not last, narrow that of lists that do; whether to make new lists."""
        radius, margin = float(self.model.yarns.radius.min()), self.candidates.margin
        if self.bursts <= SHORT_LIFE:
            self.candidates.margin = min(margin * MARGIN_CHANGE, WIDEST_MARGIN * radius)
        elif self.bursts > LONG_LIFE:
            self.candidates.margin = max(margin / MARGIN_CHANGE, NARROWEST_MARGIN * radius)
        return worn or self.candidates.margin != margin

    def _set_eagerness(self, value: float) -> None:
        self.eagerness = value
        self.state.pace[EAGERNESS : EAGERNESS + 1].fill_(value)

    def _list_candidates(self) -> bool:
        """Make new candidate lists; whether launches have to be recorded again."""
        self.bursts = 0
        self.state.travel.fill_(self.candidates.margin / 2)
        forces.sample(self.model, self.state, self.model.launch)
        wp.copy(self.state.listed_points, self.state.points)
        return find_candidates(self.model, self.state.samples, self.candidates)

    def _launch_burst(self) -> None:
        for _ in range(BURST):
            for launch in self.launches:
                launch.launch()

    def _record(self) -> None:
        """Prepare the launches of an iteration, in their order."""
        model, state, record = self.model, self.state, self.model.record
        material = model.material
        self.launches = [
            forces.sample(model, state, record),
            forces.internal(model, state, record, k_len=material.k_len, k_bend=material.k_bend),
        ]
        if material.k_length > 0.0:
            self.launches.append(forces.length(model, state, record))
        self.launches.append(forces.contact(model, state, self.candidates, record, watch=self.watch))
        self.launches.append(forces.gather(model, state, record))
        if self.shape is not None:
            self.launches.extend(shape_forces(model, self.shape, state, record))
        self.launches.append(self._propose())
        if self.shape is not None and len(self.shape.held) > 0:
            self.launches.append(hold_borders(self.shape, state, record))
        self.launches += [
            record(move_points, model.point_count, [state.travel, state.step, state.listed_points],
                   [state.points, state.room]),
            record(strand_sums, STRANDS, [state.power], [state.power_sums]),
            record(update_pace, 1, [state.power_sums], [state.pace]),
        ]  # fmt: skip
        if model.device.is_cuda:
            with wp.ScopedCapture(device=model.device) as capture:
                self._launch_burst()
            self.graph = capture.graph

    def _propose(self) -> wp.Launch:
        model, state = self.model, self.state
        inputs = [
            model.constants, self.point_stiffness, model.number(self.step_fraction), state.travel,
            state.points, state.listed_points, state.point_force, state.segment_stiffness, state.segment_clearance,
            state.pace,
        ]  # fmt: skip
        outputs = [state.step, state.limit, state.mobility, state.power]
        return model.record(propose_steps, model.point_count, inputs, outputs)
