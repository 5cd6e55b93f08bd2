# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A swatch of a given size: the loop length, the numbers of repeats and the needle with which it comes true.

Let w and h be the wale and the course spacing at rest, r the radius of the yarn and l the loop length. Size depends on
ratios only if the stiffness of the yarn follows its radius (Leaf et al. 2018, section 6.2), so that the looseness u
decides the shape of a stitch:

    ln w = ln r + F(u)        ln h = ln r + G(u)        u = ln(l / 2 r)

Two cases follow. The yarn is **given**: its radius stays, u is found from the width, F(u) = ln(w / r), and the height
follows; only where no width is asked for, u is found from the height. The yarn is **free**: r is found with one of
the sizes, and if both are asked for, u is found from their ratio, F(u) - G(u) = ln(w / h).

Newton's method finds u, and a swatch is relaxed at each step. F' and G' are the derivatives by the loop length of
``sensitivity`` for a swatch without friction. Friction lets the size depend on the path, and has no such derivative:
the first step then takes Munden's law, in which both sizes are proportional to the loop length, and the next steps take
the secant. Without friction each swatch relaxes from the one before it, and stays in its state of rest if there are
several. Where two swatches lie on both sides of the size, the next one lies between them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

from stitchmesh.errors import ParameterError, check_positive
from stitchmesh.io.yarn_files import yarn_of
from stitchmesh.lattice import Lattice
from stitchmesh.patterns import Pattern
from stitchmesh.periodic.relaxation.prepared_swatch import PreparedSwatch, prepare_swatch
from stitchmesh.periodic.resolve_pattern import resolve_pattern
from stitchmesh.periodic.sensitivity import sensitivity
from stitchmesh.periodic.swatch import Swatch, relax_prepared
from stitchmesh.periodic.swatch_options import COMPACT_LOOP, YARN_RADIUS
from stitchmesh.periodic.weave.weave import Weave
from stitchmesh.progress import Progress, shown_stages
from stitchmesh.quality import DEFAULT_QUALITY
from stitchmesh.run import Run
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.stitch_size import stitch_size
from stitchmesh.yarn.yarn_presets import GAUGE_LENGTH, Gauge, Yarn, needle_for, parse_gauge

CLOSE = 0.005
"""Relative error of a size at which the search ends: half of the promised error."""
TRUE = 0.01
"""Relative error up to which a size counts as reached."""
MOST_RELAXATIONS = 4
LOOSENESS = (11.0, 45.0)
"""Shortest and longest loop [yarn diameters]. Commercial plain knits have 13.9 to 22.5 (Munden's tightness factors),
and the loosest measured ones 33 (du Pasquier et al. 2025)."""
LARGEST_STEP, LEAST_SLOPE = 0.3, 0.5
"""Largest change of u in one step, and the least derivative of a size by u with which a step is taken. Fabrics that are
jammed at one loop length have smaller ones, which hold only nearby."""
RATIO_BY_LOOP = 0.5
"""Derivative of ln(w / h) by u with friction until there is a secant. It is 1.0 for stockinette without friction, and 0
by Munden's law."""
LARGEST_MISS = 0.05
"""Relative error of the ratio of both sizes from which the last swatch has one of them, instead of a further step."""
NEAR_LOOP = 0.08
"""Largest relative change of the loop length, or of a free radius, for the sake of whole repeats in the height."""
LARGEST_CELL = 600
"""Number of control points of a cell up to which derivatives are computed. The way of a larger one to its exact state
of rest takes as long as another swatch."""


