# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""How a fabric resists being stretched: a free swatch drawn along its courses or its wales, step by step.

The cell relaxes without stress first, at right angles. Then one of its sizes, L0 at rest, is set to (1 + strain) L0 for
one strain after the other, each state started from the last, and the yarns and, unless it is held, the other size come
to rest. Tension is the force on a border over that border's length in the free cell, "engineering" or nominal:

    T_course = s_course height / height0        T_wale = s_wale width / width0      [dyn/cm]

s the stress of the cell as it lies (``stress``). With the energy e of the cell over its free area the work is

    de = T_course d(width) / width0 + T_wale d(height) / height0

so that the slope of e by the strain is the tension, whether the other size is free (no tension) or held (no change).
Divided by a thousand, dyn/cm are N/m. Yarns have no friction: the curve is the same up and down, unless the fabric
snaps from one shape to another on the way, which shows as energy that no tension between two states accounts for.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Literal, get_args

import numpy as np

from stitchmesh.errors import ParameterError
from stitchmesh.io.history import HistoryEntry
from stitchmesh.mesh import FloatArray
from stitchmesh.patterns import Pattern
from stitchmesh.periodic.continuation import change_period, size_of
from stitchmesh.periodic.swatch import YARN_RADIUS, Swatch, SwatchOptions, close_contacts, swatch
from stitchmesh.periodic.weave.weave import Weave
from stitchmesh.quality import Quality, quality_named
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import REFERENCE_RADIUS, RelaxCell, YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.cell_stress import cell_stress
from stitchmesh.yarnrelax.linking.certificate import refuse_pull_through

Direction = Literal["course", "wale"]
Other = Literal["free", "held"]

STEPS = 9
"""States of a curve where no number is given."""
TOLERANCE = 1e-3
"""Residual of each state, if the quality asks for no less: ribs hardly resist, and need it."""
CONTROL_POINTS = 24
"""Of a plain stitch, if the quality has no more, those of reference: loops of 12 resist by up to 80 % too much. Yarn
of fewer is softer along itself, for a material states that by segments (``stretch``), which counts in weaves."""
CONTACT_SAMPLES = 5
"""Of a segment, if the quality has no more: three catch on one another, and tension wavers by some dyn/cm."""
SMALLEST_SNAP = 1e-3
"""Change of energy over the energy that counts; states come to rest to a tenth of ``TOLERANCE``."""
LEAST_STRAIN, MOST_STRAIN = -0.9, 9.0
"""Bounds of strains."""
NEWTONS_PER_METRE = 1e-3
"""In a dyn/cm."""

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class StretchPoint:
    """A state of rest."""

    strain: float
    """Size along the direction that is drawn, over that of the free cell, less one."""
    width: float
    """Of the cell [cm]."""
    height: float
    """Of the cell [cm]."""
    course_tension: float
    """Force along the courses over the height of the free cell [dyn/cm]."""
    wale_tension: float
    """Force along the wales over the width of the free cell [dyn/cm]."""
    energy: float
    """Over the area of the free cell [erg/cm^2]."""
    yarn_strain: float
    """Length of all yarn over its length at rest, less one."""
    residual: float
    """Relative force residual."""
    converged: bool
    """Whether it came to rest."""


@dataclass(frozen=True, eq=False)
class StretchCurve:
    """A fabric drawn in one direction."""

    direction: Direction
    """The direction that is drawn."""
    other: Other
    """Whether the other size is free or held."""
    free: Swatch
    """The cell without stress."""
    points: tuple[StretchPoint, ...]
    """What is measured at each strain."""
    states: tuple[YarnSet, ...]
    """The yarns at each strain."""

    def column(self, name: str) -> FloatArray:
        """One measure of all points, shape (steps,)."""
        return np.array([getattr(point, name) for point in self.points], dtype=np.float64)

    @property
    def tension(self) -> FloatArray:
        """Tension along the direction that is drawn [dyn/cm], shape (steps,)."""
        return self.column(f"{self.direction}_tension")

    @property
    def snaps(self) -> list[int]:
        """Points before which the fabric snapped to another shape.

        Between two points whose tension goes from one to the other the energy changes by their mean to within half of
        the larger; what lies further off was not stretching.
        """
        strain, energy = self.column("strain"), self.column("energy")
        work = (self.tension[1:] + self.tension[:-1]) / 2 * np.diff(strain)
        room = np.maximum(np.abs(self.tension[1:]), np.abs(self.tension[:-1])) * np.abs(np.diff(strain)) / 2
        noise = SMALLEST_SNAP * energy.max()
        return [int(k) + 1 for k in np.flatnonzero(np.abs(np.diff(energy) - work) > room + noise)]


