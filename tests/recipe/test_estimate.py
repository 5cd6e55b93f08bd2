# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""An estimate counts the stitches that are made, and is near the yarn that is made of them."""

from __future__ import annotations

from dataclasses import replace

import pytest

from stitchmesh.errors import ParameterError, StitchMeshError, TessellationError
from stitchmesh.io import read_mesh
from stitchmesh.labeling import label
from stitchmesh.mesh import StitchMesh
from stitchmesh.quality import PRESETS
from stitchmesh.recipe.estimate import estimate_garment
from stitchmesh.tessellate import tessellate
from stitchmesh.tessellate.planned_stitches import planned_stitches
from stitchmesh.yarngen import generate_yarns
from tests.gallery import GARMENTS, closed_cone, grid, tube
from tests.nightly import mostly_at_night

SHAPES = {
    "flat": label(grid(4, 3)),
    "tube": label(tube(8, 4)),
    "flared": label(tube(8, 4, top_radius=6.0)),
    "cone": label(closed_cone(8)),
}


def made(labeled: StitchMesh, **size: object) -> tuple[int, int]:
    """Numbers of stitches and rows of the fabric that ``tessellate`` makes."""
    fabric = tessellate(labeled, **size)
    return fabric.face_count, int(fabric.row.max()) + 1


def counted(labeled: StitchMesh, **size: object) -> tuple[int, int]:
    """Numbers of stitches and rows of the estimate."""
    planned = planned_stitches(labeled, **size)
    return planned.total, planned.rows


@pytest.mark.decides
@pytest.mark.parametrize("name", SHAPES)
def test_the_numbers_of_stitches_and_rows_are_those_that_are_made(name):
    size = {"stitch_width": 0.31, "stitch_height": 0.155}
    assert counted(SHAPES[name], **size) == made(SHAPES[name], **size)


@pytest.mark.decides
@pytest.mark.parametrize("path", mostly_at_night(GARMENTS, by_day=GARMENTS[:2]), ids=lambda path: path.stem)
def test_the_stitches_of_a_garment_are_counted_exactly(path):
    labeled = label(read_mesh(path))
    assert counted(labeled, stitch_width=2.0) == made(labeled, stitch_width=2.0)


def test_given_counts_are_counted_too():
    labeled = SHAPES["flared"]
    course, wale = int(labeled.face_start[0]), int(labeled.right_wale[0])
    size = {"stitch_width": 0.3, "counts": {course: 11, wale: 7}}
    assert counted(labeled, **size) == made(labeled, **size)


@pytest.mark.parametrize("name", ["flat", "flared"])
def test_yarn_and_control_points_are_near_those_that_are_generated(name):
    """The bounds are those that ``GarmentEstimate`` states; small pieces have the largest part of borders."""
    labeled = SHAPES[name]
    estimate = estimate_garment(labeled, stitch_width=0.3, quality="draft", device="cpu")
    yarns = generate_yarns(tessellate(labeled, stitch_width=0.3), quality="draft")
    assert estimate.yarn_length == pytest.approx(float(yarns.lengths.sum()), rel=0.1)
    assert estimate.control_points == pytest.approx(len(yarns.points), rel=0.1)


def test_finer_control_points_cost_more_and_the_costs_of_the_stages_add_up():
    costs = [estimate_garment(SHAPES["tube"], stitch_width=0.2, quality=name, device="cpu")
             for name in ("draft", "standard", "reference")]  # fmt: skip
    assert costs[0].control_points < costs[1].control_points < costs[2].control_points
    assert costs[0].memory < costs[1].memory < costs[2].memory
    assert len({cost.yarn_length for cost in costs}) == 1
    stages = costs[1].stages
    assert list(stages) == ["tessellate", "meshrelax", "yarngen", "yarnrelax"]
    assert costs[1].seconds == pytest.approx(sum(cost.seconds for cost in stages.values()))
    assert costs[1].memory == max(cost.memory for cost in stages.values())


@pytest.mark.parametrize(("name", "longer"), [("tube", "largest_change"), ("flat", "tolerance")])
def test_what_the_yarns_wait_for_decides_their_time(name, longer):
    """Closed yarns wait until their spacing hardly changes, and the open ones of a panel until their energy does."""
    draft = PRESETS["draft"]
    finer = {field: replace(draft, **{field: getattr(draft, field) / 4.0}) for field in ("largest_change", "tolerance")}
    seconds = {field: estimate_garment(SHAPES[name], stitch_width=0.2, quality=quality, device="cpu").seconds
               for field, quality in ({"draft": draft} | finer).items()}  # fmt: skip
    assert {field for field in finer if seconds[field] > seconds["draft"]} == {longer}


REFUSED = {
    "zero": {"stitch_width": 0.0},
    "wider than the garment": {"stitch_width": 90.0},
    "too many": {"stitch_width": 1e-4},
    "count": {"stitch_width": 0.5, "counts": {0: 0}},
    "mark on a course edge": {"stitch_width": 0.5, "marked": [int(SHAPES["tube"].face_start[0])]},
    "no edge": {"stitch_width": 0.5, "counts": {(0, 0): 4}},
    "too few courses": {"stitch_width": 0.5, "counts": {0: 600}},
}


@pytest.mark.parametrize("size", REFUSED.values(), ids=REFUSED)
def test_an_estimate_refuses_what_the_division_refuses_in_the_same_words(size):
    with pytest.raises((ParameterError, TessellationError)) as division:
        tessellate(SHAPES["tube"], **size)
    with pytest.raises(StitchMeshError) as estimate:
        estimate_garment(SHAPES["tube"], device="cpu", **size)
    assert str(estimate.value) == str(division.value)
    assert type(estimate.value) is type(division.value)


def test_a_size_that_is_not_met_is_doubted_without_a_log(caplog):
    """A tube of 3 cm is smaller than a garment, and its faces of 2.3 cm do not hold two stitches of 1.5 cm."""
    estimate = estimate_garment(SHAPES["tube"], stitch_width=1.5, device="cpu")
    assert "stitch" in estimate.doubt
    assert not caplog.records
    large = label(tube(40, 20, radius=25.0, height=2.5))
    assert estimate_garment(large, stitch_width=0.8, device="cpu").doubt == ""


def test_a_mesh_without_labels_is_refused():
    with pytest.raises(ParameterError, match=r"estimate_garment: got a Mesh; .*sm\.label\(mesh\)"):
        estimate_garment(grid(3, 3), stitch_width=0.3)
