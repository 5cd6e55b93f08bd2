# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Dry, wet and full relaxation: a knit is let go off the needles, and friction holds a part of its stretch.

On the needles a plain stitch is as wide as their pitch, about a third of the yarn that it takes (machines of gauge E18
to E28 knit jersey with 2.7 to 3.1 pitches of yarn in a loop), and the take-down draws its rows. Without friction a
fabric forgets this. With friction the states of rest of a plain knit lie on a line, from tall and narrow to low and
wide, and the path ends on it where friction first holds (Crassous, Poincloux and Steinberger 2024). The path is

    on the needles    wale spacing = loop length / ``NEEDLES_K_W``, course spacing = loop length / ``NEEDLES_K_C``;
                      there the yarns come to rest with friction
    dry               the forces on both borders fall together in equal ratios to ``LAST_FORCE``, and then to zero,
                      with the whole friction
    wet               friction falls in steps to ``WET`` of itself, without forces on the borders
    full              friction falls in steps to zero

Water and shaking do not lower the coefficient of friction (it even rises in wet wool). They move yarns against each
other, and a yarn that is moved resists a small steady force less, as if its friction were lower. Munden's dry, wet and
full knits have 19.0, 21.6 and 23.1 stitches on the square of the loop length: a wet relaxation goes 63 % of the path
from dry to full, and ``WET`` is the remaining share.

A knit whose size is free comes off the needles dry, unless the options choose another state. Without friction yarn
slides from stitch to stitch, so that wide repeats end far from what was knitted: cables lose a quarter of their height.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from stitchmesh.errors import ParameterError, SolverError
from stitchmesh.mesh import StitchMesh
from stitchmesh.periodic.relaxation.continuation import change_period
from stitchmesh.periodic.relaxation.spirality import sheared_by_torque
from stitchmesh.periodic.swatch_options import YARN_FRICTION, KnitState, LetGo, SwatchOptions
from stitchmesh.quality import Quality
from stitchmesh.run import QUIET, SHOWN, Run
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.energies.term import YarnChoice
from stitchmesh.yarnrelax.friction.friction import Friction
from stitchmesh.yarnrelax.load_steps import LoadStep, StepAtRest, relax_through_steps
from stitchmesh.yarnrelax.relaxation_result import Relaxation

NEEDLES_K_W, NEEDLES_K_C = 3.0, 4.6
"""Loop length over the wale and the course spacing of a plain knit on the needles."""
WET = 0.37
"""Share of friction that is left after a wet relaxation."""
RELEASE_STEPS, LAST_FORCE = 12, 1e-3
"""Number of steps in which the forces on the borders fall, and their last share before zero. A soft fabric such as
garter recovers half of its stretch under the last hundredth of the force."""
FRICTION_STEPS = 4
"""Steps in which friction falls to ``WET``, and from there to ``LAST_FRICTION``."""
LAST_FRICTION = 0.02
"""Last share of friction before zero."""
ON_NEEDLES = RelaxCell(course=None, wale=None, shear=False)
"""A cell on the needles keeps its size. Knitting gives each stitch its yarn, and friction keeps it there. Without
friction the stitches of ribs and welts take yarn from each other on the needles, until some are wide and others narrow.
Noise, the sampling or the processor then decides which ones are wide, and dry sizes differ by up to 14 %."""
TOLERANCE = 5e-3
"""Largest residual of each step."""


@dataclass(frozen=True)
class Release:
    """How a knit is let go."""

    state: LetGo
    """The state to reach."""
    friction: float
    """Coefficient of friction between yarns."""
    cell: RelaxCell
    """Which changes the periods are free to make; without loads."""


def state_of_rest(options: SwatchOptions, *, woven: bool) -> KnitState:
    """Return the state to which the options lead: dry for a knit whose size is free, otherwise without friction.

    Relaxation without friction reaches a given size, a tension of blocking and the loads of a ``RelaxCell``. A weave
    comes off no needles.

    Args:
        options: options of the swatch.
        woven: whether the repeat is a weave.
    """
    if options.relaxation is not None:
        return options.relaxation
    lies_free = options.relax_cell is True and options.period == (None, None) and options.blocked is None
    return "dry" if lies_free and not woven else "frictionless"


