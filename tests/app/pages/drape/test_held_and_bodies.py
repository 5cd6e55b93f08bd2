# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What is held and bodies, on the page Drape without a browser."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from stitchmesh.app.pages.drape.page import RUN
from stitchmesh.mixed.scene.simple_bodies import box
from tests.app.pages.drape.on_page import opened, page_of, paint, run, words
from tests.app.pages.headless import call, press, wait_for_task
from tests.mixed.small_scene import SWINGING


def test_a_border_is_held_moved_and_let_go(swinging):
    """The lower border is painted with one click, moves as it is asked to, and is let go again."""
    call(swinging, swinging.controls.set, "A drag", "holds the cloth")
    call(swinging, swinging.controls.set, "Brush", "Border")
    mesh = opened(swinging).mesh
    paint(swinging, (1.4, 0.1), (1.5, 0.1), (1.6, 0.1))
    wait_for_task(swinging)
    lower = np.flatnonzero(mesh.vertices[:, 1] == 0.0)
    held = opened(swinging).prepared.held[1]
    assert np.isin(lower, held.vertices).all() and len(held.nodes)
    assert opened(swinging).mesh is mesh  # the cloth is not made again
    call(swinging, swinging.controls.set, "Part moved by", "0, 0.5, 0.2")
    call(swinging, swinging.controls.press, "The part", "Moves")
    wait_for_task(swinging)
    moving = opened(swinging).scene
    assert "part 2" in words(swinging) and "moves by 0, 0.5, 0.2 cm" in words(swinging)
    assert "held motion" in swinging.scene.drawings
    run(swinging, RUN)
    end = page_of(swinging).run.result.end.vertices
    # rounding of float64 places of a few cm
    assert np.allclose(end[held.vertices] - mesh.vertices[held.vertices], [0.0, 0.5, 0.2], atol=1e-12)
    call(swinging, swinging.controls.set, "Show", "Scene")
    call(swinging, swinging.controls.set, "A drag", "lets go of the cloth")
    paint(swinging, (1.4, 0.1), (1.5, 0.1), (1.6, 0.1))
    wait_for_task(swinging)
    assert opened(swinging).scene == SWINGING and "held motion" not in swinging.scene.drawings
    press(swinging, "Undo")
    wait_for_task(swinging)
    assert opened(swinging).scene == moving and swinging.notices() == ""


def test_parts_that_touch_share_nothing_and_run(swinging):
    """A part that is painted over another one holds what is left."""
    call(swinging, swinging.controls.set, "A drag", "holds the cloth")
    call(swinging, swinging.controls.set, "Brush", "Panel")
    paint(swinging, (1.4, 1.4), (1.5, 1.5), (1.6, 1.6))
    wait_for_task(swinging)
    first, second = opened(swinging).prepared.held
    for one, other in ((first.vertices, second.vertices), (first.nodes, second.nodes)):
        assert len(np.intersect1d(one, other)) == 0
    assert len(first.vertices) + len(second.vertices) == len(opened(swinging).cloth.vertices)
    run(swinging, RUN)
    assert swinging.notices() == ""
    assert np.array_equal(page_of(swinging).run.result.end.vertices, opened(swinging).cloth.vertices)  # All is held.
    press(swinging, "Begin a new part")
    call(swinging, swinging.controls.set, "Show", "Scene")
    paint(swinging, (1.4, 1.4), (1.5, 1.5), (1.6, 1.6))
    wait_for_task(swinging)
    assert "attachments[2]: holds only what attachments before it hold" in swinging.notices()
    assert len(opened(swinging).scene.attachments) == 2


def test_what_lies_in_a_box_is_held_and_a_part_is_freed_and_removed(swinging):
    call(swinging, swinging.controls.set, "Box from", "-1, -1, -1")
    call(swinging, swinging.controls.set, "Box to", "4, 0.3, 1")
    call(swinging, swinging.controls.press, "Box", "Hold")
    wait_for_task(swinging)
    call(swinging, swinging.controls.act, "choose-part", "1")
    call(swinging, swinging.controls.set, "Let go at [s]", 0.01)
    wait_for_task(swinging)
    box, part = opened(swinging).scene.attachments[1].boxes[0], opened(swinging).scene.attachments[1]
    assert (box.low, box.high, part.release) == ((-1.0, -1.0, -1.0), (4.0, 0.3, 1.0), 0.01)
    call(swinging, swinging.controls.act, "drop-part", "1")
    wait_for_task(swinging)
    assert opened(swinging).scene == SWINGING and swinging.notices() == ""


def test_bodies_are_added_changed_and_removed(swinging, tmp_path):
    controls = swinging.controls
    call(swinging, controls.press, "Add a body", "Ball")
    wait_for_task(swinging)
    for name, text in (("Centre", "1.5, 1.5, -2"), ("Size", "0.7"), ("Body moved by", "0, 0, 1")):
        call(swinging, controls.set, name, text)
    call(swinging, controls.press, "The body", "Take numbers")
    wait_for_task(swinging)
    call(swinging, controls.set, "Friction", 0.5)
    wait_for_task(swinging)
    (ball,) = opened(swinging).scene.bodies
    assert (ball.shape, ball.centre, ball.size, ball.friction) == ("ball", (1.5, 1.5, -2.0), (0.7,), 0.5)
    assert ball.keyframes[-1].displacement == (0.0, 0.0, 1.0) and "body 0" in swinging.scene.drawings
    box_mesh(tmp_path / "table.obj", closed=True)
    call(swinging, controls.set, "Unit of meshes", "mm")
    call(swinging, controls.send, "Add a mesh", "table.obj", (tmp_path / "table.obj").read_bytes())
    wait_for_task(swinging)
    assert [body.name for body in opened(swinging).scene.bodies] == [ball.name, "table"]
    assert opened(swinging).scene.bodies[1].unit == "mm" and swinging.notices() == ""
    box_mesh(tmp_path / "open.obj", closed=False)
    call(swinging, controls.set, "Path of a body", str(tmp_path / "open.obj"))
    call(swinging, controls.press, "Add a body", "Mesh")
    wait_for_task(swinging)
    assert "open" in swinging.notices() and "\n" not in swinging.notices()
    assert len(opened(swinging).scene.bodies) == 2
    for _ in range(2):
        call(swinging, controls.act, "drop-body", "0")
        wait_for_task(swinging)
    assert opened(swinging).scene == SWINGING and "body 0" not in swinging.scene.drawings


def box_mesh(path: Path, *, closed: bool) -> None:
    """Write a box far from the cloth; an open one lacks its first face."""
    mesh = box((9.0, 9.0, 9.0), (0.0, 0.0, -60.0))
    faces = np.split(mesh.face_vertex, mesh.face_start[1:-1])[0 if closed else 1 :]
    lines = [f"v {x} {y} {z}" for x, y, z in mesh.vertices.tolist()]
    path.write_text("\n".join([*lines, *(f"f {' '.join(str(corner + 1) for corner in face)}" for face in faces)]))
