# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The values of a yarn that give a fabric the size and the load-extension curves that were measured.

The unknowns are the logarithms q of some of ``VALUES``. With the tensions T and the sizes s of ``fabric_response``, the
sum of squares

    sum ((T - T_measured) / sigma)^2 + sum (ln(s / s_measured) / sigma_s)^2 + sum ((q - q_start) / ln 100)^2
    sigma = tension_error sqrt(T_measured^2 + (T_largest / 10)^2),        sigma_s = size_error

is minimised by the method of Levenberg and Marquardt, with the derivatives of the states at rest. The last sum is weak:
a value that nothing determines stays at its start. Stiffnesses start with the common factor that fits the tensions
best, because all tensions are proportional to it.

Let J be the derivatives of the first two sums' terms, and c^2 their mean square over the degrees of freedom, at least
1. The covariance of q is (J^T J / c^2 + 1 / ln^2 100)^-1, and the interval of a value holds it with a probability of
95 %. Where the model misses the curves, c^2 carries this into the intervals. A singular vector of J with the singular
value s is a change of the values that the measurements know with the standard error c / s. Above ``LOOSE`` they do not
tell it: such changes are named.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from os import fspath
from typing import Any

import numpy as np

from stitchmesh.errors import ParameterError, SolverError, check_kind
from stitchmesh.io.atomic import write_text
from stitchmesh.io.contents import FilePath
from stitchmesh.io.measured_curves import MeasuredCurve, read_measured_curves
from stitchmesh.io.yarn_files import yarn_of
from stitchmesh.mesh import FloatArray
from stitchmesh.patterns import Pattern
from stitchmesh.periodic.fabric_response import (
    FabricResponse,
    KnittedYarn,
    first_response,
    new_response,
    next_response,
)
from stitchmesh.periodic.fit_settings import STIFFNESSES, VALUES, FitSettings
from stitchmesh.periodic.gauge import counts_of
from stitchmesh.periodic.resolve_pattern import resolve_pattern
from stitchmesh.periodic.stretch import NEWTONS_PER_METRE, refine_for_tension
from stitchmesh.periodic.swatch_options import SwatchOptions
from stitchmesh.periodic.weave.weave import Weave
from stitchmesh.quality import DEFAULT_QUALITY, Quality, quality_named
from stitchmesh.run import SHOWN, Run
from stitchmesh.yarn.yarn_description import COMPACT_LOOP, YarnDescription
from stitchmesh.yarn.yarn_presets import LOOP_OVER_WIDTH, Gauge, Yarn, YarnMechanics, parse_gauge
from stitchmesh.yarnrelax import YarnMaterial

UNITS = {"bending_rigidity": ("cN cm2", 1e3), "axial_stiffness": ("N", 1e5), "transverse_modulus": ("MPa", 1e7),
         "core_diameter": ("mm", 0.1), "loop_length": ("mm", 0.1)}  # fmt: skip
"""The unit in which a value is shown, and its size in CGS units."""
SPREAD = math.log(100.0)
"""Standard error of the logarithm of a value at the start."""
LOOSE = math.log(1.5)
"""The measurements do not tell a change of the values whose standard error is larger."""
SMALL_PART = 0.1
"""A tension below this part of the largest one of its curve is known no better than this part."""
NEAR, SMALL_STEP = 0.02, 1e-3
"""The search ends with a step that changes the fit by less than the first part of its differences from the measurements
(rms), or each value by less than the second part."""
SMALL_CHANGE = 0.1
"""A search that can lower the sum no further has converged if its next step would change the measured quantities by
less than this part of their errors (rms)."""
MOST_STEPS, MOST_NEW = 25, 8
"""Largest number of steps of the search from state to state, and of steps with fabrics that are drawn from new."""
MOST_REFUSED = 4
"""The search ends after this number of steps, one after another, that do not lower the sum of squares: the contacts of
sampled yarns make it rough by some thousandths."""
LARGEST_STEP = math.log(2.0)
"""Largest change of the logarithm of a value in a step."""

CURVES = "sm.read_measured_curves(path)"
"""Call that makes curves, for messages."""


