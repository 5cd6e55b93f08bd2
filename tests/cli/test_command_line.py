# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The commands, run in this process; bad input gives one line and the exit status 2."""

from __future__ import annotations

import csv
import importlib
import json
import logging
import os
import re
import signal
from contextlib import redirect_stdout, suppress
from dataclasses import asdict, replace
from io import StringIO
from pathlib import Path

import numpy as np
import pytest

from stitchmesh.cli import main as cli
from stitchmesh.cli.commands.library import PatternsCommand
from stitchmesh.io import read_stitches, read_yarns, write_mesh, write_yarns
from stitchmesh.io.own_files import RECORD
from stitchmesh.mesh import extent
from stitchmesh.tessellate import tessellate
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.rest_length import plain_stitches, stitch_lengths
from stitchmesh.yarn.stitch_size import fabric_gauge
from stitchmesh.yarn.yarn_presets import Yarn
from stitchmesh.yarngen import generate_yarns
from tests.cli.calls import refused, refused_without_files, run
from tests.gallery import tube
from tests.output_files import visible

REPORT = {
    "label": {"seconds", "rows", "faces"},
    "tessellate": {"seconds", "faces", "increases", "decreases"},
    "meshrelax": {"seconds", "iterations", "converged", "max_stretch", "rms_stretch"},
    "yarngen": {"seconds", "yarns", "control_points", "length_cm"},
    "yarnrelax": {"seconds", "iterations", "converged", "residual", "energy", "max_strain",
                  "min_distance_over_radius", "pull_throughs", "certificate"},
}  # fmt: skip


