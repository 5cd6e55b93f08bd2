# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Relaxation of a swatch, one repeat of a knitted or woven pattern on its lattice: the order of operations.

As on a knitting machine, the yarn length of a stitch is given and the size of the fabric follows. The repeat is
generated (``drawn_swatch``), brought to its radii, lengths and size (``prepared_swatch``), relaxed (``way_to_rest``),
scaled by 1 / gamma and measured.

Hands and machines do not lay yarn evenly, and some patterns have several states of rest within this noise. To find the
spread of a size, the same repeat is relaxed again from shaken starts, whose control points are displaced by ``NOISE``
radii; equal numbers of starts give equal displacements.

``relax_swatches`` makes many swatches, as in a sweep over patterns, materials and options. Each is made in a thread of
its own by the same functions as one alone. All threads wait at their relaxations and examinations, which then run for
all of them together (``compute.work_together``), in batches of cells (``yarnrelax.together.relax_together``).
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field, replace
from functools import partial
from typing import Any, Literal

import numpy as np

from stitchmesh.budget.budget import Budget
from stitchmesh.budget.plan import Plan, limit_of, make_plan
from stitchmesh.budget.tables import BudgetScene
from stitchmesh.compute.shared_work import compute_each
from stitchmesh.compute.work_together import done_together
from stitchmesh.errors import ParameterError, SolverError, StitchMeshError
from stitchmesh.io.history import HistoryEntry
from stitchmesh.lattice import Lattice
from stitchmesh.linking.certificate import refuse_pull_through
from stitchmesh.mesh import StitchMesh
from stitchmesh.patterns import Pattern
from stitchmesh.periodic.fabric_shape import FlatFabric
from stitchmesh.periodic.gauge import swatch_report
from stitchmesh.periodic.relaxation.continuation import size_of
from stitchmesh.periodic.relaxation.off_needles import let_go, needle_size, state_of_rest
from stitchmesh.periodic.relaxation.prepared_swatch import CellAtRest, PreparedSwatch, check_kept_states, prepare_swatch
from stitchmesh.periodic.relaxation.spirality import torque, torque_report
from stitchmesh.periodic.relaxation.steaming import keeps_bends, state_before, with_lasting_bends
from stitchmesh.periodic.relaxation.support import planes_report, refuse_tearing, remedy_of, tearing
from stitchmesh.periodic.relaxation.way_to_rest import relax_along
from stitchmesh.periodic.repeat.smallest_cell import SmallestCell
from stitchmesh.periodic.resolve_pattern import resolve_pattern, stitches_of
from stitchmesh.periodic.sampling.even_sampling import sample_evenly
from stitchmesh.periodic.swatch_options import KnitState, SwatchOptions
from stitchmesh.periodic.validated_range import swatch_verdict
from stitchmesh.periodic.weave.jamming import jam_report
from stitchmesh.periodic.weave.weave import Weave
from stitchmesh.progress import Progress, shown_progress
from stitchmesh.quality import DEFAULT_QUALITY, Quality
from stitchmesh.run import QUIET, Run
from stitchmesh.time_limit import limited_to
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial
from stitchmesh.yarnrelax.convergence import rest_text
from stitchmesh.yarnrelax.relaxation_result import Relaxation
from stitchmesh.yarnrelax.together.relax_together import ways_together

NOISE = 0.01
"""Standard deviation of the displacements of a shaken start [radii]."""

logger = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class Swatch:
    """A relaxed repeat."""

    yarns: YarnSet
    """The relaxed yarns, on their lattice."""
    report: dict[str, Any]
    """Measurements as plain numbers: the values of ``gauge.swatch_report``, for a weave also of ``jamming.jam_report``,
    the shape (``FabricShape.report``), what acted on the fabric (relaxation, friction, and ``support.planes_report``),
    and the report of ``relax_yarns``."""
    fabric: StitchMesh | None
    """The stitch mesh from which the yarns were generated; None for a weave."""
    history: list[HistoryEntry]
    """Entries of the history of the relaxation, one for each assessment."""
    at_rest: CellAtRest | None = None
    """The cell that came to rest, from which ``sensitivity`` and others compute; None for a swatch from a file."""

    def __repr__(self) -> str:
        """Return one line: stitches (or crossings of a weave), size, state of rest, and yarns."""
        counts = f"{self.report['wales']} x {self.report['courses']}"
        size = f"{self.report['width']:.3g} x {self.report['height']:.3g} cm"
        return f"Swatch({counts}, {size}, {rest_text(self.report)}, {self.yarns})"

    @property
    def lattice(self) -> Lattice:
        """The lattice of the relaxed repeat."""
        assert self.yarns.lattice is not None
        return self.yarns.lattice


