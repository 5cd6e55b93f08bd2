# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Runs on the page Drape without a browser: as in Python, stopped, continued, sketched, and kept."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.app.pages.drape import page as drape_page
from stitchmesh.app.pages.drape.drape_session import name_of, read_history, write_history
from stitchmesh.app.pages.drape.page import CONTINUE, RUN, RUN_AGAIN
from stitchmesh.app.pages.view import draped_view
from stitchmesh.app.pages.view.draped_view import DrapedSketch, SketchLines
from stitchmesh.cli.main import main
from stitchmesh.compute.device import alone
from stitchmesh.editing.undo_history import UndoHistory
from stitchmesh.mixed.drape import drape
from stitchmesh.mixed.scene.region_section import RegionSection
from stitchmesh.mixed.scene.scene import read_scene, write_scene
from stitchmesh.mixed.scene.scene_fabric import prepare
from tests.app.pages.drape.on_page import open_file, opened, page_of, region, run, run_to_a_pause, words
from tests.app.pages.headless import SAFETY, call, press, wait_for_task
from tests.mixed.small_scene import SWINGING


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
    run_to_a_pause(swinging)
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
    run_to_a_pause(swinging)
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
        monkeypatch.setattr(draped_view, "MOST_LINES", most)
        monkeypatch.setattr(draped_view, "PIECE", 1)
        lines = SketchLines.of(yarns, region)
        longest = int(np.diff(yarns.yarn_start).max())
        assert 0 < len(lines.node) <= most + longest and set(lines.yarn) <= set(whole.yarn)


def test_frames_are_chosen_and_the_page_view_shows_the_run(swinging):
    run(swinging, RUN)
    page = page_of(swinging)
    result = page.run.result
    call(swinging, swinging.controls.set, "Moment", 0.0)
    call(swinging, swinging.controls.press, "Frames", "Next frame")
    swinging.app.queue.settle(SAFETY)
    assert np.array_equal(swinging.scene.drawings["viewed"].points, result.yarns_at(result.frames[1]).points)
    call(swinging, swinging.controls.set, "Show", "Scene")
    assert "cloth" in swinging.scene.drawings and "viewed" not in swinging.scene.drawings
    press(swinging, "Look on the page View")
    assert swinging.notices() == ""
    assert "The run in the folder run is finished." in words(swinging)
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
    history = UndoHistory(SWINGING).do(other).do(replace(SWINGING, duration=0.04)).undo("none")
    write_history(tmp_path, history)
    assert read_history(tmp_path, other) == history
    by_hand = replace(SWINGING, duration=0.05)
    assert read_history(tmp_path, by_hand) == UndoHistory(by_hand, (SWINGING,))
    (tmp_path / name_of(SWINGING)).write_text("[cloth]\n")
    assert read_history(tmp_path, other) == UndoHistory(other)


def test_the_scene_does_not_change_while_it_runs(swinging):
    with alone():
        press(swinging, RUN)
        call(swinging, swinging.controls.set, "Hybrid rings", 2)
        assert "stop that first, or wait" in swinging.notices()
        assert swinging.controls.find("Hybrid rings").value == 1
    wait_for_task(swinging)
    assert region(swinging).rings == 1
