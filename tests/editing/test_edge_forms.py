# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Folded and rolled edges: rows beyond a border, in their place, worked as a knitter works them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.editing.edge_forms import ARC, GAP_OVER_RADIUS, EdgeForm, parse_edge_form, with_edge_forms
from stitchmesh.editing.spiral import make_spiral
from stitchmesh.errors import ParameterError
from stitchmesh.labeling import label
from stitchmesh.mesh import BORDER, StitchMesh
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.pipeline.garment import Garment
from stitchmesh.pipeline.options import KnitOptions
from stitchmesh.pipeline.stage_table import EDGE_FORMS
from stitchmesh.recipe.recipe import Recipe, recipe_options
from stitchmesh.run import QUIET
from stitchmesh.tessellate import tessellate
from stitchmesh.yarngen import generate_yarns
from stitchmesh.yarngen.clearance import smallest_distance
from stitchmesh.yarngen.loop_check.loop_linking import check_loops
from tests.gallery import grid, tube

RADIUS, WIDE = 0.06, 3.0
"""Radius of the yarn and of the tube [cm]."""


def round_piece() -> StitchMesh:
    """A tube of plain stitches half a centimetre wide; its lower border is the hem, the other one the neck."""
    fabric = tessellate(label(tube(12, 2, radius=WIDE, height=2.0)), stitch_width=0.5, stitch_height=0.4)
    return replace(fabric, stretch=np.linspace(0.9, 1.1, len(fabric.edge_side)))


FABRIC = round_piece()
ROUND = int((FABRIC.row == 0).sum())
FORMS = [("neck=fold:4",), ("hem=roll:5",), ("hem=fold:3", "neck=roll:6")]


def edged(*texts: str, fabric: StitchMesh = FABRIC) -> StitchMesh:
    return with_edge_forms(fabric, [parse_edge_form(text) for text in texts], RADIUS)


@pytest.mark.decides
@pytest.mark.parametrize(("texts", "spiral"), [(FORMS[0], False), (FORMS[1], False), (FORMS[2], True)])
def test_the_yarns_of_every_form_hold_each_other_and_start_apart(texts, spiral):
    fabric = make_spiral(edged(*texts)) if spiral else edged(*texts)
    yarns = generate_yarns(fabric, yarn_radius=RADIUS, quality="draft")
    check_loops(fabric, yarns)
    # as plain stitches; where a chain lies beside another layer, or a spiral steps, three quarters of it
    assert smallest_distance(yarns, 2 * RADIUS)[0] > 0.75 * RADIUS


@pytest.mark.parametrize("texts", FORMS)
def test_the_fabric_stays_as_it_is_and_rows_are_numbered_in_the_order_of_knitting(texts):
    fabric = edged(*texts)
    np.testing.assert_array_equal(fabric.vertices[: len(FABRIC.vertices)], FABRIC.vertices)
    np.testing.assert_array_equal(fabric.face_vertex[: FABRIC.side_count], FABRIC.face_vertex)
    assert len(fabric.boundary_loops) == 2
    tops = np.flatnonzero((fabric.side_role == 2) & (fabric.twin != BORDER))
    steps = fabric.row[fabric.side_face[fabric.twin[tops]]] - fabric.row[fabric.side_face[tops]]
    assert (steps == 1).all()
    np.testing.assert_array_equal(fabric.stitch == Stitch.CAST_ON, fabric.row == 0)
    assert fabric.stretch is not None and FABRIC.stretch is not None
    kept = fabric.stretch[fabric.side_edge[: FABRIC.side_count]]
    np.testing.assert_array_equal(kept, FABRIC.stretch[FABRIC.side_edge])


