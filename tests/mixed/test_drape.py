# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Scenes from end to end: a hanging patch in three forms, files, stopping and resuming, memory."""

from __future__ import annotations

import io
import json
import sys
from dataclasses import asdict, replace
from pathlib import Path
from typing import Literal

import numpy as np
import pytest

from stitchmesh import progress
from stitchmesh.cli.main import main
from stitchmesh.errors import ParameterError
from stitchmesh.io import read_mesh, read_yarns, write_stitches
from stitchmesh.labeling import label
from stitchmesh.mixed.crossings.crossing_material import CrossingMaterial
from stitchmesh.mixed.drape import Draped, drape
from stitchmesh.mixed.memory import check_scene_memory, estimate_memory
from stitchmesh.mixed.output.files import read_maps
from stitchmesh.mixed.scene.motion_section import AttachmentSection, BodySection, Keyframe
from stitchmesh.mixed.scene.region_section import BoxSection, RegionSection
from stitchmesh.mixed.scene.scene import (
    ClothSection,
    OutputSection,
    Scene,
    SceneSolverSection,
    YarnsSection,
    write_scene,
)
from stitchmesh.mixed.scene.scene_fabric import prepare
from stitchmesh.run import CHECKPOINT, Checkpoints, Run
from stitchmesh.run_control import RunControl
from stitchmesh.tessellate import tessellate
from stitchmesh.time_limit import TimeLimit, limited_to
from tests.gallery import grid
from tests.mixed.small_scene import stopping_after

FORMS = ("none", "chosen", "all")
STARTS: tuple[Literal["layout", "triangles"], ...] = ("layout", "triangles")
TOP = AttachmentSection(boxes=(BoxSection(low=(-1.0, 2.8, -1.0), high=(9.0, 9.0, 1.0)),))
HANGING = Scene(
    cloth=ClothSection(rectangle=(3.0, 3.0), edge_length=0.6),
    yarns=YarnsSection(weave="plain", ends=5.0, picks=5.0),
    region=RegionSection(boxes=(BoxSection(low=(0.8, 0.8, -1.0), high=(2.2, 2.2, 1.0)),)),
    attachments=(TOP,),
    solver=SceneSolverSection(device="cpu"),
    output=OutputSection(picture=False, yarns=("bcc", "h5", "usda")),
)
"""A patch of 3 cm that hangs from its upper side."""


def form(kind: str, **changes: object) -> Scene:
    return replace(HANGING, region=replace(HANGING.region, yarns=kind), **changes)


@pytest.fixture(scope="module")
def hanging() -> dict[str, Draped]:
    return {kind: drape(form(kind)) for kind in FORMS}


@pytest.mark.parametrize("kind", FORMS)
def test_a_patch_hangs_by_its_weight(hanging, kind):
    """The lower end of a strip of length L, density d and stiffness k sags by d g L^2 / 2 k under its own weight."""
    run = hanging[kind]
    mixed = run.report["mixed"]
    assert mixed["converged"]
    simulated = mixed["yarn_nodes_full"] + mixed["yarn_nodes_hybrid"]
    assert (simulated > 0, simulated == 225) == (kind != "none", kind == "all")
    shown, start = run.shown.nodes, run.prepared.fabric.yarns.world(run.prepared.fabric.cloth)
    sag = start[:, 1] - shown[:, 1]
    lowest = np.abs(start[:, 1] - 0.3) < 0.05  # above the last weft, which may slide on the ends of the warps
    assert sag[lowest].mean() == pytest.approx(0.0044, rel=0.2)  # a strip of 0.2 g/cm^2, 1.96e5 dyn/cm and 3 cm
    assert np.abs(shown[:, 2]).max() < 1e-9  # nothing pushes it out of its plane


def test_the_three_forms_hang_alike(hanging):
    """The default cloth has the stiffness and the weight of the yarns but for their loose ends."""
    sags = [hanging[kind].shown.nodes[15:30, 1].mean() for kind in FORMS]
    assert np.ptp(sags) < 0.001


