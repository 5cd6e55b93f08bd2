# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stretch tests: a free swatch is stretched along its courses or its wales, and its tension is measured at each strain.

The cell is first relaxed without stress and with its periods at right angles. It lies between the planes of a free
swatch (``support``) all the time, because fabrics buckle. One of its sizes, with the free value L0, is then set to
(1 + strain) L0 for each strain in turn. Each state starts from the previous one: the yarns are relaxed, and so is the
other size unless it is held. The tension is nominal ("engineering"): the force on a border over the length of that
border in the free cell,

    T_course = s_course height / height0        T_wale = s_wale width / width0      [dyn/cm]

where s is the stress of the deformed cell (``yarnrelax/stress``). Let e be the energy of the cell over the area of the
free cell. The work is

    de = T_course d(width) / width0 + T_wale d(height) / height0

so the slope of e over the strain equals the tension, both if the other size is free (its tension is zero) and if it is
held (its change is zero). 1000 dyn/cm are 1 N/m. Yarns have no friction, so the curve is the same for loading and
unloading, unless the fabric snaps from one shape to another. A snap is a change of energy that no tension between the
two states can explain.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Literal, get_args

import numpy as np

from stitchmesh.budget.budget import Budget
from stitchmesh.budget.plan import limit_of
from stitchmesh.errors import ParameterError, SolverError
from stitchmesh.io.history import HistoryEntry
from stitchmesh.memory_need import BASE_MEMORY, BYTES_PER_KEPT_POINT, check_memory
from stitchmesh.mesh import FloatArray
from stitchmesh.patterns import Pattern
from stitchmesh.periodic.kept_states import check_kept_states
from stitchmesh.periodic.relaxation.continuation import change_period, size_of
from stitchmesh.periodic.relaxation.prepared_swatch import PreparedSwatch, prepare_swatch
from stitchmesh.periodic.relaxation.support import planes
from stitchmesh.periodic.swatch import Swatch, relax_prepared
from stitchmesh.periodic.swatch_options import STRETCH_STEPS
from stitchmesh.periodic.weave.weave import Weave
from stitchmesh.quality import DEFAULT_QUALITY, Quality, quality_named
from stitchmesh.time_limit import limited_to
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.cell_stress import cell_stress
from stitchmesh.yarnrelax.energies.term import TermChoice
from stitchmesh.yarnrelax.linking.certificate import refuse_pull_through

Direction = Literal["course", "wale"]
Other = Literal["free", "held"]

TOLERANCE = 1e-3
"""Largest residual of each state; ribs have a small resistance and need this value."""
LARGEST_CHANGE = 1e-4
"""Largest estimate of the change that is left: a stiff fabric turns a small strain into a large tension."""
CONTROL_POINTS = 24
"""Smallest number of control points of a plain stitch, as in the quality ``reference``. With 12 control points loops
resist up to 80 % too much. Fewer control points make the yarn softer along its axis, because a material gives the
stretch stiffness for each segment (``energies/stretch``); this matters for weaves."""
CONTACT_SAMPLES = 5
"""Smallest number of contact samples of a segment. With three samples, samples of touching yarns interlock, and the
tension varies by some dyn/cm."""
SMALLEST_SNAP = 1e-3
"""Smallest unexplained change of energy that counts as a snap, relative to the largest energy; states are relaxed to a
tenth of ``TOLERANCE``."""
LEAST_STRAIN, MOST_STRAIN = -0.9, 9.0
"""Smallest and largest strain."""
NEWTONS_PER_METRE = 1e-3
"""1 dyn/cm in N/m."""

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class StretchPoint:
    """One relaxed state of a stretch test."""

    strain: float
    """Size in the stretch direction over that of the free cell, minus one."""
    width: float
    """Width of the cell [cm]."""
    height: float
    """Height of the cell [cm]."""
    course_tension: float
    """Force along the courses over the height of the free cell [dyn/cm]."""
    wale_tension: float
    """Force along the wales over the width of the free cell [dyn/cm]."""
    energy: float
    """Energy over the area of the free cell [erg/cm^2]."""
    yarn_strain: float
    """Length of all yarn over its rest length, minus one."""
    residual: float
    """Relative force residual."""
    converged: bool
    """Whether the relaxation converged."""


