# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What a free swatch lies on, and swatches that are blocked with a tension."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from stitchmesh.errors import ParameterError
from stitchmesh.periodic.fabric_shape import THICK, FlatFabric
from stitchmesh.periodic.relaxation.continuation import size_of
from stitchmesh.periodic.relaxation.support import CLEARANCE, planes, remedy_of
from stitchmesh.periodic.repeat.drawn_swatch import draw_swatch
from stitchmesh.periodic.resolve_pattern import resolve_pattern
from stitchmesh.periodic.swatch import Swatch, scale_yarns, swatch
from stitchmesh.periodic.swatch_options import SwatchOptions
from stitchmesh.quality import PRESETS
from stitchmesh.yarnrelax import RelaxCell, YarnMaterial
from tests.nightly import at_night
from tests.periodic.free_cells import FREE, drawn, free_swatch

pytestmark = pytest.mark.usefixtures("first_state")
EXACT = replace(PRESETS["draft"], precision="float64", tolerance=1e-4, largest_change=1e-4)


def free(pattern: str, **options: Any) -> Swatch:
    """A free swatch, between planes unless the options say otherwise."""
    return swatch(pattern, **(FREE | {"quality": EXACT, "device": "cpu", "progress": False} | options))


@pytest.mark.parametrize("pattern", ["checks", *at_night("eyelet-lace", "rib3x3")])
def test_a_free_swatch_lies_flat(pattern: str) -> None:
    report = free_swatch(pattern).report
    assert report["shape"] == "flat" and report["thickness_ratio"] <= THICK


def test_stockinette_rests_as_without_support() -> None:
    lying, alone = free_swatch("stockinette"), free("stockinette", unsupported=True, quality="draft")
    # the planes lie where its yarns end as they are drawn, and rounding may let them touch
    assert lying.report["energies"]["confinement"] < 1e-9 * lying.report["energies"]["bend"]
    # a tenth of what draft promises
    assert size_of(lying.lattice) == pytest.approx(size_of(alone.lattice), rel=5e-3)


def test_a_given_cell_lies_on_nothing() -> None:
    brief = replace(EXACT, max_iterations=20)
    assert "confinement" not in free("rib1x1", quality=brief, relax_cell=RelaxCell(shear=False)).report["energies"]
    assert "confinement" not in free("rib1x1", quality=brief, unsupported=True).report["energies"]
    assert "confinement" in free("rib1x1", quality=brief).report["energies"]


def test_planes_follow_the_size_of_the_yarn() -> None:
    """The distance of the planes scales with the fabric, so that the similarity of take-up stays exact."""
    source = resolve_pattern("rib1x1")
    fabric, drawn = draw_swatch(source, SwatchOptions(), EXACT)
    larger = scale_yarns(drawn, 3.0)
    flat, other = FlatFabric.of(drawn, fabric, source), FlatFabric.of(larger, fabric, source)
    free = SwatchOptions(relax_cell=True)
    (one,), (three,) = (planes(free, *each) for each in ((flat, drawn.radius), (other, larger.radius)))
    assert three.half_thickness == pytest.approx(3.0 * one.half_thickness, rel=1e-12)  # rounding
    loop, radius = drawn.rest_length.sum() / fabric.face_count, drawn.radius[0]
    thickness = 2.0 * one.half_thickness + 2.0 * radius
    assert thickness == pytest.approx(2.0 * radius * flat.common + CLEARANCE * loop, rel=1e-12)


def test_the_tension_of_a_blocked_swatch_is_that_over_its_size_as_generated() -> None:
    tension, pattern, gamma = 60.0, "rib1x1", 2.0
    exact = replace(EXACT, tolerance=1e-5, largest_change=1e-5)
    made = free(pattern, quality=exact, blocked=tension, relax_cell=False, gamma=gamma)
    width, height = (size / gamma for size in size_of(drawn(pattern, EXACT).lattice))
    now = size_of(made.lattice)
    # the residual of 1e-5 leaves an imbalance of the loads below this
    assert made.report["course_tension"] * now[1] == pytest.approx(tension * height, rel=0.002)
    assert made.report["wale_tension"] * now[0] == pytest.approx(tension * width, rel=0.002)
    loose = size_of(free(pattern, gamma=gamma).lattice)
    assert now[0] * now[1] > loose[0] * loose[1]
    assert made.report["shape"] == "flat"


@pytest.mark.nightly
def test_lace_has_courses_as_high_as_those_of_plain_knit() -> None:
    """Its decreases are thicker than its other stitches, which do not slide behind one another for that."""
    lace, plain = (free_swatch(name).report for name in ("eyelet-lace", "stockinette"))
    assert lace["converged"] and lace["course_spacing"] == pytest.approx(plain["course_spacing"], rel=0.1)


def test_a_size_that_is_given_stays_while_the_other_one_is_blocked() -> None:
    made = free("stockinette", blocked=50.0, relax_cell=False, period=(1.2, None))
    assert size_of(made.lattice)[0] == pytest.approx(1.2, rel=1e-12)
    assert made.report["wale_tension"] * 1.2 > 0.0


@pytest.mark.parametrize(
    ("tension", "message"),
    [
        (1e6, "it tears at 30 %"), (6e4, "strain the yarn by [5-6]"),
    ],
)
def test_a_tension_that_tears_is_refused_in_one_line(tension: float, message: str) -> None:
    with pytest.raises(ParameterError, match=message) as caught:
        free("stockinette", blocked=tension, quality="draft")
    assert "\n" not in str(caught.value) and "give a smaller tension" in str(caught.value)


def test_a_tension_strains_the_yarn_at_least_as_much_as_the_virial_says() -> None:
    """The bound by which ``blocking`` refuses tensions, with stiff contacts, which carry the tension."""
    material, tension = replace(YarnMaterial.named(), k_contact=1e6), 2000.0
    made = free("stockinette", blocked=tension, material=material)
    yarns = drawn("stockinette", EXACT)
    width, height = size_of(yarns.lattice)
    force = 2.0 * tension * width * height / yarns.rest_length.sum()
    assert made.yarns.strain.mean() > force / material.axial_stiffness


@pytest.mark.parametrize("tension", [0.0, np.nan])
def test_impossible_tensions_are_refused(tension: float) -> None:
    with pytest.raises(ParameterError, match="expected a positive tension"):
        SwatchOptions(blocked=tension)


def test_a_given_cell_cannot_be_blocked() -> None:
    with pytest.raises(ParameterError, match="blocked: got a RelaxCell beside it"):
        free("stockinette", blocked=10.0, relax_cell=RelaxCell())


@pytest.mark.parametrize(
    ("cell", "lies", "advice"),
    [(None, False, "--relax-cell"), (RelaxCell(), False, "no --unsupported"), (RelaxCell(), True, "--blocked")],
)
def test_a_fabric_that_is_not_flat_gets_the_advice_that_helps(cell: RelaxCell | None, lies: bool, advice: str) -> None:
    assert advice in remedy_of(cell, lies=lies)