def chosen_release(options: SwatchOptions, *, woven: bool) -> Release | None:
    """Check the choice of a relaxation, and return it; None without friction. Arguments as for ``state_of_rest``.

    Raises:
        ParameterError: the options ask for a state of knits for a weave, for a coefficient without friction or one that
            no yarn has, or for sizes or loads beside a state.
    """
    meant = state_of_rest(options, woven=woven)
    if meant == "frictionless":
        if options.friction is not None:
            found = f"friction: got {options.friction:g} for a swatch that relaxes without it"
            raise ParameterError(f"{found}; add a relaxation: dry, wet or full")
        return None
    if woven:
        raise ParameterError("relaxation: got one for a weave, which comes off no needles; leave it out")
    if options.period != (None, None) or options.blocked is not None:
        raise ParameterError("relaxation: got a period or blocking beside it; a knit off the needles finds its size")
    cell = options.relax_cell if isinstance(options.relax_cell, RelaxCell) else sheared_by_torque(options)
    if (cell.course, cell.wale) != (0.0, 0.0):
        raise ParameterError("relaxation: got a load or a held size beside it; a knit off the needles has neither")
    mu = YARN_FRICTION if options.friction is None else options.friction
    Friction(mu)
    return Release(meant, mu, cell)


def needle_size(fabric: StitchMesh, loop_length: float) -> tuple[float, float]:
    """Width and height of a repeat on the needles [cm]."""
    faces = fabric.face_count
    courses = len(np.unique(fabric.row))
    return faces / courses * loop_length / NEEDLES_K_W, courses * loop_length / NEEDLES_K_C


def let_go(
    yarns: YarnSet,
    needles: tuple[float, float],
    release: Release,
    material: YarnMaterial,
    quality: Quality,
    device: str | None = None,
    terms: Sequence[YarnChoice] = (),
    run: Run[YarnSet] = SHOWN,
) -> Relaxation:
    """Draw yarns to their size on the needles, let them go with friction, and relax them to a state.

    Args:
        yarns: the yarns of a repeat, on their lattice.
        needles: width and height on the needles [cm].
        release: the state, and friction.
        material: material of the yarns.
        quality: resolution of all steps.
        device: device of the kernels.
        terms: further energies that act after the fabric has left the needles, such as the planes on which it lies.
        run: progress, states and checkpoints; a control is refused.

    Returns:
        The relaxation. Its report counts the iterations and the seconds of all steps, those on the needles included. It
        has ``relaxation``, ``friction``, ``needle_tension`` [dyn/cm] along courses and wales, ``steps`` and
        ``steps_not_at_rest``: the number of steps before the last (also the one on the needles), and how many of these
        ended before they were at rest. ``energy`` is the energy of the yarns alone.

    Raises:
        SolverError: the yarns cannot be drawn to that size, or a yarn passed through another one.
    """
    quality = _on_the_way(quality)
    start = on_needles(yarns, needles, release, material, quality, device, terms)
    found = _release(start, release, material, quality, device, terms, run)
    on_the_way = [start.converged, *(step.converged for step in found[:-1])]
    (width, height), (course, wale) = needles, start.border_forces
    own = {
        "relaxation": release.state, "friction": release.friction, "needle_tension": [course / height, wale / width],
        "steps": len(on_the_way), "steps_not_at_rest": on_the_way.count(False),
    }  # fmt: skip
    report = _steps_report(found, quality) | own
    report["seconds"] += start.seconds
    return Relaxation(found[-1].yarns, report, [entry for step in found for entry in step.history])


def rest_with_friction(
    yarns: YarnSet, release: Release, material: YarnMaterial, quality: Quality, device: str | None,
    terms: Sequence[YarnChoice], run: Run[YarnSet], before: Relaxation,
) -> Relaxation:  # fmt: skip
    """Let yarns that were let go come to rest once more, with the friction that their state has left.

    Args:
        yarns: the yarns, changed since they came to rest; their contacts hold no slip.
        release: the state, and friction.
        material: material of the yarns.
        quality: resolution.
        device: device of the kernels.
        terms: further energies.
        run: progress, states and checkpoints.
        before: the relaxation to the state, whose report, iterations, seconds and history go on.

    Raises:
        SolverError: a yarn passed through another one.
    """
    quality = _on_the_way(quality)
    share = [1.0, *friction_left(release.state)][-1]
    found = relax_through_steps(
        yarns, [LoadStep(friction=share)], terms=[Friction(release.friction), *terms], material=material,
        quality=quality, cell=release.cell, device=device, run=run,
    )  # fmt: skip
    report = before.report | _steps_report(found, quality)
    report["steps"] += 1
    report["iterations"] += before.report["iterations"]
    report["seconds"] += before.report["seconds"]
    return Relaxation(found[-1].yarns, report, [*before.history, *found[-1].history])


