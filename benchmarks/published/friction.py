# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Knits with friction: Munden's dry, wet and full constants, width of ribs, returned work, and orders of stiffness."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from benchmarks.published.knits import DIAMETER, MATERIAL, MUNDEN, Gauge, gauge
from benchmarks.published.stretch import PATTERNS, PUBLISHED
from stitchmesh.periodic.fabric_shape import FlatFabric
from stitchmesh.periodic.relaxation.continuation import change_period, size_of
from stitchmesh.periodic.relaxation.off_needles import LAST_FORCE, ON_NEEDLES, RELEASE_STEPS, TOLERANCE, falling
from stitchmesh.periodic.relaxation.support import planes
from stitchmesh.periodic.repeat.drawn_swatch import draw_swatch
from stitchmesh.periodic.resolve_pattern import resolve_pattern
from stitchmesh.periodic.sampling.sampling import close_contacts
from stitchmesh.periodic.stretch import refine_for_tension
from stitchmesh.periodic.swatch import Swatch, swatch
from stitchmesh.periodic.swatch_options import COMPACT_LOOP, YARN_FRICTION, KnitState, SwatchOptions
from stitchmesh.quality import PRESETS
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial
from stitchmesh.yarnrelax.friction.friction import Friction
from stitchmesh.yarnrelax.load_steps import LoadStep, StepAtRest, relax_through_steps

LOOPS = (14, 15, 16, COMPACT_LOOP, 18, 20, 22, 24)
"""Loop lengths [yarn diameters]."""
COEFFICIENTS = (0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5)
STATES: tuple[KnitState, ...] = ("dry", "wet", "full", "frictionless")
"""Columns of the tables; the last one is a free cell without friction."""
NEEDLES = ((4.4, 3.0), (4.6, 3.0), (5.0, 3.0), (4.6, 3.4))
"""Loop length over course and wale spacing on the needles."""
STIFF_LOOPS = (14, 15, COMPACT_LOOP)
"""Loop lengths for orders of stiffness, as without friction (``loads``)."""
STIFF_COEFFICIENTS = (0.3, 0.5)
LOADS = (500.0, 1e3, 1500.0)
"""Tensions under which extensions are compared [dyn/cm]."""
CYCLE_STEPS = 20
"""Steps of a cycle from rest to its largest tension."""
LOAD_STEPS = 20
"""Steps in equal ratios from a thousandth of the largest load."""
QUALITY = replace(refine_for_tension(PRESETS["standard"]), tolerance=TOLERANCE)


@cache
def let_go(pattern: str, loop: float, state: KnitState, mu: float = YARN_FRICTION) -> Swatch:
    """A swatch off the needles, or in a free cell without friction."""
    return swatch(
        pattern, material=YarnMaterial.named(MATERIAL), quality=QUALITY, device="cpu", relax_cell=True,
        relaxation=state, friction=None if state == "frictionless" else mu, loop_length=loop * DIAMETER, progress=False,
    )  # fmt: skip


def munden_table() -> Iterable[list[object]]:
    """Compare stockinette of several loop lengths with Munden's constants."""
    yield ["loop length / d", *(f"K_c, K_w, K_s {state}" for state in STATES)]
    found = {state: [gauge(let_go("stockinette", loop, state)) for loop in LOOPS] for state in STATES}
    for number, loop in enumerate(LOOPS):
        yield [loop, *(_constants(found[state][number]) for state in STATES)]
    means = [np.mean([(each.k_c, each.k_w, each.k_s) for each in found[state]], axis=0) for state in STATES]
    yield ["mean", *(f"{k_c:.2f}, {k_w:.2f}, {k_s:.1f}" for k_c, k_w, k_s in means)]
    yield ["Munden", *(_constants(MUNDEN[state]) for state in STATES if state in MUNDEN), ""]


def _constants(found: Gauge) -> str:
    return f"{found.k_c:.2f}, {found.k_w:.2f}, {found.k_s:.1f}"


def coefficients_table() -> Iterable[list[object]]:
    """Compare coefficients of friction for dry stockinette."""
    yield ["coefficient", *(f"K_c, K_w, K_s at {loop} d" for loop in (15, COMPACT_LOOP, 20, 24))]
    for mu in COEFFICIENTS:
        yield [mu, *(_constants(gauge(let_go("stockinette", loop, "dry", mu))) for loop in (15, COMPACT_LOOP, 20, 24))]


