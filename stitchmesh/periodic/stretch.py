# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stretch tests: a free swatch is stretched along its courses or its wales, and its tension is measured at each strain.

The cell is first relaxed without stress and with its periods at right angles. It lies between the planes of a free
swatch (``support``) all the time, because fabrics buckle. One of its sizes, with the free value L0, is then set to (1 +
strain) L0 for each strain in turn (``drawn_cell``). Each state starts from the previous one. The yarns relax, and the
other size too unless it is held. The tension is nominal ("engineering"): the force on a border over the length of that
border in the free cell,

    T_course = s_course height / height0        T_wale = s_wale width / width0      [dyn/cm]

where s is the stress of the deformed cell (``yarnrelax/cell_stress``). Let e be the energy of the cell over the area of
the free cell. The work is

    de = T_course d(width) / width0 + T_wale d(height) / height0

so the slope of e over the strain equals the tension, both if the other size is free (its tension is zero) and if it is
held (its change is zero). 1000 dyn/cm are 1 N/m. Without friction the curve is the same for loading and unloading while
the fabric stays on one branch; a fabric that snaps from one shape to another continues on another branch. With friction
loading and unloading differ. Loading then begins at the free cell without friction.
"""

from __future__ import annotations

import csv
import io
import logging
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import pairwise
from typing import Any, get_args

import numpy as np

from stitchmesh.budget.budget import Budget
from stitchmesh.budget.plan import limit_of
from stitchmesh.errors import ParameterError, SolverError
from stitchmesh.io.atomic import write_text
from stitchmesh.io.contents import FilePath
from stitchmesh.linking.certificate import refuse_pull_through
from stitchmesh.memory_need import BASE_MEMORY, BYTES_PER_KEPT_POINT, check_memory
from stitchmesh.mesh import FloatArray
from stitchmesh.patterns import Pattern
from stitchmesh.periodic.hysteresis import StretchLoop, closed_loops
from stitchmesh.periodic.relaxation.continuation import size_of
from stitchmesh.periodic.relaxation.drawn_cell import (
    Direction,
    DrawnCell,
    DrawnState,
    Other,
    draw_with_friction,
    draw_without_friction,
)
from stitchmesh.periodic.relaxation.prepared_swatch import PreparedSwatch, check_kept_states, prepare_swatch
from stitchmesh.periodic.relaxation.support import planes
from stitchmesh.periodic.swatch import Swatch, relax_prepared
from stitchmesh.periodic.swatch_options import StretchSettings
from stitchmesh.periodic.validated_range import NOT_JUDGED, RangeVerdict, fabric_of, tension_verdict
from stitchmesh.periodic.weave.weave import Weave
from stitchmesh.quality import DEFAULT_QUALITY, PRESETS, Quality, quality_named
from stitchmesh.run import SHOWN, Run
from stitchmesh.settings import check_settings
from stitchmesh.time_limit import limited_to
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial
from stitchmesh.yarnrelax.energies.term import YarnChoice
from stitchmesh.yarnrelax.friction.friction import Friction

TOLERANCE = 1e-3
"""Largest residual of each state; the small resistance of ribs needs this value."""
LEAST_STRAIN, MOST_STRAIN = -0.9, 9.0
"""Smallest and largest strain."""
NEWTONS_PER_METRE = 1e-3
"""1 dyn/cm in N/m."""

logger = logging.getLogger(__name__)


@dataclass(frozen=True, kw_only=True)
class StretchPath(StretchSettings):
    """The strains that a stretch test goes through, one after another, with the size across and the friction.

    Raises:
        ParameterError: not exactly one direction is given, a strain is out of bounds, there is one strain only, two
            strains one after another are equal, there are fewer than two steps or a negative number of cycles, cycles
            are given for a path that turns, or no yarn has this friction.
    """

    course: tuple[float, ...] | None = None
    """First and last strain along the courses, for example 0.4 for 40 %. Strains between them are turning points:
    (0.0, 0.4, 0.2, 0.4) stretches to 40 %, lets back to 20 % and stretches to 40 % again."""
    wale: tuple[float, ...] | None = None
    """The same along the wales. Either ``course`` or ``wale`` must be given."""
    other: Other = "free"
    """``free`` relaxes the size across the stretch direction; ``held`` keeps its value in the free cell."""

    def __post_init__(self) -> None:
        if (self.course is None) == (self.wale is None):
            got = "neither" if self.course is None else "both"
            raise ParameterError(f"stretch: got {got} of course and wale; expected strains of one of them")
        if len(self.ends) < 2:
            raise ParameterError(f"{self.direction}: got {len(self.ends)} strains; expected two or more")
        low, high = min(self.ends), max(self.ends)
        if not (np.isfinite(self.ends).all() and LEAST_STRAIN <= low and high <= MOST_STRAIN):
            found = " to ".join(f"{100 * strain:g} %" for strain in self.ends)
            bounds = f"{100 * LEAST_STRAIN:g} % to {100 * MOST_STRAIN:g} %"
            raise ParameterError(f"{self.direction}: got {found}; expected strains of {bounds}")
        for before, after in pairwise(self.ends):
            if before == after:
                raise ParameterError(f"{self.direction}: got {100 * after:g} % twice; expected two different strains")
        check_settings(self)
        if self.cycles and len(self.ends) > 2:
            found = f"cycles: got {self.cycles} for a path of {len(self.ends)} strains"
            raise ParameterError(f"{found}; expected 0: write the way back into the path")
        if self.other not in get_args(Other):
            raise ParameterError(f"other: got {self.other!r}; expected free or held")
        states = 1 + sum(steps for _, _, steps in self._parts)
        need = BASE_MEMORY + BYTES_PER_KEPT_POINT * states
        check_memory(f"a stretch test of {states:,} strains", need, "fewer steps")
        Friction(self.friction or 0.0, self.slip_length or Friction.slip_length)

    @property
    def rubbing(self) -> Friction | None:
        """The friction between the yarns; None without friction."""
        friction = Friction(self.friction or 0.0, self.slip_length or Friction.slip_length)
        return friction if self.friction else None

    @property
    def direction(self) -> Direction:
        """The stretch direction."""
        return "wale" if self.course is None else "course"

    @property
    def ends(self) -> tuple[float, ...]:
        """The first and the last strain, and the turning points between them."""
        ends = self.wale if self.course is None else self.course
        assert ends is not None
        return ends

    @property
    def _parts(self) -> list[tuple[float, float, int]]:
        """Where each part of the path begins and ends, and its number of steps.

        A way that passes a turning point of the path has parts before and behind it: the tension there is then known.
        """
        ends = [*self.ends, *self.ends * self.cycles][: len(self.ends) + max(2 * self.cycles - 1, 0)]
        spacing = max(abs(after - before) for before, after in pairwise(ends)) / (self.steps - 1)
        parts: list[tuple[float, float, int]] = []
        for before, after in pairwise(ends):
            between = {strain for strain in ends if min(before, after) < strain < max(before, after)}
            stops = [before, *sorted(between, reverse=after < before), after]
            # Rounding error of a number of steps
            parts += [(here, there, max(math.ceil(abs(there - here) / spacing - 1e-9), 1))
                      for here, there in pairwise(stops)]  # fmt: skip
        return parts

    @property
    def strains(self) -> FloatArray:
        """The strains one after another, shape (n,); each turning point occurs once."""
        ways: dict[tuple[float, float], FloatArray] = {}
        for before, after, steps in self._parts:
            # The way back has the strains of the way there, to the last bit.
            ways.setdefault((before, after), ways[after, before][::-1] if (after, before) in ways else
                            np.linspace(before, after, steps + 1))  # fmt: skip
        return np.concatenate([self.ends[:1], *(ways[before, after][1:] for before, after, _ in self._parts)])


@dataclass(frozen=True)
class StretchPoint:
    """One relaxed state of a stretch test."""

    strain: float
    """Size in the stretch direction over the size of the free cell, minus one."""
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
    branch: int = 1
    """Number of the branch, from 1. Without friction two states are on one branch if the fabric goes from one to the
    other and back again. With friction each way out, and each way back, is a branch."""


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
    friction: float = 0.0
    """Coefficient of friction between yarns."""
    out_of_time: bool = False
    """Whether a limit on the time ended the curve before its last strain."""
    ranges: RangeVerdict = NOT_JUDGED
    """Whether tensions were compared with measurements, and the error to expect (``validated_range``)."""

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
    def loops(self) -> tuple[StretchLoop, ...]:
        """The loops of the curve, which say what work friction takes and whether they close (``hysteresis``)."""
        return closed_loops(self.column("strain"), self.tension)

    @property
    def snaps(self) -> list[int]:
        """Indices of the points before which fabric without friction snapped to another branch."""
        return [] if self.friction else (np.flatnonzero(np.diff([point.branch for point in self.points])) + 1).tolist()

    @property
    def snap_texts(self) -> list[str]:
        """A clause about each snap."""
        branch, percent = [point.branch for point in self.points], 100.0 * self.column("strain")
        return [
            f"between {percent[k - 1]:.3g} % and {percent[k]:.3g} % the fabric snapped from branch {branch[k - 1]} to "
            f"branch {branch[k]}, another shape, from which it does not come back the same way"
            for k in self.snaps
        ]


def stretch_test(
    pattern: str | Pattern | Weave,
    path: StretchPath,
    *,
    material: YarnMaterial | None = None,
    quality: str | Quality = DEFAULT_QUALITY,
    device: str | None = None,
    budget: Budget | None = None,
    run: Run[StretchPoint] = SHOWN,
    **options: Any,
) -> StretchCurve:
    """Stretch a swatch in one direction and measure its tension.

    Args:
        pattern: a pattern or a weave, the name of one in the library, or the path of a file.
        path: the strains, and the friction between the yarns. The free cell is the one without friction.
        material: material of the yarn; by default the material ``stitchmesh``, scaled to the radius of the yarn.
        quality: a preset or a ``Quality``; it is refined to the needs of tensions (``refine_for_tension``).
        device: device of the kernels, for example ``cpu`` or ``cuda:0``; by default the first GPU, or the CPU if there
            is no GPU.
        budget: a limit on the time, which raises no error: the curve ends with the last state that came to rest in
            time.
        run: progress of the relaxation of each state; ``on_state`` is called with each point. The test obeys nothing
            else of it.
        options: fields of ``SwatchOptions``, except the period.

    Raises:
        ParameterError: a period, a tension of blocking or an error is given, or the run asks for something that a test
            does not obey.
        FileError, PatternError: an error of ``swatch``.
        SolverError: an error of ``swatch``, or the time does not suffice for one state.
    """
    run.refuse_all_but("stretch_test", "on_state")
    if budget is not None and budget.error is not None:
        raise ParameterError("error: got one for a stretch test, whose tensions are not measured by it; give a quality")
    for name in {"period", "blocked"} & options.keys():
        raise ParameterError(f"{name}: got one for a stretch test, which begins at the free cell; leave it out")
    if options.get("residual_twist"):
        found = "residual_twist: got one for a stretch test, whose cell does not shear"
        raise ParameterError(f"{found}; leave it out")
    with limited_to(limit_of(budget)):
        quality = refine_for_tension(quality_named(quality))
        prepared = prepare_swatch(
            pattern, material=material, quality=quality, device=device, relax_cell=True, relaxation="frictionless",
            **options,
        )  # fmt: skip
        curve = _stretch(prepared, path, device, run)
    radius = prepared.options.yarn_radius
    loops = curve.free.report["loop_length"] / (2.0 * radius)
    ranges = tension_verdict(fabric_of(prepared.source), loops, path, prepared.material, radius, quality)
    return replace(curve, ranges=ranges)


def _stretch(
    prepared: PreparedSwatch, path: StretchPath, device: str | None, run: Run[StretchPoint]
) -> StretchCurve:  # fmt: skip
    """Stretch a swatch in the remaining time; other arguments and errors as for ``stretch_test``."""
    strains, friction = path.strains, path.rubbing
    relaxing: Run[YarnSet] = Run(run.progress)
    check_kept_states("stretch", len(strains), prepared.yarns)
    free, own = relax_prepared(prepared, prepared.yarns, relaxing), prepared.smallest
    drawn = DrawnCell(own.part_of(free.yarns), path.direction, path.other, prepared.material, prepared.quality,
                      planes_of(free, prepared), device, relaxing)  # fmt: skip
    if friction is not None:
        found = draw_with_friction(drawn, strains.tolist(), friction)
    else:
        found = draw_without_friction(drawn, strains.tolist())
    points, states = list[StretchPoint](), list[YarnSet]()
    for state in found:
        points.append(measure_point(drawn, state, own.copies))
        states.append(own.repeated(state.yarns, free.yarns))
        if run.on_state is not None:
            run.on_state(points[-1])
    if not points:
        raise SolverError("stretch: the time was over before one state was at rest; give more, or a coarser quality")
    refuse_pull_through(free.yarns, states[-1], device)
    out_of_time = len(points) < len(strains)
    curve = StretchCurve(path.direction, path.other, free, tuple(points), tuple(states), path.friction or 0.0,
                         out_of_time)  # fmt: skip
    for text in curve.snap_texts:
        logger.warning("stretch: %s; friction may hold it (--friction)", text)
    return curve


def refine_for_tension(quality: Quality) -> Quality:
    """Return a quality that is at least as fine as tensions need."""
    own, most = quality.control_points_per_stitch, PRESETS["reference"].control_points_per_stitch
    # A plain stitch has half as many control points again, up to the number of ``reference``: with 12 of them loops
    # resist up to 80 % too much. A segment has at least five contact samples: with three, samples of touching yarns
    # interlock, and the tension varies by some dyn/cm.
    return replace(
        quality, tolerance=min(quality.tolerance, TOLERANCE),
        # A stiff fabric turns a small strain into a large tension.
        largest_change=min(quality.largest_change, 1e-4),
        control_points_per_stitch=max(own, min(round(1.5 * own), most)),
        contact_samples=max(quality.contact_samples, 5),
    )  # fmt: skip


def planes_of(free: Swatch, prepared: PreparedSwatch) -> list[YarnChoice]:
    """Return the planes between which a free swatch lies, at its final size."""
    gamma = prepared.options.gamma
    flat = replace(prepared.flat, stitch_length=prepared.flat.stitch_length / gamma)
    return planes(prepared.options, flat, free.yarns.radius)


def measure_point(drawn: DrawnCell, state: DrawnState, copies: int) -> StretchPoint:
    """Measure a state; the repeat consists of several copies of the cell, one above another."""
    yarns, (width0, height0) = state.yarns, drawn.free_size
    assert yarns.lattice is not None
    width, height = size_of(yarns.lattice)
    return StretchPoint(
        strain=state.strain, width=width, height=copies * height, course_tension=state.tension[0],
        wale_tension=state.tension[1], energy=state.energy / (width0 * height0),
        yarn_strain=float(yarns.lengths.sum() / yarns.rest_length.sum() - 1.0), residual=state.residual,
        converged=state.converged, branch=state.branch,
    )  # fmt: skip


UNITS = {"width": "cm", "height": "cm", "course_tension": "dyn_per_cm", "wale_tension": "dyn_per_cm",
         "energy": "erg_per_cm2"}  # fmt: skip
"""Units of the columns that have a unit."""
NEWTONS = ("course_tension", "wale_tension")
"""Columns that are also written in N/m."""


def write_stretch(path: FilePath, curve: StretchCurve) -> None:
    """Write a stretch curve as a table.

    The columns are the fields of ``StretchPoint`` with their units, the tensions in N/m, and whether the fabric snapped
    to another branch before the state.

    Args:
        path: a ``.csv`` file; missing folders are made.
        curve: the result of a stretch test.

    Raises:
        FileError: the file cannot be written.
    """
    columns = {
        f"{name}_newton_per_metre": [float(value) * NEWTONS_PER_METRE for value in curve.column(name)]
        for name in NEWTONS
    }
    snapped = [number in curve.snaps for number in range(len(curve.points))]
    write_points(path, curve.points, UNITS, columns | {"snapped": snapped})


def write_points(
    path: FilePath, points: Sequence[Any], units: Mapping[str, str], columns: Mapping[str, Sequence[object]]
) -> None:
    """Write the points of a test as a table: their fields, named with their units, and further columns.

    Args:
        path: a ``.csv`` file; missing folders are made.
        points: dataclasses of one kind.
        units: unit of each field that has one.
        columns: further columns by title, with a value for each point.

    Raises:
        FileError: the file cannot be written.
    """
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    rows = [asdict(point) for point in points]
    table.writerow([*(f"{name}_{units[name]}" if name in units else name for name in rows[0]), *columns])
    for row, *further in zip(rows, *columns.values(), strict=True):
        table.writerow([*row.values(), *further])
    write_text(path, text.getvalue())
