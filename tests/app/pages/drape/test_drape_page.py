# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Drape without a browser: scenes are opened, their region is chosen, and they run as in Python."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from html import unescape
from pathlib import Path

import numpy as np
import pytest

from stitchmesh.app.pages.drape import page as drape_page
from stitchmesh.app.pages.drape.kept_history import name_of, read_history, write_history
from stitchmesh.app.pages.drape.opened_scene import OpenedScene
from stitchmesh.app.pages.drape.page import CONTINUE, RUN, RUN_AGAIN, DrapePage
from stitchmesh.app.pages.drape.scene_history import SceneHistory
from stitchmesh.app.pages.view import draped_sketch
from stitchmesh.app.pages.view.draped_sketch import DrapedSketch, SketchLines
from stitchmesh.app.scene.drawing import Colours, Surface
from stitchmesh.app.scene.scene import Stroke
from stitchmesh.cli.main import main
from stitchmesh.compute.device import alone
from stitchmesh.io import write_stitches
from stitchmesh.labeling import label
from stitchmesh.mixed.drape import drape
from stitchmesh.mixed.enrichment.region import YARNS
from stitchmesh.mixed.memory import estimate_memory
from stitchmesh.mixed.output.report import region_counts
from stitchmesh.mixed.placement.triangle_choice import triangles_of_faces
from stitchmesh.mixed.scene.region_section import RegionSection
from stitchmesh.mixed.scene.scene import Scene
from stitchmesh.mixed.scene.scene_fabric import prepare
from stitchmesh.mixed.scene.scene_file import read_scene, write_scene
from stitchmesh.mixed.scene.simple_bodies import box
from stitchmesh.selection import select
from stitchmesh.tessellate import tessellate
from tests.app.pages.headless import Headless, headless
from tests.app.pages.tasks import SAFETY, call, press, wait_for_task
from tests.gallery import grid
from tests.mixed.small_scene import MIDDLE, SWINGING

EYE = np.array([1.5, 1.5, 30.0])


@pytest.fixture
def shown(tmp_path) -> Iterator[Headless]:
    with headless(tmp_path, None, "Drape") as page:
        yield page


@pytest.fixture
def swinging(shown, tmp_path) -> Headless:
    """The page with the small scene."""
    write_scene(tmp_path / "swinging.toml", SWINGING)
    open_file(shown, tmp_path / "swinging.toml")
    return shown


def open_file(shown: Headless, path: Path) -> None:
    call(shown, shown.controls.set, "Path", str(path))
    press(shown, "Open path")
    wait_for_task(shown)


def page_of(shown: Headless) -> DrapePage:
    assert isinstance(shown.app.page, DrapePage)
    return shown.app.page


def opened(shown: Headless) -> OpenedScene:
    found = page_of(shown).session.opened
    assert found is not None
    return found


def region(shown: Headless) -> RegionSection:
    return opened(shown).scene.region


def words(shown: Headless) -> str:
    """All that the page says, without marks."""
    return " ".join(unescape(re.sub("<[^>]*>", " ", shown.controls.text_shown())).split())


def run(shown: Headless, button: str) -> None:
    press(shown, button)
    wait_for_task(shown)


def paint(shown: Headless, *points: tuple[float, float]) -> None:
    """Drag over places of the flat cloth, seen from the front."""
    phases = ["start", *["move"] * (len(points) - 2), "end"]
    for (x, y), phase in zip(points, phases, strict=True):
        stroke = Stroke(EYE, np.array([x, y, 0.0]) - EYE, phase=phase)
        call(shown, page_of(shown).stroked, stroke)


def test_a_scene_is_shown_with_its_counts_and_its_memory(swinging):
    prepared = prepare(SWINGING)
    counts = region_counts(prepared.fabric.cloth, prepared.fabric.yarns, prepared.region)
    assert opened(swinging).counts == counts
    text = words(swinging)
    assert f"Yarn nodes, simulated {counts['yarn_nodes_full']}" in text
    assert f"about {1e-6 * estimate_memory(prepared.region, contact=False).total:,.0f} of" in text
    cloth = swinging.scene.drawings["cloth"]
    assert isinstance(cloth, Surface) and len(cloth.triangles) == counts["triangles"]
    assert {"held", "cloth edges"} <= set(swinging.scene.drawings)


