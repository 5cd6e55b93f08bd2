# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page View in a real browser: near yarns are tubes, far ones lines; clicks measure; a picture is saved."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from io import BytesIO
from typing import TYPE_CHECKING

import numpy as np
import pytest
from PIL import Image

from stitchmesh.app.scene.drawing import IN_PLACE, YarnTubes
from stitchmesh.app.scene.levels_of_detail import LEVELS
from stitchmesh.io.meshes import write_mesh
from stitchmesh.io.yarns import read_yarns, write_yarns
from stitchmesh.render.yarn_blocks import make_blocks
from tests.gallery import ROOT
from tests.gallery import tube as quad_tube
from tests.yarn.test_strand_distance import lines
from tests.yarnrelax.stockinette import tube

if TYPE_CHECKING:
    from tests.app.browser import Rig

COMPLETE = """(version) => {
  const found = Object.values(window.stitchmeshYarns.report());
  return found.length > 0 && found.every((one) => one.waiting === 0 && one.version >= version);
}"""
REPORT = "() => Object.values(window.stitchmeshYarns.report())[0]"
VERTICES = """() => {
  const set = [...window.stitchmeshYarns.sets.values()][0], found = [];
  for (const part of set.parts) {
    const array = part.object.geometry.attributes.position.array;
    for (let i = 0; i < array.length; i += 3) found.push([array[i], array[i + 1], array[i + 2]]);
  }
  return found;
}"""
NORMALS = VERTICES.replace("position", "normal").replace("i += 3", "i += 4")
BUDGET_OF_ONE = """() => {
  const set = [...window.stitchmeshYarns.sets.values()][0];
  Object.defineProperty(set, "moving", { get: () => 1, set: () => {} });
  window.levelsSeen = [];
  const watch = () => {
    if (![...window.stitchmeshYarns.sets.values()].includes(set)) return;
    if (set.version > 1) window.levelsSeen.push(Object.values(window.stitchmeshYarns.report())[0].levels);
    requestAnimationFrame(watch);
  };
  watch();
}"""
"""Lets a page draw one triangle while yarns move, and notes the levels in each of its frames."""
LINES_ONLY = "() => [...window.stitchmeshYarns.sets.values()][0].parts.every((part) => part.object.isLine)"


def complete(rig, version: int = 1) -> dict:
    """Wait until all yarns have the detail that they need, and return what is drawn."""
    rig.settle()
    rig.browser_page.wait_for_timeout(200)  # the script looks at the cameras twelve times a second
    rig.browser_page.wait_for_function(COMPLETE, arg=version)
    return rig.browser_page.evaluate(REPORT)


def drawn(rig, yarns) -> YarnTubes:
    """Draw yarns in red, in place of what the page shows."""
    red = np.tile(np.array([200, 30, 30], dtype=np.uint8), (len(yarns.points), 1))
    drawing = YarnTubes(make_blocks(yarns), yarns.points, red)
    rig.call(rig.app.scene.show, "viewed", drawing)
    rig.call(rig.app.scene.look_at, yarns.points.min(axis=0), yarns.points.max(axis=0), "front")
    return drawing


def stand_at(rig, distance: float) -> None:
    """Place the camera in front of the origin."""
    rig.client.camera.position = (0.0, 0.5, distance)
    rig.client.camera.look_at = (0.0, 0.5, 0.0)


@pytest.fixture
def rig(app_in_browser) -> Iterator[Rig]:
    with app_in_browser(page="View") as opened:
        yield opened


def test_tubes_lie_around_the_curves_face_outwards_in_their_colour_and_move_with_the_next_frame(rig):
    """Each vertex of a tube is a little more than a radius away from its curve, along its normal."""
    yarns = lines(0.0, 1.0)
    drawing = drawn(rig, yarns)
    assert len(complete(rig)["levels"]) == len(LEVELS)
    vertices = np.array(rig.browser_page.evaluate(VERTICES))
    normals = np.array(rig.browser_page.evaluate(NORMALS)) / 127
    height = np.where(vertices[:, 1] > 0.5, 1.0, 0.0)
    away = vertices - np.stack([vertices[:, 0], height, np.zeros(len(vertices))], axis=1)
    radius = np.linalg.norm(away, axis=1)
    # polygons of the mean width of a circle have corners 1 to 21 % beyond it; packing adds a thousandth
    assert (radius > 0.1).all() and (radius < 0.122).all()
    outward = np.einsum("ij,ij->i", away / radius[:, None], normals)
    assert (outward > 0.98).all()  # normals have eight bits
    assert vertices[:, 0].max() <= 4.0 and vertices[:, 0].min() >= 0.0
    rig.settle()
    pixels = np.asarray(Image.open(BytesIO(rig.screenshot())).convert("RGB")).astype(int)
    red = (pixels[..., 0] > pixels[..., 1] + 60) & (pixels[..., 0] > pixels[..., 2] + 60)
    assert red.sum() > 500  # two lines of 400 pixels, several pixels wide
    rig.call(rig.app.scene.show, "viewed", replace(drawing, points=drawing.points + np.array([0.0, 0.0, 0.5])))
    complete(rig, version=2)
    moved = np.array(rig.browser_page.evaluate(VERTICES)) - vertices
    # both frames are packed with steps of a hundred-thousandth of the size
    np.testing.assert_allclose(moved, np.tile([0.0, 0.0, 0.5], (len(vertices), 1)), atol=1e-3)