def _on_the_way(quality: Quality) -> Quality:
    """Return the quality of each step.

    Its largest change is that of the size that may remain after each step, as the exact step to rest predicts it. A
    rope cable that balances on its way has 2 % to go by the forces there, and goes 30 %; ribs fold on the way where
    larger changes remain.
    """
    return replace(
        quality, tolerance=min(quality.tolerance, TOLERANCE),
        largest_change=min(quality.largest_change, 2e-3),
    )  # fmt: skip


def on_needles(
    yarns: YarnSet, needles: tuple[float, float], release: Release, material: YarnMaterial, quality: Quality,
    device: str | None, terms: Sequence[YarnChoice],
) -> StepAtRest:  # fmt: skip
    """Draw yarns to their size on the needles without friction, and let them come to rest there with friction.

    Generated yarns that are too crowded to be drawn first relax to their free size.

    Raises:
        SolverError: the yarns cannot be drawn to that size, or a yarn passed through another one.
    """
    try:
        drawn = change_period(yarns, needles, material, quality, device)
    except SolverError:
        free = relax_yarns(
            yarns, material=material, quality=quality, cell=RelaxCell(shear=False), device=device,
            terms=terms, run=QUIET,
        )  # fmt: skip
        drawn = change_period(free.yarns, needles, material, quality, device)
    (rest,) = relax_through_steps(
        drawn, [LoadStep()], terms=[Friction(release.friction)], material=material, quality=quality, cell=ON_NEEDLES,
        device=device, run=QUIET,
    )  # fmt: skip
    return rest


def _release(
    start: StepAtRest, release: Release, material: YarnMaterial, quality: Quality, device: str | None,
    terms: Sequence[YarnChoice], run: Run[YarnSet],
) -> list[StepAtRest]:  # fmt: skip
    """Let yarns go from the needles to the state."""
    course, wale = (max(force, 0.0) for force in start.border_forces)  # no force on a border where the fabric pushes
    steps = [LoadStep(share * course, share * wale) for share in falling(1.0, LAST_FORCE, RELEASE_STEPS)]
    steps += [LoadStep(friction=share) for share in friction_left(release.state)]
    return relax_through_steps(
        start.yarns, steps, terms=[Friction(release.friction), *terms], material=material, quality=quality,
        cell=release.cell, device=device, run=run,
    )  # fmt: skip


def _steps_report(found: Sequence[StepAtRest], quality: Quality) -> dict[str, Any]:
    """The report of a relaxation through steps."""
    last = found[-1]
    return {
        "iterations": sum(step.iterations for step in found), "converged": last.converged,
        "seconds": last.seconds, "stopped": False, "out_of_time": last.out_of_time,
        "residual": last.residual, "remaining_change": None if last.remaining is None else asdict(last.remaining),
        "energy": last.elastic, "energies": last.energies,
        "max_strain": float(np.abs(last.yarns.strain).max()), "min_distance_over_radius": last.nearest,
        "pull_throughs": 0, "certificate": "unchanged", "solver": quality.solver, "device": last.device,
    }  # fmt: skip


def friction_left(state: LetGo) -> list[float]:
    """Shares of friction after the release, one for each step."""
    wet = falling(1.0, WET, FRICTION_STEPS)[:-1]
    return {"dry": [], "wet": wet, "full": wet + falling(WET, LAST_FRICTION, FRICTION_STEPS)}[state]


def falling(first: float, last: float, count: int) -> list[float]:
    """Shares that fall in equal ratios after ``first`` to ``last`` in ``count`` steps, and then zero."""
    return [*np.geomspace(first, last, count + 1)[1:].tolist(), 0.0]
