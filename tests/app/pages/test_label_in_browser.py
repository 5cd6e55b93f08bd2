# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The pages Label and Divide in a real browser: a garment is labeled and divided with the mouse alone."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image

from stitchmesh.app.project.project import Project
from stitchmesh.io.meshes import write_mesh
from stitchmesh.labeling import start_labeling
from stitchmesh.labeling.steps import LabelStep
from stitchmesh.mesh import Mesh, StitchMesh
from stitchmesh.tessellate import tessellate
from tests.gallery import grid, odd_corner, tube


@pytest.fixture
def opened(app_in_browser, tmp_path):
    """A function that opens the page Label on a mesh, in the browser."""

    def open_mesh(mesh: Mesh, **options):
        write_mesh(tmp_path / "garment.obj", mesh)
        project = Project.create(tmp_path / "project")
        project.import_mesh("garment.obj", (tmp_path / "garment.obj").read_bytes())
        project.close()
        return app_in_browser(page="Label", **options)

    return open_mesh


def front_side(mesh: Mesh, sides: np.ndarray) -> int:
    """The one of some sides that is nearest to the camera."""
    return int(max(sides.tolist(), key=lambda side: middle_of(mesh, side)[2]))


def middle_of(mesh: Mesh, side: int) -> np.ndarray:
    return (mesh.corner_position[side] + mesh.corner_position[mesh.side_next[side]]) / 2


def face_in_row(mesh: Mesh, row: np.ndarray, number: int) -> int:
    """The face of a row that is nearest to the camera."""
    faces = np.flatnonzero(row == number).tolist()
    return max(faces, key=lambda face: middle_of_face(mesh, face)[2])


def middle_of_face(mesh: Mesh, face: int) -> np.ndarray:
    return mesh.corner_position[mesh.face_start[face] : mesh.face_start[face + 1]].mean(axis=0)


def low_border(mesh: Mesh) -> np.ndarray:
    return min(mesh.boundary_loops, key=lambda loop: mesh.corner_position[loop, 1].mean())


def test_a_garment_is_labeled_by_clicks_and_a_row_is_flipped(opened):
    """The steps that the clicks take are the steps that Python takes."""
    with opened(tube(12, 5)) as rig:
        rig.key("n")
        rig.settle()
        assert rig.app.project.labeling.row_count == 1
        rig.key("Control+z")
        rig.settle()
        mesh = rig.app.project.mesh
        border = front_side(mesh, low_border(mesh))
        rig.click_at(middle_of(mesh, border))
        expected = start_labeling(mesh).start_at_edge(border)
        assert (rig.app.project.labeling.row == expected.row).all()
        while not rig.app.project.labeling.labeled.all():
            labeling = rig.app.project.labeling
            rig.click_at(middle_of_face(mesh, face_in_row(mesh, labeling.row, labeling.row_count - 1)))
            assert rig.app.project.labeling.row_count == labeling.row_count + 1
        rig.choose("A click", "flips a row")
        rig.settle()
        face = face_in_row(mesh, rig.app.project.labeling.row, 2)
        rig.click_at(middle_of_face(mesh, face))
        expected = expected.label_all().flip_row(face)
        assert (rig.app.project.labeled.face_vertex == expected.finish().face_vertex).all()
        rig.wait_for_text("At 24 edges the arrows of two rows do not match")
        rig.key("Control+z")
        rig.settle()
        assert (rig.app.project.labeling.row_is_reversed == 0).all()


def test_a_click_with_shift_takes_the_border_past_its_corners(opened):
    with opened(grid(5, 4)) as rig:
        mesh = rig.app.project.mesh
        side = int(mesh.boundary_loops[0][0])
        rig.click_at(middle_of(mesh, side), "Shift")
        assert rig.app.project.label_steps == (LabelStep("start_at_border", {"edge": side}),)


def test_faults_are_explained_beside_a_red_picture(opened):
    with opened(odd_corner()) as rig:
        rig.press("Label all")
        rig.settle()
        reason = rig.app.project.labeling.faults[0].reason
        rig.browser_page.get_by_role("button", name=reason[:40]).first.wait_for()
        pixels = np.asarray(Image.open(io.BytesIO(rig.screenshot())).convert("RGB"), dtype=int)
        scene = pixels[:, : int(0.6 * pixels.shape[1])]
        red = (scene[..., 0] > 120) & (scene[..., 1] < 70) & (scene[..., 2] < 80)
        assert np.count_nonzero(red) > 400


def test_a_labeled_garment_is_divided_with_a_number_and_a_marked_edge(opened):
    with opened(tube(12, 4, radius=6.0, height=1.5)) as rig:
        rig.press("Label all")
        rig.settle()
        rig.press("Go on: divide into stitches")
        rig.settle()
        rig.type("Stitch width [cm]", 0.5)
        rig.settle()
        labeled = rig.app.project.labeled
        face = face_in_row(labeled, labeled.row, 2)
        course, wale = int(labeled.face_start[face]), int(labeled.left_wale[face])
        rig.click_at(near(labeled, course))
        rig.type("Number", 9)
        rig.settle()
        rig.click_at(near(labeled, wale))
        rig.tick("Marked edge")
        rig.settle()
        rig.press("Divide into stitches")
        rig.wait_for(lambda: rig.app.project.fabric is not None, "the division")
        rig.settle()
        expected = tessellate(labeled, stitch_width=0.5, counts={course: 9}, marked=[wale])
        assert (rig.app.project.fabric.face_vertex == expected.face_vertex).all()
        rig.button("Go on: edit the stitches").wait_for()
        rig.wait_for_text("cast on: 72")


def near(labeled: StitchMesh, side: int) -> np.ndarray:
    """A place in the face of a side, near the side."""
    return 0.85 * middle_of(labeled, side) + 0.15 * middle_of_face(labeled, int(labeled.side_face[side]))


@pytest.mark.nightly
def test_two_browsers_see_the_same_labeling_and_division(opened):
    with opened(tube(12, 5)) as rig:
        other = rig.another_window()
        rig.press("Label all")
        rig.settle()
        other.wait_for_text("60 of 60 faces labeled")
        other.press("Go on: divide into stitches")
        rig.button("Divide into stitches").wait_for()
        assert other.faults == []
        other.close()
