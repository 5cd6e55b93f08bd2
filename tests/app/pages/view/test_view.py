# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page View without a browser: files, results of the project and jobs are drawn, coloured, cut and measured."""

from __future__ import annotations

import json
import os
import re
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stitchmesh.app.pages.view import opened as opened_files
from stitchmesh.app.pages.view import thing_view
from stitchmesh.app.pages.view.opened import job_files
from stitchmesh.app.project.project import Project
from stitchmesh.app.scene.drawing import Colours, Surface, YarnTubes
from stitchmesh.errors import ParameterError
from stitchmesh.io.folder_lock import FolderLock
from stitchmesh.io.history import write_history
from stitchmesh.io.meshes import write_mesh
from stitchmesh.io.stitches import write_stitches
from stitchmesh.io.yarns import write_yarns
from stitchmesh.jobs.job_status import JobLog, StageStatus
from stitchmesh.labeling import start_labeling, write_labeling
from stitchmesh.mesh import Mesh
from stitchmesh.quality import PRESETS
from stitchmesh.run import Checkpoints, Run
from stitchmesh.yarnrelax import relax_yarns
from tests.app.pages.headless import SAFETY, Headless, face_middle, headless, on_project
from tests.app.project.projects import relaxed_project
from tests.gallery import tube
from tests.io.test_history import ENTRIES
from tests.render.test_pictures import fabric
from tests.yarn.test_strand_distance import lines
from tests.yarnrelax.stockinette import tube as yarn_tube
from tests.yarnrelax.stockinette import woven_cell

PNG = b"\x89PNG\r\n\x1a\n" + bytes(40)


@pytest.fixture
def view(tmp_path) -> Iterator[Headless]:
    with headless(tmp_path, None, "View") as page:
        yield page


def opened(page: Headless, path: Path) -> None:
    """Open a path as a user does; an error becomes a notice."""
    page.controls.set("Path", str(path))
    page.app.page._attempt(lambda: page.controls.press("Open path"))


def yarns_drawn(page: Headless) -> YarnTubes:
    drawing = page.scene.drawings["viewed"]
    assert isinstance(drawing, YarnTubes)
    return drawing


def written(folder: Path, name: str, thing: object) -> Path:
    (write_mesh if isinstance(thing, Mesh) else write_yarns)(folder / name, thing)
    return folder / name


@contextmanager
def in_project(folder: Path) -> Iterator[Headless]:
    """The page on a project that has results of all stages."""
    with on_project(relaxed_project(folder / "project"), "View") as page:
        yield page


def test_the_newest_result_of_the_project_is_shown_first(tmp_path):
    with in_project(tmp_path) as page:
        assert yarns_drawn(page).points is page.project.relaxed.points
        assert page.controls.find("Colour by").value == "Rows"
        page.controls.act("show", "Mesh")
        drawing = page.scene.drawings["viewed"]
        assert isinstance(drawing, Surface) and len(drawing.points) == page.project.mesh.side_count
        page.controls.act("show", "Stitches")
        assert isinstance(page.scene.drawings["viewed"].colours, Colours)
        page.project.undo()
        page.app.refresh()
        assert "Relaxed yarns" not in page.controls.text_shown()


def test_yarns_of_an_uploaded_file_are_drawn_with_their_figures(view, tmp_path):
    assert "Open a file" in view.controls.text_shown() and not view.scene.drawings
    yarns = yarn_tube(6, 20)
    content = written(tmp_path, "yarns.h5", yarns).read_bytes()
    view.controls.send("Open a file", "C:\\some\\yarns.h5", content)
    np.testing.assert_array_equal(yarns_drawn(view).points, yarns.points)
    shown = view.controls.text_shown()
    assert "1,440" in shown and "6" in shown and "yarns.h5" in shown
    np.testing.assert_array_equal(view.scene.shown[0], yarns.points.min(axis=0))