def swatch(
    pattern: str | Pattern | Weave,
    *,
    material: YarnMaterial | None = None,
    quality: str | Quality = DEFAULT_QUALITY,
    device: str | None = None,
    shaken: int = 0,
    budget: Budget | None = None,
    progress: Progress | Literal[False] | None = None,
    **options: Any,
) -> Swatch:
    """Relax one repeat of a pattern.

    Args:
        pattern: a pattern or a weave, the name of one in the library, or the path of a file.
        material: material of the yarn; by default the material ``stitchmesh``, scaled to the radius of the yarn.
        quality: a preset or a ``Quality``.
        device: device of the kernels, for example ``cpu`` or ``cuda:0``; by default the first GPU, or the CPU if there
            is no GPU.
        shaken: number of shaken starts that relax too. The report then has ``shaken``; ``shaken_at_rest``, how many of
            them came to rest; and ``size_spread``, the largest minus the smallest width and height of all starts at
            rest, over their means (None if none is at rest).
        budget: limits on the time and on the error. Measured tables then choose the quality, unless the caller gives
            another than the default, and the report says what they chose (``budget.plan``).
        progress: called about every half second with the stage, its completed part and a line of text; by default a
            line shows them on a terminal or in a notebook, and False shows nothing.
        options: fields of ``SwatchOptions``: loops, size, whether the size is relaxed (``relax_cell``), the relaxation
            of a knit, and what else acts on it (``terms``). ``yarn`` is a ``Yarn``, the name of one or the path of its
            file: it gives the sizes, the mass and the material that are not given, and the yarns carry it.

    Raises:
        FileError: the file cannot be read.
        ParameterError: an option is out of bounds, does not apply to the pattern, or asks for too many starts.
        PatternError: the pattern does not repeat, a float is too long, or the weave falls apart.
        SolverError: the yarns cannot be relaxed.
    """
    began = time.perf_counter()
    with limited_to(limit_of(budget)):
        plan = None
        if budget is not None:
            plan = plan_swatch(pattern, budget, quality, device, **options)
        prepared = prepare_swatch(
            pattern, material=material, quality=quality if plan is None else plan.quality, device=device, **options
        )
        made = relax_shaken(prepared, shaken, Run(progress))
    own = {"seconds": time.perf_counter() - began} | ({} if plan is None else {"budget": plan.report()})
    return replace(made, report=made.report | own)


def plan_swatch(
    pattern: str | Pattern | Weave, budget: Budget, quality: str | Quality, device: str | None, **options: Any
) -> Plan:
    """Return the plan of a swatch for a budget; arguments as for ``swatch``.

    Raises:
        StitchMeshError: an error of ``swatch``, or a quality beside an error.
    """
    chosen = SwatchOptions(**options)
    source = resolve_pattern(pattern)
    # Number of relaxations, one after another, on the needles and in the release to each state (``off_needles``)
    relaxations: dict[KnitState, int] = {"frictionless": 1, "dry": 14, "wet": 18, "full": 23}
    scene = BudgetScene(
        kind="free cell" if chosen.has_free_size else "given cell",
        stitches=stitches_of(source) * chosen.columns * chosen.rows,
        name=source.name if (chosen.columns, chosen.rows) == (1, 1) else "",
        relaxations=relaxations[state_of_rest(chosen, woven=isinstance(source, Weave))],
    )  # fmt: skip
    return make_plan(budget, scene, quality, device)


def relax_shaken(prepared: PreparedSwatch, shaken: int, run: Run[YarnSet] = QUIET) -> Swatch:
    """Relax a prepared repeat and measure it, with the spread of its size over a number of shaken starts.

    Raises:
        ParameterError: a negative number of starts, more than fit into the memory, or an error of ``relax_prepared``.
        SolverError: an error of ``relax_prepared``.
    """
    if shaken < 0:
        raise ParameterError(f"shaken: got {shaken} starts; expected 0 or more")
    if shaken:
        check_kept_states("swatch", shaken, prepared.yarns)
    made = relax_prepared(prepared, prepared.yarns, run)
    if not shaken:
        return made
    starts = [shaken_yarns(prepared.yarns, number) for number in range(shaken)]
    others = compute_each([partial(relax_prepared, prepared, start) for start in starts])
    for other in others:
        if isinstance(other, StitchMeshError) and not isinstance(other, SolverError):
            raise other
    swatches = [each for each in others if isinstance(each, Swatch)]
    spread = size_spread([made, *swatches]) if made.report["converged"] else None
    resting = sum(each.report["converged"] for each in swatches)
    own = {"shaken": shaken, "shaken_at_rest": resting, "size_spread": spread if resting else None}
    return replace(made, report=made.report | own)