@dataclass(frozen=True)
class FittedValue:
    """A value of a fitted yarn, in CGS units."""

    name: str
    """One of ``VALUES``."""
    value: float
    """The value."""
    low: float
    """Lower end of the interval that holds it with a probability of 95 %; the value itself if it was given."""
    high: float
    """Upper end of this interval."""
    found: bool
    """Whether the fit found the value; if not, it was given."""

    @property
    def text(self) -> str:
        """The value with its interval and unit."""
        unit, size = UNITS[self.name]
        own = f"{self.value / size:.4g} {unit}"
        return f"{own} ({self.low / size:.3g} to {self.high / size:.3g})" if self.found else f"{own}, given"


@dataclass(frozen=True, eq=False)
class FittedCurve:
    """A measured curve beside the curve of the fitted yarn."""

    measured: MeasuredCurve
    """The curve as it was measured."""
    strain: FloatArray
    """The strains that were computed, shape (n,)."""
    expected: FloatArray
    """The measured tension at these strains [dyn/cm], shape (n,)."""
    tension: FloatArray
    """The tension with the fitted yarn [dyn/cm], shape (n,)."""

    @property
    def error(self) -> float:
        """Root mean square of the differences over the root mean square of the measured tensions."""
        return float(np.sqrt(((self.tension - self.expected) ** 2).sum() / (self.expected**2).sum()))


@dataclass(frozen=True, eq=False)
class YarnFit:
    """A yarn whose fabric behaves as measured."""

    values: tuple[FittedValue, ...]
    """The values of the yarn, in the order of ``VALUES``."""
    correlation: FloatArray
    """Correlation of the logarithms of the values that were found, in their order, shape (n, n)."""
    curves: tuple[FittedCurve, ...]
    """The measured curves beside the fitted ones."""
    measured_gauge: str | None
    """The gauge that was measured, as it was given."""
    gauge: Gauge
    """Gauge of the free fabric of the fitted yarn, without friction."""
    cannot_tell: tuple[str, ...]
    """A clause for each change of the values that the measurements do not tell."""
    yarn: YarnDescription
    """The fitted yarn, for ``write_yarn`` and ``--yarn``; its gauge is the one of its loop length."""
    steps: int
    """Number of times that the fabric was relaxed with another yarn."""
    converged: bool
    """Whether the search ended because its steps became small."""

    def __repr__(self) -> str:
        """Return one line: the values, and the error."""
        shown = ", ".join(f"{each.name} {each.text}" for each in self.values if each.found)
        return f"YarnFit({shown}; rms {100.0 * self.error:.3g} %)"

    def __getitem__(self, name: str) -> FittedValue:
        """Return a value by its name."""
        return self.values[VALUES.index(name)]

    @property
    def error(self) -> float:
        """Root mean square of the errors of the curves; 0 without a curve."""
        return math.sqrt(sum(each.error**2 for each in self.curves) / max(len(self.curves), 1))

    @property
    def material(self) -> YarnMaterial:
        """Material of the fitted yarn, for its core radius."""
        return YarnMaterial.of_yarn(self.yarn.yarn())

    def table(self) -> list[dict[str, Any]]:
        """Return a row for each value: its name, unit, value, the ends of its interval, and whether it was found."""
        rows = []
        for each in self.values:
            unit, size = UNITS[each.name]
            ends = {"value": each.value / size, "low": each.low / size, "high": each.high / size}
            rows.append({"name": each.name, "unit": unit, **ends, "found": each.found})
        return rows