def test_results_are_written_and_read_again(tmp_path, hanging):
    run = hanging["chosen"]
    run.write(tmp_path)
    curves = run.yarns
    for name in ("yarns.h5", "yarns.usda"):
        assert np.allclose(read_yarns(tmp_path / name).points, curves.points, atol=1e-6)  # USD has float32
    assert read_yarns(tmp_path / "yarns.bcc", radius=0.05).yarn_count == curves.yarn_count
    surface = read_mesh(tmp_path / "cloth.obj")
    assert surface.face_count == len(run.display.triangles)
    written = surface.vertices[surface.face_vertex].reshape(-1, 3, 3)
    assert np.allclose(written, run.shown.surface[run.display.triangles], atol=1e-6)
    maps = read_maps(tmp_path / "maps.h5")
    assert np.array_equal(maps.nodes, run.shown.nodes)
    assert maps.yarn_tension.max() > 0.0
    assert json.loads((tmp_path / "report.json").read_text())["mixed"]["yarn_nodes"] == 225


def test_tension_at_the_top_carries_the_weight(hanging):
    """In the full-yarn form the warps at the top carry the weight of all nodes below them."""
    from stitchmesh.mixed.output.files import state_maps

    run = hanging["all"]
    maps = state_maps(run.prepared.fabric, run.display, run.end)
    yarns = run.prepared.fabric.yarns
    upper = np.flatnonzero((yarns.position[yarns.yarn_node, 1] > 2.5) & (yarns.yarn_coordinate == 1))
    tension = maps.yarn_tension[upper][maps.yarn_tension[upper] > 0.0].max()
    length = (2.6 + 0.1) + 14 * 2.8 / 15  # of the warp below the last segment, and of fourteen wefts for each warp
    assert tension == pytest.approx(0.02 * 981.0 * length, rel=0.05)  # warps at the sides carry less than those inside


def test_frames_of_a_motion_are_at_their_times_and_in_the_animation(tmp_path):
    swing = form("none", mode="dynamic", duration=0.1, gravity=(0.0, -981.0, 300.0), largest_step=0.007)
    run = drape(swing, tmp_path)
    run.write(tmp_path)
    times = [frame.time for frame in run.frames]
    assert times[:4] == pytest.approx([0.0, 1 / 30, 2 / 30, 0.1])
    assert run.end.vertices[:, 2].max() > 0.1  # it swings towards the pull
    assert read_yarns(tmp_path / "animation.usdc").yarn_count == run.yarns.yarn_count
    from pxr import Usd, UsdGeom

    stage = Usd.Stage.Open(str(tmp_path / "animation.usdc"))
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/yarns/cloth"))
    assert mesh.GetPointsAttr().GetNumTimeSamples() == len(times)
    last = np.array(mesh.GetPointsAttr().Get(stage.GetEndTimeCode()))
    assert np.allclose(last, run.shown.surface, atol=1e-5)  # float32


def test_a_stopped_run_resumes_to_the_same_bits(tmp_path):
    moving = replace(
        TOP, keyframes=(Keyframe(time=0.0), Keyframe(time=0.02, displacement=(0.0, 0.0, 0.02))), release=0.006
    )
    loose = replace(HANGING.solver, velocity_tolerance=1.0)
    changes = {"mode": "dynamic", "duration": 0.008, "largest_step": 0.002, "attachments": (moving,), "solver": loose}
    scene = form("chosen", **changes)
    whole = drape(scene, tmp_path / "whole")
    control: RunControl[Draped] = RunControl(lambda seen: control.stop(), seconds=0.0)
    stopped = drape(scene, tmp_path / "cut", run=Run(control=control))
    assert not stopped.report["mixed"]["converged"]
    assert stopped.end.time < whole.end.time
    again = drape(scene, tmp_path / "cut", run=Run(resume=tmp_path / "cut" / CHECKPOINT))
    assert len(again.frames) == len(whole.frames)
    for mine, theirs in zip(again.frames, whole.frames, strict=True):
        assert np.array_equal(mine.vertices, theirs.vertices)
        assert np.array_equal(mine.nodes, theirs.nodes)
    numbers = ("steps", "newton_iterations", "solve_iterations", "energy")
    assert [again.report["mixed"][name] for name in numbers] == [whole.report["mixed"][name] for name in numbers]