def shaken_yarns(yarns: YarnSet, number: int) -> YarnSet:
    """Return yarns whose control points have the noise of the start with this number."""
    random = np.random.default_rng(number)
    noise = NOISE * yarns.radius[yarns.point_yarn, None] * random.normal(size=yarns.points.shape)
    return replace(yarns, points=yarns.points + noise)


def size_spread(swatches: Sequence[Swatch]) -> tuple[float, float]:
    """Return the largest minus the smallest width and height of the swatches at rest, over their means.

    If none is at rest, all swatches count.
    """
    rested = [each for each in swatches if each.report["converged"]] or swatches
    sizes = np.array([size_of(each.lattice) for each in rested])
    width, height = (np.ptp(sizes, axis=0) / sizes.mean(axis=0)).tolist()
    return width, height


def relax_prepared(prepared: PreparedSwatch, yarns: YarnSet, run: Run[YarnSet] = QUIET) -> Swatch:
    """Relax a prepared repeat, starting from the prepared yarns or from the same yarns at other places, and measure it.

    Raises:
        ParameterError: the tension of a blocked swatch is too large.
        SolverError: the yarns cannot be relaxed, or a yarn passed through another one.
    """
    chosen = prepared.options
    with tearing(chosen):
        if prepared.release is not None and prepared.fabric is not None:
            needles = needle_size(prepared.fabric, chosen.plain_loop * chosen.gamma)
            relaxed = let_go(
                yarns, needles, prepared.release, prepared.similar, prepared.quality, prepared.device, prepared.terms,
                run,
            )  # fmt: skip
        else:
            relaxed = relax_along(prepared, yarns, run)
        before: dict[str, Any] = {}
        if keeps_bends(prepared):
            before = {"steamed": chosen.steamed or 0.0, "before_steam": state_before(relaxed, prepared)}
            prepared, relaxed = with_lasting_bends(prepared, relaxed, run)
            chosen = prepared.options
    own = prepared.smallest
    at_rest = CellAtRest.of(prepared, relaxed.yarns)
    drawn = prepared.drawn if len(prepared.path) == 1 else sample_evenly(prepared.drawn, relaxed.yarns)
    refuse_pull_through(drawn, relaxed.yarns, prepared.device)
    refuse_tearing(relaxed.report["max_strain"], chosen)
    if own.copies > 1:
        like = prepared.drawn_with(prepared.quality)
        drawn = own.repeated(drawn, like)
        relaxed = whole_repeat(relaxed, own, like)
    result = replace(in_fabric(relaxed.yarns, chosen), made_of=prepared.made_of)
    measures = swatch_report(
        result, prepared.fabric, prepared.material, prepared.quality, relaxed.report["energy"], prepared.device,
        twist=next(iter(torque(chosen, prepared.material, 1.0)), None),
    )  # fmt: skip
    if isinstance(prepared.source, Weave):
        measures |= jam_report(prepared.source, result)
    acting = {"relaxation": "frictionless", "friction": 0.0}
    acting |= torque_report(chosen, prepared.material, measures["loop_length"])
    acting |= planes_report(prepared.terms, at_rest.yarns, prepared.similar, chosen.gamma)
    flat = replace(FlatFabric.of(drawn, prepared.fabric, prepared.source), diameters=prepared.flat.diameters)
    shape = flat.shape_of(result)
    if shape.name != "flat":
        logger.warning("%s; %s", shape.text, remedy_of(prepared.cell, lies=acting["planes_distance"] is not None))
    report = measures | shape.report() | acting | before | relaxed.report
    report |= {"solver_seconds": relaxed.report["seconds"]}
    report |= swatch_verdict(prepared.source, chosen, measures["loop_length"], prepared.material).report()
    return Swatch(result, report, prepared.fabric, relaxed.history, at_rest)