@dataclass(frozen=True, eq=False)
class _Problem:
    """What was measured, and what is unknown."""

    settings: FitSettings
    curves: tuple[MeasuredCurve, ...]
    """The curves at the strains that are computed."""
    spacings: tuple[float, ...]
    """Measured distances of the wales and of the courses [cm], as far as they were measured."""
    counts: tuple[int, int]
    """Wales and courses of the repeat."""
    base: Yarn
    """The yarn whose other properties stay."""
    unknowns: tuple[str, ...]
    start: Mapping[str, float]
    """The values at the start."""

    @property
    def columns(self) -> list[int]:
        """Places of the unknowns in ``VALUES``."""
        return [VALUES.index(name) for name in self.unknowns]

    @property
    def expected(self) -> FloatArray:
        """Measured tensions of all curves [dyn/cm], shape (n,)."""
        return np.concatenate([curve.tension for curve in self.curves]) if self.curves else np.zeros(0)

    @property
    def tension_errors(self) -> FloatArray:
        """Standard errors of the tensions [dyn/cm], shape (n,)."""
        own = [np.hypot(each.tension, SMALL_PART * np.abs(each.tension).max()) for each in self.curves]
        return self.settings.tension_error * np.concatenate(own) if own else np.zeros(0)

    def differences(self, response: FabricResponse) -> tuple[FloatArray, FloatArray]:
        """Return the differences from what was measured over its errors, and their derivatives by the unknowns."""
        errors = self.tension_errors
        rows = [(response.tension - self.expected) / errors]
        slopes = [response.tension_slopes[:, self.columns] / errors[:, None]]
        if self.spacings:
            count = len(self.spacings)
            wanted = np.array(self.spacings) * self.counts[:count]
            rows.append(np.log(response.size[:count] / wanted) / self.settings.size_error)
            slopes.append(response.size_slopes[:count, self.columns] / self.settings.size_error)
        return np.concatenate(rows), np.concatenate(slopes)

    def from_start(self, values: Mapping[str, float]) -> FloatArray:
        """Return the logarithms of the unknowns over their start, over ``SPREAD``, shape (U,)."""
        return np.array([math.log(values[name] / self.start[name]) for name in self.unknowns]) / SPREAD

    def cost(self, response: FabricResponse, values: Mapping[str, float]) -> float:
        """Return the sum of squares."""
        return float((self.differences(response)[0] ** 2).sum() + (self.from_start(values) ** 2).sum())

    def knitted(self, values: Mapping[str, float]) -> KnittedYarn:
        """Return the yarn with these values."""
        radius = values["core_diameter"] / 2.0
        mechanics = YarnMechanics(
            axial_stiffness=values["axial_stiffness"], flexural_rigidity=values["bending_rigidity"],
            transverse_modulus=values["transverse_modulus"],
        )  # fmt: skip
        yarn = replace(self.base, core_radius=radius, apparent_radius=radius, mechanics=mechanics)
        return KnittedYarn(
            material=YarnMaterial.of_yarn(yarn), core_radius=radius, loop_length=values["loop_length"]
        )  # fmt: skip


def fit_yarn(
    curves: FilePath | MeasuredCurve | Sequence[MeasuredCurve],
    pattern: str | Pattern,
    *,
    yarn: str | Yarn | YarnDescription | None = None,
    quality: str | Quality = DEFAULT_QUALITY,
    device: str | None = None,
    run: Run[Any] = SHOWN,
    **settings: Any,
) -> YarnFit:
    """Find the values of a yarn from measured load-extension curves and the gauge of a knitted swatch.

    The fabric is without friction: give the loading branch of curves that were drawn before, or expect the friction in
    the stiffnesses.

    Args:
        curves: what was measured, or the path of its table (``read_measured_curves``); none if only a gauge was
            measured.
        pattern: a knitting pattern, the name of one in the library, or the path of a file.
        yarn: the yarn at the start, whose other properties stay: a name, the path of a description, or a value; by
            default the default material for loops of 16.67 diameters.
        quality: a preset or a ``Quality``; it is refined to the needs of tensions.
        device: device of the kernels, for example ``cpu`` or ``cuda:0``; by default the first GPU, or the CPU if there
            is no GPU.
        run: progress; the fit obeys nothing else of it.
        settings: fields of ``FitSettings``: the values to find, what else was measured, and the errors.

    Raises:
        ParameterError: nothing was measured, nothing is to be found, the pattern is a weave, or a setting is wrong.
        FileError, PatternError: a file cannot be read, or the pattern cannot be knitted.
        SolverError: the fabric does not come to rest with the yarn at the start.
    """
    run.refuse_all_but("fit_yarn")
    chosen, measured = FitSettings(**settings), _measured(curves)
    source = resolve_pattern(pattern)
    if isinstance(source, Weave):
        raise ParameterError("fit: got a weave; expected a knitting pattern, such as stockinette")
    if not measured and chosen.gauge is None:
        raise ParameterError("fit: got no measurement; expected a load-extension curve, or a gauge")
    base = _base(yarn, chosen)
    start = _values_of(base, chosen)
    thin = tuple(each.thinned(chosen.strains) for each in measured)
    first = first_response(source, KnittedYarn(
        material=YarnMaterial.of_yarn(base), core_radius=base.core_radius, loop_length=start["loop_length"]
    ), thin, refine_for_tension(quality_named(quality)), device)  # fmt: skip
    wales, courses, _stitches = counts_of(first.prepared.repeat, first.prepared.fabric)
    problem = _Problem(
        chosen, thin, _measured_spacings(chosen.gauge), (wales, courses), base, chosen.unknowns(pulled=bool(thin)),
        start,
    )  # fmt: skip
    if not problem.unknowns:
        raise ParameterError("fit: got nothing to find; expected some of fit, or a curve or a gauge")
    problem, response = _with_common_stiffness(problem, first)
    with run.assessments_shown("fit", SMALL_STEP, MOST_STEPS) as show:
        search = _search(problem, response, show)
    return _result(problem, measured, search, source.name)


