# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Extreme yarns in both precisions: each relaxation converges, stops with a message, or raises a StitchMesh error.

A fault is a number that is not finite, a distance of zero, a changed linking, a stop without a message, or another
exception.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from benchmarks.scenes.stockinette import stockinette_tube
from benchmarks.table import Rows
from stitchmesh.linking.certificate import changed_pairs, doubled_linking
from stitchmesh.quality import Quality, quality_named
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial, relax_yarns
from stitchmesh.yarnrelax.constraints.pins import Pins
from stitchmesh.yarnrelax.energies.term import ConstraintChoice
from stitchmesh.yarnrelax.model.material import REFERENCE_RADIUS
from tests.extremes.outcome import AT_REST, FAILED, NOT_AT_REST, Outcome, ended, table

RADIUS = REFERENCE_RADIUS
"""Yarn radius of scenes with a usual radius [cm]."""
STITCHMESH = YarnMaterial.named("stitchmesh")


@dataclass(frozen=True)
class Case:
    """One extreme scene."""

    name: str
    make: Callable[[], YarnSet]
    """Function that generates the yarns."""
    material: YarnMaterial | None = None
    """Stiffnesses; by default those for the yarn radius."""
    constraints: tuple[ConstraintChoice, ...] = ()
    """Constraints of control points."""
    large: bool = False
    """Whether the case takes too long for a test."""
    iterations: int = 3000
    """Limit of iterations."""


def knit() -> YarnSet:
    """A small tube of plain knit."""
    return stockinette_tube(4, 6, 12, RADIUS)


def crossing(distance: float) -> YarnSet:
    """Two straight yarns across each other, their axes ``distance`` radii apart."""
    place = np.linspace(-1.5, 1.5, 13)
    lower = np.stack([place, 0 * place, 0 * place], axis=1)
    upper = np.stack([0 * place, place, np.full(13, distance * RADIUS)], axis=1)
    return YarnSet.from_curves([lower, upper], closed=[False, False], radius=RADIUS)


def side_by_side(distance: float) -> YarnSet:
    """Two straight parallel yarns, their axes ``distance`` radii apart."""
    place = np.linspace(-1.5, 1.5, 13)
    lower = np.stack([place, 0 * place, 0 * place], axis=1)
    upper = lower + np.array([0.0, 0.0, distance * RADIUS])
    return YarnSet.from_curves([lower, upper], closed=[False, False], radius=RADIUS)


def ring(count: int, size: float, middle: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> NDArray[np.float64]:
    """Control points of a ring."""
    angle = np.arange(count) / count * 2 * np.pi
    return np.asarray(middle) + size * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)


def linked(count: int) -> YarnSet:
    """Two linked rings of ``count`` control points."""
    first = ring(count, 1.0)
    second = first[:, [0, 2, 1]] + np.array([1.0, 0.0, 0.0])
    return YarnSet.from_curves([first, second], closed=[True, True], radius=RADIUS / 2)


def repeated_point(times: int) -> YarnSet:
    """Return the tube with ``times`` successive control points at one position and unchanged rest lengths."""
    yarns = knit()
    points = yarns.points.copy()
    points[10 : 10 + times] = points[10]
    return replace(yarns, points=points)


def point_on_another() -> YarnSet:
    """Return two yarns with a control point at the same position."""
    yarns = knit()
    points = yarns.points.copy()
    first, second = points[: yarns.start[1]], points[yarns.start[1] : yarns.start[2]]
    apart = np.linalg.norm(first[:, None] - second[None], axis=2)
    one, other = np.unravel_index(apart.argmin(), apart.shape)
    points[one] = points[yarns.start[1] + other]
    return replace(yarns, points=points)


def rest_lengths(factor: float) -> YarnSet:
    """The tube with other rest lengths."""
    yarns = knit()
    return replace(yarns, rest_length=factor * yarns.rest_length)


def in_steps(step: float, last: float) -> YarnSet:
    """Return the tube after changes of its rest lengths by the factor ``step`` to ``last``, with short relaxations."""
    yarns, factor = knit(), 1.0
    rest_length = yarns.rest_length
    while factor != last:
        factor = max(factor * step, last) if step < 1.0 else min(factor * step, last)
        yarns = replace(yarns, rest_length=factor * rest_length)
        yarns = relax_yarns(yarns, quality=replace(quality_named("draft"), max_iterations=200), device="cpu").yarns
    return yarns


def thick(factor: float) -> YarnSet:
    """Return the tube at the same position with another yarn radius."""
    yarns = knit()
    return replace(yarns, radius=factor * yarns.radius)


