# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Sensitivities are what relaxations with changed inputs, and strains, give; sums that follow from units; refusals."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.errors import ParameterError
from stitchmesh.lattice import Lattice, lattice_frame
from stitchmesh.periodic.relaxation.continuation import size_of
from stitchmesh.periodic.relaxation.prepared_swatch import CellAtRest
from stitchmesh.periodic.stretch import StretchPath, stretch_test
from stitchmesh.quality import PRESETS
from stitchmesh.run import QUIET
from stitchmesh.yarnrelax.energies.confinement import Confinement
from stitchmesh.yarnrelax.relaxation_loop import RelaxationLoop
from stitchmesh.yarnrelax.rest_derivatives import polished
from tests.nightly import at_night, mostly_at_night
from tests.periodic.free_cells import FREE, free_swatch, from_generated_yarns

CHANGE, STEP, STRAIN = 1e-5, 1e-4, 1e-5
"""Relative change of an input, strain of a stretch test, and strain, of the differences."""
SHEARED = sm.RelaxCell()
CASES: dict[str, tuple[str, dict[str, Any]]] = {
    "stockinette": ("stockinette", {}),
    "stockinette whose yarn slides along itself": ("stockinette", {"quality": "standard"}),
    "leaning rib": ("rib1x1", {"relax_cell": SHEARED}),
    "rib of held width": ("rib1x1", {"period": (1.2, None)}),
    "plain weave": ("plain", {}),
}
"""Patterns, and options of their swatches."""
FEW = ("stockinette whose yarn slides along itself", "leaning rib", "rib of held width")
"""The cases that need more than the other ones: a soft motion, a lean, and a held size."""
STIFFNESSES = ("k_len", "k_length", "k_bend", "k_contact")


@cache
def made(case: str) -> sm.Swatch:
    pattern, options = CASES[case]
    if not options:
        return free_swatch(pattern)
    with from_generated_yarns():
        given = {"quality": "draft"} | FREE | options
        return sm.swatch(pattern, device="cpu", progress=False, **given)


@cache
def found(case: str) -> sm.Sensitivity:
    return sm.sensitivity(made(case))


def rest_of(case: str) -> CellAtRest:
    """The cell of a swatch, in the state in which it is differentiated."""
    rest = made(case).at_rest
    assert rest is not None
    return replace(rest, yarns=at_rest(rest).simulation.good_yarns())


def at_rest(rest: CellAtRest) -> RelaxationLoop:
    loop = polished(rest.inputs)
    assert loop.last.residual[0] < 1e-10
    return loop


def changed(rest: CellAtRest, name: str, factor: float) -> CellAtRest:
    yarns = rest.yarns
    if name == "loop_length":
        return replace(rest, yarns=replace(yarns, rest_length=factor * yarns.rest_length))
    if name == "radius":
        return replace(rest, yarns=yarns.with_radius(factor * yarns.radius))
    if name == "planes":
        planes = [Confinement(factor * term.half_thickness) for term in rest.terms if isinstance(term, Confinement)]
        return replace(rest, terms=planes)
    return replace(rest, material=replace(rest.material, **{name: factor * getattr(rest.material, name)}))


def measures(lattice: Lattice | None) -> np.ndarray:
    """Logarithms of width and height, and the lean."""
    assert lattice is not None
    first, second = lattice.periods
    width, height = size_of(lattice)
    return np.array([np.log(width), np.log(height), first @ second / (width * height)])


@pytest.mark.parametrize("case", mostly_at_night(CASES, by_day=FEW))
def test_they_are_the_changes_of_size_of_relaxations_with_changed_inputs(case: str) -> None:
    rest = rest_of(case)
    for row in found(case).table():
        ends = [at_rest(changed(rest, row["input"], 1.0 + side * CHANGE)).simulation.good_yarns().lattice
                for side in (1.0, -1.0)]  # fmt: skip
        expected = (measures(ends[0]) - measures(ends[1])) / (2.0 * CHANGE)
        # At the residual of 1e-10 the size is known to 1e-11, because the last step is a full one, and steps of 1e-5
        # make that 1e-6. Pairs of samples that begin to touch within the steps change the differences in proportion
        # to these: by 6e-4 with steps of 1e-4.
        # Yarn that slides along itself has hardly any stiffness: steps leave this motion out (``newton_system``,
        # SOFTEST), and factors do not.
        slides = 5e-6 if case == "stockinette whose yarn slides along itself" else 1e-6
        np.testing.assert_allclose([row["width"], row["height"], row["lean"]], expected, rtol=1e-4, atol=slides)


@pytest.mark.parametrize("case", ["stockinette", "leaning rib", "rib of held width", "plain weave"])
def test_the_size_does_not_change_with_all_stiffnesses_and_changes_like_all_lengths(case: str) -> None:
    """Forces without loads are proportional to the stiffnesses; k_bend grows with lengths, as in L section 6.2.

    k_contact falls with the square of lengths, and the stiffness along the yarn falls with lengths.

    A held width is a length too, and the height follows it as the stiffness of the cell says.
    """
    own, holds_width = found(case), case == "rib of held width"
    follows = own.stiffness[0, 1] / own.stiffness[1, 1] if holds_width else 0.0
    rules = ((own.width, 0.0 if holds_width else 1.0), (own.height, 1.0 + follows), (own.lean, 0.0))
    for values, by_lengths in rules:  # rounding over the steps of 1e-6
        assert sum(values[name] for name in STIFFNESSES) == pytest.approx(0.0, abs=1e-8)
        lengths = sum(values[name] for name in ("loop_length", "radius", "planes", "k_bend"))
        lengths -= values["k_len"] + values["k_length"] + 2.0 * values["k_contact"]
        assert lengths == pytest.approx(by_lengths, abs=1e-8)