def test_a_run_that_is_resumed_after_its_last_step_has_the_kinetic_energy_of_one_that_was_not_stopped(tmp_path):
    """The masses of crossing yarns follow the positions, which no further step finds anew."""
    changes = {"mode": "dynamic", "duration": 0.006, "largest_step": 0.002, "gravity": (0.0, -981.0, 700.0)}
    scene = form("chosen", solver=replace(HANGING.solver, velocity_tolerance=1.0), **changes)
    whole = drape(scene, tmp_path / "whole").report["mixed"]
    cut = drape(scene, tmp_path / "cut", run=Run(control=stopping_after(whole["steps"]))).report["mixed"]
    assert not cut["converged"]
    again = drape(scene, tmp_path / "cut", run=Run(resume=tmp_path / "cut" / CHECKPOINT)).report["mixed"]
    assert again["energies"] == whole["energies"] and whole["energies"]["kinetic"] > 0.0


def test_a_run_that_was_stopped_before_its_first_checkpoint_begins_anew(tmp_path):
    resumed = drape(form("none"), tmp_path, run=Run(resume=tmp_path / CHECKPOINT))
    fresh = drape(form("none"))
    assert np.array_equal(resumed.end.vertices, fresh.end.vertices)


def test_a_line_shows_the_progress_on_a_terminal(monkeypatch):
    terminal = io.StringIO()
    monkeypatch.setattr(terminal, "isatty", lambda: True)
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setattr(progress, "LINE_SECONDS", 0.0)
    drape(form("none"), run=Run(None))
    assert "draping: 100%" in terminal.getvalue()


PULLED = replace(TOP, keyframes=(Keyframe(time=0.0), Keyframe(time=1.0, displacement=(0.1, 0.2, 0.0))), release=0.9)
"""Pulls the upper side in the first of two equilibria and is gone in the second."""
LOWER = AttachmentSection(boxes=(BoxSection(low=(-1.0, -1.0, -1.0), high=(9.0, 0.3, 1.0)),))


def test_a_search_for_an_equilibrium_resumes_to_the_same_bits(tmp_path):
    """With yarns that slide and stick: the limits of their friction last as long as a search."""
    scene = form("chosen", attachments=(PULLED, LOWER), load_steps=2)
    whole = drape(scene, tmp_path / "whole")
    seen: list[str] = []
    control: RunControl[Draped] = RunControl()

    def stop_in_time(stage: str, done: float, note: str) -> None:
        seen.append(note)
        if len(seen) == 9:  # in the second of the two searches
            control.stop()

    stopped = drape(scene, tmp_path / "cut", run=Run(stop_in_time, control=control))
    assert not stopped.report["mixed"]["converged"]
    assert len(seen) == 9
    again = drape(scene, tmp_path / "cut", run=Run(resume=tmp_path / "cut" / CHECKPOINT))
    assert len(again.frames) == len(whole.frames)
    for mine, theirs in zip(again.frames, whole.frames, strict=True):
        assert np.array_equal(mine.nodes, theirs.nodes)
        assert np.array_equal(mine.sliding, theirs.sliding)
    numbers = ("steps", "newton_iterations", "solve_iterations", "energy", "error")
    assert [again.report["mixed"][name] for name in numbers] == [whole.report["mixed"][name] for name in numbers]


