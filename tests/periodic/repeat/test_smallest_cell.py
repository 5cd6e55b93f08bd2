# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The smallest cell of a repeat is found, its images are the repeat, and both are in balance."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from stitchmesh.periodic.relaxation.continuation import size_of
from stitchmesh.periodic.relaxation.prepared_swatch import prepare_swatch
from stitchmesh.periodic.repeat.smallest_cell import SmallestCell
from stitchmesh.periodic.sampling.sampling import GENERATED
from stitchmesh.periodic.swatch import Swatch, relax_prepared, swatch
from stitchmesh.yarn.rest_length import RestLengths
from stitchmesh.yarnrelax import relax_yarns
from tests.periodic.free_cells import FREE, drawn, free_swatch, yarn_lengths

pytestmark = [pytest.mark.decides, pytest.mark.usefixtures("first_state")]
DRAFT: dict[str, Any] = {"quality": "draft", "device": "cpu"} | FREE
ALIKE = {"stockinette": (2, 0), "slip-stitch-honeycomb": (2, 1), "left-diagonal": (6, 5), "jacquard3": (4, 1)}
"""Images of the smallest cell in the repeat, and n-th parts of the width by which the cell above lies aside."""


@pytest.mark.parametrize("pattern", ALIKE)
def test_the_images_of_the_smallest_cell_are_the_repeat(pattern: str) -> None:
    yarns = drawn(pattern, GENERATED)
    found = SmallestCell.of(yarns, yarn_lengths(yarns))
    part = found.part_of(yarns)
    assert (found.copies, found.aside) == ALIKE[pattern]
    assert part.lattice is not None and yarns.lattice is not None
    assert part.lattice.area == pytest.approx(yarns.lattice.area / found.copies, rel=1e-12)
    assert part.yarn_count * found.copies == yarns.yarn_count
    again = found.repeated(part, yarns)
    # images are sums of a few periods, some centimetres, in double precision
    np.testing.assert_allclose(again.points, yarns.points, atol=1e-12)
    np.testing.assert_allclose(again.lattice.periods, yarns.lattice.periods, atol=1e-12)  # type: ignore[union-attr]
    np.testing.assert_array_equal(again.face, yarns.face)


@pytest.mark.parametrize("pattern", ["garter", "half-cardigan"])
def test_courses_that_no_translation_takes_to_another_are_kept(pattern: str) -> None:
    yarns = drawn(pattern, GENERATED)
    found = SmallestCell.of(yarns, yarn_lengths(yarns))
    assert found.copies == 1 and found.part_of(yarns) is yarns and found.repeated(yarns, yarns) is yarns


def test_courses_of_other_lengths_or_radii_are_not_alike() -> None:
    yarns = drawn("rib1x1", GENERATED)
    assert SmallestCell.of(yarns, yarn_lengths(yarns) * [1.0, 1.01]).copies == 1
    assert SmallestCell.of(yarns.with_radius([0.125, 0.12]), yarn_lengths(yarns)).copies == 1


@pytest.mark.parametrize(
    "given, copies",
    [
        ({}, 2),
        ({"rows": 2}, 1),
        ({"columns": 2}, 1),
        ({"unsupported": True}, 1),
        ({"rest_lengths": RestLengths(rows={1: 0.9})}, 1),
        ({"rest_lengths": RestLengths(stitches={"k": 0.9})}, 2),
        ({"relax_cell": False}, 1),
    ],
)
def test_free_swatches_rest_in_the_smallest_cell_where_courses_may_only_lie_alike(
    given: dict[str, Any], copies: int
) -> None:
    found = prepare_swatch("rib1x1", material=None, **(DRAFT | given)).smallest
    assert found.copies == copies


def in_both_cells(pattern: str, **options: Any) -> list[Swatch]:
    """The swatch relaxed in its smallest cell and in that of the repeat."""
    made = [prepare_swatch(pattern, material=None, smallest=smallest, **DRAFT, **options) for smallest in (True, False)]
    assert [each.smallest.copies for each in made] == [2, 1]
    return [relax_prepared(each, each.yarns) for each in made]


@pytest.mark.parametrize(
    "pattern, options", [("seed", {}), ("stockinette", {"blocked": 100.0, "gamma": 1.1})]
)
def test_a_fabric_with_one_state_rests_alike_in_both_cells(pattern: str, options: dict[str, Any]) -> None:
    one, other = in_both_cells(pattern, **options)
    for name in ("width", "height", "energy", "energy_per_stitch", "thickness", "loop_length", "areal_density"):
        # both are at rest up to a twentieth of what draft promises
        assert one.report[name] == pytest.approx(other.report[name], rel=2.5e-3), name
    assert sum(one.report["energies"].values()) == pytest.approx(one.report["energy"], rel=1e-5)
    assert one.report["control_points"] == other.report["control_points"]
    assert one.history[-1]["energies"] == one.report["energies"]


def test_the_repeat_is_at_rest_where_its_smallest_cell_is() -> None:
    prepared = prepare_swatch("rib2x2", material=None, **DRAFT)
    made = relax_prepared(prepared, prepared.yarns)
    whole = relax_yarns(
        made.yarns, material=prepared.material, quality=prepared.quality, device="cpu", cell=prepared.cell,
        terms=prepared.terms,
    )  # fmt: skip
    assert whole.report["converged"]
    assert whole.report["energy"] == pytest.approx(made.report["energy"], rel=1e-3)
    # both are at rest up to a tenth of what draft promises
    np.testing.assert_allclose(size_of(whole.yarns.lattice), size_of(made.lattice), rtol=5e-3)  # type: ignore[arg-type]


def test_a_height_is_that_of_the_repeat() -> None:
    free = free_swatch("seed")
    made = swatch("seed", period=(None, 1.1 * free.report["height"]), **DRAFT)
    assert made.report["height"] == pytest.approx(1.1 * free.report["height"], rel=1e-6)
    assert made.lattice.periods[1] == pytest.approx([0.0, made.report["height"], 0.0], abs=1e-5)
    assert size_of(made.lattice)[0] < free.report["width"]


def test_noise_on_the_start_does_not_change_the_state() -> None:
    """Slack 1x1 rib falls over in the cell of two courses, by chance, and stands in that of one."""
    prepared = prepare_swatch("rib1x1", material=None, loop_length=2 * 20.0 * 0.125, **DRAFT)
    noise = np.random.default_rng(1).normal(size=prepared.yarns.points.shape) * 0.01 * 0.125
    shaken = replace(prepared.yarns, points=prepared.yarns.points + noise)
    one, other = (relax_prepared(prepared, yarns).report for yarns in (prepared.yarns, shaken))
    for name in ("width", "height"):
        assert other[name] == pytest.approx(one[name], rel=0.02)
