# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A skirt from its mesh to relaxed yarns by the mouse alone equals the same calls in Python, to the last bit."""

from __future__ import annotations

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.io.meshes import write_mesh
from stitchmesh.pipeline.options import RelaxOptions
from stitchmesh.pipeline.yarn_relaxation import relax_with_options
from tests.app.project.projects import same
from tests.gallery import tube

STITCH_WIDTH = 1.0


@pytest.fixture
def skirt_file(tmp_path):
    """A small skirt, wider at its hem."""
    path = tmp_path / "skirt.obj"
    write_mesh(path, tube(10, 4, radius=5.5, height=2.0, top_radius=4.0))
    return path


def middle_of_side(mesh: sm.Mesh, side: int) -> np.ndarray:
    return 0.5 * (mesh.corner_position[side] + mesh.corner_position[mesh.side_next[side]])


def front_border_side(mesh: sm.Mesh) -> int:
    """The side of the lower border that is nearest to the front."""
    sides = np.flatnonzero(mesh.twin < 0)
    middles = np.array([middle_of_side(mesh, side) for side in sides])
    return int(sides[np.argmax(middles[:, 2] - 10.0 * middles[:, 1])])


def front_face(mesh: sm.Mesh, height: float) -> tuple[int, np.ndarray]:
    """The face that is nearest to the front at a height, and its middle."""
    middles = np.array([mesh.corner_position[a:b].mean(axis=0) for a, b in
                        zip(mesh.face_start[:-1], mesh.face_start[1:], strict=True)])  # fmt: skip
    face = int(np.argmin(np.linalg.norm(middles - [0.0, height, 10.0], axis=1)))
    return face, middles[face]


def made_in_python(mesh: sm.Mesh, border: tuple[int, int], flipped: int) -> tuple[sm.StitchMesh, sm.YarnSet]:
    """The evened fabric and the relaxed yarns of the same steps."""
    labeling = sm.start_labeling(mesh).start_at_edge(border).label_all().flip_row(flipped).flip_row(flipped)
    fabric = sm.tessellate(labeling.finish(), stitch_width=STITCH_WIDTH)
    fabric = sm.lay_pattern(fabric, sm.read_pattern("rib2x2"), faces=sm.select(fabric, "hem 2")).fabric
    fabric = sm.relax_mesh(fabric, surface=mesh, options=sm.MeshRelaxOptions(aspect=0.77)).fabric
    yarns = sm.generate_yarns(fabric, quality="draft")
    relaxed = relax_with_options(yarns, RelaxOptions(), quality="draft", device="cpu", fabric=fabric)
    return fabric, relaxed.yarns


@pytest.mark.nightly
def test_the_clicks_make_what_the_same_calls_make(app_in_browser, skirt_file, tmp_path):
    with app_in_browser(page="Project") as rig:
        project = rig.app.project
        rig.upload(skirt_file)
        rig.wait_for_text("Label all")
        rig.settle()
        mesh = project.mesh
        side = front_border_side(mesh)
        rig.click_at(middle_of_side(mesh, side))
        assert project.labeling.row_count == 1
        rig.press("Label all")
        rig.settle()
        face, middle = front_face(mesh, 5.0)
        for flips in (1, 2):
            rig.click_at(middle)
            assert len(project.label_steps) == 2 + flips
        rig.press("Go on: divide into stitches")
        rig.settle()
        rig.type("Stitch width [cm]", STITCH_WIDTH)
        rig.press("Divide into stitches")
        rig.settle()
        rig.press("Go on: edit the stitches")
        rig.settle()
        rig.type("Select by words", "hem 2")
        rig.press("Select these")
        rig.press("Lay a pattern")
        rig.act("pattern", "rib2x2")
        rig.settle()
        rig.press("Lay the pattern")
        rig.wait_for(lambda: len(project.edits) == 1, "the rib is laid")
        ribbed = project.fabric
        rig.press("Undo")
        rig.wait_for(lambda: not project.edits, "the rib is undone")
        rig.press("Redo")
        rig.wait_for(lambda: len(project.edits) == 1, "the rib is back")
        assert same(project.fabric.stitch, ribbed.stitch)
        rig.page_button("Even out")
        rig.press("Even out the stitches")
        rig.wait_for(lambda: project.evened is not None, "the stitches are even")
        rig.press("Go on to the yarns")
        rig.open_group("Accuracy and edges")
        rig.choose("Quality", "draft")
        rig.press("Generate the yarns")
        rig.wait_for(lambda: project.yarns is not None, "the yarns are generated")
        rig.press("Relax the yarns")
        rig.wait_for(lambda: project.relaxed is not None, "the yarns are relaxed")
        rig.settle()
        rig.page_button("Project")
        rig.open_group("Download")
        rig.settle()
        _, content = rig.downloaded(lambda: rig.act("download", "relaxed.h5"))
    (tmp_path / "relaxed.h5").write_bytes(content)
    corners = mesh.face_vertex[side], mesh.face_vertex[mesh.side_next[side]]
    evened, relaxed = made_in_python(sm.read_mesh(skirt_file), (int(corners[0]), int(corners[1])), face)
    assert same(sm.read_yarns(tmp_path / "relaxed.h5"), relaxed)
    saved = type(project).open(project.folder)
    assert same(saved.evened, evened) and same(saved.relaxed, relaxed)
    saved.close()
