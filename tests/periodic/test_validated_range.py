# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What lies outside of the validated ranges is said, and the errors inside are those that were found."""

from __future__ import annotations

from dataclasses import replace

import pytest

from benchmarks.published.comparison import Figure
from benchmarks.published.validation_page import PAGE, found
from stitchmesh.periodic.resolve_pattern import resolve_pattern
from stitchmesh.periodic.stretch import StretchPath, refine_for_tension
from stitchmesh.periodic.swatch_options import SwatchOptions
from stitchmesh.periodic.validated_range import (
    NEAR,
    RANGES,
    fabric_of,
    gauge_verdict,
    named_material,
    swatch_verdict,
    tension_verdict,
)
from stitchmesh.quality import PRESETS
from stitchmesh.yarn.yarn_description import LIBRARY
from stitchmesh.yarn.yarn_presets import Yarn, yarn_names
from stitchmesh.yarnrelax import YarnMaterial
from stitchmesh.yarnrelax.model.material import NAMED, REFERENCE_RADIUS

STOCKINETTE = resolve_pattern("stockinette")


def figures_of(section: str, *words: str) -> list[Figure]:
    """The figures of a section of the page whose names have all words."""
    kept = [item for item in found(section) if isinstance(item, Figure)]
    return [figure for figure in kept if all(word in figure.quantity for word in words)]


def kinds(verdict) -> list[str]:
    return [finding.kind for finding in verdict.findings]


def tension(loops: float, yarn: str, fabric="stockinette", quality="draft", **path):
    """The verdict on the tension of a fabric of a yarn or a named material."""
    named = None if yarn in NAMED else Yarn.named(yarn)
    material = YarnMaterial.named(yarn) if named is None else YarnMaterial.of_yarn(named)
    radius = REFERENCE_RADIUS if named is None else named.core_radius
    return tension_verdict(fabric, loops, StretchPath(**path), material, radius, refine_for_tension(PRESETS[quality]))


@pytest.mark.parametrize(
    ("error", "section", "words"),
    [
        (gauge_verdict("stockinette", 16.24, "wet").error, "V8", (", wet",)),
        (gauge_verdict("stockinette", 16.24, "dry").error, "V8", (", dry",)),
        (gauge_verdict("stockinette", 18.0, "full").error, "V1", ("K_s",)),
        (tension(16.67, "cotton-28-tex", wale=(0.0, 0.15)).error, "V6", ()),
        (tension(13.8, "acrylic-77-tex", wale=(0.0, 0.3)).error, "V4", ("modulus of jersey",)),
        (tension(13.8, "acrylic-77-tex", "seed", wale=(0.0, 0.5)).error, "V4", ("modulus of seed",)),
        (tension(13.8, "acrylic-77-tex", "garter", wale=(0.0, 0.6)).error, "V4", ("modulus of garter",)),
    ],
)
def test_the_error_to_expect_is_that_of_the_page(error, section, words):
    largest = max(abs(figure.deviation) for figure in figures_of(section, *words))
    # Rows are rounded to a percent, the gauge of V8 up to the 4 % of V1, and a factor of 2 covers the 44 % of V6.
    assert largest - 0.01 <= error <= largest + 0.07 and error > 0.0


def test_the_section_of_each_row_is_on_its_page():
    for row in RANGES:
        headings = [line.lstrip("#").strip() for line in (PAGE.parent / row.page).read_text("utf-8").splitlines()
                    if line.startswith("#")]  # fmt: skip
        assert row.heading in headings
        assert row.off and (row.error is None or row.loops or row.quantity == "crimp")


def test_fabrics_are_told_by_their_stitches():
    known = {"stockinette": "stockinette", "reverse-stockinette": "stockinette", "garter": "garter", "seed": "seed",
             "rib1x1": "1x1 rib", "rib2x2": "other", "moss": "other", "honeycomb": "other", "plain": "plain weave",
             "twill-2x1": "other"}  # fmt: skip
    assert {name: fabric_of(resolve_pattern(name)) for name in known} == known


@pytest.mark.parametrize(("loops", "inside"), [(16.0 / (1 + NEAR), True), (15.0, False), (19.3, True), (25.0, False)])
def test_loops_outside_of_a_range_have_no_error_but_the_nearest_comparison(loops, inside):
    verdict = gauge_verdict("stockinette", loops, "wet")
    assert verdict.good == inside == (verdict.error is not None)
    assert inside or ("with loops of" in str(verdict) and "expect a larger error" in str(verdict))
    assert "(V2)" in str(gauge_verdict("stockinette", 50.0, "wet"))  # 60 is nearer than 19.3


