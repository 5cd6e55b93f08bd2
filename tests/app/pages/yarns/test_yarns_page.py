# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The page Yarns, without a browser: it gives what the library gives, live, and after any interruption."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stitchmesh.app.pages.page_run import STALE
from stitchmesh.app.pages.view import thing_view
from stitchmesh.app.pages.yarns.page import CONTINUE, GENERATE, GENERATE_AGAIN, RELAX, RELAX_AGAIN, YarnsPage
from stitchmesh.app.pages.yarns.yarn_view import COLOURINGS
from stitchmesh.app.project.division import Division
from stitchmesh.app.project.project import Project
from stitchmesh.app.scene.drawing import Surface, YarnTubes
from stitchmesh.app.scene.scene import CameraView, ScreenBox
from stitchmesh.compute.device import alone
from stitchmesh.editing.edit import Edit
from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io.meshes import write_mesh
from stitchmesh.labeling.steps import LabelStep
from stitchmesh.mesh import Mesh
from stitchmesh.meshrelax import relax_mesh
from stitchmesh.pipeline.options import RelaxOptions
from stitchmesh.pipeline.yarn_relaxation import relax_with_options
from stitchmesh.quality import quality_named, quality_with
from stitchmesh.yarngen import generate_yarns
from stitchmesh.yarnrelax import Relaxation
from stitchmesh.yarnrelax.constraints.pins import Pins, pinned_points
from stitchmesh.yarnrelax.model.material import DEFAULT_MATERIAL
from tests.app.pages.headless import Headless, call, headless, on_project, press, wait_for_task
from tests.app.pages.test_even_out import uneven_tube
from tests.app.project.projects import same

MOST = 120
"""Iterations of the relaxations of these tests, which need not come to rest."""


@contextmanager
def with_even_stitches(folder: Path) -> Iterator[Headless]:
    """The page on a project whose stitches are even, with choices that take little time."""
    with headless(folder, uneven_tube(), "Label") as app:
        app.project.apply_label_step(LabelStep("label_all"))
        app.project.divide(Division(stitch_width=1.3))
        assert app.project.fabric is not None and app.project.mesh is not None
        app.project.set_evened(relax_mesh(app.project.fabric, surface=app.project.mesh).fabric)
        app.app.open_page("Yarns")
        app.controls.set("Quality", "draft")
        app.controls.set("Automatic end", False)
        app.controls.set("Most iterations", MOST)
        yield app