def _measured(curves: FilePath | MeasuredCurve | Sequence[MeasuredCurve]) -> tuple[MeasuredCurve, ...]:
    """Return the curves of a table, or the given ones."""
    if isinstance(curves, MeasuredCurve):
        return (curves,)
    if isinstance(curves, Sequence) and not isinstance(curves, str):
        return tuple(check_kind("fit_yarn, curves", each, MeasuredCurve, CURVES) for each in curves)
    return read_measured_curves(fspath(curves))


def _measured_spacings(gauge: str | None) -> tuple[float, ...]:
    """Return the distance of the wales and, if rows were counted, the one of the courses [cm]."""
    if gauge is None:
        return ()
    found = parse_gauge(gauge)
    return (found.stitch_width, found.stitch_height) if "x" in gauge.lower() else (found.stitch_width,)


def _base(yarn: str | Yarn | YarnDescription | None, settings: FitSettings) -> Yarn:
    """Return the yarn at the start, at the loop length of the settings."""
    if yarn is not None:
        if isinstance(yarn, YarnDescription):
            return yarn.yarn()
        return yarn if isinstance(yarn, Yarn) else yarn_of(fspath(yarn))
    loop = settings.loop_length or SwatchOptions().plain_loop
    if settings.loop_length is None and settings.gauge is not None:
        loop = parse_gauge(settings.gauge).loop_length
    radius = loop / COMPACT_LOOP / 2.0
    mass = YarnMaterial.named().of_radius(radius).mass_per_length
    return Yarn("", radius, radius, 100.0 * mass, _gauge_of_loop(loop))


def _gauge_of_loop(loop_length: float) -> Gauge:
    """Return the gauge of stockinette with loops of a length [cm]."""
    return Gauge(10.0 * LOOP_OVER_WIDTH / loop_length)


def _values_of(yarn: Yarn, settings: FitSettings) -> dict[str, float]:
    """Return the values of a yarn, in CGS units."""
    material = YarnMaterial.of_yarn(yarn)
    return {
        "bending_rigidity": material.flexural_rigidity,
        "axial_stiffness": material.axial_stiffness,
        "transverse_modulus": material.transverse_modulus(yarn.core_radius),
        "core_diameter": 2.0 * yarn.core_radius,
        "loop_length": settings.loop_length or yarn.loop_length,
    }


def _with_common_stiffness(problem: _Problem, first: FabricResponse) -> tuple[_Problem, FabricResponse]:
    """Multiply the unknown stiffnesses at the start by the factor that fits the tensions best."""
    unknown = [name for name in STIFFNESSES if name in problem.unknowns]
    if not (problem.curves and "bending_rigidity" in unknown):
        return problem, first
    weight = 1.0 / problem.tension_errors**2
    factor = float((weight * first.tension * problem.expected).sum() / (weight * first.tension**2).sum())
    if not factor > 0.0 or abs(math.log(factor)) < SMALL_STEP:
        return problem, first
    start = {name: value * (factor if name in unknown else 1.0) for name, value in problem.start.items()}
    return replace(problem, start=start), next_response(first, problem.knitted(start), problem.curves)