@dataclass(frozen=True, eq=False)
class StretchCurve:
    """The result of a stretch test in one direction."""

    direction: Direction
    """The stretch direction."""
    other: Other
    """Whether the size across the stretch direction is free or held."""
    free: Swatch
    """The cell without stress."""
    points: tuple[StretchPoint, ...]
    """Measurements at each strain."""
    states: tuple[YarnSet, ...]
    """Relaxed yarns at each strain."""

    def __repr__(self) -> str:
        """Return one line: the direction and the strains."""
        strains = f"{self.points[0].strain:.3g} to {self.points[-1].strain:.3g}"
        return f"StretchCurve({self.direction}, {len(self.points)} strains from {strains}, the other {self.other})"

    def column(self, name: str) -> FloatArray:
        """Return one measurement of all points, shape (steps,)."""
        return np.array([getattr(point, name) for point in self.points], dtype=np.float64)

    @property
    def tension(self) -> FloatArray:
        """Tension in the stretch direction [dyn/cm], shape (steps,)."""
        return self.column(f"{self.direction}_tension")

    @property
    def snaps(self) -> list[int]:
        """Indices of the points before which the fabric snapped to another shape.

        If the tension between two points lies between the two measured tensions, the change of energy differs from the
        work of the mean tension by at most half of the work of the larger tension. A larger difference is a snap.
        """
        strain, energy = self.column("strain"), self.column("energy")
        work = (self.tension[1:] + self.tension[:-1]) / 2 * np.diff(strain)
        largest = np.maximum(np.abs(self.tension[1:]), np.abs(self.tension[:-1])) * np.abs(np.diff(strain)) / 2
        noise = SMALLEST_SNAP * energy.max()
        return [int(k) + 1 for k in np.flatnonzero(np.abs(np.diff(energy) - work) > largest + noise)]


def stretch_test(
    pattern: str | Pattern | Weave,
    *,
    course: tuple[float, float] | None = None,
    wale: tuple[float, float] | None = None,
    other: Other = "free",
    steps: int = STRETCH_STEPS,
    material: YarnMaterial | None = None,
    quality: str | Quality = DEFAULT_QUALITY,
    device: str | None = None,
    budget: Budget | None = None,
    progress: Callable[[StretchPoint], None] | Literal[False] | None = None,
    on_entry: Callable[[HistoryEntry], None] | None = None,
    **options: Any,
) -> StretchCurve:
    """Stretch a swatch in one direction and measure its tension.

    Args:
        pattern: as for ``swatch``.
        course: first and last strain along the courses, for example 0.4 for 40 %.
        wale: first and last strain along the wales. Either ``course`` or ``wale`` must be given.
        other: ``free`` relaxes the size across the stretch direction; ``held`` keeps its value in the free cell.
        steps: number of strains, including the first and the last.
        material: as for ``swatch``.
        quality: a preset or a ``Quality``; it is refined to the needs of tensions (``refine_for_tension``).
        device: as for ``swatch``.
        budget: a limit on the time, without an error; the curve ends with the last state that came to rest in time.
        progress: function that is called with each point; by default a line shows the progress of each relaxation on a
            terminal or in a notebook, and False shows nothing.
        on_entry: function that is called about every half second during the relaxation of a state.
        options: fields of ``SwatchOptions``, except the period.

    Raises:
        ParameterError: not exactly one direction is given, a strain is out of bounds, the strains are equal, there are
            fewer than two steps, or a period, a tension of blocking or an error is given.
        FileError, PatternError: as for ``swatch``.
        SolverError: as for ``swatch``, or the time does not suffice for one state.
    """
    if budget is not None and budget.error is not None:
        raise ParameterError("error: got one for a stretch test, whose tensions are not measured by it; give a quality")
    with limited_to(limit_of(budget)):
        return _stretch(pattern, course, wale, other, steps, material, quality, device, progress, on_entry, options)


def _stretch(
    pattern: str | Pattern | Weave, course: tuple[float, float] | None, wale: tuple[float, float] | None, other: Other,
    steps: int, material: YarnMaterial | None, quality: str | Quality, device: str | None,
    progress: Callable[[StretchPoint], None] | Literal[False] | None, on_entry: Callable[[HistoryEntry], None] | None,
    options: dict[str, Any],
) -> StretchCurve:  # fmt: skip
    """Stretch a swatch in the time that is left; arguments and errors as for ``stretch_test``."""
    direction, strains = choose_strains(course, wale, steps)
    if other not in get_args(Other):
        raise ParameterError(f"other: got {other!r}; expected free or held")
    for name in {"period", "blocked"} & options.keys():
        raise ParameterError(f"{name}: got one for a stretch test, which begins at the free cell; leave it out")
    quality = refine_for_tension(quality_named(quality))
    prepared = prepare_swatch(pattern, material=material, quality=quality, device=device, relax_cell=True, **options)
    check_kept_states("stretch", steps, prepared.yarns)
    of_entries: Callable[[HistoryEntry], None] | Literal[False] | None = on_entry
    if on_entry is None and progress is False:
        of_entries = False
    free = relax_prepared(prepared, prepared.yarns, of_entries)
    material, quality = prepared.material, prepared.quality
    cell, terms = held_cell(direction, other), planes_of(free, prepared)
    yarns, points, states = free.yarns, [], []
    for strain in strains:
        yarns = change_period(yarns, size_at(free, direction, other, strain), material, quality, device)
        rest = relax_yarns(
            yarns, material=material, quality=quality, device=device, cell=cell, terms=terms, progress=of_entries
        )
        if rest.report["out_of_time"]:
            break
        yarns = rest.yarns
        points.append(measure_point(free, strain, yarns, rest.report, material, quality, device))
        states.append(yarns)
        if progress:
            progress(points[-1])
    if not points:
        raise SolverError("stretch: the time was over before one state was at rest; give more, or a coarser quality")
    refuse_pull_through(free.yarns, yarns, device)
    curve = StretchCurve(direction, other, free, tuple(points), tuple(states))
    _warn_of_snaps(curve)
    return curve


