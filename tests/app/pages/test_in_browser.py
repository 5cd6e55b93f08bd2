# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Each page in a real browser, once from its start to its end: what the mouse and the keyboard do is what Python does.

All tests share one page of the browser, which takes seconds to load.
"""

from __future__ import annotations

import base64
import io
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, closing
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from PIL import Image

import stitchmesh as sm
from stitchmesh.app.page_messages import LARGEST_UPLOAD
from stitchmesh.app.pages.drape.page import RUN
from stitchmesh.app.pages.even_out import START
from stitchmesh.app.pages.swatch.page import SwatchPage
from stitchmesh.app.pages.swatch.state import Look, SwatchState, state_table
from stitchmesh.app.pages.yarns.page import CONTINUE, GENERATE, RELAX
from stitchmesh.app.project.division import Division
from stitchmesh.app.project.project import Project
from stitchmesh.app.project.shaping import Shaping
from stitchmesh.compute.device import alone
from stitchmesh.editing.edit import Edit
from stitchmesh.io import write_stitches
from stitchmesh.io.meshes import write_mesh
from stitchmesh.io.stitches import read_stitches
from stitchmesh.labeling import start_labeling
from stitchmesh.labeling.steps import LabelStep
from stitchmesh.mesh import Mesh
from stitchmesh.meshrelax import relax_mesh
from stitchmesh.mixed.drape import drape
from stitchmesh.mixed.scene.scene import write_scene
from stitchmesh.patterns import apply_pattern
from stitchmesh.periodic.swatch_design import SwatchDesign
from stitchmesh.selection import select
from stitchmesh.shaping.marks import TimeMark
from stitchmesh.tessellate import tessellate
from tests.app.pages.headless import face_middle
from tests.app.pages.test_even_out import DIVISION, evened, uneven_tube, with_wide_rows
from tests.app.pages.test_rows_page import triangles_of
from tests.app.pages.yarns.test_yarns_page import MOST, relaxed
from tests.app.project.projects import LABEL_ALL, divided_project, same
from tests.app.test_accessibility import faults, faults_in_both_themes
from tests.editing.fabrics import flat
from tests.editing.random_edits import bits
from tests.gallery import tube
from tests.mixed.small_scene import SWINGING

if TYPE_CHECKING:
    from tests.app.browser import Rig

Shown = Callable[..., AbstractContextManager["Rig"]]
"""The fixture ``app_in_browser``."""
DROP = """([name, text]) => {
  const bytes = Uint8Array.from(atob(text), c => c.charCodeAt(0));
  const data = new DataTransfer();
  data.items.add(new File([bytes], name));
  const target = window.__viserMutable.canvas;
  target.dispatchEvent(new DragEvent("dragover", { bubbles: true, cancelable: true, dataTransfer: data }));
  target.dispatchEvent(new DragEvent("drop", { bubbles: true, cancelable: true, dataTransfer: data }));
}"""
BROKEN_FILES = [
    ("broken.obj", b"v 0 0 0\nf 1 2 3\n", "broken.obj"),
    ("empty.obj", b"", "empty.obj: the file is empty"),
    ("text.h5", b"no HDF5", "text.h5"),
    ("../../escape.obj", b"v a b c\n", "escape.obj"),
]
"""Names and contents of files, and what is said of them."""
FABRIC = flat(10, 12)
COLOUR_OF_FACE = """(name) => {
  let mesh = null;
  const scene = window.__viserMutable.nodeRefFromName;
  for (const key of Object.keys(scene)) if (key.startsWith(name) && !key.includes("edges")) {
    scene[key] && scene[key].traverse((part) => { if (part.isMesh && part.geometry.attributes.color) mesh = part; });
  }
  return mesh ? Array.from(mesh.geometry.attributes.color.array) : [];
}"""
"""Script that returns the colours of all corners of the triangles of a block."""


@pytest.fixture(autouse=True)
def own_folders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setenv("STITCHMESH_PROJECTS", str(tmp_path / "projects"))
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    yield


def imported(folder: Path, mesh: Mesh) -> Project:
    """A project of a mesh."""
    project = Project.create(folder)
    write_mesh(folder / "garment.obj", mesh)
    project.import_mesh("garment.obj", (folder / "garment.obj").read_bytes())
    return project


def divided(folder: Path, division: Division) -> Project:
    """A project of a tube with a waist, whose stitches are not even."""
    project = imported(folder, uneven_tube())
    project.apply_label_step(LABEL_ALL)
    project.divide(division)
    return project


def drop(rig: Rig, name: str, content: bytes) -> None:
    """Drop a file on the scene."""
    rig.browser_page.evaluate(DROP, [name, base64.b64encode(content).decode()])


def test_project_broken_files_are_refused_in_words_and_a_good_one_opens_the_next_page(
    app_in_browser: Shown, tmp_path: Path
):
    with app_in_browser(page="Project") as rig:
        drop(rig, "letter.doc", b"Dear")
        rig.wait_for_text("letter.doc: no upload of this page takes such a file")
        for name, content, said in BROKEN_FILES:
            drop(rig, name, content)
            rig.wait_for(lambda: any(said in notice and "Not possible" in notice for notice in rig.notices()), said)  # noqa: B023
        rig.browser_page.evaluate("() => { window.stitchmeshDrop.largest = 3; }")
        drop(rig, "tube.obj", b"v 0 0 0\n")
        rig.wait_for_text(f"tube.obj: is larger than {LARGEST_UPLOAD // 2**20} MiB")
        rig.browser_page.evaluate(f"() => {{ window.stitchmeshDrop.largest = {LARGEST_UPLOAD}; }}")
        assert rig.app.project.source is None
        write_mesh(tmp_path / "tube.obj", tube(12, 4, radius=18.0, height=5.0))
        rig.upload(tmp_path / "tube.obj")
        rig.wait_for_text("Label all")
        rig.wait_for_text("File uploaded successfully.")
        assert rig.app.project.mesh.face_count == 48 and rig.app.page.name == "Label"


def middle_of(mesh: Mesh, side: int) -> np.ndarray:
    return (mesh.corner_position[side] + mesh.corner_position[mesh.side_next[side]]) / 2


def face_in_row(mesh: Mesh, row: np.ndarray, number: int) -> int:
    """The face of a row that is nearest to the camera."""
    return max(np.flatnonzero(row == number).tolist(), key=lambda face: face_middle(mesh, face)[2])


def near(mesh: Mesh, side: int) -> np.ndarray:
    """A place in the face of a side, near the side."""
    return 0.85 * middle_of(mesh, side) + 0.15 * face_middle(mesh, int(mesh.side_face[side]))


def test_label_and_divide_rows_are_made_by_clicks_and_edges_get_a_number_and_a_mark(
    app_in_browser: Shown, tmp_path: Path
):
    """The steps that the clicks take are the steps that Python takes."""
    imported(tmp_path / "project", tube(12, 4, radius=6.0, height=1.5)).close()
    with app_in_browser(page="Label") as rig:
        project = rig.app.project
        mesh = project.mesh
        lowest = min(mesh.boundary_loops, key=lambda loop: mesh.corner_position[loop, 1].mean())
        border = max(lowest.tolist(), key=lambda side: middle_of(mesh, side)[2])
        rig.click_at(middle_of(mesh, border), "Shift")
        assert project.label_steps == (LabelStep("start_at_border", {"edge": border}),)
        rig.click_at(face_middle(mesh, face_in_row(mesh, project.labeling.row, 0)))
        rig.key("n")
        rig.settle()
        assert project.labeling.row_count == 3
        rig.press("Label all")
        rig.settle()
        face = face_in_row(mesh, project.labeling.row, 2)
        rig.click_at(face_middle(mesh, face))
        expected = start_labeling(mesh).start_at_edge(border).label_all()
        assert same(project.labeled, expected.flip_row(face).finish())
        rig.wait_for_text("At 24 edges the arrows of two rows do not match")
        rig.key("Control+z")
        rig.settle()
        labeled = project.labeled
        assert same(labeled, expected.finish())
        rig.press("Go on: divide into stitches")
        rig.settle()
        rig.type("Stitch width [cm]", 0.5)
        rig.settle()
        face = face_in_row(labeled, labeled.row, 2)
        course, wale = int(labeled.face_start[face]), int(labeled.left_wale[face])
        rig.click_at(near(labeled, course))
        rig.type("Number", 9)
        rig.settle()
        rig.click_at(near(labeled, wale))
        rig.tick("Marked edge")
        rig.settle()
        rig.press("Divide into stitches")
        rig.wait_for(lambda: project.fabric is not None, "the division")
        assert same(project.fabric, tessellate(labeled, stitch_width=0.5, counts={course: 9}, marked=[wale]))
        rig.button("Go on: edit the stitches").wait_for()
        rig.wait_for_text("cast on: 72")
        assert faults_in_both_themes(rig) == []


@pytest.mark.nightly
def test_rows_a_tip_is_put_and_dragged_and_the_rows_of_a_marked_border_are_knitted(
    app_in_browser: Shown, tmp_path: Path
):
    project = imported(tmp_path / "project", triangles_of(tube(12, 8)))
    draft = {"stitch_width": 1.2, "stitch_height": None, "marks": [], "up": [0.0, 1.0, 0.0], "multiple": 1}
    project.set_settings("Rows", {"draft": draft})
    project.close()
    start, middle, end = ([0.0, height, 3.0] for height in (3.0, 4.0, 5.0))
    with app_in_browser(page="Rows") as rig:

        def tip() -> np.ndarray:
            (mark,) = rig.app.project.settings("Rows")["draft"]["marks"]
            return np.array(mark["points"][0])

        rig.settle()
        rig.choose("A click", "puts a tip")
        rig.settle()
        rig.click_at(start)
        put = tip()
        assert np.allclose(put, start, atol=0.1)  # a click hits within a few pixels
        rig.drag([put, middle, end])
        assert np.allclose(tip(), end, atol=0.15)
        rig.key("Control+z")
        rig.settle()
        assert np.allclose(tip(), put)
        rig.key("x")
        rig.choose("A click", "marks a border")
        rig.settle()
        rig.click_at([0.0, 8.0, 3.0])
        rig.press("Find the stitches")
        rig.press("Knit these rows")
        rig.wait_for(lambda: rig.app.project.fabric is not None, "the stitches are in the project")
        (mark,) = rig.app.project.shaping.marks
        assert rig.app.project.shaping == Shaping(
            stitch_width=1.2, marks=(TimeMark("border", (tuple(mark.points[0]),), "begin"),)
        )
        rig.press("Go on: edit the stitches")
        rig.wait_for_text("Lay a pattern")


def test_edit_stitches_are_painted_selected_and_laid_with_the_mouse_and_with_keys(
    app_in_browser: Shown, tmp_path: Path
):
    write_stitches(tmp_path / "piece.h5", FABRIC)
    project = Project.create(tmp_path / "project")
    project.import_mesh("piece.h5", (tmp_path / "piece.h5").read_bytes())
    project.close()
    middle = lambda face: face_middle(FABRIC, face)  # noqa: E731
    with app_in_browser("Edit") as rig:

        def corner_colours() -> np.ndarray:
            """Colour of each triangle of the first block, shape (T, 4)."""
            return np.array(rig.browser_page.evaluate(COLOUR_OF_FACE, "/fabric/0/")).reshape(-1, 3, 4)[:, 0]

        purl = Edit("change_stitch", {"faces": [44], "stitch": "p"})
        before = corner_colours()
        stitch = rig.browser_page.locator('[data-action="stitch"][data-value="p"]')
        stitch.focus()
        rig.browser_page.keyboard.press("Enter")
        rig.click_at(middle(44))
        assert rig.app.project.edits == (purl,)
        changed = np.flatnonzero((corner_colours() != before).any(axis=1))
        assert changed.tolist() == [88, 89]  # The two triangles of face 44; no other colour has changed.
        rig.key("Control+z")
        rig.wait_for(lambda: rig.app.project.edits == (), "undo")
        rig.drag([middle(41), middle(44)])
        assert rig.app.project.edits == (Edit("change_stitch", {"faces": [41, 42, 43, 44], "stitch": "p"}),)
        camera = lambda: rig.call(lambda: rig.app.scene.cameras()[0].position)  # noqa: E731
        stood = camera()
        rig.drag([(5.0, 10.5, 0.0), (5.2, 10.6, 0.0)])  # beside the fabric
        rig.wait_for(lambda: not np.allclose(camera(), stood), "the view turns")
        assert len(rig.app.project.edits) == 1
        rig.key("Control+z")
        rig.press("Front")
        rig.act("stitch", "d12k")
        rig.settle()
        rig.click_at(middle(44))
        reason = "face 44: k2tog needs 2 and 1"
        rig.wait_for(lambda: any(reason in notice for notice in rig.notices()), "the reason of the refusal")
        names = rig.browser_page.evaluate("() => Object.keys(window.__viserMutable.nodeRefFromName)")
        assert any("refused/reason" in name for name in names) and rig.app.project.edits == ()
        rig.key("s")
        rig.settle()
        rig.drag([middle(22) - [0.4, 0.3, 0.0], middle(77) - [-0.4, -0.3, 0.0]], "Shift")
        faces = select(FABRIC, "rectangle 22 6x6")
        rig.wait_for_text(f"{len(faces)} stitches are selected")
        rig.act("tool", "Lay a pattern")
        rig.settle()
        rig.act("pattern", "eyelet-lace")
        rig.wait_for_text("Preview of Eyelet lace")
        rig.press("Lay the pattern")
        rig.settle()
        assert bits(rig.app.project.fabric) == bits(apply_pattern(FABRIC, "eyelet-lace", faces=faces))


def test_even_out_one_button_evens_the_stitches_out_and_a_click_outlines_uneven_rows(
    app_in_browser: Shown, tmp_path: Path
):
    divided(tmp_path / "project", DIVISION).close()
    with app_in_browser("Even out") as rig:
        rig.press(START)
        rig.wait_for(lambda: rig.app.project.evened is not None, "the stitches are even")
        rig.wait_for_text("of the sides of stitches are within 20 % of the average")
        assert np.array_equal(rig.app.project.evened.vertices, evened(rig.app.project).vertices)
        rig.call(lambda: rig.app.project.set_evened(with_wide_rows(rig.app.project.fabric)))
        rig.call(rig.app.refresh)
        rig.wait_for_text("Some rows are uneven")
        rig.settle()
        before = rig.screenshot()
        rig.act("rows", "0")
        rig.settle()
        assert rig.screenshot() != before


def evened_project(folder: Path) -> None:
    """Write a project whose stitches are even, with quick choices on the page Yarns."""
    project = divided(folder, Division(stitch_width=1.3))
    assert project.fabric is not None and project.mesh is not None
    project.set_evened(relax_mesh(project.fabric, surface=project.mesh).fabric)
    project.set_settings("Yarns", {"choices": {"quality": "draft", "most_iterations": MOST}})
    project.close()


@pytest.mark.nightly
def test_yarns_are_generated_pinned_relaxed_paused_stepped_stopped_and_continued(
    app_in_browser: Shown, tmp_path: Path
):
    evened_project(tmp_path / "project")
    with app_in_browser("Yarns") as rig:
        rig.press(GENERATE)
        rig.wait_for(lambda: rig.app.project.yarns is not None, "the yarns are generated")
        rig.settle()
        rig.open_group("Pins")
        rig.tick("Pin by clicking")
        rig.settle()
        yarns, page = rig.app.project.yarns, rig.app.page
        rig.click_at(yarns.points[yarns.points[:, 2].argmax()])
        rig.wait_for_text("1 stitch held")
        (face,) = page.settings.pins
        assert yarns.points[yarns.face == face, 2].mean() > yarns.points[:, 2].mean()  # it is on the side that is seen
        rig.press("Remove all pins")
        rig.wait_for_text("0 stitches held")
        with alone():  # The relaxation cannot begin before it is paused.
            rig.press(RELAX)
            rig.wait_for(lambda: page._run.live is not None, "the relaxation starts")
            rig.key("p")
            rig.wait_for(lambda: page._run.live.paused, "the key pauses")
        rig.key("n")
        rig.wait_for_text("Paused: iteration 20,")
        rig.press("Step")
        rig.wait_for_text("Paused: iteration 40,")
        rig.press("Stop")
        rig.wait_for_text("was stopped after 40 iterations")
        rig.press(CONTINUE)
        rig.wait_for(lambda: rig.app.project.report["iterations"] == MOST, "the relaxation ends")
        assert np.array_equal(rig.app.project.relaxed.points, relaxed(rig.app.project).yarns.points)
        rig.settle()
        rig.browser_page.locator(".js-plotly-plot").first.wait_for()


def swatch_page(rig: Rig) -> SwatchPage:
    assert isinstance(rig.app.page, SwatchPage)
    return rig.app.page


def rest(rig: Rig) -> None:
    """Wait until the fabric rests, and the browser has drawn it."""
    rig.settle()
    variant = swatch_page(rig).variant
    # Until a change is taken, the frame before it is at rest too; the limit [s] names a session that hangs.
    variant.session.wait_until_rest(120.0)
    rig.wait_for(
        lambda: variant.frame is variant.session.frame and not variant.frame.report["running"], "the fabric rests"
    )
    rig.settle()


def fabric_seen(rig: Rig) -> np.ndarray:
    """The middle of the scene, which the fabric covers, as the browser shows it, shape (h, w, 3)."""
    rig.browser_page.wait_for_timeout(400)  # The renderer draws when it is idle.
    picture = np.asarray(Image.open(io.BytesIO(rig.screenshot())).convert("RGB"), dtype=np.int64)
    (left, top), (right, bottom) = rig.place((0.25, 0.25)), rig.place((0.75, 0.75))
    return picture[int(top) : int(bottom), int(left) : int(right)]


def changed_pixels(before: np.ndarray, after: np.ndarray) -> float:
    """Part of the pixels that differ by more than the noise of two drawings of one scene."""
    return float((np.abs(after - before).max(axis=2) > 12).mean())


@pytest.mark.nightly
def test_swatch_a_dyed_thread_and_a_turned_dial_change_the_fabric_and_its_yarns_come_home(
    app_in_browser: Shown, tmp_path: Path
):
    """A plain weave, because other patterns relax for seconds."""
    project = Project.create(tmp_path / "project")
    design = SwatchDesign(sm.read_weave("plain"))
    project.set_settings("Swatch", state_table(SwatchState((design,), look=Look(columns=4, rows=4))))
    project.close()
    with app_in_browser("Swatch") as rig:
        rest(rig)
        before = fabric_seen(rig)
        # The fabric covers the middle, apart from the gaps between the yarns: the background is white.
        assert (before.min(axis=2) < 250).mean() > 0.3
        rig.act("yarn", "1")
        rig.settle()
        rig.browser_page.locator("[data-chart] canvas").focus()
        rig.browser_page.keyboard.press("w")  # dyes the weft under the cursor
        rig.wait_for(lambda: swatch_page(rig).state.design.pattern != design.pattern, "the weft is dyed")
        rest(rig)
        dyed = fabric_seen(rig)
        assert changed_pixels(before, dyed) > 0.05
        rig.type("Tightness", 1.3)
        rig.wait_for(lambda: swatch_page(rig).state.design.dials.gamma == 1.3, "the dial is turned")
        rest(rig)
        assert changed_pixels(dyed, fabric_seen(rig)) > 0.05
        rig.open_group("Download")
        name, content = rig.downloaded(lambda: rig.press("Download the yarns"))
        (tmp_path / name).write_bytes(content)
        frame = swatch_page(rig).variant.frame
        assert frame is not None
        np.testing.assert_array_equal(sm.read_yarns(tmp_path / name).points, frame.yarns.points)


def open_scene(rig: Rig, path: Path) -> None:
    """Open the small scene on the page Drape."""
    write_scene(path, SWINGING)
    rig.type("Path", path)
    rig.press("Open path")
    rig.wait_for(lambda: rig.app.page.session.opened is not None, "the scene opens")
    rig.settle()


@pytest.mark.nightly
def test_drape_a_scene_is_opened_painted_and_run(app_in_browser: Shown, tmp_path: Path):
    with app_in_browser("Drape") as rig:
        open_scene(rig, tmp_path / "swinging.toml")
        session = rig.app.page.session
        rig.choose("A drag", "adds to the region")
        rig.choose("Brush", "Triangle")
        rig.settle()
        mesh = session.opened.mesh
        corner = mesh.vertices[mesh.face_vertex.reshape(-1, 3)].mean(axis=1)
        lowest = int(np.argmin(corner[:, 1]))
        rig.click_at(corner[lowest])
        assert session.opened.scene.region.faces == (lowest,)
        rig.drag([corner[lowest], [1.5, 0.3, 0.0]])
        painted = session.opened.scene.region
        assert len(painted.faces) > 1
        rig.drag([[0.2, 0.2, 0.0], [2.8, 2.7, 0.0]], "Shift")
        assert len(session.opened.marked) > len(painted.faces) + len(SWINGING.region.boxes)
        rig.key("Control+z")
        rig.wait_for(lambda: session.opened.scene.region == painted, "undo")
        rig.press(RUN)
        rig.wait_for(lambda: rig.app.page.run.result is not None, "the run ends")
        rig.wait_for_text("The run has converged")
        rig.settle()
        assert np.array_equal(rig.app.page.run.result.yarns.points, drape(session.opened.scene).yarns.points)
        rig.type("Moment", 0)
        rig.wait_for(lambda: rig.app.page._view.frame.time == 0.0, "the first frame")


@pytest.mark.nightly
def test_downloads_are_as_the_library_writes_them_and_go_to_the_browser_that_asked(
    app_in_browser: Shown, tmp_path: Path
):
    divided_project(tmp_path / "project").close()
    with app_in_browser(page="Project") as rig, closing(rig.another_window()) as other:
        received = []
        rig.browser_page.on("download", lambda download: received.append("first"))
        other.browser_page.on("download", lambda download: received.append("second"))
        for window in (rig, other):
            window.open_group("Download")
            rig.settle()
            name, content = window.downloaded(lambda window=window: window.act("download", "stitches.h5"))
            (tmp_path / name).write_bytes(content)
            assert same(read_stitches(tmp_path / name), rig.app.project.fabric)
            rig.settle()
            other.browser_page.wait_for_timeout(300)
        assert received == ["first", "second"]


@pytest.mark.nightly
def test_a_second_browser_and_a_page_that_is_loaded_again_show_the_same(app_in_browser: Shown, tmp_path: Path):
    divided_project(tmp_path / "project").close()
    with app_in_browser(page="Project") as rig, closing(rig.another_window()) as other:
        other.wait_for_text("tube.obj, 48 faces")
        rig.page_button("Garment")
        other.wait_for_text("Label all")
        other.press("Undo")
        rig.wait_for(lambda: rig.app.project.labeled is None, "the step is undone by the other browser")
        rig.press("Label all")
        other.wait_for_text("Go on: divide into stitches")
        rig.settle()
        rig.browser_page.reload()
        rig.wait_until_ready()
        rig.settle()
        rig.wait_for_text("Go on: divide into stitches")
        other.page_button("Project")
        rig.wait_for_text("tube.obj, 48 faces")
        assert other.faults == []


@pytest.mark.nightly
def test_a_browser_that_leaves_in_the_middle_of_a_frame_ends_nothing(app_in_browser: Shown, tmp_path: Path):
    divided_project(tmp_path / "project").close()
    with app_in_browser(page="Project") as rig:
        for _ in range(2):
            other = rig.another_window()
            rig.app.post(rig.app.open_page, "Label")
            other.browser_page.goto("about:blank")
            rig.app.post(rig.app.open_page, "Project")
            other.close()
            rig.settle()
        rig.wait_for_text("tube.obj, 48 faces")
        assert len(rig.opened.server.get_clients()) == 1


@pytest.mark.nightly
def test_axe_finds_no_fault_on_the_pages_with_results_and_open_groups(app_in_browser: Shown, tmp_path: Path):
    evened_project(tmp_path / "project")
    with app_in_browser("Yarns", size=(1280, 800)) as rig:
        rig.press(GENERATE)
        rig.wait_for(lambda: rig.app.project.yarns is not None, "the yarns are generated")
        rig.settle()
        rig.press(RELAX)
        rig.wait_for(lambda: rig.app.project.relaxed is not None, "the relaxation ends")
        for group in ("Figures", "Accuracy and edges", "Lengths and forces", "Body", "Pins"):
            rig.open_group(group)
        rig.choose("Colours show", "Strain of the yarn")
        rig.settle()
        assert faults_in_both_themes(rig) == []
        rig.call(lambda: rig.app.project.set_evened(with_wide_rows(rig.app.project.fabric)))
        rig.page_button("Even out")
        rig.wait_for_text("Some rows are uneven")
        rig.open_group("Settings")
        rig.settle()
        assert faults_in_both_themes(rig) == []
        rig.page_button("Drape")
        rig.settle()
        open_scene(rig, tmp_path / "swinging.toml")
        rig.press(RUN)
        rig.wait_for_text("The run has converged")
        for group in ("Box and selection", "What is held", "Bodies", "Scene", "Save and download"):
            rig.open_group(group)
        rig.settle()
        assert faults(rig) == []
