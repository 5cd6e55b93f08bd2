# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The add-on for Blender, as far as it needs no Blender: its zip file, its words, its processes and its curves."""

from __future__ import annotations

import ast
import importlib.util
import sys
import time
import tomllib
import zipfile
from types import ModuleType

import numpy as np
import pytest

from stitchmesh.cli.main import COMMANDS
from stitchmesh.errors import FileError
from stitchmesh.io.blender_addon import FILES, NAME, write_blender_addon
from stitchmesh.io.meshes import read_mesh
from stitchmesh.mesh.upright import turned_upright
from stitchmesh.quality import PRESETS
from tests.cli.test_arguments import parsed
from tests.gallery import ROOT, tube

ADDON = ROOT / "assets" / "blender" / NAME
GIVEN_BY_BLENDER = {"bpy", "mathutils", "numpy"}


def module(name: str) -> ModuleType:
    """Load a file of the add-on that needs no Blender."""
    spec = importlib.util.spec_from_file_location(f"addon_{name}", ADDON / f"{name}.py")
    assert spec is not None and spec.loader is not None
    made = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = made  # dataclasses look their module up
    spec.loader.exec_module(made)
    return made


program, curves = module("program"), module("curves")


def test_the_zip_file_holds_the_folder_of_the_add_on_and_has_the_same_bytes_each_time(tmp_path):
    first, second = tmp_path / "a.zip", tmp_path / "b.zip"
    write_blender_addon(first)
    write_blender_addon(second)
    assert first.read_bytes() == second.read_bytes()
    with zipfile.ZipFile(first) as archive:
        contents = {name: archive.read(name) for name in archive.namelist()}
    assert contents == {f"{NAME}/{path.name}": path.read_bytes() for path in ADDON.iterdir() if path.is_file()}
    assert set(FILES) == {name.rpartition("/")[2] for name in contents}


def test_another_ending_than_zip_is_refused(tmp_path):
    with pytest.raises(FileError, match=r"got the ending '\.blend'; expected \.zip"):
        write_blender_addon(tmp_path / "addon.blend")
    assert not any(tmp_path.iterdir())


def test_the_manifest_names_the_folder_and_the_licence_of_each_file():
    manifest = tomllib.loads((ADDON / "blender_manifest.toml").read_text())
    assert manifest["id"] == NAME and manifest["type"] == "add-on" and manifest["schema_version"] == "1.0.0"
    assert manifest["license"] == ["SPDX:GPL-3.0-or-later"]
    assert "GNU GENERAL PUBLIC LICENSE" in (ADDON / "LICENSE").read_text()
    for name in FILES:
        if name != "LICENSE":
            assert "SPDX-License-Identifier: GPL-3.0-or-later" in (ADDON / name).read_text(), name


def test_the_add_on_imports_only_what_blender_brings():
    for path in ADDON.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom):
                names += [node.module or ""] if node.level == 0 else []
            roots = {name.partition(".")[0] for name in names}
            assert roots <= GIVEN_BY_BLENDER | sys.stdlib_module_names, path.name


def test_the_commands_are_those_of_the_program(tmp_path):
    choices = program.KnitChoices(stitch_width=1.25, auto=True, quality="standard", pattern="rib2x2")
    knit, convert = program.commands("/bin/stitchmesh", tmp_path, choices)
    made = parsed(knit[1:])
    assert type(made) is COMMANDS["knit"]
    settings = made.garment
    assert (made.quality, made.pattern, made.no_picture) == ("standard", ("rib2x2",), True)
    assert settings.rows.auto and settings.stitch_width == 1.25
    assert type(parsed(convert[1:])) is COMMANDS["convert"] and made.output in convert[2]


def test_the_qualities_of_the_panel_are_those_of_the_program():
    tree = ast.parse((ADDON / "__init__.py").read_text())
    assigned = [node for node in tree.body if isinstance(node, ast.Assign)]
    (values,) = [node.value for node in assigned if ast.unparse(node.targets[0]) == "QUALITIES"]
    assert [name for name, *_ in ast.literal_eval(values)] == list(PRESETS)