@dataclass(frozen=True, eq=False)
class _Search:
    """The end of a search."""

    values: Mapping[str, float]
    response: FabricResponse
    steps: int
    """Number of steps, those that were refused too."""
    converged: bool
    """Whether the steps became small."""


Respond = Callable[[FabricResponse, KnittedYarn, Sequence[MeasuredCurve]], FabricResponse]
"""Returns the response of a fabric with a changed yarn."""


def _search(problem: _Problem, response: FabricResponse, show: Callable[..., None] | None) -> _Search:
    """Minimise the sum of squares, at first from state to state, and then with fabrics that are drawn from new.

    The cells of the first part start from the cells of other yarns. A fabric that snaps may then be on another branch
    than a new one, and the contacts of any fabric may lie a little differently.
    """
    quick = _minimised(problem, _Search(problem.start, response, 0, converged=False), next_response, MOST_STEPS, show)
    try:
        again = new_response(quick.response, quick.response.yarn, problem.curves)
    except SolverError:
        return replace(quick, converged=False)
    return _minimised(problem, replace(quick, response=again), new_response, MOST_NEW, show)


def _minimised(
    problem: _Problem, begin: _Search, respond: Respond, most: int, show: Callable[..., None] | None
) -> _Search:
    """Minimise the sum of squares from a state, in at most ``most`` steps.

    A step that does not lower the sum, or with which the fabric does not come to rest, is made again with more damping.
    """
    values, response, damping, refused = begin.values, begin.response, 1e-3, 0
    cost, done = problem.cost(response, values), begin.steps
    for number in range(done, done + most):
        rows, slopes = problem.differences(response)
        step = _damped_step(rows, slopes, problem.from_start(values), damping)
        change = float(np.sqrt(((slopes @ step) ** 2).mean()))
        if show is not None:
            show(number + 1, float(np.abs(step).max()))
        if change < NEAR * math.sqrt((rows**2).mean()) or np.abs(step).max() < SMALL_STEP:
            return _Search(values, response, number, True)
        if refused == MOST_REFUSED:
            return _Search(values, response, number, change < SMALL_CHANGE)
        trial = dict(values) | {
            name: values[name] * math.exp(own) for name, own in zip(problem.unknowns, step.tolist(), strict=True)
        }
        try:
            found = respond(response, problem.knitted(trial), problem.curves)
            new = problem.cost(found, trial)
        except SolverError:
            new = math.inf
        if new < cost:
            values, response, cost = trial, found, new
            damping, refused = max(damping / 10.0, 1e-9), 0
        else:
            damping, refused = max(10.0 * damping, 1e-3), refused + 1
    return _Search(values, response, done + most, change < SMALL_CHANGE)


def _damped_step(rows: FloatArray, slopes: FloatArray, from_start: FloatArray, damping: float) -> FloatArray:
    """Return the step of Levenberg and Marquardt, shape (U,)."""
    normal = slopes.T @ slopes + np.eye(len(from_start)) / SPREAD**2
    slope = slopes.T @ rows + from_start / SPREAD
    level = damping * float(np.trace(normal)) / len(from_start)
    step = np.linalg.solve(normal + level * np.eye(len(from_start)), -slope).astype(np.float64)
    return step * min(1.0, LARGEST_STEP / max(float(np.abs(step).max()), 1e-30))


def _result(
    problem: _Problem, measured: Sequence[MeasuredCurve], search: _Search, pattern: str
) -> YarnFit:  # fmt: skip
    values, response = search.values, search.response
    rows, slopes = problem.differences(response)
    freedom = len(rows) - len(problem.unknowns)
    scale = max(1.0, float((rows**2).sum()) / freedom) if freedom > 0 else 1.0
    covariance = np.linalg.inv(slopes.T @ slopes / scale + np.eye(len(problem.unknowns)) / SPREAD**2)
    errors = np.sqrt(covariance.diagonal())
    reach = dict(zip(problem.unknowns, (_quantile(freedom) * errors).tolist(), strict=True))
    found = tuple(
        FittedValue(name, values[name], values[name] * math.exp(-reach.get(name, 0.0)),
                    values[name] * math.exp(reach.get(name, 0.0)), name in reach)
        for name in VALUES
    )  # fmt: skip
    curves, place = list[FittedCurve](), 0
    for whole, thin in zip(measured, problem.curves, strict=True):
        own = response.tension[place : place + len(thin.strain)]
        curves.append(FittedCurve(whole, thin.strain, thin.tension, own))
        place += len(thin.strain)
    width, height = (response.size / problem.counts).tolist()
    return YarnFit(
        values=found, correlation=covariance / np.outer(errors, errors), curves=tuple(curves),
        measured_gauge=problem.settings.gauge, gauge=Gauge.of_stitch(width, height),
        cannot_tell=_loose_changes(problem.unknowns, slopes, math.sqrt(scale)),
        yarn=_description(values, problem.base, pattern), steps=search.steps, converged=search.converged,
    )  # fmt: skip