@pytest.fixture(scope="module")
def tube_obj(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("meshes") / "tube.obj"
    write_mesh(path, tube(8, 2, radius=2.0, height=1.5))
    return path


@pytest.fixture(scope="module")
def said(tmp_path_factory, tube_obj) -> tuple[Path, list[str]]:
    """Return the folder of a knitted tube, and the lines that the command printed."""
    folder = tmp_path_factory.mktemp("knitted") / "out"
    with redirect_stdout(StringIO()) as printed:
        run("knit", tube_obj, "--stitch-width", 2, "--quality", "draft", "--device", "cpu", "-o", folder)
    return folder, printed.getvalue().splitlines()


@pytest.fixture(scope="module")
def knitted(said) -> Path:
    return said[0]


def test_knit_writes_its_files(knitted):
    assert visible(knitted) == {
        "stitches.h5", "yarns.h5", "yarns.bcc", "preview.png", "report.json", "convergence.csv", "convergence.png",
        "garment.toml",
    }  # fmt: skip
    report = json.loads((knitted / "report.json").read_text())
    for stage, keys in REPORT.items():
        assert keys <= set(report[stage]), stage
    assert report["device"] == "cpu" and report["quality"] == "draft"
    assert report["yarnrelax"]["pull_throughs"] == 0
    assert report["yarnrelax"]["certificate"] == "unchanged"


def test_the_files_of_knit_agree_with_each_other(knitted):
    report = json.loads((knitted / "report.json").read_text())
    fabric, yarns = read_stitches(knitted / "stitches.h5"), read_yarns(knitted / "yarns.h5")
    assert report["tessellate"]["faces"] == fabric.face_count
    assert report["yarngen"]["control_points"] == len(yarns.points)
    relaxed = report["yarnrelax"]
    assert np.abs(yarns.strain).max() == pytest.approx(relaxed["max_strain"], rel=1e-6)
    with (knitted / "convergence.csv").open() as file:
        *_, last = csv.DictReader(file)
    assert (int(last["iteration"]), float(last["residual"])) == (relaxed["iterations"], relaxed["residual"])
    assert {name: float(last[f"{name}_erg"]) for name in relaxed["energies"]} == relaxed["energies"]


def test_the_stages_one_by_one_give_the_result_of_knit(tmp_path, tube_obj, knitted, capsys):
    """The files between the stages lose nothing: the yarns have the same bits."""
    at = {name: str(tmp_path / f"{name}.h5") for name in ("rows", "stitches", "even", "yarns", "relaxed")}
    assert cli.main(["label", str(tube_obj), "-o", at["rows"]]) == 0
    assert cli.main(["tessellate", at["rows"], "--stitch-width", "2", "-o", at["stitches"]]) == 0
    assert cli.main(["relax-mesh", at["stitches"], "--surface", at["rows"], "-o", at["even"]]) == 0
    assert cli.main(["yarns", at["even"], "--quality", "draft", "-o", at["yarns"]]) == 0
    words = ["relax", at["yarns"], "--keep-shape", at["even"], "--quality", "draft", "--device", "cpu"]
    assert cli.main([*words, "-o", at["relaxed"]]) == 0
    stepwise, whole = read_yarns(at["relaxed"]), read_yarns(knitted / "yarns.h5")
    np.testing.assert_array_equal(stepwise.points, whole.points)


def test_knit_says_in_four_lines_what_it_made(said):
    folder, (what, gauge, state, where) = said
    fabric, yarns = read_stitches(folder / "stitches.h5"), read_yarns(folder / "yarns.h5")
    assert what == f"Knitted {fabric.face_count} stitches in {fabric.row.max() + 1} rows, {extent(yarns.points)}."
    assert gauge.startswith(f"Gauge: {fabric_gauge(fabric)}. Yarn: {yarns.lengths.sum() / 100:.3g} m, about ")
    assert state.startswith("Good: the yarns are at rest, strained by at most ")
    assert where == f"Open {folder / 'preview.png'}; {folder / 'report.json'} holds all numbers."


def test_knit_prints_its_report_in_the_place_of_the_lines(tube_obj, tmp_path, capsys):
    words = ["knit", tube_obj, "--yarn", "bulky", "--quality", "draft", "--max-iterations", 5, "--no-picture"]
    run(*words, "--json", "-o", tmp_path)
    report = json.loads(capsys.readouterr().out)
    assert report == json.loads((tmp_path / "report.json").read_text())
    assert report["gauge"] == asdict(fabric_gauge(read_stitches(tmp_path / "stitches.h5")))
    assert report["yarnrelax"]["iterations"] == 5 and not report["yarnrelax"]["converged"]


def test_a_yarn_sets_the_sizes_of_every_stage(tmp_path, tube_obj):
    rows, stitches, yarns = tmp_path / "rows.h5", tmp_path / "stitches.h5", tmp_path / "yarns.h5"
    bulky, options = Yarn.named("bulky"), ["--yarn", "bulky"]
    brief = ["--quality", "draft", "--max-iterations", "20", "--no-picture"]  # rest lengths are set before
    for words in (
        ["label", tube_obj, "-o", rows],
        ["tessellate", rows, "-o", stitches, *options],
        ["yarns", stitches, "-o", yarns, "--quality", "draft", *options],
        ["knit", tube_obj, "-o", tmp_path / "knit", *brief, *options],
    ):
        assert cli.main([str(word) for word in words]) == 0
    expected = tessellate(read_stitches(rows), stitch_width=bulky.stitch_width, stitch_height=bulky.stitch_height)
    np.testing.assert_array_equal(read_stitches(stitches).vertices, expected.vertices)
    fabric, knitted = read_stitches(tmp_path / "knit" / "stitches.h5"), read_yarns(tmp_path / "knit" / "yarns.h5")
    assert fabric.face_count == expected.face_count
    assert set(read_yarns(yarns).radius) == set(knitted.radius) == {bulky.core_radius}
    lengths = stitch_lengths(knitted, fabric)[plain_stitches(fabric)]
    np.testing.assert_allclose(lengths, bulky.loop_length, rtol=1e-12)  # sums of rest lengths in double precision


def test_info_check_and_convert(knitted, tmp_path, capsys):
    run("info", knitted / "yarns.h5")
    assert "control points" in capsys.readouterr().out
    run("check", knitted / "stitches.h5")
    assert "valid stitch mesh" in capsys.readouterr().out
    yarns, fabric = read_yarns(knitted / "yarns.h5"), read_stitches(knitted / "stitches.h5")
    counts = f"{yarns.yarn_count:,} yarns, {len(yarns.points):,} control points, {yarns.lengths.sum() / 100:.3g} m"
    kind = f"stitch mesh, {fabric.face_count:,} stitches in {fabric.row.max() + 1} rows"
    capsys.readouterr()
    for source, name, what in (("yarns.h5", "yarns.obj", counts), ("stitches.h5", "stitches.smobj", kind)):
        run("convert", knitted / source, tmp_path / name)
        assert capsys.readouterr().out == f"Wrote {tmp_path / name}: {what}.\n"
    run("info", tmp_path / "yarns.obj")


def test_a_chart_and_the_options_colour_the_yarns_of_a_garment(tube_obj, tmp_path):
    """A chart in red and green stays red and green in the fabric, in the yarns and in the files for renderers."""
    from PIL import Image
    from pxr import Usd, UsdGeom

    Image.fromarray(np.array([[[255, 0, 0], [0, 128, 0]]] * 2, dtype=np.uint8)).save(tmp_path / "chart.png")
    words = ["--pattern", str(tmp_path / "chart.png"), "--drawn-radius", "0.25", "--no-picture", "--device", "cpu"]
    words += ["--stitch-width", "1", "--quality", "draft", "--max-iterations", "20"]
    assert cli.main(["knit", str(tube_obj), *words, "-o", str(tmp_path / "a")]) == 0
    yarns = read_yarns(tmp_path / "a" / "yarns.h5")
    assert yarns.palette.tolist() == [[255, 0, 0], [0, 128, 0]] and set(yarns.colour.tolist()) == {0, 1}
    assert (yarns.drawn_radius == 0.25).all() and (yarns.radius < 0.25).all()
    assert cli.main(["convert", str(tmp_path / "a" / "yarns.h5"), str(tmp_path / "y.usda")]) == 0
    stage = Usd.Stage.Open(str(tmp_path / "y.usda"))
    prims = [prim for prim in stage.Traverse() if prim.IsA(UsdGeom.BasisCurves)]
    shown = np.concatenate([UsdGeom.BasisCurves(prim).GetDisplayColorPrimvar().Get() for prim in prims])
    green = ((128 / 255 + 0.055) / 1.055) ** 2.4  # IEC 61966-2-1
    np.testing.assert_allclose(np.unique(shown, axis=0), [[0, green, 0], [1, 0, 0]], atol=1e-6)
    assert cli.main(["knit", str(tube_obj), *words, "--colour", "0=cream", "-o", str(tmp_path / "b")]) == 0
    kept = read_yarns(tmp_path / "b" / "yarns.h5").palette.tolist()
    assert kept == [[236, 226, 206], [255, 0, 0], [0, 128, 0]]  # the cast-on is cream, the chart as it was drawn


def test_render_draws_each_kind(knitted, tube_obj, tmp_path):
    for source, words in [
        (knitted / "yarns.h5", []),
        (knitted / "stitches.h5", ["--colour-by", "strain"]),
        (tube_obj, []),
    ]:
        picture = tmp_path / "picture.png"
        run("render", source, *words, "--size", 160, 120, "-o", picture)
        assert picture.stat().st_size > 1000
        picture.unlink()


@pytest.fixture
def far_ring(tmp_path) -> Path:
    """Return a file of one ring that states no radius; the radius cannot be estimated without other yarns nearby."""
    angle = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)
    points = 3.0 * np.stack([np.cos(angle), np.sin(angle), np.zeros(16)], axis=1)
    write_yarns(tmp_path / "ring.bcc", YarnSet.from_curves([points], closed=[True], radius=0.5))
    return tmp_path / "ring.bcc"