def _warn_of_snaps(curve: StretchCurve) -> None:
    strain = 100 * curve.column("strain")
    for point in curve.snaps:
        between = f"{strain[point - 1]:g} % and {strain[point]:g} %"
        logger.warning("stretch: between %s the fabric snapped to another shape; frictionless yarn can snap", between)


def choose_strains(
    course: tuple[float, float] | None, wale: tuple[float, float] | None, steps: int
) -> tuple[Direction, FloatArray]:
    """Return the stretch direction, and its strains, shape (steps,).

    Raises:
        ParameterError: not exactly one direction is given, a strain is out of bounds, the strains are equal, or there
            are fewer than two steps.
    """
    if (course is None) == (wale is None):
        got = "neither" if course is None else "both"
        raise ParameterError(f"stretch: got {got} of course and wale; expected strains of one of them")
    direction: Direction = "wale" if course is None else "course"
    given = wale if course is None else course
    assert given is not None
    first, last = given
    if not (np.isfinite([first, last]).all() and LEAST_STRAIN <= min(given) and max(given) <= MOST_STRAIN):
        bounds = f"{100 * LEAST_STRAIN:g} % to {100 * MOST_STRAIN:g} %"
        raise ParameterError(f"{direction}: got {100 * first:g} % to {100 * last:g} %; expected strains of {bounds}")
    if first == last:
        raise ParameterError(f"{direction}: got {100 * first:g} % twice; expected two different strains")
    if steps < 2:
        raise ParameterError(f"steps: got {steps}; expected at least 2")
    check_memory(f"a stretch test of {steps:,} strains", BASE_MEMORY + BYTES_PER_KEPT_POINT * steps, "fewer steps")
    return direction, np.linspace(first, last, steps)


def refine_for_tension(quality: Quality) -> Quality:
    """Return a quality that is at least as fine as the constants of this file."""
    return replace(
        quality, tolerance=min(quality.tolerance, TOLERANCE),
        largest_change=min(quality.largest_change, LARGEST_CHANGE),
        control_points_per_stitch=max(quality.control_points_per_stitch, CONTROL_POINTS),
        contact_samples=max(quality.contact_samples, CONTACT_SAMPLES),
    )  # fmt: skip


def held_cell(direction: Direction, other: Other) -> RelaxCell:
    """Return the degrees of freedom of the cell during a stretch test."""
    pull = 0.0 if other == "free" else None
    return RelaxCell(course=None, wale=pull, shear=False) if direction == "course" else RelaxCell(pull, None, False)


def planes_of(free: Swatch, prepared: PreparedSwatch) -> list[TermChoice]:
    """Return what a free swatch lies on, at its final size."""
    gamma = prepared.options.gamma
    flat = replace(prepared.flat, stitch_length=prepared.flat.stitch_length / gamma)
    return planes(True, prepared.options, flat, free.yarns.radius)


def size_at(free: Swatch, direction: Direction, other: Other, strain: float) -> tuple[float | None, float | None]:
    """Return the width and height to set [cm]; None where the size is free."""
    width, height = size_of(free.lattice)
    if direction == "course":
        return (1.0 + strain) * width, height if other == "held" else None
    return width if other == "held" else None, (1.0 + strain) * height


def measure_point(
    free: Swatch, strain: float, yarns: YarnSet, report: dict[str, Any], material: YarnMaterial, quality: Quality,
    device: str | None,
) -> StretchPoint:  # fmt: skip
    """Measure a relaxed state at a strain; ``report`` is the report of ``relax_yarns``."""
    assert yarns.lattice is not None
    (width0, height0), (width, height) = size_of(free.lattice), size_of(yarns.lattice)
    stress = cell_stress(
        yarns, material, quadrature_points=quality.quadrature_points, contact_samples=quality.contact_samples,
        device=device,
    )  # fmt: skip
    return StretchPoint(
        strain=float(strain), width=width, height=height, course_tension=stress.course * height / height0,
        wale_tension=stress.wale * width / width0, energy=report["energy"] / (width0 * height0),
        yarn_strain=float(yarns.lengths.sum() / yarns.rest_length.sum() - 1.0), residual=report["residual"],
        converged=report["converged"],
    )  # fmt: skip
