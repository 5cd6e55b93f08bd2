# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Search for the states of rest of a swatch: random starts, their relaxations, and the distinct states among them.

Two relaxations of one repeat end in the same state if the fabric has the same size, lean and relief. Yarns may have
moved along the fabric by any amount, to another image, along themselves, or to the place of an equal stitch, and the
fabric may be mirrored. The comparison therefore uses only figures that depend on none of this:

    width, height        of the repeat, relative differences
    lean                 the magnitude of the shear of the repeat
    relief               heights of points at equal distances along the yarns over their mean, in ascending order, over
                         the thickness; the root mean square of the differences, of the fabric or of its back

The distance of two states is the largest of these differences. It is symmetric and fulfils the triangle inequality up
to the choice of the side. States at a distance below ``SAME`` are the same. Each state is compared with the lowest
state of each group, in ascending order of energy, so that the result does not depend on the order of the starts.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from stitchmesh.errors import ParameterError, SolverError
from stitchmesh.lattice import lattice_frame
from stitchmesh.mesh import FloatArray
from stitchmesh.patterns import Pattern
from stitchmesh.periodic.relaxation.lowest_rest import perturbed_start
from stitchmesh.periodic.relaxation.prepared_swatch import check_kept_states, prepare_swatch
from stitchmesh.periodic.swatch import Swatch, relax_prepared, size_spread
from stitchmesh.periodic.weave.weave import Weave
from stitchmesh.progress import Progress, shown_stages
from stitchmesh.quality import DEFAULT_QUALITY, Quality
from stitchmesh.run import Run
from stitchmesh.yarn import YarnSet
from stitchmesh.yarnrelax import YarnMaterial

SAME = 0.05
"""Distance below which two states are the same: the spacing that the quality ``draft`` promises."""
HEIGHTS = 256
"""Heights that are compared."""


@dataclass(frozen=True, eq=False)
class Rest:
    """A state of rest, and how many starts came to it."""

    swatch: Swatch
    """The swatch of the lowest energy that was found in this state."""
    count: int
    """Number of starts that came to this state."""
    usual: bool = False
    """Whether ``swatch`` comes to this state."""

    @property
    def energy(self) -> float:
        """Energy of a stitch [erg]."""
        return float(self.swatch.report["energy_per_stitch"])

    def row(self) -> dict[str, Any]:
        """Return the figures of the state as plain numbers and words."""
        report = self.swatch.report
        names = ("energy_per_stitch", "wale_spacing", "course_spacing", "thickness", "thickness_ratio", "course_fold",
                 "wale_fold", "shape")  # fmt: skip
        # A fabric leans from this value of its lean
        leaned = abs(report["shear"]) >= 0.02
        return {name: report[name] for name in names} | {
            "lean": report["shear"], "posture": "leaned" if leaned else "upright", "count": self.count,
            "usual": self.usual,
        }  # fmt: skip


def distance(first: YarnSet, second: YarnSet) -> float:
    """Return the distance of two states of the yarns of one repeat."""
    one, two = (_size(yarns) for yarns in (first, second))
    sizes = np.abs(np.log(one[:2] / two[:2])).max()
    return max(float(sizes), abs(abs(one[2]) - abs(two[2])), _relief_distance(first, second))


def distinct_rests(swatches: Sequence[Swatch], usual: Swatch | None = None) -> list[Rest]:
    """Group relaxed swatches by state, in ascending order of energy.

    Args:
        swatches: the relaxed swatches.
        usual: the swatch among these that ``swatch`` returns.
    """
    groups: list[list[Swatch]] = []
    for made in sorted(swatches, key=lambda made: float(made.report["energy_per_stitch"])):
        near = [group for group in groups if distance(group[0].yarns, made.yarns) < SAME]
        if near:
            near[0].append(made)
        else:
            groups.append([made])
    return [Rest(group[0], len(group), any(made is usual for made in group)) for group in groups]


def _size(yarns: YarnSet) -> FloatArray:
    """Return width and height of the repeat [cm], and its lean."""
    assert yarns.lattice is not None
    along, across, _normal = lattice_frame(yarns.lattice.periods)
    width, height = yarns.lattice.periods[0] @ along, yarns.lattice.periods[1] @ across
    return np.array([width, height, (yarns.lattice.periods[1] @ along) / height])


def _relief_distance(first: YarnSet, second: YarnSet) -> float:
    one, two = _relief(first), _relief(second)
    whole = max(float(np.ptp(one)), float(np.ptp(two)), 2.0 * float(first.radius.mean()))
    return min(float(np.sqrt(np.mean((one - other) ** 2))) for other in (two, -two[::-1])) / whole


