# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Label, without a browser: clicks take the steps that Python takes, and the page says what is so."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from stitchmesh.app.pages.label import CLEAR, COURSE_EDGE, FLIP, INSIDE, ROWS, WALE
from stitchmesh.app.scene.drawing import Colours, Labels, Lines, Surface
from stitchmesh.errors import ParameterError, StitchMeshError
from stitchmesh.labeling import PartialLabeling, start_labeling
from stitchmesh.labeling.steps import LabelStep
from stitchmesh.mesh import BORDER, Mesh
from stitchmesh.mesh.orientation import turn_inside_out
from stitchmesh.render.labeling_drawing import UNLABELED_COLOUR
from tests.app.pages.headless import Headless, headless
from tests.gallery import grid, odd_corner, torus, tube


@pytest.fixture
def page(tmp_path: Path) -> Iterator[Headless]:
    """The page Label on a tube of 12 x 5 faces."""
    with headless(tmp_path, tube(12, 5), "Label") as opened:
        yield opened


def bits(labeling: PartialLabeling) -> list[bytes]:
    """Every array of a labeling."""
    return [getattr(labeling, part.name).tobytes() for part in fields(labeling) if part.name != "mesh"]


def mesh_of(page: Headless) -> Mesh:
    assert page.project.mesh is not None
    return page.project.mesh


def labeling_of(page: Headless) -> PartialLabeling:
    assert page.project.labeling is not None
    return page.project.labeling


def low_border(page: Headless) -> int:
    """A side of the lower border of the tube."""
    mesh = mesh_of(page)
    borders = np.flatnonzero(mesh.twin == BORDER)
    return int(borders[mesh.corner_position[borders, 1].argmin()])


def test_a_click_at_a_border_starts_the_first_row_and_clicks_make_the_next(page):
    border = low_border(page)
    page.click_side(border, 1.0)
    started = start_labeling(mesh_of(page)).start_at_edge(border)
    assert bits(labeling_of(page)) == bits(started)
    above = np.flatnonzero(labeling_of(page).labeled)[0]
    for rows in range(2, 6):
        page.click_face(int(above))
        assert labeling_of(page).row_count == rows
        above = np.flatnonzero(labeling_of(page).row == rows - 1)[0]
    assert bits(labeling_of(page)) == bits(started.label_all())
    assert page.front.notices == []


def test_a_click_a_little_beside_the_border_means_the_border(page):
    point = np.array([0.0, -0.2, 3.0])
    page.click(point)
    assert labeling_of(page).row_count == 1
    assert labeling_of(page).labeled[mesh_of(page).side_face[low_border(page)]]
    page.click((50.0, 50.0, 0.0))  # far beside the mesh
    assert len(page.project.label_steps) == 1 and page.front.notices == []


def test_label_all_is_the_labeling_in_one_call_and_divide_is_next(page):
    with pytest.raises(ParameterError, match="is hidden"):
        page.controls.find("Go on: divide into stitches")
    page.controls.press("Label all")
    assert bits(labeling_of(page)) == bits(start_labeling(mesh_of(page)).label_all())
    assert "5 rows" in page.controls.text_shown()
    assert "60 of 60 faces" in page.controls.text_shown()
    assert page.controls.find("Go on: divide into stitches")
    with pytest.raises(ParameterError, match="is hidden"):
        page.controls.find("Label all")


def test_a_click_flips_a_row_once_all_faces_have_rows(page):
    """The list of what a click means shows it, and what the user has chosen stays; seams are said and drawn."""
    page.controls.press("Label all")
    assert page.controls.find("A click").value == FLIP
    assert "seams" not in page.scene.drawings
    page.click_face(24)
    assert bits(labeling_of(page)) == bits(start_labeling(mesh_of(page)).label_all().flip_row(24))
    assert "At 24 edges the arrows of two rows do not match" in page.controls.text_shown()
    seams = page.scene.drawings["seams"]
    assert isinstance(seams, Lines)
    assert len(seams.segments) == 24
    page.click_face(24)
    assert "seams" not in page.scene.drawings
    page.controls.press("Start again")
    assert page.controls.find("A click").value == ROWS
    page.controls.set("A click", WALE)
    page.controls.press("Label all")
    assert page.controls.find("A click").value == WALE


def test_undo_and_redo_by_buttons_and_keys(page):
    page.controls.press("Next row")
    page.controls.press("Next row")
    two = bits(labeling_of(page))
    page.controls.press("Undo")
    assert labeling_of(page).row_count == 1
    page.controls.act("undo")
    assert labeling_of(page).row_count == 0
    page.controls.act("redo")
    page.controls.press("Redo")
    assert bits(labeling_of(page)) == two
    page.controls.press("Label one row more")
    assert labeling_of(page).row_count == 3


@pytest.mark.parametrize(("meaning", "label"), [(WALE, "wale"), (COURSE_EDGE, "course"), (CLEAR, None)])
def test_a_click_beside_an_edge_sets_its_label(page, meaning, label):
    page.controls.press("Label all")
    side = int(labeling_of(page).left_wale[13])
    page.controls.set("A click", meaning)
    page.click_side(side)
    expected = start_labeling(mesh_of(page)).label_all()
    if page.front.notices:
        with pytest.raises(Exception, match=r"cannot be|edge") as refused:
            expected.set_edge(side, label)
        assert str(refused.value) in page.notices()
    else:
        assert bits(labeling_of(page)) == bits(expected.set_edge(side, label))