def test_other_colours_change_nothing_but_the_colours(view, tmp_path):
    opened(view, written(tmp_path, "yarns.h5", yarn_tube(6, 20)))
    before = yarns_drawn(view)
    view.controls.set("Colour by", "Strain of the yarn")
    after = yarns_drawn(view)
    assert after.blocks is before.blocks and after.points is before.points
    assert not np.array_equal(after.colours, before.colours)
    assert "% strain" in view.controls.text_shown()  # the legend
    view.controls.set("Colour by", "One colour")
    view.controls.set("Colour", "#102030")
    assert (yarns_drawn(view).colours == [16, 32, 48]).all()


@pytest.mark.parametrize("leaves", [False, True])
def test_colours_that_take_long_are_a_task_and_draw_nothing_once_the_page_was_left(
    view, tmp_path, monkeypatch, leaves
):
    monkeypatch.setattr(thing_view, "SLOW_COLOURS", {"distance": 10})
    opened(view, written(tmp_path, "yarns.h5", lines(0.0, 1.0)))
    plain = yarns_drawn(view).colours
    view.app.post(view.controls.set, "Colour by", "Distance between yarns")
    if leaves:
        view.app.post(view.app.open_page, "Project")
    view.app.queue.settle()
    for thread in [one for one in threading.enumerate() if one.name == "finding the colours"]:
        thread.join()
    view.app.queue.settle()
    if leaves:
        assert "viewed" not in view.scene.drawings
    else:
        assert not np.array_equal(yarns_drawn(view).colours, plain)


def test_colours_without_their_stitches_are_refused_and_nothing_changes(view, tmp_path):
    opened(view, written(tmp_path, "yarns.h5", yarn_tube(6, 20)))
    before = yarns_drawn(view).colours
    view.controls.set("Colour by", "Stitch types")
    assert "without their stitch mesh; give the stitch mesh too" in view.notices()
    np.testing.assert_array_equal(yarns_drawn(view).colours, before)


def test_a_body_is_opened_for_the_distance_from_it(view, tmp_path):
    opened(view, written(tmp_path, "yarns.h5", yarn_tube(6, 20)))
    view.controls.set("Colour by", "Distance from a body")
    assert "give the mesh of the body too" in view.notices()
    body = written(tmp_path, "body.obj", tube(12, 4))
    view.controls.send("Open a body", "body.obj", body.read_bytes())
    assert "mm distance" in view.controls.text_shown()
    assert isinstance(view.scene.drawings["viewed body"], Surface)
    view.controls.set("Colour by", "Rows")
    assert "viewed body" not in view.scene.drawings


def test_a_periodic_cell_is_drawn_with_its_copies(view, tmp_path):
    cell = woven_cell()
    opened(view, written(tmp_path, "cell.h5", cell))
    assert len(yarns_drawn(view).copies) == 25
    low, high = view.scene.shown[:2]
    far = np.abs(cell.lattice.periods).max(axis=0)
    assert (high - low >= 4 * far - 1e-9).all()


def test_a_click_says_what_is_there(view, tmp_path):
    opened(view, written(tmp_path, "lines.h5", lines(0.0, 1.0)))
    view.click([2.0, 1.0, 0.0])
    assert "Yarn 1, row 1, strain +0.0 %" in view.controls.text_shown()
    view.click([2.0, 0.5, 0.0])  # between the yarns
    assert "Yarn 1" in view.controls.text_shown()


def test_two_clicks_measure_a_distance_and_the_length_of_yarn(view, tmp_path):
    opened(view, written(tmp_path, "lines.h5", lines(0.0, 1.0)))
    view.controls.set("Measure", True)
    view.click([1.0, 1.0, 0.0])
    assert "Click the second place" in view.controls.text_shown() and "measured line" not in view.scene.drawings
    view.click([3.0, 1.0, 0.0])
    assert "2.00 cm; 2.00 cm along the yarn" in view.controls.text_shown()
    assert view.scene.drawings["measured length"].texts == ("2.00 cm",)
    view.click([1.0, 0.0, 0.0])  # a third click begins again
    assert "measured line" not in view.scene.drawings
    view.click([1.0, 1.0, 0.0])
    assert "1.00 cm<" in view.controls.text_shown()  # two yarns have no length between them
    view.controls.set("Measure", False)
    assert "measured line" not in view.scene.drawings