def test_colours_show_kinds_or_the_weight_of_the_yarns(swinging):
    kinds = opened(swinging).region.triangle_kind
    by_kind = swinging.scene.drawings["cloth"].colours
    assert isinstance(by_kind, Colours) and len(np.unique(by_kind.index)) == len(np.unique(kinds)) == 3
    call(swinging, swinging.controls.set, "Colours", "Alpha")
    alpha = swinging.scene.drawings["cloth"]
    assert not alpha.flat and len(alpha.colours.index) == len(alpha.points)


def test_undo_and_redo_of_every_change_are_exact(swinging):
    """Painting, boxes, words, kinds and materials go back, and come again, as they were."""
    controls, seen = swinging.controls, [opened(swinging).scene]

    def keep() -> None:
        wait_for_task(swinging)
        assert opened(swinging).scene != seen[-1], swinging.notices()
        seen.append(opened(swinging).scene)

    call(swinging, controls.set, "A drag", "adds to the region")
    call(swinging, controls.set, "Brush", "Triangle")
    paint(swinging, (0.3, 0.2), (1.5, 0.2), (2.7, 0.2))
    keep()
    call(swinging, controls.set, "A drag", "takes out of the region")
    paint(swinging, (1.5, 1.5), (1.6, 1.5))
    keep()
    call(swinging, controls.set, "By words", "faces 0-4")
    call(swinging, controls.press, "These", "Only")
    keep()
    call(swinging, controls.press, "Box", "Add box")
    keep()
    call(swinging, controls.set, "Yarns", "where triangles err")
    keep()
    call(swinging, controls.set, "Hybrid rings", 2)
    keep()
    call(swinging, controls.set, "Yarn", "gong-3")
    keep()
    for scene in reversed(seen[:-1]):
        press(swinging, "Undo")
        wait_for_task(swinging)
        assert opened(swinging).scene == scene
        assert read_scene(page_of(swinging).session.scene_path) == scene  # it is on disk at once
    for scene in seen[1:]:
        press(swinging, "Redo")
        wait_for_task(swinging)
        assert opened(swinging).scene == scene
    assert swinging.notices() == ""


def test_a_drag_paints_the_triangles_under_it_once_it_ends(swinging):
    call(swinging, swinging.controls.set, "A drag", "adds to the region")
    call(swinging, swinging.controls.set, "Brush", "Triangle")
    before = region(swinging)
    for phase, x in (("start", 0.1), ("move", 2.9)):
        call(swinging, page_of(swinging).stroked, Stroke(EYE, np.array([x, 0.15, 0.0]) - EYE, phase=phase))
    assert region(swinging) == before and "painted" in swinging.scene.drawings
    call(swinging, page_of(swinging).stroked, Stroke(EYE, np.array([2.9, 0.15, 0.0]) - EYE, phase="end"))
    assert "painted" not in swinging.scene.drawings
    mesh = opened(swinging).mesh
    corners = mesh.vertices[mesh.face_vertex.reshape(-1, 3)]
    crossed = (corners[:, :, 1].min(axis=1) < 0.15) & (corners[:, :, 1].max(axis=1) > 0.15)
    # triangles of which the line passes a corner only may be missed between two rays of the drag
    assert set(region(swinging).faces) <= set(np.flatnonzero(crossed).tolist())
    assert len(region(swinging).faces) >= 0.7 * crossed.sum()