def scaled(factor: float) -> YarnSet:
    """The tube in other units."""
    yarns = knit()
    lengths = {name: factor * getattr(yarns, name) for name in ("points", "rest_length", "radius")}
    return replace(yarns, **lengths)


def moved(distance: float) -> YarnSet:
    """Return the tube, moved by ``distance`` radii."""
    yarns = knit()
    return replace(yarns, points=yarns.points + distance * RADIUS)


def far_apart(distance: float) -> YarnSet:
    """Two pairs of crossing yarns, ``distance`` radii apart."""
    near = crossing(1.5)
    curves = [near.points[:13], near.points[13:]]
    away = [curve + np.array([distance * RADIUS, 0.0, 0.0]) for curve in curves]
    return YarnSet.from_curves([*curves, *away], closed=[False] * 4, radius=RADIUS)


def hairpin(bend: float) -> YarnSet:
    """A yarn that turns back on itself around a radius of ``bend`` yarn radii."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, 7)
    turn = bend * RADIUS * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    leg = np.arange(10, 0, -1)[:, None] * [-RADIUS, 0.0, 0.0]
    curve = np.concatenate([leg + turn[0], turn, leg[::-1] + turn[-1]])
    return YarnSet.from_curves([curve], closed=[False], radius=RADIUS)


def squeezed(axis: int) -> YarnSet:
    """Return the tube compressed to half its size in one direction, with unchanged rest lengths."""
    yarns = knit()
    scale = np.ones(3)
    scale[axis] = 0.5
    return replace(yarns, points=yarns.points * scale)


def coil(count: int) -> YarnSet:
    """One yarn of ``count`` control points, wound so tightly that its turns overlap by a tenth."""
    turn = 48
    angle = np.arange(count) / turn * 2 * np.pi
    height = np.arange(count) / turn * 1.8 * RADIUS
    size = turn * RADIUS / (2 * np.pi)
    curve = np.stack([size * np.cos(angle), size * np.sin(angle), height], axis=1)
    return YarnSet.from_curves([curve], closed=[False], radius=RADIUS)


def chains(count: int) -> YarnSet:
    """``count`` rings, hanging in each other two by two, so tight that they touch."""
    pair = linked(8)
    size = pair.points.max(axis=0) - pair.points.min(axis=0) + 2 * RADIUS
    across = int(np.ceil(np.sqrt(count / 2)))
    curves = []
    for number in range(count // 2):
        place = np.array([number % across, number // across, 0.0]) * size
        curves += [pair.points[:8] + place, pair.points[8:] + place]
    return YarnSet.from_curves(curves, closed=[True] * len(curves), radius=2 * RADIUS)


def cases() -> list[Case]:
    """Return all cases."""
    everything = Pins(points=np.arange(len(knit().points)))
    straight = np.stack([np.arange(4) * 0.3, np.zeros(4), np.zeros(4)], axis=1)
    bent = straight + np.array([[0.0, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.0]])
    result = [
        Case("overlapping by half", lambda: crossing(1.0)),
        Case("overlapping by nine tenths", lambda: crossing(0.2)),
        Case("axes 0.01 radii apart", lambda: crossing(0.01)),
        Case("axes cross", lambda: crossing(0.0)),
        Case("axes side by side, 0.2 radii apart", lambda: side_by_side(0.2)),
        Case("one yarn on another", lambda: side_by_side(0.0)),
        Case("just touching", lambda: crossing(2.0)),
        Case("2 control points in one place", lambda: repeated_point(2)),
        Case("3 control points in one place", lambda: repeated_point(3)),
        Case("4 control points in one place", lambda: repeated_point(4)),
        Case("control points of 2 yarns in one place", point_on_another),
        Case("rest lengths x 0.2", lambda: rest_lengths(0.2)),
        Case("rest lengths x 0.5", lambda: rest_lengths(0.5)),
        Case("rest lengths x 2", lambda: rest_lengths(2.0)),
        Case("rest lengths x 5", lambda: rest_lengths(5.0)),
        Case("rest lengths x 0.2, x 0.8 at a time", lambda: in_steps(0.8, 0.2), large=True),
        Case("rest lengths x 5, x 1.25 at a time", lambda: in_steps(1.25, 5.0), large=True),
    ]
    for power in (-4, -2, 2, 4):
        factor = 10.0**power
        result.append(Case(f"k_bend x 1e{power}", knit, replace(STITCHMESH, k_bend=STITCHMESH.k_bend * factor)))
    for power in (-4, -2, 2, 4):
        factor = 10.0**power
        stiff = replace(STITCHMESH, k_contact=STITCHMESH.k_contact * factor)
        result.append(Case(f"k_contact x 1e{power}", knit, stiff))
    for factor, iterations in ((0.01, 200), (0.1, 400), (2.0, 3000), (10.0, 3000), (100.0, 200)):
        result.append(Case(f"radius x {factor:g}", lambda factor=factor: thick(factor), iterations=iterations))
    for factor in (1e-3, 1e3):
        result.append(Case(f"units x {factor:g}", lambda factor=factor: scaled(factor)))
    return [
        *result,
        Case("1e5 radii from the origin", lambda: moved(1e5)),
        Case("two scenes 1e5 radii apart", lambda: far_apart(1e5)),
        Case("open yarn of 4 points", lambda: YarnSet.from_curves([bent], closed=[False], radius=RADIUS)),
        Case("closed yarn of 3 points", lambda: YarnSet.from_curves([ring(3, 1.0)], closed=[True], radius=RADIUS)),
        Case("linked yarns of 3 points", lambda: linked(3)),
        Case("hairpin around 0.9 radii", lambda: hairpin(0.9)),
        Case("hairpin around 0.3 radii", lambda: hairpin(0.3)),
        Case("hairpin around 0.05 radii", lambda: hairpin(0.05)),
        Case("isolated ring", lambda: YarnSet.from_curves([ring(24, 1.0)], closed=[True], radius=RADIUS)),
        Case("all pinned", knit, constraints=(everything,)),
        Case("half as wide", lambda: squeezed(0)),
        Case("half as high", lambda: squeezed(1)),
        Case("yarn of 100,000 points", lambda: coil(100_000), large=True, iterations=20),
        Case("10,000 yarns", lambda: chains(10_000), large=True, iterations=40),
    ]


class _Heard(logging.Handler):
    """A log handler that stores warnings."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.lines: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.lines.append(record.getMessage())