def test_a_written_mesh_is_read_back_in_centimetres_with_y_up(tmp_path):
    mesh = tube(8, 3, radius=20.0, height=12.0)
    x, y, z = mesh.vertices.T / 100
    corners, sizes = np.asarray(mesh.face_vertex), np.diff(mesh.face_start)
    program.write_obj(tmp_path / "garment.obj", np.stack([x, -z, y], axis=1), corners, sizes)
    found = turned_upright(read_mesh(tmp_path / "garment.obj", unit="m"), (0.0, 0.0, 1.0))
    # nine digits are written, of lengths below 32 cm
    np.testing.assert_allclose(found.vertices, mesh.vertices, atol=1e-6)
    np.testing.assert_array_equal(found.face_vertex, mesh.face_vertex)


def test_a_mesh_without_faces_is_refused(tmp_path):
    with pytest.raises(program.ProgramError, match="has no faces"):
        program.write_obj(tmp_path / "a.obj", np.zeros((3, 3)), np.zeros(0, dtype=int), np.zeros(0, dtype=int))


def test_progress_and_errors_are_found_among_the_messages():
    log = "a note\nrelaxing yarns: 22%, 10 to 40 s left (iteration 60, residual 0.0225)\n"
    assert program.last_step(log) == program.Step("relaxing yarns, 10 to 40 s left", 0.22)
    assert program.last_step(log + "drawing: 0% (a.png)\n") == program.Step("drawing", 0.0)
    assert program.last_step("a note\n") is None
    refusal = "MeshError: garment.obj: has 3 sides at face 1; expected quads"
    assert program.error_line(f"{refusal}\n{log.splitlines()[1]}\n", 2) == refusal
    assert "status 7" in program.error_line("", 7)


def ended(run) -> None:
    while not run.poll():
        time.sleep(0.01)


def test_commands_run_one_after_the_other_and_the_folder_goes():
    run = program.ProgramRun()
    words = "import sys; open(sys.argv[1], 'a').write(sys.argv[2]); print('knitting: 50% (x)', file=sys.stderr)"
    run.start([[sys.executable, "-c", words, "out", text] for text in ("a", "b")])
    ended(run)
    assert (run.folder / "out").read_text() == "ab" and run.step == program.Step("knitting", 0.5)
    run.close()
    assert not run.folder.exists()


def test_a_failed_command_gives_its_line_and_no_later_command_runs():
    run = program.ProgramRun()
    failing, later = "import sys; sys.exit('a.obj: is wrong')", "open('b', 'w')"
    run.start([[sys.executable, "-c", words] for words in (failing, later)])
    with pytest.raises(program.ProgramError, match=r"^a\.obj: is wrong$"):
        ended(run)
    assert not (run.folder / "b").exists() and run.poll()
    run.close()


def test_closing_stops_the_command():
    run = program.ProgramRun()
    run.start([[sys.executable, "-c", "import time; time.sleep(600)"]])
    process = run._process
    assert not run.poll()
    run.close()
    assert process.returncode not in (None, 0) and not run.folder.exists()


def test_a_program_that_is_missing_is_named(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(program.ProgramError, match="stitchmesh: is not on the search path; set its path"):
        program.find_program("")
    with pytest.raises(program.ProgramError, match="/none/x: is no program"):
        program.find_program("/none/x")
    assert program.find_program(sys.executable) == sys.executable


@pytest.mark.parametrize("closed", [True, False])
def test_points_lie_on_the_b_spline_and_take_the_labels_of_the_nearest_control_points(closed):
    control = np.random.default_rng(1).normal(size=(7, 3))
    points, nearest = curves.on_spline(control, closed), curves.nearest_control(len(control), closed)
    segments = 7 if closed else 4
    assert len(points) == len(nearest) == 3 * segments + 1
    # at a knot a uniform cubic B-spline is (before + 4 own + after) / 6; tolerance: a few roundings
    knots = np.arange(segments + 1)
    before, own, after = (control[(knots + k) % 7] for k in range(3))
    np.testing.assert_allclose(points[::3], (before + 4 * own + after) / 6, atol=1e-14)
    np.testing.assert_array_equal(nearest[::3], (knots + 1) % 7)
    assert closed == bool((points[0] == points[-1]).all())


def test_length_is_measured_along_a_curve():
    np.testing.assert_array_equal(curves.length_along(np.array([[0, 0, 0], [3, 4, 0], [3, 4, 2.0]])), [0, 5, 7])