def test_yarns_that_begin_on_the_triangles_come_to_the_same_equilibrium(tmp_path):
    """A flat pulled patch of yarns without friction has one equilibrium: nothing buckles, and no path matters."""
    smooth = {**asdict(CrossingMaterial.named("gong-3")), "friction": 0.0}
    lines = [f"{name} = {value}" for name, value in smooth.items()]
    (tmp_path / "smooth.toml").write_text("\n".join(["[smooth]", *lines]))
    yarns = replace(HANGING.yarns, material="smooth", material_file=str(tmp_path / "smooth.toml"))
    tight = replace(HANGING.solver, force_tolerance=1e-4)
    changes = {"attachments": (replace(PULLED, release=None), LOWER), "load_steps": 2, "solver": tight, "yarns": yarns}
    scene = form("all", gravity=(0.0, 0.0, 0.0), **changes)
    laid, placed = (drape(replace(scene, region=RegionSection(yarns="all", start=start))) for start in STARTS)
    numbers = laid.report["mixed"], placed.report["mixed"]
    assert all(each["converged"] for each in numbers)
    assert [each["steps"] for each in numbers] == [2, 1]
    assert ["triangle_run" in each for each in numbers] == [False, True]
    # the tolerance of the forces over the smallest stiffness of a smooth motion, that of shear
    np.testing.assert_allclose(placed.shown.nodes, laid.shown.nodes, atol=1e-5)


def test_the_run_with_triangles_alone_stops_too(tmp_path):
    region = replace(HANGING.region, start="triangles")
    scene = replace(HANGING, attachments=(PULLED, LOWER), load_steps=4, region=region)
    seen: list[Draped] = []
    control: RunControl[Draped] = RunControl(lambda found: (seen.append(found.state), control.stop()), seconds=0.0)
    stopped = drape(scene, tmp_path, run=Run(control=control))
    assert len(seen[0].end.nodes) == len(stopped.end.nodes) == 0  # triangles alone
    assert not stopped.report["mixed"]["converged"]
    assert np.array_equal(stopped.end.vertices, seen[0].end.vertices)
    assert not (tmp_path / CHECKPOINT).exists()
    with limited_to(TimeLimit(0.0)):
        assert not drape(scene).report["mixed"]["converged"]


def test_a_motion_cannot_begin_on_the_triangles():
    with pytest.raises(ParameterError, match=r"region\.start: got 'triangles' in a dynamic scene"):
        replace(HANGING, mode="dynamic", region=RegionSection(yarns="all", start="triangles"))


def test_a_released_attachment_lets_the_patch_fall(tmp_path):
    scene = form("none", mode="dynamic", duration=0.05, attachments=(replace(TOP, release=0.01),), largest_step=0.005)
    fallen = drape(scene).end.vertices
    top = fallen[fallen[:, 1].argmax(), 1]
    assert 3.0 - top == pytest.approx(0.5 * 981.0 * 0.04**2, rel=0.25)  # free fall for 0.04 s, in steps of 0.005 s


def test_a_checkpoint_of_another_scene_is_refused(tmp_path):
    scene = form("none", mode="dynamic", duration=0.01, largest_step=0.005)
    drape(scene, tmp_path, run=Run(checkpoints=Checkpoints(tmp_path, 1)))
    assert (tmp_path / CHECKPOINT).exists()
    with pytest.raises(ParameterError, match=r"scene\.gravity"):
        drape(replace(scene, gravity=(0.0, -1.0, 0.0)), tmp_path, run=Run(resume=tmp_path / CHECKPOINT))


def test_a_stitch_mesh_is_a_cloth_with_its_own_yarns(tmp_path):
    fabric = tessellate(label(grid(4, 3)), stitch_width=0.5)
    write_stitches(tmp_path / "fabric.h5", fabric)
    top = float(fabric.vertices[:, 1].max())
    section = AttachmentSection(boxes=(BoxSection(low=(-99.0, top - 0.1, -99.0), high=(99.0, 99.0, 99.0)),))
    scene = form(
        "none",
        cloth=ClothSection(file=str(tmp_path / "fabric.h5")),
        yarns=YarnsSection(knit="stitches"),
        attachments=(section,),
    )
    run = drape(scene)
    assert run.report["mixed"]["converged"]
    assert run.prepared.fabric.yarns.kind == "knit"
    assert len(run.prepared.fabric.cloth.vertices) == len(fabric.vertices)
    assert run.yarns.yarn_count == run.prepared.fabric.yarns.yarn_count
    with pytest.raises(ParameterError, match=r"expected a cloth\.file"):
        prepare(replace(scene, cloth=HANGING.cloth))