def stretch_test(
    pattern: str | Pattern | Weave,
    *,
    course: tuple[float, float] | None = None,
    wale: tuple[float, float] | None = None,
    other: Other = "free",
    steps: int = STEPS,
    material: YarnMaterial | None = None,
    quality: str | Quality = "standard",
    device: str | None = None,
    progress: Callable[[StretchPoint], None] | None = None,
    on_entry: Callable[[HistoryEntry], None] | None = None,
    **options: Any,
) -> StretchCurve:
    """Draw a swatch in one direction.

    Args:
        pattern: as for ``swatch``.
        course: first and last strain along the courses, 0.4 for 40 %.
        wale: the same along the wales; one of the two is given.
        other: whether the size across the direction is free to follow, or held as it is in the free cell.
        steps: how many strains, the first and the last among them.
        material: as for ``swatch``.
        quality: a preset or a ``Quality``, made as fine as tension needs (``fine_enough``).
        device: as for ``swatch``.
        progress: called with each point.
        on_entry: called every half second or so while a state comes to rest.
        options: fields of ``SwatchOptions``, without the period.

    Raises:
        ParameterError: not one direction, a strain out of bounds, no range, too few steps, or a period.
        FileError, PatternError, SolverError: as for ``swatch``.
    """
    direction, strains = chosen_strains(course, wale, steps)
    if other not in get_args(Other):
        raise ParameterError(f"other: got {other!r}; expected free or held")
    if "period" in options:
        raise ParameterError("period: got one for a stretch, which begins at the free cell; leave it out")
    quality = fine_enough(quality_named(quality))
    free = swatch(
        pattern, material=material, quality=quality, device=device, relax_cell=RelaxCell(shear=False),
        progress=on_entry, **options,
    )  # fmt: skip
    if material is None:
        material = YarnMaterial.named("stitchmesh").scaled(options.get("yarn_radius", YARN_RADIUS) / REFERENCE_RADIUS)
    quality = close_contacts(quality, SwatchOptions(**options))
    cell = held_cell(direction, other)
    yarns, points, states = free.yarns, [], []
    for strain in strains:
        yarns = change_period(yarns, size_at(free, direction, other, strain), material, quality, device)
        rest = relax_yarns(yarns, material=material, quality=quality, device=device, cell=cell, progress=on_entry)
        yarns = rest.yarns
        points.append(measured(free, strain, yarns, rest.report, material, quality, device))
        states.append(yarns)
        if progress is not None:
            progress(points[-1])
    refuse_pull_through(free.yarns, yarns, device)
    curve = StretchCurve(direction, other, free, tuple(points), tuple(states))
    _tell_snaps(curve)
    return curve


def _tell_snaps(curve: StretchCurve) -> None:
    strain = 100 * curve.column("strain")
    for point in curve.snaps:
        between = f"{strain[point - 1]:g} % and {strain[point]:g} %"
        logger.warning("stretch: between %s the fabric snapped to another shape; yarns without friction may", between)


def chosen_strains(
    course: tuple[float, float] | None, wale: tuple[float, float] | None, steps: int
) -> tuple[Direction, FloatArray]:
    """The direction that is drawn, and its strains.

    Raises:
        ParameterError: not one direction, a strain out of bounds, no range, or too few steps.
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
        raise ParameterError(f"{direction}: got {100 * first:g} % twice; expected two strains that differ")
    if steps < 2:
        raise ParameterError(f"steps: got {steps}; expected at least 2")
    return direction, np.linspace(first, last, steps)


def fine_enough(quality: Quality) -> Quality:
    """The quality with ``TOLERANCE``, ``CONTROL_POINTS`` and ``CONTACT_SAMPLES`` where its own are coarser."""
    return replace(
        quality, tolerance=min(quality.tolerance, TOLERANCE),
        control_points_per_stitch=max(quality.control_points_per_stitch, CONTROL_POINTS),
        contact_samples=max(quality.contact_samples, CONTACT_SAMPLES),
    )  # fmt: skip


def held_cell(direction: Direction, other: Other) -> RelaxCell:
    """What the cell is free to do while it is held in one direction."""
    pull = 0.0 if other == "free" else None
    return RelaxCell(course=None, wale=pull, shear=False) if direction == "course" else RelaxCell(pull, None, False)


def size_at(free: Swatch, direction: Direction, other: Other, strain: float) -> tuple[float | None, float | None]:
    """Width and height to set [cm]; None where the size is free."""
    width, height = size_of(free.lattice)
    if direction == "course":
        return (1.0 + strain) * width, height if other == "held" else None
    return width if other == "held" else None, (1.0 + strain) * height


def measured(
    free: Swatch, strain: float, yarns: YarnSet, report: dict[str, Any], material: YarnMaterial, quality: Quality,
    device: str | None,
) -> StretchPoint:  # fmt: skip
    """What is known of yarns at rest at that strain; ``report`` is of ``relax_yarns``."""
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