def test_a_box_and_panels_and_stitches_are_chosen_by_words(swinging, tmp_path):
    call(swinging, swinging.controls.set, "By words", "panel")
    call(swinging, swinging.controls.press, "These", "Add")
    assert len(opened(swinging).marked) == len(opened(swinging).cloth.triangles)
    call(swinging, swinging.controls.press, "These", "Remove")
    assert len(opened(swinging).marked) == 0
    call(swinging, swinging.controls.set, "Box from", "1, 1, -1")
    call(swinging, swinging.controls.set, "Box to", "2, 2, 1")
    call(swinging, swinging.controls.press, "Box", "Add box")
    assert region(swinging) == SWINGING.region
    fabric = tessellate(label(grid(2, 3)), stitch_width=0.5)
    write_stitches(tmp_path / "stitches.h5", fabric)
    open_file(swinging, tmp_path / "stitches.h5")
    call(swinging, swinging.controls.set, "By words", "rows 1-2")
    call(swinging, swinging.controls.press, "These", "Add")
    assert np.array_equal(opened(swinging).marked, triangles_of_faces(fabric, select(fabric, "rows 1-2")))
    assert swinging.notices() == ""


def test_a_border_is_held_moved_and_let_go(swinging):
    """The lower border is painted with one click, moves as it is asked to, and is let go again."""
    seen = [opened(swinging).scene]
    call(swinging, swinging.controls.set, "A drag", "holds the cloth")
    call(swinging, swinging.controls.set, "Brush", "Border")
    mesh = opened(swinging).mesh
    paint(swinging, (1.4, 0.1), (1.5, 0.1), (1.6, 0.1))
    wait_for_task(swinging)
    seen.append(opened(swinging).scene)
    lower = np.flatnonzero(mesh.vertices[:, 1] == 0.0)
    held = opened(swinging).prepared.held[1]
    assert np.isin(lower, held.vertices).all() and len(held.nodes)
    assert opened(swinging).mesh is mesh  # the cloth is not made again
    call(swinging, swinging.controls.set, "Part moved by", "0, 0.5, 0.2")
    call(swinging, swinging.controls.press, "The part", "Moves")
    wait_for_task(swinging)
    seen.append(opened(swinging).scene)
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
    assert len(opened(swinging).scene.attachments) == 1 and "held motion" not in swinging.scene.drawings
    for scene in reversed(seen):
        press(swinging, "Undo")
        wait_for_task(swinging)
        assert opened(swinging).scene == scene
    assert swinging.notices() == ""


def test_what_lies_in_a_box_is_held_and_a_part_is_freed_and_removed(swinging):
    call(swinging, swinging.controls.set, "Box from", "-1, -1, -1")
    call(swinging, swinging.controls.set, "Box to", "4, 0.3, 1")
    call(swinging, swinging.controls.press, "Box", "Hold")
    wait_for_task(swinging)
    call(swinging, swinging.controls.act, "choose-part", "1")
    call(swinging, swinging.controls.set, "Let go at", 0.01)
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


def test_the_budget_of_an_automatic_region_is_a_number_of_nodes_or_a_time(swinging):
    call(swinging, swinging.controls.set, "Yarns", "where triangles err")
    call(swinging, swinging.controls.set, "Budget", "time of a step")
    call(swinging, swinging.controls.set, "Seconds", 0.25)
    assert (region(swinging).nodes, region(swinging).seconds) == (None, 0.25)
    call(swinging, swinging.controls.set, "Budget", "number of nodes")
    assert (region(swinging).nodes, region(swinging).seconds) == (1000, None)
    assert swinging.notices() == ""


def test_the_region_is_found_as_a_run_finds_it(swinging):
    scene = replace(SWINGING, region=replace(SWINGING.region, yarns="automatic", nodes=60))
    call(swinging, swinging.controls.set, "Yarns", "where triangles err")
    call(swinging, swinging.controls.set, "Most nodes", 60)
    press(swinging, "Find the region now")
    wait_for_task(swinging)
    assert region(swinging).yarns == "chosen" and len(region(swinging).faces)
    assert np.array_equal(opened(swinging).region.triangle_kind, drape(scene).prepared.region.triangle_kind)