@pytest.mark.parametrize("border", ["hem", "neck"])
def test_a_fold_turns_by_a_purl_row_and_lies_behind_the_fabric(border):
    fabric = edged(f"{border}=fold:4")
    added = np.arange(FABRIC.face_count, fabric.face_count)
    assert len(added) == 5 * ROUND
    assert (fabric.stitch[added[:ROUND]] == Stitch.PURL).all(), "the row at the turn"
    assert (fabric.stitch[added] == Stitch.PURL).sum() == ROUND
    behind = fabric.vertices[len(FABRIC.vertices) :]
    # the tube is a polygon of twelve sides: its radius differs by 1 - cos(pi / 12) = 3.4 %
    inner = np.hypot(behind[:, 0], behind[:, 2])
    np.testing.assert_allclose(inner, WIDE - GAP_OVER_RADIUS * RADIUS, atol=0.04 * WIDE)
    low, high = FABRIC.vertices[:, 1].min(), FABRIC.vertices[:, 1].max()
    reach = behind[:, 1] - low if border == "hem" else high - behind[:, 1]
    np.testing.assert_allclose(np.unique(reach.round(6)), 0.4 * np.arange(5), atol=0.02)  # rows are 0.4 cm high


def test_a_rolled_edge_has_its_rows_on_an_arc_outside_the_fabric():
    rows, height = 5, 0.4
    fabric = edged(f"neck=roll:{rows}")
    rolled = fabric.vertices[len(FABRIC.vertices) :].reshape(rows, -1, 3)
    radius = (rows + 2) * height / ARC
    middle = FABRIC.vertices[:, 1].max(), WIDE + radius
    out = np.hypot(rolled[..., 0], rolled[..., 2]) - middle[1], rolled[..., 1] - middle[0]
    # on a circle that the edge leaves along the wales; a polygon of twelve sides is 3.4 % narrower at its sides
    np.testing.assert_allclose(np.hypot(*out), radius, atol=0.04 * WIDE)
    assert (out[0] > -radius - 0.04 * WIDE).all(), "outside"


def test_purl_at_the_hem_goes_on_into_the_first_row():
    purled = np.where(np.isin(FABRIC.row, [1, 2]), Stitch.PURL, FABRIC.stitch)
    fabric = edged("hem=fold:2", fabric=replace(FABRIC, stitch=purled))
    assert (fabric.stitch[: FABRIC.face_count][FABRIC.row == 0] == Stitch.PURL).all()


def test_a_recipe_adds_the_rows_after_the_mesh_relaxation_with_the_radius_of_its_yarn():
    recipe = Recipe(mesh="tube.obj", stitch_width=0.5, yarn_radius=RADIUS, edge_forms=("hem=fold:4",))
    garment = Garment(mesh=FABRIC, options=recipe_options(recipe), values={StitchMesh: FABRIC})
    made = EDGE_FORMS.run(garment, QUIET)
    np.testing.assert_array_equal(made.value.vertices, edged("hem=fold:4").vertices)
    assert made.report["edge_forms"]["stitches"] == 5 * ROUND
    assert EDGE_FORMS.asked(garment) and not EDGE_FORMS.asked(replace(garment, options=KnitOptions()))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("hem", "edge: got 'hem'; expected BORDER=FORM:ROWS, such as hem=fold:5 or neck=roll:4"),
        ("hem=icord:3", "edge hem: got the form 'icord'; expected fold or roll"),
        ("hem=fold:0", "edge hem: got 0 rows; expected 1 to 30"),
        ("front=fold:3", "edge: got 'front'; expected a border, such as hem, neck, cuffs or 'border 2'"),
        ("cuffs=fold:3", "cuffs: the fabric has no such border; its borders are hem, neck"),
    ],
)
def test_what_is_no_edge_is_refused(text, message):
    with pytest.raises(ParameterError, match=message):
        edged(text)


def test_a_border_has_one_form_and_runs_around_a_tube():
    with pytest.raises(ParameterError, match=r"edge border 0: .* has a form already; name it once"):
        edged("hem=fold:3", "neck=roll:2", "border 0=roll:2")
    flat = tessellate(label(grid(1, 1, width=4.0, height=3.0)), stitch_width=0.5)
    with pytest.raises(ParameterError, match="edge border 0: border 0 is not along one row around a tube"):
        with_edge_forms(flat, [EdgeForm("border 0", "fold", 3)], RADIUS)