@pytest.mark.parametrize("case", ["stockinette", *at_night("plain weave")])
def test_the_stiffness_is_the_second_difference_of_the_energy_at_held_strains(case: str) -> None:
    rest = replace(rest_of(case), cell=sm.RelaxCell(None, None, shear=False))
    directions = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0], [1, 0, 1], [0, 1, 1]], dtype=np.float64)
    before = at_rest(rest).last.energy[0]
    curvature = [sum(energy_at(rest, side * STRAIN * strain) for side in (1.0, -1.0)) - 2.0 * before
                 for strain in directions]  # fmt: skip
    expected = np.diag(curvature[:3])
    for (m, n), own in zip([(0, 1), (0, 2), (1, 2)], curvature[3:], strict=True):
        expected[m, n] = expected[n, m] = (own - curvature[m] - curvature[n]) / 2.0
    assert rest.yarns.lattice is not None
    expected *= rest.gamma**2 / (STRAIN**2 * rest.yarns.lattice.area)
    # pairs of samples that part within the strains, and rounding of 1e2 erg over the square of the strains
    np.testing.assert_allclose(found(case).stiffness, expected, atol=1e-4 * np.abs(expected).max())


def energy_at(rest: CellAtRest, strain: np.ndarray) -> float:
    """Energy of a cell at rest at strains along courses and wales, and a shear [erg]."""
    yarns = rest.yarns
    assert yarns.lattice is not None
    first, second, _normal = lattice_frame(yarns.lattice.periods)
    course, wale, shear = strain
    lean = shear * np.outer(second, first)
    matrix = np.eye(3) + course * np.outer(first, first) + wale * np.outer(second, second) + lean
    moved = replace(yarns, points=yarns.points @ matrix, lattice=Lattice(yarns.lattice.periods @ matrix))
    return float(at_rest(replace(rest, yarns=moved)).last.energy[0])


@pytest.mark.usefixtures("first_state")
def test_a_stretch_test_begins_with_their_slope_of_the_tension() -> None:
    exact = replace(PRESETS["draft"], precision="float64", tolerance=1e-9, largest_change=1e-9)
    path = StretchPath(course=(-STEP, STEP), steps=3)
    curve = stretch_test("stockinette", path, quality=exact, device="cpu", run=QUIET)
    slope = sm.sensitivity(curve.free).tension_slope("course", "free")
    # contacts that open within the strains
    assert (curve.tension[2] - curve.tension[0]) / (2.0 * STEP) == pytest.approx(slope, rel=1e-3)


@pytest.mark.usefixtures("first_state")
def test_a_larger_cell_has_the_same_sensitivity() -> None:
    given: dict[str, Any] = {"quality": "draft", "device": "cpu", "progress": False} | FREE
    large, own = sm.sensitivity(sm.swatch("stockinette", columns=2, rows=2, **given)), found("stockinette")
    for row, other in zip(own.table(), large.table(), strict=True):
        for name in ("width", "height", "lean"):  # the conditions of the larger cell's system: rounding grows
            assert other[name] == pytest.approx(row[name], abs=1e-7)
    np.testing.assert_allclose(large.stiffness, own.stiffness, atol=1e-6 * own.stiffness.max())


def test_the_lean_is_that_of_the_repeat() -> None:
    """The smallest cell of moss stitch leans, its repeat does not, and keeps its right angle."""
    own = sm.sensitivity(free_swatch("moss"))
    assert not any(own.lean.values()) and own.height["loop_length"] > 1.0


def test_a_result_says_what_it_is_of() -> None:
    own = found("stockinette")
    assert own.minimum and own.residual < 1e-10
    assert own.change < PRESETS["draft"].largest_change
    assert "minimum" in repr(own) and "saddle" in repr(replace(own, negative_eigenvalues=2))
    with pytest.raises(ParameterError, match="got 'bias' with the other size 'free'; expected course or wale, and"):
        own.tension_slope("bias")  # type: ignore[arg-type]


def test_swatches_without_sensitivity_are_refused() -> None:
    one = made("stockinette")
    assert one.at_rest is not None
    with pytest.raises(ParameterError, match=r"was read from a file; make it again by sm\.swatch"):
        sm.sensitivity(replace(one, at_rest=None))
    with pytest.raises(ParameterError, match="with friction, whose size follows from its path; make it with"):
        sm.sensitivity(replace(one, at_rest=replace(one.at_rest, rubs=True)))
    held = replace(one, at_rest=replace(one.at_rest, cell=sm.RelaxCell(None, None, shear=False)))
    with pytest.raises(ParameterError, match=r"of constant size; let it relax \(relax_cell=True, no period\)"):
        sm.sensitivity(held)