def test_a_run_is_that_of_python_and_of_the_command_line(swinging, tmp_path, capsys):
    run(swinging, RUN)
    made, result = drape(SWINGING), page_of(swinging).run.result
    assert result is not None and np.array_equal(result.yarns.points, made.yarns.points)
    assert "The run has converged: 5 steps" in words(swinging) and "Newton iterations" in words(swinging)
    assert {"viewed", "viewed surface"} <= set(swinging.scene.drawings)
    saved = tmp_path / "saved"
    call(swinging, swinging.controls.set, "Folder", str(saved))
    press(swinging, "Save there")
    assert main(["drape", str(saved / "scene.toml"), "-o", str(tmp_path / "again"), "--no-picture"]) in (None, 0)
    assert (tmp_path / "again" / "yarns.bcc").read_bytes() == (saved / "yarns.bcc").read_bytes()
    call(swinging, swinging.controls.act, "download", "scene.toml")
    (tmp_path / "sent.toml").write_bytes(swinging.front.downloads[-1][1])
    assert read_scene(tmp_path / "sent.toml") == opened(swinging).scene


def test_a_stopped_run_continues_to_the_same_bits(swinging):
    page = page_of(swinging)
    with alone():  # The run cannot begin before it is paused.
        press(swinging, RUN)
        call(swinging, page.run.live.control.pause)
        call(swinging, page.run.live.control.step)
    for _ in range(int(SAFETY / 0.02)):
        if page.run.live.newest is not None:
            break
        swinging.app.queue.settle(SAFETY)
    press(swinging, "Stop")
    wait_for_task(swinging)
    assert not page.run.result.report["mixed"]["converged"] and "was stopped" in words(swinging)
    run(swinging, CONTINUE)
    assert np.array_equal(page.run.result.yarns.points, drape(SWINGING).yarns.points)
    with pytest.raises(Exception, match="hidden"):
        swinging.controls.find(CONTINUE)
    swinging.controls.find(RUN_AGAIN)


def test_a_large_run_is_sketched_while_it_goes_on_and_whole_when_it_pauses_or_ends(swinging, monkeypatch):
    monkeypatch.setattr(drape_page, "LARGE", 10)
    page = page_of(swinging)
    with alone():  # The run cannot go on before it is paused.
        press(swinging, RUN)
        call(swinging, page.run.live.control.pause)
        call(swinging, page.run.live.control.step)
    for _ in range(int(SAFETY / 0.02)):
        if page.run.live.newest is not None:
            break
        swinging.app.queue.settle(SAFETY)
    call(swinging, page.refresh)
    assert "viewed" in swinging.scene.drawings and "sketched yarns" not in swinging.scene.drawings
    state = page.run.live.newest.state
    sketch = DrapedSketch(state)
    sketch.draw(swinging.scene, alpha=False)
    lines, nodes = swinging.scene.drawings["sketched yarns"].segments, state.end.nodes
    region, yarns = state.prepared.region, state.prepared.fabric.yarns
    runs = [np.flatnonzero(region.node_number[each] >= 0) for each in np.split(yarns.yarn_node, yarns.yarn_start[1:-1])]
    assert len(lines) == sum(len(run) - 1 for run in runs if len(run))  # each run of simulated nodes is one piece
    assert {tuple(point) for point in lines.reshape(-1, 3).tolist()} <= {tuple(node) for node in nodes.tolist()}
    assert np.isin(swinging.scene.drawings["viewed surface"].points, state.end.vertices).all()
    sketch.clear(swinging.scene)
    call(swinging, page.run.live.control.resume)
    call(swinging, page.refresh)
    if page.run.live is not None:
        assert "sketched yarns" in swinging.scene.drawings and "viewed" not in swinging.scene.drawings
    wait_for_task(swinging)
    assert "viewed" in swinging.scene.drawings and "sketched yarns" not in swinging.scene.drawings
    assert swinging.notices() == ""


def test_the_lines_of_a_sketch_are_bounded(monkeypatch):
    prepared = prepare(replace(SWINGING, region=RegionSection(yarns="all")))
    yarns, region = prepared.fabric.yarns, prepared.region
    whole = SketchLines.of(yarns, region)
    for most in (3, 10, 60):
        monkeypatch.setattr(draped_sketch, "MOST_LINES", most)
        monkeypatch.setattr(draped_sketch, "PIECE", 1)
        lines = SketchLines.of(yarns, region)
        longest = int(np.diff(yarns.yarn_start).max())
        assert 0 < len(lines.node) <= most + longest and set(lines.yarn) <= set(whole.yarn)


