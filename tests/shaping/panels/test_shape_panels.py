# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stitches on panels: their directions, their seams, and what can be made of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stitchmesh.errors import ParameterError, TessellationError, YarnError
from stitchmesh.mesh import BORDER, TOP, StitchMesh
from stitchmesh.mesh.courses import find_courses
from stitchmesh.meshrelax import relax_mesh
from stitchmesh.shaping.panels.panel_mesh import PanelMesh
from stitchmesh.shaping.panels.shape_panels import ShapedPanels, knit_panels, shape_panels
from stitchmesh.yarngen import generate_yarns, make_room
from stitchmesh.yarngen.loop_check.loop_linking import check_loops
from tests.shaping.panels.sewing_patterns import (
    BAG_HEIGHT,
    BAG_WIDTH,
    DART_DEPTH,
    GORES,
    HEM,
    WAIST,
    PatternText,
    bag,
    darted,
    dress,
    nodes,
    skirt,
    t_shirt,
)

pytestmark = pytest.mark.decides
WIDTH = 1.0
ROUNDING = 1.0
"""Difference of a number of stitches or rows from a length over their size: rounding, and the gap at seams."""


def rectangle(folder: Path, width: float, height: float) -> PanelMesh:
    """A flat panel in the plane z = 0."""
    text = PatternText()
    texture = nodes(np.linspace(0.0, width, 7), np.linspace(0.0, height, 6))
    text.add_panel(texture, np.concatenate([texture, np.zeros((*texture.shape[:2], 1))], axis=2))
    return text.read(folder)


def kinds(shaped: ShapedPanels) -> list[tuple[int, int, str]]:
    return sorted((*sorted(seam.panels), seam.kind) for seam in shaped.seams)


def course_directions(fabric: StitchMesh) -> np.ndarray:
    """Unit vectors along the top sides, from right to left."""
    tops = np.flatnonzero(fabric.side_role == TOP)
    step = fabric.vertices[fabric.face_vertex[fabric.side_next[tops]]] - fabric.vertices[fabric.face_vertex[tops]]
    return step / np.linalg.norm(step, axis=1, keepdims=True)


def test_rows_of_a_flat_panel_are_across_the_direction(tmp_path):
    panels = rectangle(tmp_path, 18.0, 15.0)
    direction = np.cos(np.radians(225.0)), np.sin(np.radians(225.0))
    fabric = shape_panels(panels, stitch_width=WIDTH, directions={0: direction})
    along = course_directions(fabric) @ np.array([*direction, 0.0])
    # The time of a flat panel is exactly linear, and vertices off a level by 1e-6 courses tilt a row less than this.
    assert np.abs(along).max() < 1e-5