def test_stitches_are_described_and_measured_without_a_mouse(tmp_path):
    with in_project(tmp_path) as page:
        page.controls.act("show", "Stitches")
        page.controls.set("Stitch", 30)
        page.controls.press("Describe")
        assert "Stitch 30 (purl), row 1" in page.controls.text_shown()
        page.controls.set("Other stitch", 31)
        page.controls.press("Measure between them")
        first, second = (face_middle(page.project.fabric, face) for face in (30, 31))
        assert page.scene.drawings["measured length"].texts == (f"{np.linalg.norm(second - first):.2f} cm",)
        page.controls.set("Stitch", 99_999)
        with pytest.raises(ParameterError, match="there is no stitch 99999 in what is shown"):
            page.controls.press("Describe")


def test_a_box_cuts_yarns_and_faces(view, tmp_path):
    yarns = lines(0.0, 1.0)
    opened(view, written(tmp_path, "lines.h5", yarns))
    whole = yarns_drawn(view)
    view.controls.set("Clip", True)
    assert len(yarns_drawn(view).blocks.source) == len(whole.blocks.source)  # a whole box cuts nothing
    view.controls.set("Top", 50.0)
    view.app.queue.settle()
    assert set(yarns.point_yarn[yarns_drawn(view).blocks.source]) == {0}
    assert len(view.scene.drawings["clip box"].segments) == 12
    view.controls.set("Bottom", 40.0)
    view.app.queue.settle()
    assert "viewed" not in view.scene.drawings  # nothing lies in the box
    view.controls.set("Clip", False)
    assert len(yarns_drawn(view).blocks.source) == len(whole.blocks.source)
    assert "clip box" not in view.scene.drawings
    opened(view, written(tmp_path, "tube.obj", tube(12, 4)))
    faces = len(view.scene.drawings["viewed"].triangles)
    view.controls.set("Clip", True)
    view.controls.set("Bottom", 0.0)
    view.app.queue.settle()
    assert len(view.scene.drawings["viewed"].triangles) == faces // 2


def test_files_without_a_thing_are_shown_in_the_panel(view, tmp_path):
    write_history(tmp_path / "convergence.csv", ENTRIES)
    opened(view, tmp_path / "convergence.csv")
    (residual,) = [curve for curve in view.app.page._plot.figure.data if curve.name == "residual"]
    assert list(residual.y) == [1.0, 0.25] and not view.scene.drawings
    (tmp_path / "report.json").write_text('{"a": "<b>"}')
    opened(view, tmp_path / "report.json")
    assert "{&quot;a&quot;: &quot;&lt;b&gt;&quot;}" in view.controls.text_shown()
    (tmp_path / "stretch.csv").write_text("strain,force\n1,2\n")  # a table that is no convergence
    opened(view, tmp_path / "stretch.csv")
    assert "strain,force" in view.controls.text_shown()
    (tmp_path / "preview.png").write_bytes(PNG)
    opened(view, tmp_path / "preview.png")
    assert "data:image/png;base64," in view.controls.text_shown()


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("yarns.h5", b"junk", "yarns.h5: is not an HDF5 file, or it is damaged; write it again"),
        ("mesh.obj", b"v 1 2\nf 1 1 1\n", "mesh.obj"),
        ("a.png", b"no picture", "a.png: is no PNG picture; expected one that StitchMesh wrote"),
        ("a.csv", b"x,\0y\n", "holds binary data; expected a text file"),
        ("a.xyz", b"1", "unknown format '.xyz'"),
        ("a" * 300 + ".h5", b"1", "cannot be opened"),
        ("a\0.h5", b"1", "cannot be opened"),
    ],
)
def test_a_file_that_cannot_be_read_is_a_notice(view, tmp_path, name, content, message):
    good = written(tmp_path, "lines.h5", lines(0.0, 1.0))
    opened(view, good)
    view.app.post(view.controls.send, "Open a file", name, content)
    view.app.queue.settle()
    assert message in view.notices() and "\n" not in view.notices()
    assert "/tmp" not in view.notices()  # the place of the upload on the server is nobody's business
    assert yarns_drawn(view) is not None