def test_frames_are_chosen_and_the_page_view_shows_the_run(swinging):
    run(swinging, RUN)
    page = page_of(swinging)
    result = page.run.result
    call(swinging, swinging.controls.set, "Moment", 0.0)
    swinging.app.queue.settle(SAFETY)
    assert np.array_equal(swinging.scene.drawings["viewed"].points, result.yarns_at(result.frames[0]).points)
    call(swinging, swinging.controls.press, "Frames", "Next frame")
    swinging.app.queue.settle(SAFETY)
    assert np.array_equal(swinging.scene.drawings["viewed"].points, result.yarns_at(result.frames[1]).points)
    call(swinging, swinging.controls.set, "Show", "Scene")
    assert "cloth" in swinging.scene.drawings and "viewed" not in swinging.scene.drawings
    press(swinging, "Look on the page View")
    assert swinging.notices() == ""
    assert "The run in run is finished." in words(swinging)
    assert np.array_equal(swinging.scene.drawings["viewed"].points, result.yarns.points)


def test_a_result_belongs_to_its_scene(swinging, tmp_path):
    """After a change the page says so; with another cloth the result is forgotten."""
    run(swinging, RUN)
    call(swinging, swinging.controls.set, "Hybrid rings", 2)
    assert "The scene has changed since the run" in words(swinging)
    press(swinging, "Undo")
    assert "The run has converged" in words(swinging)
    write_scene(tmp_path / "other.toml", replace(SWINGING, cloth=replace(SWINGING.cloth, rectangle=(4.0, 3.0))))
    open_file(swinging, tmp_path / "other.toml")
    assert page_of(swinging).run.result is None and "run" not in words(swinging)
    open_file(swinging, tmp_path / "swinging.toml")
    assert "The run has converged" in words(swinging)


def test_a_project_comes_back_with_its_scene_its_result_and_its_history(swinging):
    for rings in (3, 2, 4):
        call(swinging, swinging.controls.set, "Hybrid rings", rings)
    press(swinging, "Undo")
    run(swinging, RUN)
    scene, points = opened(swinging).scene, page_of(swinging).run.result.yarns.points
    swinging.app._pages.clear()
    call(swinging, swinging.app.open_page, "Drape")
    wait_for_task(swinging)
    assert opened(swinging).scene == scene
    assert np.array_equal(page_of(swinging).run.result.yarns.points, points)
    for button, rings in (("Redo", 4), ("Undo", 2), ("Undo", 3), ("Undo", 1)):
        press(swinging, button)
        assert region(swinging).rings == rings
    kept = {path.name for path in page_of(swinging).session.history_folder.iterdir()}
    assert len(kept) == 3 + 1  # three scenes to come again, and their order


def test_a_damaged_history_is_forgotten_and_one_of_another_scene_is_not_redone(tmp_path):
    other = replace(SWINGING, duration=0.03)
    history = SceneHistory(SWINGING).changed(other).changed(replace(SWINGING, duration=0.04)).undone()
    write_history(tmp_path, history)
    assert read_history(tmp_path, other) == history
    by_hand = replace(SWINGING, duration=0.05)
    assert read_history(tmp_path, by_hand) == SceneHistory(by_hand, (SWINGING,))
    (tmp_path / name_of(SWINGING)).write_text("[cloth]\n")
    assert read_history(tmp_path, other) == SceneHistory(other)