@dataclass(frozen=True, eq=False)
class SizedSwatch:
    """A relaxed repeat that has the size that was asked for, and what a knitter needs for it."""

    swatch: Swatch
    """The repeat at rest."""
    asked: Mapping[str, float]
    """What was asked for: ``stitches`` and ``rows`` in 10 cm, ``width`` and ``height`` of the piece [cm]."""
    repeats: tuple[int, int]
    """Number of repeats of the piece, side by side and above one another; 1 along which no size was asked for."""
    loop_length: float
    """Yarn length of a plain stitch [cm]; that of the mean stitch is in the report of the swatch."""
    yarn_radius: float
    """Contact radius of the yarn [cm]."""
    needle: float
    """Diameter of the needle that gives about this loop length [mm]."""
    relaxations: int
    """Number of swatches that were relaxed on the way."""
    notes: tuple[str, ...] = ()
    """What is not possible, each in one line."""

    @property
    def stitches(self) -> int:
        """Number of stitches of a row of the piece."""
        return int(self.repeats[0] * self.swatch.report["wales"])

    @property
    def rows(self) -> int:
        """Number of rows of the piece."""
        return int(self.repeats[1] * self.swatch.report["courses"])

    @property
    def gauge(self) -> Gauge:
        """The gauge at rest."""
        return Gauge.of_stitch(self.swatch.report["wale_spacing"], self.swatch.report["course_spacing"])

    @property
    def size(self) -> tuple[float, float]:
        """Width and height of the piece at rest [cm]."""
        return tuple(n * self.swatch.report[name] for n, name in zip(self.repeats, ("width", "height"), strict=True))

    @property
    def errors(self) -> dict[str, float]:
        """Relative error of each size that was asked for."""
        (width, height), gauge = self.size, self.gauge
        found = {"stitches": gauge.stitches, "rows": gauge.rows, "width": width, "height": height}
        return {name: found[name] / asked - 1.0 for name, asked in self.asked.items()}

    def report(self) -> dict[str, Any]:
        """Return all figures as plain numbers and words."""
        return {
            "asked": dict(self.asked), "errors": self.errors, "repeats": list(self.repeats), "stitches": self.stitches,
            "rows": self.rows, "size": list(self.size), "loop_length": self.loop_length, "needle": self.needle,
            "yarn_radius": self.yarn_radius, "relaxations": self.relaxations, "notes": list(self.notes),
        }  # fmt: skip

    def __repr__(self) -> str:
        """Return one line: what was asked for, the errors, and the loop length."""
        errors = ", ".join(f"{name} {self.asked[name]:g} {100 * error:+.2g} %" for name, error in self.errors.items())
        return f"SizedSwatch({errors}, loop length {self.loop_length:.4g} cm, {self.swatch})"


def swatch_to(
    pattern: str | Pattern | Weave,
    *,
    gauge: str | float | Gauge | None = None,
    width: float | None = None,
    height: float | None = None,
    yarn: str | Yarn | None = None,
    progress: Progress | Literal[False] | None = None,
    **options: Any,
) -> SizedSwatch:
    """Relax a swatch that has a gauge or a size, by finding its loop length (module docstring).

    With a yarn, or a ``yarn_radius`` among the options, stitches come true and rows follow; a piece has the whole
    repeats whose height is nearest. Without a yarn its radius is found too, and both come true.

    Args:
        pattern: a knitting pattern, the name of one in the library, or the path of a file.
        gauge: stitches, or stitches and rows, in 10 cm of this pattern at rest: ``22``, ``22x30`` or a ``Gauge``. With
            a width or a height it chooses the numbers of repeats, and the size of the piece comes true.
        width: width of the piece [cm], of whole repeats.
        height: height of the piece [cm], of whole repeats.
        yarn: a yarn, the name of one, or the path of its file.
        progress: as for ``swatch``.
        options: ``quality``, ``device``, ``material`` and other options of ``swatch``. The size relaxes; the state is
            ``dry`` unless ``relaxation`` is given.

    Raises:
        ParameterError: nothing is asked for, a size is not positive, the pattern is a weave, an option is given that
            the search finds itself, or no loop length gives the size.
        SolverError, FileError, PatternError: as for ``swatch``.
    """
    source = resolve_pattern(pattern)
    if isinstance(source, Weave):
        raise ParameterError(f"swatch to: got the weave {source.name!r}; expected a knit; give a weave its --period")
    taken = sorted({"loop_length", "period", "relax_cell", "columns", "rows", "gamma"} & set(options))
    if taken:
        raise ParameterError(f"swatch to: got {taken[0]}, which follows from the size; leave it out")
    asked = _asked(gauge, width, height)
    known = yarn_of(yarn) if isinstance(yarn, str) else yarn
    sizes = stitch_size(known, yarn_radius=options.pop("yarn_radius", None))
    given = sizes.yarn_radius is not None
    if not given and options.get("material") is not None:
        raise ParameterError("swatch to: got a material without a yarn; give the yarn_radius that it belongs to")
    radius = sizes.yarn_radius or YARN_RADIUS
    loop = sizes.loop_length or 2 * COMPACT_LOOP * radius
    with shown_stages(progress) as shown:
        usual = {"material": None, "quality": DEFAULT_QUALITY, "device": None, "yarn": known}
        search = _Search(source, asked, given, usual | options, shown)
        return search.run(math.log(loop / (2.0 * radius)), radius)