@pytest.mark.parametrize(
    "words",
    [["info", "{}"], ["check", "{}"], ["convert", "{}", "out.h5"], ["render", "{}", "-o", "out.png", "--size", 32, 32]],
    ids=lambda words: words[0],
)
def test_a_file_that_states_no_radius_needs_the_option(far_ring, tmp_path, capsys, monkeypatch, words):
    monkeypatch.chdir(tmp_path)
    words = [far_ring if word == "{}" else word for word in words]
    assert "give it (--yarn-radius)" in refused_without_files(capsys, tmp_path, *words)
    message = refused_without_files(capsys, tmp_path, *words, "--yarn-radius", "-0.1")
    assert "radius: got -0.1 cm; expected a positive number" in message
    run(*words, "--yarn-radius", "0.25")
    if words[0] == "info":
        assert "radius: 0.25 to 0.25 cm" in capsys.readouterr().out
    if words[0] == "convert":
        assert read_yarns("out.h5").radius.tolist() == [0.25]


@pytest.mark.parametrize("command", ["info", "check"])
def test_a_yarn_radius_without_yarns_is_an_error(tube_obj, capsys, command):
    assert "holds no yarns; leave the yarn radius out" in refused(capsys, command, tube_obj, "--yarn-radius", "0.1")


@pytest.mark.parametrize("words", [[], ["--verbose"]])
def test_details_are_said_with_verbose_only(far_ring, tmp_path, capsys, monkeypatch, words):
    """The error of a conversion, and what other packages do."""
    given = ["convert", str(far_ring), str(tmp_path / "other.bcc"), "--yarn-radius", "0.1"]
    level = logging.root.level
    with monkeypatch.context() as patch:
        patch.setattr(logging.root, "handlers", [])  # pytest has handlers of its own
        assert cli.main([*given, *words]) == 0
        logging.getLogger("matplotlib.font_manager").info("generated new fontManager")
        logging.getLogger("matplotlib.font_manager").warning("a font is missing")
    logging.root.setLevel(level)
    said = capsys.readouterr().err
    assert ("Catmull-Rom curves differ" in said) == ("generated new fontManager" in said) == bool(words)
    assert "a font is missing" in said