def test_the_example_and_the_stitches_of_the_project_are_opened(tmp_path):
    with headless(tmp_path, None, "Drape") as shown:
        press(shown, "Take the example")
        wait_for_task(shown)
        assert opened(shown).counts["yarn_nodes_full"] > 0
        write_stitches(tmp_path / "own.h5", tessellate(label(grid(2, 2)), stitch_width=0.5))
        call(shown, shown.app.project.import_mesh, "own.h5", (tmp_path / "own.h5").read_bytes())
        call(shown, shown.app.open_page, "Drape")
        press(shown, "Take the stitches of the garment")
        wait_for_task(shown)
        assert opened(shown).fabric.face_count == shown.project.fabric.face_count
        assert opened(shown).prepared.fabric.yarns.kind == "knit"
        call(shown, shown.controls.set, "Yarns", "everywhere")
        assert opened(shown).trouble == ""  # its border is held by yarns too
        assert shown.notices() == ""


BAD = {
    "by words": (("set", "By words", "sleeve"), ("press", "These", "Add"), "got panel 'sleeve'; expected one of panel"),
    "beyond": (("set", "By words", "faces 900"), ("press", "These", "Add"), "got triangle 900; expected 0 to"),
    "box": (("set", "Box from", "1, 2"), ("press", "Box", "Add box"), "box from: got '1, 2'; expected three numbers"),
    "away": (("set", "Box from", "1, 2, 90"), ("press", "Box", "Add box"), "got low [1.0, 2.0, 90.0] above high"),
    "save": (("set", "Folder", ""), ("press", "Save there"), "save: got nothing; expected a folder"),
}


@pytest.mark.parametrize("case", BAD.values(), ids=BAD)
def test_what_is_not_possible_is_one_line_and_changes_nothing(swinging, case):
    before = opened(swinging).scene
    for act in case[:-1]:
        call(swinging, getattr(swinging.controls, act[0]), *act[1:])
    assert case[-1] in swinging.notices() and "\n" not in swinging.notices()
    assert opened(swinging).scene == before


def test_files_that_are_no_scene_are_refused_in_one_line(swinging, tmp_path):
    before = opened(swinging).scene
    (tmp_path / "wrong.toml").write_text("[cloth]\nrectangel = [3, 3]\n")
    (tmp_path / "flat.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    for name in ("wrong.toml", "flat.obj", "missing.toml", "shirt.txt"):
        swinging.front.notices.clear()
        open_file(swinging, tmp_path / name)
        assert name.split(".")[0] in swinging.notices() and "\n" not in swinging.notices()
    assert opened(swinging).scene == before


def test_a_region_that_is_not_possible_is_said_beside_the_counts_and_does_not_run(shown, tmp_path):
    away = replace(MIDDLE, low=(90.0, 0.0, 0.0), high=(91.0, 1.0, 1.0))
    scene: Scene = replace(SWINGING, region=RegionSection(boxes=(away,)))
    write_scene(tmp_path / "away.toml", scene)
    open_file(shown, tmp_path / "away.toml")
    assert "holds no triangle of the cloth" in words(shown)
    press(shown, RUN)
    assert "holds no triangle of the cloth" in shown.notices() and not shown.app.tasks.running


def test_a_region_that_takes_hold_of_nothing_is_said_before_it_runs(shown, tmp_path):
    """The upper border is held by vertices alone; with yarns there, nothing would hold them."""
    box = replace(SWINGING.attachments[0].boxes[0], low=(-1.0, 2.95, -1.0))
    scene = replace(SWINGING, attachments=(replace(SWINGING.attachments[0], boxes=(box,)),))
    write_scene(tmp_path / "loose.toml", scene)
    open_file(shown, tmp_path / "loose.toml")
    assert "none of its yarn nodes" not in words(shown)
    call(shown, shown.controls.set, "Yarns", "everywhere")
    assert "none of its yarn nodes" in words(shown)
    assert (opened(shown).region.triangle_kind == YARNS).all()  # it is shown nevertheless


def test_the_scene_does_not_change_while_it_runs(swinging):
    with alone():
        press(swinging, RUN)
        call(swinging, swinging.controls.set, "Hybrid rings", 2)
        assert "stop that first, or wait" in swinging.notices()
        assert swinging.controls.find("Hybrid rings").value == 1
    wait_for_task(swinging)
    assert region(swinging).rings == 1