def _asked(gauge: str | float | Gauge | None, width: float | None, height: float | None) -> dict[str, float]:
    """Return the sizes that are asked for, by name.

    Raises:
        ParameterError: there is none, or one is not a positive number.
    """
    asked: dict[str, float] = {}
    if isinstance(gauge, Gauge):
        asked = {"stitches": gauge.stitches, "rows": gauge.rows}
    elif gauge is not None:
        text = str(gauge)
        found = parse_gauge(text)
        asked = {"stitches": found.stitches} | ({"rows": found.rows} if "x" in text.lower() else {})
    for name, size in {"width": width, "height": height}.items():
        if size is not None:
            check_positive(f"swatch to: {name}", size, "cm")
            asked[name] = float(size)
    if not asked:
        raise ParameterError("swatch to: got no size; expected a gauge, a width or a height")
    return asked


@dataclass(frozen=True, eq=False)
class _Trial:
    """A swatch of the search."""

    made: Swatch
    looseness: float
    """The logarithm of the loop length over the yarn diameter, u."""
    radius: float
    """Radius of the yarn [cm]."""
    slopes: tuple[float, float] | None
    """Derivatives of ln w and ln h by u at constant radius; None with friction."""

    @property
    def spacing(self) -> tuple[float, float]:
        """Wale and course spacing [cm]."""
        return self.made.report["wale_spacing"], self.made.report["course_spacing"]