def paths_table() -> Iterable[list[object]]:
    """Let stockinette go from several sizes on the needles, in several orders."""
    yield ["on the needles: K_c, K_w", "let go", *(f"K_c, K_w, K_s at {mu:g}" for mu in (0.1, 0.2, 0.3))]
    for k_c, k_w in NEEDLES:
        for order in ("together", "courses first", "wales first"):
            yield [f"{k_c}, {k_w}", order, *(_let_go_from(k_c, k_w, order, mu) for mu in (0.1, 0.2, 0.3))]


def _let_go_from(k_c: float, k_w: float, order: str, mu: float) -> str:
    material, loop = YarnMaterial.named(MATERIAL), COMPACT_LOOP * DIAMETER
    free = let_go("stockinette", COMPACT_LOOP, "frictionless")
    wales, courses = free.report["wales"], free.report["courses"]
    held = change_period(free.yarns, (wales * loop / k_w, courses * loop / k_c), material, QUALITY, "cpu")
    common: dict[str, Any] = {"terms": [Friction(mu)], "material": material, "quality": QUALITY, "device": "cpu"}
    start = relax_through_steps(held, [LoadStep()], cell=ON_NEEDLES, **common)[0]
    course, wale = start.border_forces
    shares = falling(1.0, LAST_FORCE, RELEASE_STEPS)
    steps = {
        "together": [LoadStep(course * share, wale * share) for share in shares],
        "courses first": [LoadStep(course * share, wale) for share in shares]
        + [LoadStep(0.0, wale * share) for share in shares],
        "wales first": [LoadStep(course, wale * share) for share in shares]
        + [LoadStep(course * share, 0.0) for share in shares],
    }[order]
    last = relax_through_steps(start.yarns, steps, cell=RelaxCell(shear=False), **common)[-1]
    assert last.yarns.lattice is not None
    width, height = size_of(last.yarns.lattice)
    return _constants(Gauge(courses * loop / height, wales * loop / width))


def rib_table() -> Iterable[list[object]]:
    """Compare the wale spacing of ribs with that of stockinette in the same state."""
    yield ["pattern", "loop length / d", *STATES]
    for pattern in ("rib1x1", "rib2x2"):
        for loop in LOOPS:
            yield [pattern, loop, *(_width(pattern, loop, state) for state in STATES)]


def _width(pattern: str, loop: float, state: KnitState) -> str:
    rib, plain = (let_go(name, loop, state).report["wale_spacing"] for name in (pattern, "stockinette"))
    return f"{rib / plain:.2f}"


def garter_table() -> Iterable[list[object]]:
    """Compare the rows of garter to the width of a stitch; knitters count on two."""
    yield ["loop length / d", *STATES]
    for loop in LOOPS:
        yield [loop, *(f"{gauge(let_go('garter', loop, state)).ratio:.2f}" for state in STATES)]


def drawn(
    pattern: str, loop: float, state: KnitState, direction: str, loads: np.ndarray, mu: float
) -> list[StepAtRest]:  # fmt: skip
    """Relax a swatch off the needles under tensions [dyn/cm] of its free borders, with friction, between its planes."""
    start, options = let_go(pattern, loop, state, mu), SwatchOptions(loop_length=loop * DIAMETER)
    width, height = size_of(start.lattice)
    border = height if direction == "course" else width
    fabric, generated = draw_swatch(resolve_pattern(pattern), options, QUALITY)
    flat = FlatFabric.of(generated, fabric, resolve_pattern(pattern))
    steps = [LoadStep(), *(LoadStep(**{direction: tension * border}) for tension in loads)]
    return relax_through_steps(
        start.yarns, steps, terms=[Friction(mu), *planes(replace(options, relax_cell=True), flat, start.yarns.radius)],
        material=YarnMaterial.named(MATERIAL), quality=close_contacts(QUALITY, options),
        cell=RelaxCell(shear=False), device="cpu",
    )  # fmt: skip