def test_files_of_each_kind_are_shown(view, tmp_path):
    """Yarns, a cell of another program, stitches, meshes, and a mesh that is partly labeled."""
    yarns, mesh = lines(0.0, 1.0), tube(8, 3)
    opened(view, written(tmp_path, "yarns.bcc", yarns))
    low, high = yarns_drawn(view).points.min(axis=0), yarns_drawn(view).points.max(axis=0)
    # the ends of an open spline that is drawn through points may reach beyond its own by a segment
    np.testing.assert_allclose([low, high], [yarns.points.min(axis=0), yarns.points.max(axis=0)], atol=0.15)
    opened(view, written(tmp_path, "cell.pyp", woven_cell()))
    assert len(yarns_drawn(view).copies) == 25
    write_stitches(tmp_path / "stitches.smobj", fabric())
    opened(view, tmp_path / "stitches.smobj")
    assert isinstance(view.scene.drawings["viewed"], Surface) and "Stitches" in view.controls.text_shown()
    opened(view, written(tmp_path, "mesh.glb", mesh))
    assert isinstance(view.scene.drawings["viewed"], Surface) and "Faces" in view.controls.text_shown()
    write_labeling(tmp_path / "labeling.h5", start_labeling(mesh))
    opened(view, tmp_path / "labeling.h5")
    assert len(view.scene.drawings["viewed"].points) == mesh.side_count and not view.notices()
    opened(view, written(tmp_path, "tubes.glb", yarns))  # tubes for renderers are no yarns
    assert "tubes.glb" in view.notices()


def test_a_checkpoint_without_its_yarns_says_what_is_missing(view, tmp_path):
    (tmp_path / "checkpoint.smc").write_bytes(b"x")
    opened(view, tmp_path / "checkpoint.smc")
    assert "put yarns.h5 of the same job beside it" in view.notices()


def test_a_job_is_followed(view, tmp_path):
    """The stitches come first; afterwards the yarns, each time that they are written."""
    job = tmp_path / "job"
    job.mkdir()
    opened(view, job)
    assert "Waiting for the first result" in view.controls.text_shown()
    write_stitches(job / "stitches.h5", fabric())
    job_changed(view, job)
    assert isinstance(view.scene.drawings["viewed"], Surface)
    first = lines(0.0, 1.0)
    write_yarns(job / "yarns.h5", first)
    job_changed(view, job)
    drawn = yarns_drawn(view)
    assert "is running, or was stopped" in view.controls.text_shown()
    write_yarns(job / "yarns.h5", replace(first, points=first.points + 0.25))
    job_changed(view, job)
    np.testing.assert_array_equal(yarns_drawn(view).points, first.points + 0.25)
    assert yarns_drawn(view).blocks is drawn.blocks and yarns_drawn(view).colours is drawn.colours
    write_history(job / "convergence.csv", ENTRIES)
    written_at = (job / "yarns.h5").stat().st_mtime_ns + 1
    os.utime(job / "convergence.csv", ns=(written_at, written_at))
    job_changed(view, job)
    assert "is finished" in view.controls.text_shown()