def test_memory_grows_with_the_region_and_the_message_says_what_fits():
    region = prepare(form("all")).region
    few, many = estimate_memory(prepare(form("none")).region, contact=False), estimate_memory(region, contact=False)
    assert few.total < many.total
    enough = check_scene_memory(region, many.total, contact=False)
    assert enough.nodes_within(many.total, len(region.nodes)) == len(region.nodes)
    short = many.total - 60 * many.each_node
    found = r"the scene with 225 yarn nodes needs about .* GB.* at most 165 yarn nodes"
    with pytest.raises(ParameterError, match=found):
        check_scene_memory(region, short, contact=False)


def test_more_yarns_than_fit_into_the_memory_are_refused_before_they_are_laid_out():
    dense = replace(HANGING, yarns=YarnsSection(weave="plain", ends=5e5, picks=5e5))
    with pytest.raises(ParameterError, match=r"a cloth with about .* crossings of yarns needs about .* GB.* at most"):
        prepare(dense)


def test_the_command_writes_its_files(tmp_path, capsys):
    write_scene(tmp_path / "scene.toml", form("chosen"))
    folder = tmp_path / "out"
    assert main(["drape", str(tmp_path / "scene.toml"), "-o", str(folder), "--region", "none", "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["mixed"]["yarn_nodes_full"] == 0
    names = {path.name for path in folder.iterdir()}
    assert {"yarns.bcc", "cloth.obj", "maps.h5", "report.json", "scene.toml", "animation.usdc"} <= names


def test_the_command_compares_three_forms(tmp_path, capsys):
    write_scene(tmp_path / "scene.toml", form("chosen"))
    words = ["drape", str(tmp_path / "scene.toml"), "-o", str(tmp_path / "out"), "--compare", "--no-picture"]
    assert main(words) == 0
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    assert [report[name]["yarn_nodes_full"] for name in ("triangles", "yarns")] == [0, 225]
    assert 0 < report["mixed"]["yarn_nodes_full"] + report["mixed"]["yarn_nodes_hybrid"] < 225
    assert all((tmp_path / "out" / name / "yarns.bcc").exists() for name in report)
    assert "triangles:" in capsys.readouterr().out


def test_the_command_refuses_in_one_line_and_writes_nothing(tmp_path, capsys):
    write_scene(tmp_path / "scene.toml", replace(HANGING, bodies=(BodySection(file="nowhere.obj"),)))
    assert main(["drape", str(tmp_path / "scene.toml"), "-o", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "nowhere.obj" in error
    assert not (tmp_path / "out").exists()


def test_the_command_needs_a_folder(tmp_path):
    write_scene(tmp_path / "scene.toml", HANGING)
    assert main(["drape", str(tmp_path / "scene.toml")]) == 2


def test_a_region_that_does_not_fit_into_the_memory_writes_nothing(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("stitchmesh.mixed.drape.available_memory", lambda device: 276e6)
    write_scene(tmp_path / "scene.toml", form("all"))
    assert main(["drape", str(tmp_path / "scene.toml"), "-o", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1 and "GB free" in error
    assert not (tmp_path / "out").exists()


def test_the_command_writes_an_example_once(tmp_path, capsys):
    path = Path(tmp_path / "mine.toml")
    assert main(["drape", str(path), "--init"]) == 0
    assert main(["drape", str(path), "--init"]) == 2
    assert "is there already" in capsys.readouterr().err