@pytest.mark.parametrize("fabric", ["garter", "seed", "other"])
def test_a_fabric_without_a_measured_size_says_so(fabric):
    verdict = gauge_verdict(fabric, 16.67, "dry")
    assert kinds(verdict) == ["not validated"] and verdict.error is None


def test_what_changes_a_swatch_is_judged_and_a_held_size_is_not():
    material, loop = YarnMaterial.named(), 16.67 * 2.0 * REFERENCE_RADIUS

    def verdict(**options):
        return swatch_verdict(STOCKINETTE, SwatchOptions(**options), loop, material)

    for held in ({}, {"relax_cell": True, "period": (1.0, None)}):
        assert verdict(**held).good and verdict(**held).error is None
    assert verdict(relax_cell=True).error == 0.07 and verdict(relaxation="wet").error == 0.04
    for other in ({"blocked": 50.0}, {"steamed": 0.5}, {"yield_curvature": 10.0}, {"residual_twist": 50.0}):
        assert kinds(verdict(relax_cell=True, **other)) == ["not validated"]
    assert verdict(relax_cell=True, residual_twist=50.0).error == 0.07
    limp = swatch_verdict(STOCKINETTE, SwatchOptions(relax_cell=True), loop, YarnMaterial.named("kaldor-relaxation"))
    assert kinds(limp) == ["unmeasured yarn"] and limp.error is None


@pytest.mark.parametrize("radius", [0.01, REFERENCE_RADIUS, 0.4])
def test_a_named_material_is_known_at_every_radius_and_no_yarn_is_one(radius):
    for name in NAMED:
        assert named_material(YarnMaterial.named(name).of_radius(radius), radius) == name
        heavy = replace(YarnMaterial.named(name).of_radius(radius), mass_per_length=0.5)
        assert named_material(heavy, radius) == name
    for name in (*yarn_names(), *LIBRARY):
        assert named_material(YarnMaterial.named(name).of_radius(radius), radius) is None


@pytest.mark.parametrize("name", ["stitchmesh", "leaf", "kaldor-simulation", "kaldor-relaxation"])
def test_the_tension_of_a_named_material_asks_for_a_yarn(name):
    verdict = tension(16.67, name, wale=(0.0, 0.1))
    assert kinds(verdict) == ["unmeasured yarn"] and verdict.error is None
    assert f"the material {name} is that of no measured yarn" in str(verdict) and "name a yarn" in str(verdict)


@pytest.mark.parametrize(
    ("found_kinds", "arguments"),
    [
        ([], {"loops": 16.67, "yarn": "wool-2-28", "course": (0.0, 0.15)}),
        (["unmeasured yarn"], {"loops": 16.67, "yarn": "cotton-elastane", "wale": (0.0, 0.1)}),
        (["not validated", "assumed contact"], {"loops": 16.67, "yarn": "wool-2-28", "wale": (0.0, 0.3)}),
        (["not validated", "assumed contact"], {"loops": 16.67, "yarn": "wool-2-28", "wale": (-0.1, 0.1)}),
        (["not validated", "assumed contact"],
         {"loops": 16.67, "yarn": "wool-2-28", "wale": (0.0, 0.1), "other": "held"}),
        (["not validated", "assumed contact"], {"loops": 24.6, "yarn": "nylon-monofilament", "wale": (0.0, 0.4)}),
        (["not validated", "assumed contact", "coarse"], {"loops": 17.0, "yarn": "dk", "wale": (0.0, 0.5)}),
        (["not validated", "assumed contact"],
         {"loops": 17.0, "yarn": "dk", "wale": (0.0, 0.5), "quality": "standard"}),
        ([], {"loops": 16.67, "yarn": "wool-2-28", "course": (0.0, 0.1), "friction": 0.2, "cycles": 2}),
        (["not validated"], {"loops": 16.67, "yarn": "wool-2-28", "course": (0.0, 0.1), "friction": 0.5, "cycles": 2}),
        (["not validated"], {"loops": 16.67, "yarn": "wool-2-28", "course": (0.0, 0.1, 0.05, 0.1), "friction": 0.2}),
    ],
)
def test_tensions_name_what_was_not_compared(found_kinds, arguments):
    verdict = tension(**arguments)
    assert kinds(verdict) == found_kinds
    assert verdict.report()["expected_error"] == verdict.error
    assert [entry["kind"] for entry in verdict.report()["ranges"]] == found_kinds


def test_a_stated_contact_is_not_called_assumed():
    yarn = Yarn.named("wool-2-28")
    stated = replace(yarn, mechanics=replace(yarn.mechanics, transverse_modulus=3e6))
    path, quality = StretchPath(wale=(0.0, 0.3)), PRESETS["standard"]
    verdict = tension_verdict("stockinette", 16.67, path, YarnMaterial.of_yarn(stated), yarn.core_radius, quality)
    assert kinds(verdict) == ["not validated"]