def test_the_stages_of_a_job_are_followed(view, tmp_path):
    """Before there are stitches too; a newer status alone draws nothing again."""
    lock = FolderLock(tmp_path, "held")
    log = JobLog(tmp_path, lock, lambda _: None)
    log.begin("label")
    opened(view, tmp_path)
    assert "The job is running after" in words(view) and "Waiting for" in words(view)
    log.end(StageStatus(name="label", key="0", kept=False, seconds=1.5))
    write_yarns(tmp_path / "yarns.h5", lines(0.0, 1.0))
    log.begin("relax_yarns")
    job_changed(view, tmp_path)
    drawn = view.scene.drawings["viewed"]
    assert "label 1.5 s relax_yarns 0%" in words(view) and "Waiting for" not in words(view)
    status = tmp_path / "status.json"
    found = json.loads(status.read_text()) | {"seconds_left": [45.0, 180.0], "note": "iteration 20"}
    for done, shown in ((0.25, "25%, 45 s to 3 min left"), (1.0, "99%")):  # its end is not reported yet
        status.write_text(json.dumps(found | {"done": done}))
        job_changed(view, tmp_path)
        assert f"relax_yarns {shown} iteration 20" in words(view)
    assert view.scene.drawings["viewed"] is drawn
    lock.release()  # as the system does when a process is killed
    job_changed(view, tmp_path)
    assert "The job was killed after" in words(view)


def test_the_newest_checkpoint_of_a_job_is_shown(view, tmp_path):
    """A checkpoint of other yarns, as one of other options, does not stand in the way of the yarns."""
    yarns, quality = yarn_tube(4, 6), replace(PRESETS["draft"], max_iterations=20)
    write_yarns(tmp_path / "yarns.h5", yarns)
    stage = tmp_path / "stages" / "relax_yarns-0"
    relaxed = relax_yarns(yarns, quality=quality, device="cpu", run=Run(False, checkpoints=Checkpoints(stage, 20)))
    opened(view, tmp_path)
    # a checkpoint holds positions in float32, from the middle of the yarns
    moved = yarns_drawn(view).points - relaxed.yarns.points
    np.testing.assert_allclose(moved - moved.mean(axis=0), 0.0, atol=1e-6)
    write_yarns(tmp_path / "yarns.h5", lines(0.0))
    os.utime(stage / "checkpoint.smc")
    job_changed(view, tmp_path)
    np.testing.assert_array_equal(yarns_drawn(view).points, lines(0.0).points)


def words(view: Headless) -> str:
    """Return the words that the page shows, with single spaces between them."""
    return " ".join(re.sub(r"<[^>]*>", " ", view.controls.text_shown()).split())


def job_changed(view: Headless, job: Path) -> None:
    """Tell the page what its watch would tell."""
    view.app.post(view.app.page._opened.take_state, job_files(job))
    view.app.queue.settle()


def test_a_job_is_watched_while_the_page_is_open(view, tmp_path, monkeypatch):
    monkeypatch.setattr(opened_files, "EVERY_SECONDS", 0.01)
    opened(view, tmp_path)
    watch = view.app.page._opened.watch
    assert watch is not None and not watch._stopped.is_set()
    (tmp_path / "other.txt").write_text("not part of a job")
    write_yarns(tmp_path / "yarns.h5", lines(0.0, 1.0))
    for _ in range(int(SAFETY / 0.01)):
        view.app.queue.settle()
        if "viewed" in view.scene.drawings:
            break
        threading.Event().wait(0.01)
    assert len(yarns_drawn(view).points) == 60
    view.app.open_page("Project")
    assert watch._stopped.is_set()
    view.app.open_page("View")
    again = view.app.page._opened.watch
    assert again is not watch and again.folder == tmp_path and not again._stopped.is_set()


def test_the_page_opens_again_where_it_was(tmp_path):
    path = written(tmp_path, "lines.h5", lines(0.0, 1.0))
    with headless(tmp_path, None, "View") as page:
        opened(page, path)
        page.controls.set("Colour by", "Strain of the yarn")
    with on_project(Project.open(tmp_path / "project"), "View") as again:
        assert len(yarns_drawn(again).points) == 60
        assert again.controls.find("Colour by").value == "Strain of the yarn"


def test_settings_that_nobody_knows_are_those_at_first(tmp_path):
    with headless(tmp_path, None, "Label") as page:
        page.project.set_settings("View", {"yarn colour": "tartan", "path": 7, "more": True})
        page.app.open_page("View")
        assert page.app.page._state.yarn_colour == "Rows" and page.app.page._state.path == ""