class _Search:
    """The search for the looseness and the radius."""

    def __init__(
        self, source: Pattern, asked: Mapping[str, float], given: bool, options: Mapping[str, Any], shown: Progress
    ) -> None:
        self._source, self._asked, self._given, self._options = source, asked, given, options
        self._shown = shown
        self._trials: list[_Trial] = []
        self._repeats = (1, 1)
        self._wanted: tuple[float | None, float | None] = (None, None)

    def run(self, looseness: float, radius: float) -> SizedSwatch:
        """Relax until the size is true, or the relaxations are used up, and return the best swatch.

        Raises:
            ParameterError: no loop length gives the size.
        """
        least, most = (math.log(each) for each in LOOSENESS)
        looseness = min(max(looseness, least), most)
        while True:
            self._relax(looseness, radius)
            if len(self._trials) == 1:
                self._choose_repeats()
            last = self._trials[-1]
            if max(self._errors(last)) <= CLOSE or len(self._trials) == MOST_RELAXATIONS:
                break
            looseness = min(max(self._next(last), least), most)
            if not self._given:
                near = min(self._trials, key=lambda each: abs(self._residual(each)))
                lost = abs(self._residual(near)) > LARGEST_MISS
                if lost and (looseness == last.looseness or len(self._trials) == MOST_RELAXATIONS - 1):
                    last, looseness = near, near.looseness  # The ratio is out of reach, and one size comes true.
                radius = self._radius_at(last, looseness)
            elif looseness == last.looseness:
                break  # The size lies beyond the bound.
        return self._result(min(self._trials, key=self._merit))

    def _merit(self, trial: _Trial) -> tuple[bool, float]:
        """Return what ranks a swatch: first whether its width is true, then the largest error."""
        errors = self._errors(trial)
        return errors[0] > TRUE, max(errors)

    def _relax(self, looseness: float, radius: float) -> None:
        number = len(self._trials) + 1

        def show(stage: str, done: float, note: str) -> None:
            which = f"swatch {number} of at most {MOST_RELAXATIONS}"
            self._shown(stage, (number - 1 + done) / MOST_RELAXATIONS, f"{which}, {note}")

        prepared = prepare_swatch(
            self._source, loop_length=2.0 * radius * math.exp(looseness), yarn_radius=radius, relax_cell=True,
            **self._options,
        )  # fmt: skip
        made = relax_prepared(prepared, self._start(prepared, radius), Run(show))
        slopes = None
        rest = made.at_rest
        if rest is not None and not rest.rubs and len(rest.yarns.points) <= LARGEST_CELL:
            found = sensitivity(made)
            slopes = (found.width["loop_length"], found.height["loop_length"])
        self._trials.append(_Trial(made, looseness, radius, slopes))

    def _start(self, prepared: PreparedSwatch, radius: float) -> YarnSet:
        """Return the yarns from which a swatch relaxes: without friction those of the swatch before it.

        Fabrics with several states of rest then stay in one of them, in which the size changes steadily.
        """
        last = self._trials[-1] if self._trials else None
        rest = None if last is None else last.made.at_rest
        if last is None or rest is None or rest.rubs or len(rest.yarns.points) != len(prepared.yarns.points):
            return prepared.yarns
        factor = radius / last.radius
        assert rest.yarns.lattice is not None
        return replace(
            prepared.yarns, points=factor * rest.yarns.points, lattice=Lattice(factor * rest.yarns.lattice.periods)
        )

    def _choose_repeats(self) -> None:
        """Choose whole repeats of the piece, and from them the spacings that come true."""
        first, asked = self._trials[0], self._asked
        report = first.made.report
        counts = (report["wales"], report["courses"])
        own = list(first.spacing)
        for axis, name in enumerate(("stitches", "rows")):
            if name in asked:
                own[axis] = GAUGE_LENGTH / asked[name]
        sizes = (asked.get("width"), asked.get("height"))
        repeats = [
            1 if size is None else max(1, round(size / (spacing * count)))
            for size, spacing, count in zip(sizes, own, counts, strict=True)
        ]
        if None not in sizes and "stitches" not in asked:
            repeats[0] = self._repeats_for_height(first, repeats[0])
        wanted = [
            spacing if name in asked else None for spacing, name in zip(own, ("stitches", "rows"), strict=True)
        ]
        for axis, size in enumerate(sizes):
            if size is not None:
                wanted[axis] = size / (repeats[axis] * counts[axis])
        self._repeats, self._wanted = (repeats[0], repeats[1]), (wanted[0], wanted[1])

    def _repeats_for_height(self, first: _Trial, nearest: int) -> int:
        """Return the number of repeats side by side for which whole repeats have the height that is asked for, too.

        With a yarn the height follows from the width as the loop length changes. Without one both follow the radius,
        and a repeat that fits needs no other looseness. Among the numbers for which the loop length or the radius
        changes by at most ``NEAR_LOOP``, the one with the nearest height is taken.
        """
        by_width, by_height = self._slopes(first) if self._given else (1.0, 1.0)
        report, width, height = first.made.report, self._asked["width"], self._asked["height"]
        usual = width / report["width"]

        def change(number: int) -> float:
            return math.log(usual / number) / by_width

        def error(number: int) -> float:
            own = report["height"] * math.exp(by_height * change(number))
            return abs(math.log(max(1, round(height / own)) * own / height))

        reach = math.exp(NEAR_LOOP * abs(by_width))
        near = list(range(max(1, math.ceil(usual / reach)), math.floor(usual * reach) + 1)) or [nearest]
        return min(near, key=lambda number: (round(error(number), 3), abs(change(number))))

    def _residual(self, trial: _Trial) -> float:
        """Return the error that the looseness has to remove, as a logarithm."""
        own_width, own_height = trial.spacing
        width, height = self._wanted
        if width is not None and height is not None and not self._given:
            return math.log(own_width / width * height / own_height)
        if not self._given:
            return 0.0
        if width is not None:
            return math.log(own_width / width)
        assert height is not None
        return math.log(own_height / height)

    def _errors(self, trial: _Trial) -> list[float]:
        """Return the relative errors of the sizes that can be met, the width first."""
        met = (self._wanted[0], None) if self._given and self._wanted[0] is not None else self._wanted
        return [abs(math.log(own / size)) for own, size in zip(trial.spacing, met, strict=True) if size is not None]

    def _slopes(self, trial: _Trial) -> tuple[float, float]:
        """Return the derivatives of ln w and ln h by u at constant radius, or those of the secant with friction."""
        others = [each for each in self._trials if abs(each.looseness - trial.looseness) > 1e-3]
        if trial.slopes is not None or not others:
            return trial.slopes or (1.0 + RATIO_BY_LOOP / 2.0, 1.0 - RATIO_BY_LOOP / 2.0)
        near = min(others, key=lambda each: abs(each.looseness - trial.looseness))
        apart = trial.looseness - near.looseness
        width, height = (
            math.log(own / other * near.radius / trial.radius) / apart
            for own, other in zip(trial.spacing, near.spacing, strict=True)
        )
        return width, height

    def _next(self, last: _Trial) -> float:
        """Return the looseness at which the size is expected."""
        residual = self._residual(last)
        if residual == 0.0:
            return last.looseness
        beyond = [each for each in self._trials if self._residual(each) * residual <= 0.0]
        if not beyond:
            return last.looseness + min(max(self._step(last), -LARGEST_STEP), LARGEST_STEP)
        other = min(beyond, key=lambda each: abs(each.looseness - last.looseness))
        near = min((last, other), key=lambda each: abs(self._residual(each)))
        found = near.looseness + self._step(near)
        least, most = sorted((last.looseness, other.looseness))
        return found if least < found < most else (least + most) / 2.0

    def _step(self, trial: _Trial) -> float:
        """Return the change of the looseness at whose end the derivative expects the size."""
        return -self._residual(trial) / max(self._slope(*self._slopes(trial)), LEAST_SLOPE)

    def _slope(self, by_width: float, by_height: float) -> float:
        """Return the derivative of the residual by the looseness."""
        if None in self._wanted or self._given:
            return by_height if self._wanted[0] is None else by_width
        return by_width - by_height

    def _radius_at(self, last: _Trial, looseness: float) -> float:
        """Return the radius with which a swatch of this looseness is expected to have the size."""
        axis = 0 if self._wanted[0] is not None else 1
        wanted = self._wanted[axis]
        assert wanted is not None
        by_radius = math.log(last.spacing[axis] / last.radius) + self._slopes(last)[axis] * (looseness - last.looseness)
        return wanted / math.exp(by_radius)

    def _result(self, best: _Trial) -> SizedSwatch:
        """Return the swatch with what is not possible.

        Raises:
            ParameterError: the yarn is given, and even the shortest or the longest loop misses the size.
        """
        report, repeats = best.made.report, list(self._repeats)
        if self._given and "height" in self._asked:
            repeats[1] = max(1, round(self._asked["height"] / report["height"]))
        made = SizedSwatch(
            best.made, dict(self._asked), (repeats[0], repeats[1]), 2.0 * best.radius * math.exp(best.looseness),
            best.radius, needle_for(2.0 * best.radius * math.exp(best.looseness)), len(self._trials),
        )  # fmt: skip
        if self._given and max(self._errors(best)) > TRUE and self._at_bound:
            raise ParameterError(self._impossible(best))
        notes = [
            f"{name} {self._asked[name]:.4g}: reached {self._asked[name] * (1.0 + error):.4g}, {100 * error:+.2g} %; "
            + self._remedy(name, best)
            for name, error in made.errors.items()
            if abs(error) > TRUE
        ]
        return replace(made, notes=tuple(notes))

    @property
    def _at_bound(self) -> bool:
        """Whether the search has tried the shortest or the longest loop."""
        ends = [math.log(end) for end in LOOSENESS]
        return any(math.isclose(each.looseness, end) for each in self._trials for end in ends)

    def _impossible(self, best: _Trial) -> str:
        """Return the line on a size that no loop of the yarn gives."""
        loop, gauge = math.exp(best.looseness), Gauge.of_stitch(*best.spacing)
        shortest = math.isclose(loop, LOOSENESS[0])
        asked = ", ".join(f"{name} {value:g}" for name, value in self._asked.items())
        return (
            f"swatch to: {self._source.name} of this yarn cannot have {asked}; with the "
            f"{'shortest' if shortest else 'longest'} loop, {loop:.3g} yarn diameters, it has {gauge}; take a "
            f"{'thinner' if shortest else 'thicker'} yarn"
        )

    def _remedy(self, name: str, best: _Trial) -> str:
        """Return what a knitter can do about a size that is missed."""
        if self._errors(best)[0] > TRUE:
            return f"the search ended after {len(self._trials)} swatches; the fabric may have several states of rest"
        if self._given:
            return f"with a given yarn the {name} follow from the width; leave the yarn out to find one for both"
        loops = [math.exp(each.looseness) for each in self._trials]
        ratios = [each.spacing[0] / each.spacing[1] for each in self._trials]
        least, most, flat, tall = min(loops), max(loops), min(ratios), max(ratios)
        return (
            f"loops of {least:.3g} to {most:.3g} yarn diameters gave {flat:.3g} to {tall:.3g} rows to a stitch; ask "
            "for such a ratio"
        )