def test_the_version_is_printed(capsys):
    run("--version")
    assert capsys.readouterr().out.startswith("stitchmesh ")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "no faces|empty"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "9"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 3 4\n", "reverse the vertex order"),
        ("\x00\x01\x02 junk \xff", "FileError"),
    ],
)
def test_a_bad_mesh_file_gives_a_message_of_one_line(tmp_path, capsys, content, message):
    path = tmp_path / "bad.obj"
    path.write_bytes(content.encode("latin-1"))
    assert re.search(message, refused_without_files(capsys, tmp_path, "knit", path, "-o", tmp_path / "out"))


def test_a_missing_file_a_folder_and_an_unknown_suffix_are_errors(tmp_path, capsys):
    assert "nothing.obj" in refused(capsys, "knit", tmp_path / "nothing.obj", "-o", tmp_path / "out")
    folder = tmp_path / "folder.obj"
    folder.mkdir()
    assert "folder" in refused(capsys, "knit", folder, "-o", tmp_path / "out")
    assert "expected" in refused(capsys, "info", tmp_path / "mesh.xyz")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--stitch-width", "-1"], "positive"),
        (["--stitch-width", "500"], "the widest row is"),
        (["--stitch-width", "1e-5"], "GB of memory"),
        (["--stitch-width", "1", "--yarn-radius", "0.9"], "too thick"),
        (["--yarn", "worstad"], "yarn: got 'worstad'; expected worsted"),
        (["--gauge", "wide"], "gauge: got 'wide'; expected stitches in 10 cm such as 22"),
        (["--gauge", "22", "--stitch-width", "1"], "give one of the two"),
        (["--device", "tpu"], "expected one of"),
        (["--quality", "best"], "expected one of draft, standard, reference"),
        (["--unit", "furlong"], "furlong"),
        (["--seed", "0,9999"], "no edge joins"),
        (["--flip", "9999"], "does not exist"),
        (["--max-iterations", "-3"], "max iterations: got -3"),
        (["--rest-length", "zz=1.1"], "rest length zz: unknown stitch"),
        (["--stiffness", "k_bend=-2"], "k_bend is -2; expected a number from 0"),
        (["--body", "nothing.obj"], "nothing.obj: there is no such file"),
        (["--colour", "red"], "colour: got 'red'; expected the number of a yarn and its colour, such as 0=navy"),
        (["--colour", "0=navvy"], "colour: got 'navvy'"),
        (["--drawn-radius", "90"], "drawn radius: got 90 cm"),
        (["--bind-off", "knot"], "bind off: got 'knot'; expected one of drawn, chain"),
        (["--pattern", "rib2x3"], "did you mean rib3x3 or rib2x2"),
        (["--pattern-remainder", "stretch"], "pattern remainder: got stretch without a pattern; add --pattern NAME"),
    ],
)
def test_a_bad_option_gives_a_message_of_one_line(tube_obj, tmp_path, capsys, words, message):
    assert message in refused_without_files(capsys, tmp_path, "knit", tube_obj, "-o", tmp_path / "out", *words)


def test_an_output_folder_that_cannot_be_written_is_an_error(tube_obj, tmp_path, capsys):
    blocked = tmp_path / "file"
    blocked.write_text("in the way")
    assert "cannot be written" in refused(capsys, "knit", tube_obj, "-o", blocked)
    assert "cannot be written" in refused(capsys, "knit", tube_obj, "-o", blocked / "below")
    assert "choose another folder" in refused(capsys, "label", tube_obj, "-o", blocked / "rows.h5")
    assert blocked.read_text() == "in the way"


def test_a_machine_that_cannot_draw_writes_all_other_files(tube_obj, tmp_path, capsys, monkeypatch):
    render = importlib.import_module("stitchmesh.render")  # the package; sm.render is its function
    from stitchmesh.errors import DisplayError

    def cannot(*_args, **_options):
        raise DisplayError("VTK cannot draw here; apt-get install libegl1 libgl1")

    monkeypatch.setattr(render, "render_yarns", cannot)
    options = ["--stitch-width", "2", "--quality", "draft", "--max-iterations", "20", "--device", "cpu"]
    run("knit", tube_obj, *options, "-o", tmp_path)
    assert "libegl1 libgl1" in capsys.readouterr().err
    assert (tmp_path / "yarns.h5").exists() and not (tmp_path / "preview.png").exists()