def outcome(case: Case, quality: Quality, device: str | None) -> Outcome:
    """Relax the yarns of a case, and return how it ends."""
    heard = _Heard()
    logger = logging.getLogger("stitchmesh")
    logger.addHandler(heard)

    def run() -> Outcome:
        yarns = case.make()
        heard.lines.clear()
        result = relax_yarns(
            yarns, material=case.material, quality=quality, device=device, terms=case.constraints
        )
        return Outcome(*_judged(yarns, result.yarns, result.report, heard.lines, device), result.report)

    try:
        return ended(run)
    finally:
        logger.removeHandler(heard)


def _judged(
    before: YarnSet, after: YarnSet, report: dict[str, Any], heard: list[str], device: str | None
) -> tuple[str, str]:
    """Return whether relaxed yarns are valid, and their description."""
    numbers = [report[name] for name in ("residual", "energy", "max_strain", "min_distance_over_radius")]
    if not (np.isfinite(after.points).all() and np.isfinite(numbers).all()):
        return FAILED, "not finite"
    if not report["min_distance_over_radius"] > 0.0:
        return FAILED, "yarns touch"
    changed = changed_pairs(doubled_linking(before, device=device), doubled_linking(after, device=device))
    if any(before.closed[first] and before.closed[second] for first, second in changed):
        return FAILED, "the linking changed"
    if report["converged"]:
        return AT_REST, "; ".join(heard)
    return (NOT_AT_REST, "; ".join(heard)) if heard else (FAILED, "stopped without a word")


def row_of(case: Case, precision: str, found: Outcome) -> tuple[object, ...]:
    """Return a row of the table."""
    report, figures = found.report, ("", "", "", "")
    if report:
        figures = (
            report["iterations"], f"{report['residual']:.2g}", f"{report['max_strain']:.3g}",
            f"{report['min_distance_over_radius']:.3f}",
        )  # fmt: skip
    return case.name, precision, found.kind, *figures, f"{found.seconds:.1f}", found.words


def yarns(
    *,
    device: str | None = None,
    quality: str = "draft",
    tolerance: float = 0.02,
    precision: tuple[Literal["float32", "float64"], ...] = ("float32", "float64"),
    only: str = "",
) -> Rows:
    """Relax extreme yarns.

    Args:
        device: cpu, cuda:0 ...; the first GPU, else the CPU
        only: cases whose name contains this
    """
    logging.getLogger("stitchmesh").propagate = False
    base = replace(quality_named(quality), tolerance=tolerance)

    def found() -> Iterator[tuple[Outcome, tuple[object, ...]]]:
        for case in cases():
            for bits in precision if only in case.name else ():
                limit = min(case.iterations, base.max_iterations)
                end = outcome(case, replace(base, precision=bits, max_iterations=limit), device)
                yield end, row_of(case, bits, end)

    return (yield from table(("extreme", "", "outcome", "iter.", "residual", "strain", "nearest", "s", ""), found()))
