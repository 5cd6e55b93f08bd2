# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Drape without a browser: scenes are opened, and their region is chosen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.app.pages.drape.page import RUN
from stitchmesh.app.scene.drawing import Surface
from stitchmesh.app.scene.scene import Stroke
from stitchmesh.io import write_stitches
from stitchmesh.labeling import label
from stitchmesh.mixed.drape import drape
from stitchmesh.mixed.enrichment.region import YARNS
from stitchmesh.mixed.memory import estimate_memory
from stitchmesh.mixed.output.report import region_counts
from stitchmesh.mixed.placement.chosen_region import triangles_of_faces
from stitchmesh.mixed.scene.region_section import RegionSection
from stitchmesh.mixed.scene.scene import Scene, read_scene, write_scene
from stitchmesh.mixed.scene.scene_fabric import prepare
from stitchmesh.selection import select
from stitchmesh.tessellate import tessellate
from tests.app.pages.drape.on_page import EYE, open_file, opened, page_of, paint, region, words
from tests.app.pages.headless import call, headless, press, wait_for_task
from tests.gallery import grid
from tests.mixed.small_scene import MIDDLE, SWINGING


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
    assert len(np.unique(cloth.colours.index)) == len(np.unique(opened(swinging).region.triangle_kind)) == 3
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


def test_the_budget_of_an_automatic_region_is_a_number_of_nodes_or_a_time(swinging):
    call(swinging, swinging.controls.set, "Yarns", "where triangles err")
    call(swinging, swinging.controls.set, "Budget", "time of a step")
    call(swinging, swinging.controls.set, "Time of a step [s]", 0.25)
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