def test_a_click_starts_at_an_inner_edge_on_the_side_of_the_click(page):
    mesh = mesh_of(page)
    side = int(mesh.side_next[mesh.side_next[low_border(page)]])
    page.controls.set("A click", INSIDE)
    page.click_side(side)
    assert labeling_of(page).labeled[mesh.side_face[side]]
    assert not labeling_of(page).labeled[mesh.side_face[mesh.twin[side]]]


def test_shift_takes_the_whole_border_beyond_its_corners(tmp_path):
    with headless(tmp_path, grid(5, 4), "Label") as page:
        mesh = mesh_of(page)
        side = int(mesh.boundary_loops[0][0])
        page.click_side(side, 1.0, modifier="shift")
        assert page.project.label_steps == (LabelStep("start_at_border", {"edge": side}),)


def test_without_the_mouse_a_border_is_chosen_and_a_row_is_flipped(page):
    assert page.controls.text_shown().count('data-action="start"') == 2
    page.controls.act("start", str(page.app.page._drawing.mesh.boundary_loops[0][0]))
    assert labeling_of(page).row_count == 1
    page.controls.press("Label all")
    page.controls.set("Row", 3)
    outline = page.scene.drawings["row"]
    assert isinstance(outline, Lines)
    assert len(outline.segments) == 24
    before = labeling_of(page)
    page.controls.press("Flip this row")
    faces = before.faces_of_row(2)
    assert bits(labeling_of(page)) == bits(before.flip_row(int(faces[0])))


@pytest.mark.parametrize("meaning", [ROWS, FLIP, INSIDE, COURSE_EDGE])
def test_a_typed_edge_does_what_a_click_does(page, meaning):
    """Near the side that runs from the first vertex to the second."""
    for _ in range(2):
        page.controls.press("Next row")
    mesh = mesh_of(page)
    side = int(np.flatnonzero(labeling_of(page).row == 1)[0]) * 4 + 1
    page.controls.set("A click", meaning)
    page.click_side(side)
    clicked, steps = bits(labeling_of(page)), page.project.label_steps
    notices = len(page.front.notices)
    if notices == 0:
        page.controls.act("undo")
    page.controls.set("Edge", f"{mesh.face_vertex[side]},{mesh.face_vertex[mesh.side_next[side]]}")
    try:
        page.controls.press("Act at this edge")
    except StitchMeshError as error:
        assert str(error) in page.notices()
    assert bits(labeling_of(page)) == clicked
    assert len(page.project.label_steps) == len(steps)


def test_vertex_numbers_are_shown_on_request(page):
    assert "vertex numbers" not in page.scene.drawings
    page.controls.set("Vertex numbers", True)
    labels = page.scene.drawings["vertex numbers"]
    assert isinstance(labels, Labels)
    assert labels.texts == tuple(str(number) for number in range(len(mesh_of(page).vertices)))
    page.controls.set("Vertex numbers", False)
    assert "vertex numbers" not in page.scene.drawings


def test_the_borders_to_click_are_drawn_until_a_row_reaches_them(page):
    assert len(page.scene.drawings["starts"].segments) == 24
    page.click_side(low_border(page), 1.0)
    assert len(page.scene.drawings["starts"].segments) == 12
    page.controls.press("Label all")
    assert "starts" not in page.scene.drawings


def face_colours(surface: Surface) -> set[tuple[int, ...]]:
    assert isinstance(surface.colours, Colours)
    return {tuple(colour) for colour in surface.colours.palette[surface.colours.index].tolist()}


def test_faces_have_the_colours_of_their_rows_and_only_colours_change_with_a_step(page):
    before = page.scene.drawings["faces"]
    assert face_colours(before) == {UNLABELED_COLOUR}
    page.controls.press("Label all")
    after = page.scene.drawings["faces"]
    assert len(face_colours(after)) == 5
    assert after.points is before.points and after.triangles is before.triangles


def test_faces_that_cannot_be_labeled_are_red_numbered_and_explained(tmp_path):
    with headless(tmp_path, odd_corner(), "Label") as page:
        page.controls.press("Label all")
        faults = labeling_of(page).faults
        assert faults
        text = page.controls.text_shown()
        assert all(fault.reason.split(":")[0] in text for fault in faults)
        numbers = page.scene.drawings["fault numbers"]
        assert isinstance(numbers, Labels)
        assert numbers.texts == tuple(str(n + 1) for n in range(len(faults)))
        page.controls.act("fault", "0")
        low, high, _ = page.scene.shown
        middle = mesh_of(page).corner_position[mesh_of(page).sides_of(np.array(faults[0].faces))].mean(axis=0)
        assert ((low < middle) & (middle < high)).all()


def test_a_refused_step_is_a_notice_and_changes_nothing(tmp_path):
    with headless(tmp_path, torus(8, 10), "Label") as page:
        assert "The mesh has no border" in page.controls.text_shown()
        page.click_face(0)
        assert "point at a border" in page.notices()
        assert page.project.label_steps == ()


def test_a_mesh_inside_out_is_said_and_turned(tmp_path):
    with headless(tmp_path, turn_inside_out(tube(12, 5)), "Label") as page:
        assert "inside out" in page.controls.text_shown()
        page.controls.press("Turn inside out")
        assert "seems to be inside out" not in page.controls.text_shown()
        assert page.project.label_steps == (LabelStep("turn_inside_out"),)


def test_what_a_change_of_rows_removes_is_said(page):
    page.controls.press("Label all")
    from stitchmesh.app.project.division import Division

    page.project.divide(Division(stitch_width=0.5))
    page.controls.set("A click", FLIP)
    page.click_face(0)
    assert "Removed: stitches" in page.notices()