def _quantile(freedom: int) -> float:
    """Return the standard errors on either side of an interval of 95 %."""
    from scipy.stats import norm, t

    return float(t.ppf(0.975, freedom) if freedom > 0 else norm.ppf(0.975))


def _loose_changes(unknowns: Sequence[str], slopes: FloatArray, error: float) -> tuple[str, ...]:
    """Return a clause for each change of the unknowns whose standard error is above ``LOOSE``.

    Args:
        unknowns: their names.
        slopes: derivatives of what was measured over its errors, shape (m, U).
        error: factor of these errors.
    """
    spare = np.zeros((max(len(unknowns) - len(slopes), 0), len(unknowns)))
    _left, singular, vectors = np.linalg.svd(np.concatenate([slopes, spare]), full_matrices=False)
    found = []
    for value, vector in zip(singular.tolist(), vectors, strict=True):
        if value * LOOSE >= error:
            continue
        reach = error / max(value, 1e-12)
        # The change by one standard error, up to a factor of 10 of the value that changes most
        own = vector * min(reach, math.log(10.0)) / np.abs(vector).max()
        own *= np.sign(own[np.abs(own).argmax()])
        moved = [(name, math.exp(each)) for name, each in zip(unknowns, own.tolist(), strict=True)
                 if abs(each) > 0.15 * np.abs(own).max()]  # fmt: skip
        factors = " and ".join(f"{name} by {factor:.2g}" for name, factor in moved)
        together = "together " if len(moved) > 1 else ""
        found.append(f"what was measured stays within its errors if one multiplies {together}{factors}")
    return tuple(found)


def _description(values: Mapping[str, float], base: Yarn, pattern: str) -> YarnDescription:
    """Return the description of a yarn with these values, and what else is known of the yarn at the start."""
    texts = {}
    for name, (unit, size) in UNITS.items():
        texts[name] = f"{values[name] / size:.6g} {unit}"
    thick = base.apparent_radius / base.core_radius * values["core_diameter"]
    return YarnDescription(
        name=base.name and f"{base.name}-fitted",
        linear_density=f"{1e5 * base.mass_per_length:.6g} tex",
        diameter=f"{10.0 * thick:.6g} mm",
        core_diameter=texts["core_diameter"],
        bending_rigidity=texts["bending_rigidity"],
        axial_stiffness=texts["axial_stiffness"],
        transverse_modulus=texts["transverse_modulus"],
        friction=None if base.mechanics is None else base.mechanics.friction,
        gauge=f"{_gauge_of_loop(values['loop_length']).stitches:.6g}",
        source=f"fitted to measurements of {pattern}",
    )


def write_fit(path: FilePath, fit: YarnFit) -> None:
    """Write the measured and the fitted tensions of a fit as a table.

    Args:
        path: a ``.csv`` file; missing folders are made.
        fit: the fit.

    Raises:
        FileError: the file cannot be written.
    """
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(["direction", "other", "strain [%]", "load [N/m]", "fitted load [N/m]"])
    for curve in fit.curves:
        rows = zip(curve.strain.tolist(), curve.expected.tolist(), curve.tension.tolist(), strict=True)
        for strain, expected, tension in rows:
            loads = [NEWTONS_PER_METRE * each for each in (expected, tension)]
            table.writerow([curve.measured.direction, curve.measured.other, 100.0 * strain, *loads])
    write_text(path, text.getvalue())