@pytest.mark.nightly
def test_near_yarns_are_tubes_and_far_ones_lines(rig):
    drawn(rig, tube(6, 30))
    stand_at(rig, 6.0)
    near = complete(rig)
    assert sum(near["levels"][:3]) == near["parts"]
    far_plane = rig.client.camera.far
    stand_at(rig, 900.0)
    rig.client.camera.far = 10_000.0
    rig.wait_for(lambda: rig.browser_page.evaluate(LINES_ONLY), "lines far away")
    far = complete(rig)
    assert far["levels"][-1] + far["levels"][-2] == far["parts"]
    assert 20 * far["triangles"] < near["triangles"]
    stand_at(rig, 6.0)
    rig.wait_for(lambda: sum(complete(rig)["levels"][:3]) == near["parts"], "tubes again")
    rig.client.camera.far = far_plane


@pytest.mark.nightly
def test_yarns_that_move_are_tubes_also_where_the_page_draws_slowly(rig):
    drawing = drawn(rig, tube(6, 30))
    complete(rig)
    rig.browser_page.wait_for_timeout(700)  # the camera stands
    rig.browser_page.evaluate(BUDGET_OF_ONE)
    rig.call(rig.app.scene.show, "viewed", replace(drawing, points=drawing.points + np.array([0.0, 0.0, 0.5])))
    rig.wait_for(lambda: rig.browser_page.evaluate("() => window.levelsSeen.length > 0"), "a frame")
    complete(rig, version=2)
    lines_seen = [sum(levels[-2:]) for levels in rig.browser_page.evaluate("() => window.levelsSeen")]
    assert lines_seen and not any(lines_seen)


def test_copies_are_drawn_at_their_places(rig):
    positions = "() => [...window.stitchmeshYarns.sets.values()][0].parts.map((part) => part.object.position.toArray())"
    drawing = drawn(rig, lines(0.0))
    assert (drawing.copies == IN_PLACE).all()
    copies = np.array([[0.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 4.0, 0.0]])
    rig.call(rig.app.scene.show, "viewed", replace(drawing, copies=copies))
    assert complete(rig)["parts"] == 3
    np.testing.assert_allclose(rig.browser_page.evaluate(positions), copies)
    rig.call(rig.app.scene.show, "viewed", replace(drawing, copies=copies + 0.5))
    rig.wait_for(lambda: rig.browser_page.evaluate(positions)[0] == [0.5, 0.5, 0.5], "moved copies")


@pytest.mark.nightly
def test_a_second_browser_and_a_reload_see_the_same_yarns(rig):
    drawn(rig, lines(0.0, 1.0))
    complete(rig)
    other = rig.another_window()
    other.browser_page.wait_for_function(COMPLETE, arg=1)
    assert other.browser_page.evaluate(REPORT)["parts"] == rig.browser_page.evaluate(REPORT)["parts"]
    other.close()
    rig.browser_page.reload()
    rig.wait_until_ready()
    complete(rig)


def test_a_user_opens_a_file_reads_measures_cuts_and_saves(rig, tmp_path):
    yarns = lines(0.0, 1.0)
    write_yarns(tmp_path / "lines.h5", yarns)
    rig.upload(tmp_path / "lines.h5")
    rig.wait_for_text("lines.h5")
    complete(rig)
    assert rig.browser_page.locator(".sm-frames").count() == 0
    rig.tick("Frame rate")
    rig.wait_for_text("frames/s")
    rig.click_at([1.0, 1.0, 0.1])
    rig.wait_for_text("Yarn 1, row 1")
    rig.tick("Measure")
    rig.click_at([1.0, 1.0, 0.1])
    rig.click_at([3.0, 1.0, 0.1])
    rig.wait_for_text("cm along the yarn")
    measured = float(rig.browser_page.get_by_text("along the yarn").first.inner_text().split()[0])
    # two clicks hit within a pixel, which is 0.01 cm here
    assert measured == pytest.approx(2.0, abs=0.03)
    rig.browser_page.get_by_text("Picture", exact=True).click()
    rig.type("Width", 320)
    rig.type("Height", 200)
    name, content = rig.downloaded(lambda: rig.press("Save picture"))
    picture = Image.open(BytesIO(content))
    assert name == "view.png" and picture.size == (320, 200)
    assert len(np.unique(np.asarray(picture.convert("RGB")).reshape(-1, 3), axis=0)) > 10


@pytest.mark.nightly
def test_a_job_that_runs_is_followed_until_it_has_finished(app_in_browser, tmp_path):
    """A job of another process; the page shows its stitches or its yarns at once, and its relaxed yarns at the end."""
    write_mesh(tmp_path / "tube.obj", quad_tube(12, 4))
    job = tmp_path / "job"
    job.mkdir()
    options = ["--stitch-width", "0.5", "--quality", "draft", "--device", "cpu", "--no-picture", "-o", str(job)]
    with app_in_browser(page="View") as rig:
        rig.browser_page.get_by_label("Path", exact=True).or_(rig.row("Path").locator("input")).first.fill(str(job))
        rig.press("Open path")
        rig.wait_for_text("Waiting for the first result")
        command = [sys.executable, "-m", "stitchmesh", "knit", str(tmp_path / "tube.obj"), *options]
        with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
            while not (job / "stitches.h5").exists():
                assert process.poll() is None
            process.send_signal(signal.SIGSTOP)  # A page that looks late would see the finished job only.
            rig.wait_for_text("is running, or was stopped")
            process.send_signal(signal.SIGCONT)
            rig.wait_for_text("is finished")
        assert process.returncode == 0
        shown = rig.call(lambda: rig.app.page._viewed.thing)
        np.testing.assert_array_equal(shown.points, read_yarns(job / "yarns.h5").points)
        assert complete(rig)["waiting"] == 0