@pytest.fixture(scope="module")
def with_yarns(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a project with generated yarns."""
    with with_even_stitches(tmp_path_factory.mktemp("yarns")) as app:
        press(app, GENERATE)
        wait_for_task(app)
        return app.project.folder


@pytest.fixture
def generated(with_yarns: Path, tmp_path: Path) -> Iterator[Headless]:
    """The page on a project with generated yarns."""
    shutil.copytree(with_yarns, tmp_path / "project")
    with on_project(Project.open(tmp_path / "project"), "Yarns") as app:
        yield app


def relaxed(project: Project, options: RelaxOptions | None = None) -> Relaxation:
    quality = quality_named(quality_with("draft", max_iterations=MOST))
    return relax_with_options(project.yarns, options or RelaxOptions(), quality=quality, fabric=project.evened)


def run_of(shown: Headless) -> Any:
    assert isinstance(shown.app.page, YarnsPage) and shown.app.page._run.live is not None
    return shown.app.page._run.live


def paused_at(shown: Headless, steps: int, button: str = RELAX) -> Any:
    """Start a relaxation, let it make some steps, and return the run while it is paused."""
    with alone():  # The relaxation cannot begin before it is paused.
        press(shown, button)
        press(shown, "Pause")
    run = run_of(shown)
    run.control.step(steps)
    while run.newest is None or run.newest.iteration < 20 * steps:
        shown.app.queue.settle()
    shown.app.queue.settle()  # The snapshot is kept before it is drawn.
    return run


def test_yarns_are_those_of_the_library_and_take_the_place_of_the_stitches(tmp_path: Path):
    with with_even_stitches(tmp_path) as app:
        assert set(app.scene.drawings) == {"garment", "edges"}
        press(app, GENERATE)
        wait_for_task(app)
        expected = generate_yarns(app.project.evened, quality="draft")
        assert np.array_equal(app.project.yarns.points, expected.points)
        assert set(app.scene.drawings) == {"viewed"} and app.scene.shown is not None
        drawing = app.scene.drawings["viewed"]
        assert isinstance(drawing, YarnTubes) and drawing.points is app.project.yarns.points
        assert f"{expected.yarn_count} yarns, {len(expected.points):,} control points" in app.controls.text_shown()


def test_relaxed_yarns_are_those_of_the_library_to_the_last_bit_and_are_described(generated: Headless):
    expected = relaxed(generated.project)
    assert "Reached by the relaxed yarns" not in generated.controls.text_shown()
    press(generated, RELAX)
    wait_for_task(generated)
    text = generated.controls.text_shown()
    assert "Asked for: 7.69 stitches" in text  # 10 cm / 1.3 cm
    assert "Reached by the relaxed yarns" in text
    assert "Not good yet" in text and f"after {MOST} iterations" in text
    assert all(name in text for name in ("residual", "largest strain", "closest yarns", "energy"))
    (plot,) = [control for control in generated.controls.made if control.kind == "plot"]
    assert plot.figure is not None
    assert np.array_equal(generated.project.relaxed.points, expected.yarns.points)
    assert generated.project.report["residual"] == expected.report["residual"]
    assert len(generated.project.history) == len(expected.history)
    assert generated.scene.drawings["viewed"].points is generated.project.relaxed.points
    first = generated.project.relaxed
    press(generated, RELAX_AGAIN)
    wait_for_task(generated)
    assert generated.project.relaxed is not first
    assert np.array_equal(generated.project.relaxed.points, first.points)


def test_settings_reach_the_library(generated: Headless):
    generated.controls.set("Material", "kaldor-simulation")
    generated.controls.set("Yarn length", 0.95)
    generated.controls.set("Friction", 0.3)
    generated.controls.set("Gravity", 1.0)
    generated.controls.set("Keep the shape", False)
    from stitchmesh.simulation.dead_load import Gravity
    from stitchmesh.yarn.rest_length import RestLengths
    from stitchmesh.yarnrelax.friction.friction import Friction

    settings = generated.app.page.settings
    assert same(settings.relax_options(generated.project), RelaxOptions(
        material="kaldor-simulation", rest_lengths=RestLengths(factor=0.95), terms=(Gravity(), Friction(0.3)),
        keep_shape=False,
    ))  # fmt: skip
    generated.controls.set("Material", DEFAULT_MATERIAL)
    generated.controls.set("Gravity", 0.0)
    generated.controls.set("Friction", 0.0)
    options = RelaxOptions(rest_lengths=RestLengths(factor=0.95), keep_shape=False)
    expected = relaxed(generated.project, options)
    press(generated, RELAX)
    wait_for_task(generated)
    assert np.array_equal(generated.project.relaxed.points, expected.yarns.points)


def test_a_stopped_relaxation_keeps_what_is_shown_and_continues_to_the_same_bits(generated: Headless):
    expected, before = relaxed(generated.project), generated.scene.drawings["viewed"]
    run = paused_at(generated, 2)
    now = generated.scene.drawings["viewed"]
    assert now.points is run.newest.state.points
    # Colours and structure stay the same objects, so that they are not sent again.
    assert now.colours is before.colours and now.blocks is before.blocks
    with pytest.raises(ParameterError, match="is disabled"):
        generated.controls.set("Quality", "standard")
    press(generated, "Stop")
    wait_for_task(generated)
    assert np.array_equal(generated.project.relaxed.points, run.newest.state.points)
    assert "was stopped after 40 iterations" in generated.controls.text_shown()
    press(generated, CONTINUE)
    wait_for_task(generated)
    assert np.array_equal(generated.project.relaxed.points, expected.yarns.points)
    assert [entry["iteration"] for entry in generated.project.history] == list(range(0, MOST + 1, 20))


def test_a_relaxation_continues_only_with_the_choices_with_which_it_began(generated: Headless):
    paused_at(generated, 1)
    press(generated, "Stop")
    wait_for_task(generated)
    generated.controls.find(CONTINUE)
    call(generated, generated.controls.set, "Friction", 0.3)
    with pytest.raises(ParameterError, match="is hidden"):
        generated.controls.find(CONTINUE)
    call(generated, generated.controls.set, "Friction", 0.0)
    call(generated, generated.controls.set, "Most iterations", 40)  # this one may change
    press(generated, CONTINUE)
    wait_for_task(generated)
    assert generated.project.report["iterations"] == 40 and not generated.notices()


def test_a_relaxation_whose_program_was_killed_continues_to_the_same_bits(generated: Headless, tmp_path: Path):
    expected = relaxed(generated.project)
    paused_at(generated, 2)
    generated.project.save()
    # What a killed program leaves: the folder as it is now.
    shutil.copytree(generated.project.folder, tmp_path / "left", ignore=shutil.ignore_patterns(".lock"))
    press(generated, "Stop")
    wait_for_task(generated)
    with on_project(Project.open(tmp_path / "left"), "Yarns") as again:
        assert "interrupted; it can be continued" in again.controls.text_shown()
        press(again, CONTINUE)
        wait_for_task(again)
        assert np.array_equal(again.project.relaxed.points, expected.yarns.points)


def test_yarns_of_other_settings_are_said_to_be_so(generated: Headless):
    assert "other settings" not in generated.controls.text_shown()
    generated.controls.set("Cast-on", "open")
    assert "other settings" in generated.controls.text_shown()
    press(generated, GENERATE_AGAIN)
    wait_for_task(generated)
    assert "other settings" not in generated.controls.text_shown()
    assert generated.project.yarn_settings["cast_on"] == "open"


def test_stitches_that_are_edited_meanwhile_get_no_yarns_of_the_stitches_before(generated: Headless):
    with alone():
        press(generated, RELAX)
        call(generated, generated.project.apply_edit, Edit("change_stitch", {"faces": [20], "stitch": "p"}))
    wait_for_task(generated)
    assert generated.project.relaxed is None and STALE in generated.notices()


def middle_point(shown: Headless) -> tuple[int, np.ndarray]:
    """A stitch, and a control point of it in front of all others, with neighbours of the same stitch."""
    yarns = shown.project.yarns
    inside = np.all([np.roll(yarns.face, shift) == yarns.face for shift in (-2, -1, 1, 2)], axis=0) & (yarns.face >= 0)
    point = int(np.where(inside, yarns.points[:, 2], -np.inf).argmax())
    return int(yarns.face[point]), yarns.points[point]


def test_a_click_pins_a_stitch_and_the_next_click_frees_it(generated: Headless):
    face, point = middle_point(generated)
    call(generated, generated.click, point)
    assert generated.app.page.settings.pins == ()  # clicks pin nothing before the user says so
    generated.controls.set("Pin by clicking", True)
    call(generated, generated.click, point)
    assert generated.app.page.settings.pins == (face,)
    assert isinstance(generated.scene.drawings["pins"], Surface)
    assert "1 stitch held" in generated.controls.text_shown()
    call(generated, generated.click, point)
    assert generated.app.page.settings.pins == () and "pins" not in generated.scene.drawings


def test_a_box_pins_the_stitches_in_it_and_they_do_not_move(generated: Headless):
    yarns = generated.project.yarns
    generated.controls.set("Pin by clicking", True)
    camera = CameraView(np.array([0.0, 2.0, 30.0]), np.array([0.0, 1.0, 0.0, 0.0]), 0.6, 1.0)
    call(generated, generated.app.page.boxed, ScreenBox(camera, (0.0, 0.0), (0.5, 0.5)))
    pins = generated.app.page.settings.pins
    assert 0 < len(pins) < generated.project.evened.face_count
    press(generated, RELAX)
    wait_for_task(generated)
    held = pinned_points(yarns, Pins(faces=pins))
    # Positions are rounded to float32 by the solver of this quality.
    np.testing.assert_allclose(generated.project.relaxed.points[held], yarns.points[held], atol=1e-5)
    press(generated, "Remove all pins")
    assert generated.app.page.settings.pins == ()


def test_pins_of_stitches_that_exist_no_more_are_refused_before_anything_runs(generated: Headless):
    call(generated, lambda: generated.app.page._set(pins=(10_000,)))
    press(generated, RELAX)
    assert "stitch 10000 does not exist any more" in generated.notices() and not generated.app.tasks.running


def body_bytes(folder: Path) -> bytes:
    """A closed body inside the garment."""
    from tests.gallery import closed_cone

    path = folder / "body.obj"
    cone = closed_cone(8)
    write_mesh(path, Mesh(vertices=0.3 * cone.vertices, face_start=cone.face_start, face_vertex=cone.face_vertex,
                          twin=cone.twin))  # fmt: skip
    return path.read_bytes()


def test_the_program_chooses_the_radius_until_the_user_does(generated: Headless):
    with pytest.raises(ParameterError, match="is hidden"):
        generated.controls.find("Yarn radius [cm]")
    call(generated, generated.controls.set, "Automatic yarn radius", False)
    radius = generated.controls.find("Yarn radius [cm]").value
    assert generated.app.page.settings.yarn_radius == radius > 0.0
    call(generated, generated.controls.set, "Automatic yarn radius", True)
    assert generated.app.page.settings.yarn_radius == 0.0


def test_a_body_is_kept_in_the_project_drawn_and_used(generated: Headless, tmp_path: Path):
    content = body_bytes(tmp_path)
    generated.controls.send("Choose a body", "../../cone.obj", content)
    assert generated.app.page.settings.body == "cone.obj"
    assert (generated.project.folder / "bodies" / "cone.obj").read_bytes() == content
    assert isinstance(generated.scene.drawings["body"], Surface)
    press(generated, RELAX)
    wait_for_task(generated)
    assert generated.project.relaxed is not None and "body" in generated.project.report["energies"]
    press(generated, "Remove the body")
    assert "body" not in generated.scene.drawings and generated.app.page.settings.body == ""


def test_a_body_that_cannot_be_read_is_refused_and_takes_no_place_of_another(generated: Headless, tmp_path: Path):
    content = body_bytes(tmp_path)
    generated.controls.send("Choose a body", "cone.obj", content)
    for name in ("broken.obj", "cone.obj"):
        with pytest.raises(FileError, match=f"^{name}:"):
            generated.controls.send("Choose a body", name, b"v 1 2\nf 1 2 3\n")
    kept = [(path.name, path.read_bytes()) for path in (generated.project.folder / "bodies").iterdir()]
    assert kept == [("cone.obj", content)] and generated.app.page.settings.body == "cone.obj"


def test_every_colouring_colours_the_yarns(generated: Headless):
    for colouring in COLOURINGS:
        call(generated, generated.controls.set, "Colours show", colouring)
        drawing = generated.scene.drawings["viewed"]
        assert drawing.colours.shape == drawing.points.shape and not generated.notices()


def test_settings_of_another_version_do_not_stop_the_page(generated: Headless):
    call(generated, generated.project.set_settings, "Yarns", {"choices": {"quality": 3, "unknown": 1}})
    call(generated, generated.app.open_page, "Yarns")
    assert generated.controls.find("Quality").value == "standard"


def test_colours_that_take_long_are_found_while_the_page_answers(generated: Headless, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(thing_view, "SLOW_COLOURS", {"contact": 0})
    call(generated, generated.controls.set, "Colours show", "Contact force")
    wait_for_task(generated)
    assert "dyn/cm contact" in generated.controls.text_shown()
    assert generated.controls.find("Colours show").value == "Contact force"


def test_colours_that_take_long_wait_for_the_end_of_a_relaxation(
    generated: Headless, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(thing_view, "SLOW_COLOURS", {"contact": 0})
    paused_at(generated, 1)
    call(generated, generated.controls.set, "Colours show", "Contact force")
    assert "relaxing the yarns is still running" in generated.notices()
    assert generated.controls.find("Colours show").value == "Colours of the yarns"
    press(generated, "Stop")
    wait_for_task(generated)