def test_an_interrupt_writes_the_last_good_state(tube_obj, tmp_path, capsys, monkeypatch):
    """An interrupt during the relaxation: status 130, complete files, and a report that is marked as unfinished."""
    from stitchmesh.pipeline import yarn_relaxation

    relax = yarn_relaxation.relax_yarns

    def interrupted(*args, run, **options):
        def strike(*_):
            raise KeyboardInterrupt

        return relax(*args, **options, run=replace(run, progress=strike))

    monkeypatch.setattr(yarn_relaxation, "relax_yarns", interrupted)
    options = ["--stitch-width", "1", "--quality", "standard", "--device", "cpu", "-o", str(tmp_path)]
    assert cli.main(["knit", str(tube_obj), *options]) == 130
    assert "interrupted" in capsys.readouterr().err
    assert json.loads((tmp_path / "report.json").read_text())["yarnrelax"] == {"unfinished": True}
    assert np.isfinite(read_yarns(tmp_path / "yarns.h5").points).all()
    assert [name for name in os.listdir(tmp_path) if name.startswith(".")] == [RECORD], "no litter"


@pytest.mark.parametrize(
    ("words", "work"),
    [
        (["swatch", "rib1x1"], "stitchmesh.periodic.swatch.swatch"),
        (["run", "JOB"], "stitchmesh.jobs.run_job.run_job"),
    ],
)
def test_an_interrupt_ends_a_long_command_with_its_status(tmp_path, capsys, monkeypatch, words, work):
    (tmp_path / "job.toml").write_text("[swatch]\npattern = 'rib1x1'\n")
    module, _, name = work.rpartition(".")
    monkeypatch.setattr(importlib.import_module(module), name, lambda *_, **__: signal.raise_signal(signal.SIGINT))
    words = [word.replace("JOB", str(tmp_path / "job.toml")) for word in words]
    assert cli.main([*words, "-o", str(tmp_path / "out")]) == 130
    assert "interrupted" in capsys.readouterr().err


def test_an_interrupt_that_other_code_drops_shows_in_the_status(capsys, monkeypatch):
    """Code of another package that runs at that moment may drop the exception, for example while it loads a library."""

    def dropping(_command):
        with suppress(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(PatternsCommand, "run", dropping)
    assert cli.main(["patterns"]) == 130
    assert "interrupted" in capsys.readouterr().err


def test_an_interrupt_before_the_first_state_writes_the_generated_yarns(tube_obj, tmp_path, monkeypatch):
    from stitchmesh.pipeline import yarn_relaxation

    def strike(*_args, **_options):
        raise KeyboardInterrupt

    monkeypatch.setattr(yarn_relaxation, "relax_yarns", strike)
    options = ["--stitch-width", "1", "--quality", "draft", "--device", "cpu", "-o", str(tmp_path)]
    assert cli.main(["knit", str(tube_obj), *options]) == 130
    made = generate_yarns(read_stitches(tmp_path / "stitches.h5"), quality="draft")
    np.testing.assert_array_equal(read_yarns(tmp_path / "yarns.h5").points, made.points)


def test_knit_takes_rest_lengths_terms_and_checkpoints(tube_obj, tmp_path, capsys):
    """A relaxation that continues from a checkpoint with the same options gives the same bits as one without a stop."""
    words = ["knit", str(tube_obj), "--stitch-width", "1", "--quality", "draft", "--device", "cpu", "--no-picture",
             "--loop-length", "3.5", "--rest-length", "k=1.1", "--gravity", "0", "-981", "0"]  # fmt: skip
    part, rest, whole = tmp_path / "part", tmp_path / "rest", tmp_path / "whole"
    assert cli.main([*words, "-o", str(part), "--max-iterations", "20", "--checkpoint-every", "20"]) == 0
    report = json.loads((part / "report.json").read_text())
    assert report["quality"]["max_iterations"] == 20 and report["yarnrelax"]["iterations"] == 20
    assert report["yarnrelax"]["energies"]["gravity"] != 0.0
    words += ["--max-iterations", "30"]
    assert cli.main([*words, "-o", str(rest), "--resume", str(part / "checkpoint.smc")]) == 0
    assert cli.main([*words, "-o", str(whole)]) == 0
    np.testing.assert_array_equal(read_yarns(rest / "yarns.h5").points, read_yarns(whole / "yarns.h5").points)
    fabric = read_stitches(whole / "stitches.h5")
    inside = (fabric.row > 0) & (fabric.row < fabric.row.max())
    loops = stitch_lengths(read_yarns(whole / "yarns.h5"), fabric)[inside]
    np.testing.assert_allclose(loops, 1.1 * 3.5, rtol=1e-12)  # A sum of 12 products.