def strains(found: list[StepAtRest], direction: str) -> np.ndarray:
    """Strains of the steps after the first, relative to the first."""
    sizes = np.array([size_of(step.yarns.lattice)[direction == "wale"] for step in found if step.yarns.lattice])
    return sizes[1:] / sizes[0] - 1.0


@dataclass(frozen=True, eq=False)
class WorkCycle:
    """The second of two cycles of dry stockinette, from rest and back."""

    strain: np.ndarray
    tension: np.ndarray
    """[dyn/cm]"""

    @property
    def returned(self) -> float:
        """Work returned over work given."""
        work = (self.tension[1:] + self.tension[:-1]) / 2 * np.diff(self.strain)
        return float(-work[CYCLE_STEPS:].sum() / work[:CYCLE_STEPS].sum())

    @property
    def stiffer(self) -> float:
        """Tension on the way out over the tension on the way back, in the middle of the cycle."""
        middle = (self.strain.min() + self.strain.max()) / 2
        out, back = slice(0, CYCLE_STEPS + 1), slice(CYCLE_STEPS, None)
        forth = np.interp(middle, self.strain[out], self.tension[out])
        return float(forth / np.interp(middle, self.strain[back][::-1], self.tension[back][::-1]))


@cache
def work_of_cycle(direction: str, most: float, mu: float) -> WorkCycle:
    """Draw dry stockinette up to a tension [dyn/cm] and let it go, twice."""
    up = np.linspace(1.0 / CYCLE_STEPS, 1.0, CYCLE_STEPS)
    tension = most * np.tile(np.concatenate([up, up[-2::-1], [0.0]]), 2)
    strain = strains(drawn("stockinette", COMPACT_LOOP, "dry", direction, tension, mu), direction)
    second = slice(2 * CYCLE_STEPS - 1, None)
    return WorkCycle(strain[second], tension[second])


def work_table() -> Iterable[list[object]]:
    """Compare the work given and returned in the second cycle."""
    yield ["drawn along", "largest tension [dyn/cm]", "strain", "coefficient", "work returned", "published"]
    for direction in PUBLISHED:
        for most, mu in ((300.0, 0.1), (300.0, 0.2), (300.0, 0.3), (1e3, 0.2)):
            found = work_of_cycle(direction, most, mu)
            strain = found.strain[CYCLE_STEPS] - found.strain[0]
            yield [f"{direction}s", most, f"{strain:.1%}", mu, f"{found.returned:.0%}", "about half"]


def stiffness_table() -> Iterable[list[object]]:
    """Extensions of dry fabrics under several loads, when they are drawn first and when they are drawn again."""
    yield ["coefficient", "loop length / d", "drawn along", *(f"at {load / 1000:g} N/m" for load in LOADS)]
    for mu in STIFF_COEFFICIENTS:
        for again in (False, True):
            for loop in STIFF_LOOPS:
                for direction in PUBLISHED:
                    found = {pattern: extensions(pattern, loop, direction, mu)[again] for pattern in PATTERNS}
                    orders = [_order({pattern: found[pattern][k] for pattern in PATTERNS}) for k in range(len(LOADS))]
                    yield [f"{mu:g}{', drawn again' if again else ''}", loop, f"{direction}s", *orders]


@cache
def extensions(pattern: str, loop: float, direction: str, mu: float) -> tuple[list[float], list[float]]:
    """Strains under ``LOADS`` of a dry fabric that is drawn, let go and drawn again, each relative to its start."""
    up = np.unique(np.concatenate([np.geomspace(1e-3 * LOADS[-1], LOADS[-1], LOAD_STEPS), LOADS]))
    down = np.append(np.geomspace(LOADS[-1], 1e-3 * LOADS[-1], LOAD_STEPS)[1:], 0.0)
    found = strains(drawn(pattern, loop, "dry", direction, np.concatenate([up, down, up]), mu), direction)
    at, rest = np.searchsorted(up, LOADS), len(up) + len(down)
    again = (1.0 + found[rest + at]) / (1.0 + found[rest - 1]) - 1.0
    return found[at].tolist(), again.tolist()


def _order(found: dict[str, float]) -> str:
    order = sorted(found, key=lambda pattern: found[pattern])
    return ", ".join(f"{pattern.removesuffix('1x1')} {100 * found[pattern]:.0f}" for pattern in order)