def whole_repeat(relaxed: Relaxation, smallest: SmallestCell, like: YarnSet) -> Relaxation:
    """Return the relaxation of a repeat from that of its smallest cell: the yarns and energies of all images."""
    copies = smallest.copies
    history = [
        entry | {"energies": {name: copies * energy for name, energy in entry["energies"].items()}}
        for entry in relaxed.history
    ]
    report = {
        "energy": copies * relaxed.report["energy"],
        "energies": {name: copies * energy for name, energy in relaxed.report["energies"].items()},
    }
    return Relaxation(smallest.repeated(relaxed.yarns, like), relaxed.report | report, history)


def in_fabric(yarns: YarnSet, options: SwatchOptions) -> YarnSet:
    """Return yarns that relaxed at gamma times their size, with the size and the stated mass of the fabric."""
    fabric = scale_yarns(yarns, 1.0 / options.gamma)
    return replace(fabric, mass_per_length=options.stated_masses(fabric.radius))


def scale_yarns(yarns: YarnSet, factor: float) -> YarnSet:
    """Multiply all lengths of yarns on a lattice by a factor; the mass of the yarns stays the same."""
    assert yarns.lattice is not None
    return replace(
        yarns.with_radius(yarns.radius * factor), points=yarns.points * factor,
        rest_length=yarns.rest_length * factor, natural_curvature=yarns.natural_curvature / factor,
        lattice=Lattice(yarns.lattice.periods * factor), mass_per_length=yarns.mass_per_length / factor,
    )  # fmt: skip


SwatchProgress = Callable[[int, int], None]
"""Called with the number of finished swatches, and with the number of all swatches."""


@dataclass(frozen=True, eq=False)
class SwatchRequest:
    """A swatch to be made: the arguments of ``swatch``, without device, budget and progress."""

    pattern: str | Pattern | Weave
    """A pattern or a weave, the name of one in the library, or the path of a file."""
    _: KW_ONLY
    material: YarnMaterial | None = None
    """Material of the yarn; by default the material ``stitchmesh``, scaled to the radius of the yarn."""
    quality: str | Quality = DEFAULT_QUALITY
    """A preset or a ``Quality``."""
    relax_cell: bool | RelaxCell = False
    """Whether the width and height of the repeat are relaxed, or the degrees of freedom of a cell."""
    shaken: int = 0
    """Number of shaken starts that relax too, for the spread of the size."""
    options: Mapping[str, Any] = field(default_factory=dict)
    """Fields of ``SwatchOptions``; they are checked when the swatch is made."""


def relax_swatches(
    requests: Sequence[SwatchRequest],
    *,
    device: str | None = None,
    progress: SwatchProgress | Literal[False] | None = None,
) -> list[Swatch | StitchMeshError]:
    """Make swatches together, each as ``swatch`` makes it.

    On a GPU a launch costs more than the work of a small cell, so hundreds of swatches take little longer than one.
    Each has the bits that ``swatch`` gives on the same device, whatever the other requests are. Only cells of more than
    1,280 coordinates, and knits that are let go with friction, may have other rounding errors. In the reports,
    ``seconds`` is the time from the begin of a swatch to its end, and ``solver_seconds`` counts the batches in which it
    took part.

    Args:
        requests: the swatches.
        device: device of the kernels, for example ``cpu`` or ``cuda:0``; by default the first GPU, or the CPU if there
            is no GPU.
        progress: called when a swatch is done; by default a line shows the progress on a terminal or in a notebook, and
            False shows nothing.

    Returns:
        The swatches in the order of the requests; in place of one that cannot be made, the error that ``swatch``
        raises.
    """
    with shown_progress(progress, _report_swatches) as report:
        computations = [partial(_make_requested, request, device) for request in requests]

        def on_done(done: int) -> None:
            if report is not None:
                report(done, len(requests))

        return done_together(computations, ways_together(), on_done)


def _report_swatches(progress: Progress) -> SwatchProgress:
    """Return a function that reports the number of swatches as the progress of a stage."""
    return lambda done, count: progress("swatches", done / count, f"{done} of {count}")


def _make_requested(request: SwatchRequest, device: str | None) -> Swatch:
    """Make a swatch; its report gives the time, which includes work for other swatches meanwhile."""
    began = time.perf_counter()
    prepared = prepare_swatch(
        request.pattern, material=request.material, quality=request.quality, device=device,
        **{"relax_cell": request.relax_cell, **request.options},
    )  # fmt: skip
    made = relax_shaken(prepared, request.shaken)
    return replace(made, report=made.report | {"seconds": time.perf_counter() - began})