def test_rows_follow_a_straight_hem_up_to_a_slope_of_about_20_degrees(tmp_path):
    panels = rectangle(tmp_path, 18.0, 15.0)
    sloped = np.cos(np.radians(75.0)), np.sin(np.radians(75.0))
    fabric = shape_panels(panels, stitch_width=WIDTH, directions={0: sloped})
    rows = fabric.row[fabric.side_face[np.flatnonzero(fabric.side_role == TOP)]]
    slope = np.abs(course_directions(fabric)[:, 1])
    # The last course is the hem above; the rows between the hems turn towards the direction, 15 degrees away.
    assert slope[rows == rows.max()].max() < 1e-5
    middle = np.median(slope[rows == rows.max() // 2])
    assert 0.4 * np.sin(np.radians(15.0)) < middle < np.sin(np.radians(15.0))


def test_a_turn_by_a_right_angle_exchanges_courses_and_wales(tmp_path):
    panels = rectangle(tmp_path, 18.0, 15.0)
    upright = shape_panels(panels, stitch_width=WIDTH, stitch_height=WIDTH)
    turned = shape_panels(panels, stitch_width=WIDTH, stitch_height=WIDTH, directions={0: (1.0, 0.0)})
    assert len(np.unique(upright.row)) == 15 and len(np.unique(turned.row)) == 18
    assert upright.face_count == turned.face_count == 15 * 18
    same = {tuple(np.round(point, 4)) for point in upright.vertices} ^ {tuple(np.round(p, 4)) for p in turned.vertices}
    assert not same
    assert np.abs(course_directions(upright) @ course_directions(turned).T).max() < 1e-5


def test_a_bag_is_knitted_in_rounds_and_grafted_below(tmp_path):
    panels = bag().read(tmp_path)
    shaped = knit_panels(panels, stitch_width=WIDTH)
    assert kinds(shaped) == [(0, 1, "grafted"), (0, 1, "joined"), (0, 1, "joined")]
    fabric, report = shaped.fabric, shaped.report
    assert report.grafted_edges == BAG_WIDTH / WIDTH
    assert abs(report.rows - BAG_HEIGHT / (0.77 * WIDTH)) <= ROUNDING + 0.02 * report.rows  # the foot is 2 % higher
    assert report.joined_edges == 2 * report.rows and report.sewn_edges == 0
    assert all(course.closed for course in find_courses(fabric))
    assert len(fabric.boundary_loops) == 1  # the opening
    # The foot of the bag is no flat piece; elsewhere rows keep their direction.
    assert report.mean_angle < 1.0 and report.largest_angle < 5.0


def test_gores_of_a_skirt_are_knitted_in_rounds_with_decreases(tmp_path):
    shaped = knit_panels(skirt().read(tmp_path), stitch_width=2.0)
    assert {kind for *_, kind in kinds(shaped)} == {"joined"} and len(shaped.seams) == GORES
    courses = sorted(find_courses(shaped.fabric), key=lambda course: shaped.fabric.row[course.faces[0]])
    assert all(course.closed for course in courses)
    assert len(courses) == len(np.unique(shaped.fabric.row))
    assert len(courses[0].faces) <= GORES * HEM / 2.0 and len(courses[-1].faces) == GORES * WAIST / 2.0
    assert shaped.report.largest_angle < 0.1  # a cone is flat


def test_gores_of_a_skirt_decrease_at_both_of_their_seams(tmp_path):
    panels = skirt().read(tmp_path)
    spread, seams = (knit_panels(panels, stitch_width=2.0, shaping=shaping) for shaping in ("spread", "seams"))
    assert seams.report.stacked_rows > 0 == spread.report.stacked_rows and seams.report.spread_rows == 0
    fabric = seams.fabric
    for panel in range(GORES):
        faces = np.flatnonzero(seams.face_panel == panel)
        for row in np.unique(fabric.row[faces]):
            # Faces of a panel lie in the order in which its rows are made, each from left to right.
            inside = faces[fabric.row[faces] == row]
            decreases = np.flatnonzero(fabric.n_top[inside] < fabric.n_bottom[inside]).tolist()
            assert decreases in ([], [1, len(inside) - 2])


def test_a_t_shirt_is_grafted_at_the_shoulders_and_sewn_at_the_armholes(tmp_path):
    panels = t_shirt().read(tmp_path)
    shaped = knit_panels(panels, stitch_width=1.5)
    sides, shoulders = [(0, 1, "joined")] * 2, [(0, 1, "grafted")] * 2
    armholes = [(body, sleeve, "sewn") for body in (0, 1) for sleeve in (2, 3)]
    assert kinds(shaped) == sorted([*sides, *shoulders, *armholes, (2, 2, "joined"), (3, 3, "joined")])
    fabric = shaped.fabric
    grafts = np.flatnonzero(fabric.mismatched)
    assert (fabric.side_role[grafts] == TOP).all() and len(grafts) == 2 * shaped.report.grafted_edges
    # Two cuffs and two armholes of the sleeves; hem, neck and two armholes of the body.
    assert len(fabric.boundary_loops) == 8 == len(shaped.surface.boundary_loops)
    assert shaped.report.mean_angle < 1.0


def test_a_dart_along_the_direction_is_joined_row_end_to_row_end(tmp_path):
    panels = darted().read(tmp_path)
    assert panels.panel_count == 1 and [seam.panels for seam in panels.seams] == [(0, 0)]
    shaped = knit_panels(panels, stitch_width=WIDTH, progress=False)
    assert kinds(shaped) == [(0, 0, "joined")]
    # Each row below the tip goes on through the dart, and the row at the tip is one row: no slit is left.
    assert abs(shaped.report.joined_edges - DART_DEPTH / (0.77 * WIDTH)) <= ROUNDING
    assert len(shaped.fabric.boundary_loops) == 1 and shaped.report.sewn_edges == 0
    fabric = relax_mesh(shaped.fabric, surface=shaped.surface).fabric
    check_loops(fabric, generate_yarns(fabric))
    across = knit_panels(panels, stitch_width=WIDTH, directions={0: (1.0, 0.0)}, progress=False)
    assert kinds(across) == [(0, 0, "sewn")]


def towards(panels: PanelMesh, angle: float) -> dict[int, tuple[float, float]]:
    """The same direction for all panels, by its angle [degrees] in the texture."""
    return dict.fromkeys(range(panels.panel_count), (np.cos(np.radians(angle)), np.sin(np.radians(angle))))


def test_yarns_of_panels_that_lie_on_each_other_at_a_sewn_foot_hold_each_other(tmp_path):
    panels = bag().read(tmp_path)
    shaped = knit_panels(panels, stitch_width=1.5, directions=towards(panels, 0.0), progress=False)
    fabric = relax_mesh(shaped.fabric, surface=shaped.surface).fabric
    check_loops(fabric, generate_yarns(fabric, quality="draft"))


ANGLES = (0, 30, 45, 60, 90, 120, 135, 180, 210, 225, 240, 270, 300, 315, 330)
"""Directions of knitting [degrees]; 90 is upwards."""
REFUSED = (bag, 270)
"""The bag that is knitted downwards and ends at its flat foot has no room for its yarns there."""


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("pattern", "width", "angle"),
    [(pattern, width, angle) for pattern, width in ((bag, 1.0), (skirt, 2.0), (t_shirt, 1.5)) for angle in ANGLES
     if (pattern, angle) != REFUSED],
)  # fmt: skip
def test_loops_of_sewing_patterns_hold_in_every_direction(tmp_path, pattern, width, angle):
    panels = pattern().read(tmp_path)
    shaped = knit_panels(panels, stitch_width=width, directions=towards(panels, angle), progress=False)
    fabric = make_room(relax_mesh(shaped.fabric, surface=shaped.surface).fabric).fabric
    check_loops(fabric, generate_yarns(fabric))


def test_a_sleeve_with_a_curved_cuff_and_a_cap_is_knitted_in_rounds(tmp_path):
    # The first rows begin at both ends of the cuff. They lie on each other in space, but stand apart in the pattern.
    shaped = knit_panels(t_shirt(cap=9.0, cuff=3.0).read(tmp_path), stitch_width=2.0, progress=False)
    assert [kind for *pair, kind in kinds(shaped) if pair == [2, 2] or pair == [3, 3]] == ["joined", "joined"]
    # A row takes up to one stitch at each end from the row below; more are bound off.
    assert (shaped.fabric.n_bottom <= 2).all() and (shaped.fabric.n_top <= 2).all()


@pytest.mark.nightly
@pytest.mark.parametrize("pattern", [t_shirt(cap=9.0, cuff=-3.0), dress(14.0, 4.0), dress(14.0, -4.0)])
def test_yarns_of_shirts_and_dresses_hold_each_other(tmp_path, pattern):
    shaped = knit_panels(pattern.read(tmp_path), stitch_width=2.0, progress=False)
    fabric = make_room(relax_mesh(shaped.fabric, surface=shaped.surface).fabric, quality="draft").fabric
    check_loops(fabric, generate_yarns(fabric, quality="draft"))


@pytest.mark.nightly
def test_loops_of_two_layers_that_hang_in_each_other_are_moved_apart(tmp_path):
    # At the flat foot of the bag, the stitches at the ends of the rows of both sides lie on each other.
    panels = bag().read(tmp_path)
    shaped = knit_panels(panels, stitch_width=WIDTH, directions=towards(panels, 210.0), progress=False)
    fabric = relax_mesh(shaped.fabric, surface=shaped.surface).fabric
    with pytest.raises(YarnError, match=r"passes .*; near \[.*\] cm, make room \(sm.make_room\)"):
        check_loops(fabric, generate_yarns(fabric))
    room = make_room(fabric)
    check_loops(room.fabric, generate_yarns(room.fabric))
    assert 0.0 < room.farthest < WIDTH and room.faces


def test_a_border_with_steps_keeps_its_steps_in_mesh_relaxation_and_its_yarns_hold_each_other(tmp_path):
    panels = rectangle(tmp_path, 18.0, 15.0)
    shaped = knit_panels(panels, stitch_width=WIDTH, directions=towards(panels, 45.0), progress=False)
    fabric = relax_mesh(shaped.fabric, surface=shaped.surface).fabric
    # On the straight outline of the panel, stitches beside a step would have lost their area.
    area = np.linalg.norm(fabric.face_vector_area, axis=1)
    assert area.min() > 0.25 * np.median(area)
    check_loops(fabric, generate_yarns(fabric, quality="draft"))


def test_grafts_without_room_for_their_ends_are_sewn(tmp_path):
    panels = bag().read(tmp_path)
    # Rows end at the foot on both sides, and the rounds are closed beside it.
    shaped = knit_panels(panels, stitch_width=WIDTH, directions=towards(panels, 270.0), progress=False)
    assert kinds(shaped) == [(0, 1, "joined"), (0, 1, "joined"), (0, 1, "sewn")]
    # Rows begin at the shoulders, between a neck and armholes at which they end.
    panels = t_shirt().read(tmp_path)
    shaped = knit_panels(panels, stitch_width=1.5, directions=towards(panels, 270.0), progress=False)
    assert not [kind for *_, kind in kinds(shaped) if kind == "grafted"]


def test_rows_do_not_go_on_beside_three_loops_in_one_stitch(tmp_path, monkeypatch):
    # Last rows of one stitch, which takes three loops together at a seam.
    monkeypatch.setattr("stitchmesh.shaping.panels.panel_rows.SHORTEST_TIP", 0.0)
    panels = t_shirt().read(tmp_path)
    shaped = knit_panels(panels, stitch_width=1.5, directions=towards(panels, 135.0), progress=False)
    assert {kind for one, other, kind in kinds(shaped) if one == other} == {"sewn"}


def test_seams_are_left_to_be_sewn_where_that_is_asked_for(tmp_path):
    panels = skirt().read(tmp_path)
    shaped = knit_panels(panels, stitch_width=2.0, sewn=[(1, 0), (2, 3)], progress=False)
    assert kinds(shaped) == [(0, 1, "sewn"), (0, 3, "joined"), (1, 2, "joined"), (2, 3, "sewn")]
    with pytest.raises(ParameterError, match="sewn: panels 0 and 2 have no seam"):
        knit_panels(panels, stitch_width=2.0, sewn=[(0, 2)])
    with pytest.raises(ParameterError, match="sewn: panel 4 does not exist; expected 0 to 3"):
        knit_panels(panels, stitch_width=2.0, sewn=[(0, 4)])


def test_rows_that_do_not_agree_are_sewn(tmp_path):
    shaped = knit_panels(bag().read(tmp_path), stitch_width=WIDTH, directions={1: (0.0, -1.0)})
    assert kinds(shaped) == [(0, 1, "grafted"), (0, 1, "sewn"), (0, 1, "sewn")]
    fabric = shaped.fabric
    # Knitted downwards, the back ends at the graft, where the front begins: the rows go on.
    assert not fabric.mismatched.any()
    border = np.flatnonzero(fabric.twin == BORDER)
    assert shaped.report.sewn_edges == (fabric.is_wale[border]).sum()


def test_what_cannot_be_knitted_is_refused_in_one_line(tmp_path):
    panels = bag().read(tmp_path)
    with pytest.raises(ParameterError, match="directions: panel 7 does not exist; expected 0 to 1"):
        shape_panels(panels, directions={7: (0.0, 1.0)})
    with pytest.raises(ParameterError, match=r"directions: panel 1: got \(0, 0\)"):
        shape_panels(panels, directions={1: (0.0, 0.0)})
    with pytest.raises(ParameterError, match=r"directions: panel 1: got .*expected two numbers"):
        shape_panels(panels, directions={1: (np.nan, 0.0)})
    with pytest.raises(ParameterError, match="stitch width: got -1"):
        shape_panels(panels, stitch_width=-1.0)
    with pytest.raises(ParameterError, match=r"expected a PanelMesh: make one by sm.read_panels\(path\)"):
        shape_panels(panels.mesh)
    with pytest.raises(TessellationError, match="panel 0: the longest row of 24 cm is narrower than 2 stitches of 13"):
        shape_panels(panels, stitch_width=13.0, stitch_height=1.0)
    with pytest.raises(TessellationError, match=r"panel 0: near \[9.0, 7.5, 0.0\] cm: lower than one row of 40"):
        shape_panels(rectangle(tmp_path, 18.0, 15.0), stitch_height=40.0)
    with pytest.raises(TessellationError, match="stitches; at most 3,000,000 are made"):
        shape_panels(panels, stitch_width=0.001)


def test_a_texture_that_does_not_change_along_the_direction_is_refused(tmp_path):
    panels = rectangle(tmp_path, 18.0, 15.0)
    flat = PanelMesh(panels.mesh, panels.texture * np.array([1.0, 0.0]), panels.face_panel)
    with pytest.raises(TessellationError, match=r"panel 0: the texture coordinates do not change along \[0.0, 1.0\]"):
        shape_panels(flat)