def _relief(yarns: YarnSet) -> FloatArray:
    """Return heights over their mean in ascending order [cm], shape (HEIGHTS,): they are quantiles along the yarn."""
    assert yarns.lattice is not None
    curves = [curve @ lattice_frame(yarns.lattice.periods)[2] for curve in yarns.sampled(8)]
    height = np.concatenate(curves)
    quantiles: FloatArray = np.quantile(height - height.mean(), (np.arange(HEIGHTS) + 0.5) / HEIGHTS)
    return quantiles


logger = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class Exploration:
    """The states of rest that some starts reached."""

    rests: tuple[Rest, ...]
    """The distinct states, in ascending order of energy."""
    starts: int
    """Number of starts, the start of ``swatch`` included."""
    not_at_rest: int
    """Number of starts that did not come to rest; their states are not among the rests."""
    spread: tuple[float, float]
    """Largest minus smallest width and height of the starts at rest, over their means; of all starts if none is at
    rest."""

    def __repr__(self) -> str:
        """Return one line: the number of states, and of starts."""
        return f"Exploration({len(self.rests)} states of rest from {self.starts} starts)"

    def table(self) -> list[dict[str, Any]]:
        """Return the figures of each state (``Rest.row``)."""
        return [rest.row() for rest in self.rests]


def explore(
    pattern: str | Pattern | Weave,
    starts: int,
    *,
    seed: int = 0,
    material: YarnMaterial | None = None,
    quality: str | Quality = DEFAULT_QUALITY,
    device: str | None = None,
    progress: Progress | Literal[False] | None = None,
    **options: Any,
) -> Exploration:
    """List the distinct states of rest of a free swatch: the state of ``swatch``, and states from perturbed starts.

    From perturbed starts the whole repeat relaxes, so that stitches that are alike in the pattern may lie differently.
    Without friction the cell may also lean, between planes unless ``unsupported``. With friction all starts take the
    same path off the needles. Equal seeds give equal starts.

    Args:
        pattern: a pattern or a weave, the name of one in the library, or the path of a file.
        starts: number of perturbed starts, at least 1.
        seed: seed of the perturbations.
        material: material of the yarn; by default the material ``stitchmesh``, scaled to the radius of the yarn.
        quality: a preset or a ``Quality``.
        device: device of the kernels, for example ``cpu`` or ``cuda:0``; by default the first GPU, or the CPU if there
            is no GPU.
        progress: called with the completed part of all starts and the number of the present one, where 0 is the start
            of ``swatch``; by default a line shows them on a terminal or in a notebook, and False shows nothing.
        options: fields of ``SwatchOptions``. Relaxation and friction mean the same as in ``swatch``, but the default is
            no friction.

    Raises:
        ParameterError: fewer than one start, or an error of ``swatch``.
        FileError, PatternError: an error of ``swatch``.
        SolverError: no start can be relaxed.
    """
    if starts < 1:
        raise ParameterError(f"explore: got {starts} starts; expected at least 1")
    given: dict[str, Any] = {"material": material, "quality": quality, "device": device}
    given |= {"relax_cell": True, "relaxation": "frictionless"} | options
    usual, prepared = prepare_swatch(pattern, **given), prepare_swatch(pattern, smallest=False, **given)
    assert prepared.cell is not None
    if prepared.release is None:
        prepared = replace(prepared, cell=replace(prepared.cell, shear=True))
    check_kept_states("explore", starts, prepared.yarns)
    made, own, last_error = [], None, None
    with shown_stages(progress) as show:
        for number, random in enumerate([None, *(np.random.default_rng([seed, k]) for k in range(starts))]):

            def show_start(stage: str, done: float, note: str, number: int = number) -> None:
                show(stage, (number + done) / (starts + 1), f"start {number} of {starts}: {note}")

            show_start("yarnrelax", 0.0, "begins")
            try:
                if random is None:
                    own = relax_prepared(usual, usual.yarns, Run(show_start))
                    made.append(own)
                else:
                    moved = perturbed_start(prepared, prepared.yarns, random)
                    made.append(relax_prepared(prepared, moved, Run(show_start)))
            except SolverError as error:
                logger.warning("explore: start %d: %s", number, error)
                last_error = error
    if not made and last_error is not None:
        raise last_error
    return _exploration(made, own, starts + 1)


def _exploration(made: list[Swatch], own: Swatch | None, starts: int) -> Exploration:
    rested = [swatch for swatch in made if swatch.report["converged"]]
    return Exploration(tuple(distinct_rests(rested, own)), starts, starts - len(rested), size_spread(made))
