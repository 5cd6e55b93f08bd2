# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The lines that a command prints about what it has made."""

from __future__ import annotations

import dataclasses

import pytest

import stitchmesh as sm
from stitchmesh.cli.summary import knit_summary, relax_summary, spirality_lines, state_of, swatch_summary
from stitchmesh.periodic.validated_range import gauge_verdict
from stitchmesh.yarn.stitch_size import fabric_gauge
from tests.editing.fabrics import flat

GOOD = {"converged": True, "iterations": 140, "max_strain": 0.0123, "min_distance_over_radius": 1.756}


@pytest.fixture(scope="module")
def fabric() -> sm.StitchMesh:
    return flat(8, 10)


@pytest.fixture(scope="module")
def yarns(fabric) -> sm.YarnSet:
    return sm.generate_yarns(fabric, quality="draft")


@pytest.mark.parametrize(
    ("changed", "lines"),
    [
        ({"spirality": 0.0}, []),
        ({"spirality": 3.0}, ["Spirality: the wales lean 3.0 degrees to the right."]),
        (
            {"spirality": -7.25, "torque": -8.4, "snarling": 0.32},
            ["Spirality: the wales lean 7.2 degrees to the left under a torque of 840 nN m (S twist), 32 % of what "
             "makes free loops snarl."],
        ),
        (
            {"spirality": 0.0, "torque": 8.4, "snarling": 0.32},
            ["Spirality: the wales stand upright under a torque of 840 nN m (Z twist), 32 % of what makes free loops "
             "snarl."],
        ),
    ],
)  # fmt: skip
def test_the_lean_of_the_wales_is_said_with_its_sign(changed: dict[str, float], lines: list[str]) -> None:
    assert spirality_lines(changed) == lines


def test_a_good_relaxation_is_said_to_be_good():
    assert state_of(GOOD) == (
        "Good: the yarns are at rest, strained by at most 1.2 %, axes at least 1.76 radii apart (2 is touching); "
        "none passed through another."
    )


@pytest.mark.parametrize(
    ("changed", "line"),
    [
        ({"converged": False}, "the yarns are not at rest after 140 iterations; raise --max-iterations"),
        ({"max_strain": 0.06}, "some yarn is strained by 6.0 %, too long or too short for its place"),
        ({"min_distance_over_radius": 1.4},
         "yarns are crowded, their axes 1.40 radii apart (2 is touching); use a thinner yarn"),
    ],
)  # fmt: skip
def test_each_fault_is_named(changed, line):
    assert state_of(GOOD | changed) == f"Not good: {line}."
    uneven = "the stitches are not even, because the mesh relaxation did not converge"
    assert state_of(GOOD | changed, mesh_converged=False) == f"Not good: {uneven}; {line}."


def test_a_garment_has_its_size_gauge_and_yarn(fabric, yarns):
    report = {"meshrelax": {"converged": True}, "yarnrelax": GOOD}
    what, gauge, _ = knit_summary(fabric, yarns, report, None)
    assert what.startswith("Knitted 80 stitches in 10 rows, ")
    metres = yarns.lengths.sum() / 100
    assert gauge.startswith(f"Gauge: {fabric_gauge(fabric)}. Yarn: {metres:.3g} m, about ")
    assert gauge.endswith(" if it is super-bulky.")  # 10 stitches in 10 cm
    dk = sm.Yarn.named("dk")
    named = knit_summary(fabric, yarns, report, dk)[1]
    assert named.endswith(f"{metres:.3g} m of dk, about {float(f'{metres * dk.grams_per_metre:.2g}'):g} g.")
    heavy = dataclasses.replace(dk, grams_per_metre=461.0 / metres)
    assert knit_summary(fabric, yarns, report, heavy)[1].endswith(" of dk, about 460 g.")  # two digits, no exponent
    report["meshrelax"]["converged"] = False
    assert knit_summary(fabric, yarns, report, None)[-1].startswith("Not good: the stitches are not even, because the")


SIZES = {"wales": 2, "courses": 4, "width": 0.9, "height": 1.2, "wale_spacing": 0.45, "course_spacing": 0.3,
         "relaxation": "frictionless", "friction": 0.0, "planes_distance": None, "planes_pressure": None}  # fmt: skip


def plain_cell() -> sm.YarnSet:
    return sm.weave_yarns(sm.read_weave("plain"), yarn_radius=0.1, quality="draft")


def test_a_swatch_has_its_repeat_and_a_weave_its_threads():
    knit, gauge, acting, *_ = swatch_summary(sm.Swatch(plain_cell(), GOOD | SIZES, flat(), []), "rib", None)
    assert knit == "Relaxed one repeat of rib: 2 stitches x 4 rows, 0.9 x 1.2 cm."
    assert gauge.startswith("Gauge: 22.2 stitches and 33.3 rows in 10 cm. Yarn: ") and gauge.endswith(" if it is dk.")
    assert acting == "Relaxed without friction between its yarns."
    woven, threads, *_ = swatch_summary(sm.Swatch(plain_cell(), GOOD | SIZES, None, []), "plain", None)
    assert woven == "Relaxed one repeat of plain: 2 warps x 4 wefts, 0.9 x 1.2 cm."
    assert threads.startswith("22.2 warps and 33.3 wefts in 10 cm. Yarn: ") and " g" not in threads


@pytest.mark.parametrize(
    ("acting", "line"),
    [
        (("dry", 0.2, None, None), "Let go off the needles (dry) with a friction of 0.2."),
        # 0.04 g/cm^2 weigh 39.24 dyn/cm^2
        (("wet", 0.3, 0.61, 19.62), "Let go off the needles (wet) with a friction of 0.3, between planes 0.61 cm apart "
                                    "that press with 0.5 of its weight."),
    ],
)  # fmt: skip
def test_a_swatch_says_what_acted_on_it(acting, line):
    named = zip(("relaxation", "friction", "planes_distance", "planes_pressure"), acting, strict=True)
    report = GOOD | SIZES | dict(named) | {"areal_density": 0.04}
    assert swatch_summary(sm.Swatch(plain_cell(), report, None, []), "plain", None)[2] == line


def test_a_swatch_says_what_was_not_compared_with_measurements():
    entries = gauge_verdict("stockinette", 25.0, "wet").report()
    line = swatch_summary(sm.Swatch(plain_cell(), GOOD | SIZES | entries, None, []), "plain", None)[-1]
    assert line.startswith("Not validated: the size of stockinette with loops of 25 core diameters")
    inside = GOOD | SIZES | gauge_verdict("stockinette", 16.67, "wet").report()
    assert not any("alidated" in line for line in swatch_summary(sm.Swatch(plain_cell(), inside, None, []), "", None))


def test_one_yarn_is_counted_as_one():
    curve = sm.YarnSet.from_curves([[[x, 0.0, 0.0] for x in range(5)]], closed=[False], radius=0.1)
    assert relax_summary(curve, GOOD)[0] == "Relaxed 1 yarn, 0.02 m, 4.0 x 0.0 x 0.0 cm."
