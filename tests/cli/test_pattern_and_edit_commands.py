# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The commands for patterns, edits, instructions and yarns; bad input gives one line and the exit status 2."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stitchmesh.io import read_stitches, read_yarns, write_mesh, write_stitches, write_yarns
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.change import Marks, apply_change
from stitchmesh.patterns import apply_pattern, pattern_names, read_pattern
from stitchmesh.periodic.sampling.even_sampling import sample_evenly
from stitchmesh.periodic.weave.library import weave_names
from stitchmesh.quality import quality_named
from stitchmesh.run import Run
from stitchmesh.yarn import YarnSet
from stitchmesh.yarngen import generate_yarns, regenerate_yarns
from stitchmesh.yarngen.finish import YarnFinish
from stitchmesh.yarnrelax import relax_yarns
from tests.cli.calls import refused_without_files, run
from tests.gallery import ROOT
from tests.gallery import tube as coarse_tube
from tests.patterns.fabrics import differing, flat, tube

FACE = 40
"""A knit stitch in the interior of both fabrics, in the third row from below."""
DRAFT = ["--quality", "draft"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """Return a folder with a tube, a flat piece, the yarns of the tube, and files with other content."""
    folder = tmp_path_factory.mktemp("files")
    write_stitches(folder / "tube.h5", tube(18, 6))
    write_stitches(folder / "tube.smobj", tube(18, 6))
    write_stitches(folder / "flat.h5", flat(12, 8))
    write_yarns(folder / "yarns.h5", generate_yarns(tube(18, 6), quality="draft"))
    whole = (folder / "tube.h5").read_bytes()
    (folder / "half.h5").write_bytes(whole[: len(whole) // 2])
    text = (folder / "tube.smobj").read_text()
    (folder / "half.smobj").write_text(text[: len(text) // 2])
    for suffix in ("h5", "smobj", "jsonl", "knit", "png"):
        (folder / f"empty.{suffix}").touch()
        (folder / f"binary.{suffix}").write_bytes(b"\x00\x01\xff\xfe" * 50)
        (folder / f"folder.{suffix}").mkdir()
    log(folder / "purl.jsonl", ("change_stitch", {"faces": [FACE], "stitch": "p"}))
    return folder


def log(path: Path, *edits: tuple[str, dict[str, object]]) -> Path:
    path.write_text("".join(json.dumps({"edit": name, "arguments": given}) + "\n" for name, given in edits))
    return path


@pytest.mark.parametrize(
    ("bad", "message"),
    [("missing.h5", "there is no such file"), ("empty.smobj", "the file is empty"), ("folder.h5", "is a folder"),
     ("binary.h5", "is not an HDF5"), ("binary.smobj", "binary data"), ("half.h5", "damaged"),
     ("half.smobj", "corners|expected")],
)  # fmt: skip
def test_commands_do_not_accept_a_file_that_is_not_a_stitch_mesh(folder, capsys, monkeypatch, bad, message):
    monkeypatch.chdir(folder)
    other, after = ("--before", "tube.h5"), ("--after", bad)
    for words in (
        ["pattern", bad, "rib2x2", "-o", "out.h5"], ["edit", bad, "--replay", "purl.jsonl", "-o", "out.h5"],
        ["instructions", bad, "-o", "out.txt"], ["convert", bad, "out.smobj"], ["yarns", bad, "-o", "out.h5"],
        ["info", bad], ["relax-edited", "yarns.h5", *other, *after, *DRAFT, "-o", "out.h5"],
    ):  # fmt: skip
        said = refused_without_files(capsys, folder, *words)
        assert bad in said and re.search(message, said), said


def test_a_malformed_cable_is_an_error_of_reading(folder, capsys, monkeypatch):
    monkeypatch.chdir(folder)
    fabric = read_stitches("flat.h5")
    side = np.array([fabric.face_start[FACE] + 2])
    write_stitches("cable.h5", apply_change(fabric, Marks("cable_shift", side, np.array([9]))))
    for words in (["check", "cable.h5"], ["convert", "cable.h5", "out.smobj"], ["relax-mesh", "cable.h5",
                  "--surface", "flat.h5", "-o", "out.h5"]):  # fmt: skip
        assert "cable.h5: side 162 (face 40, vertices 57-56): cable_shift 9 leads off its row" in refused_without_files(
            capsys, folder, *words
        )


def test_a_pattern_is_applied_to_a_file(folder, tmp_path, capsys):
    words = ["pattern", folder / "tube.h5", "rib2x2", "-o", tmp_path / "made.h5"]
    run(*words, "--remainder", "stretch")
    expected = apply_pattern(tube(18, 6), read_pattern("rib2x2"), remainder="stretch")
    assert differing(read_stitches(tmp_path / "made.h5"), expected) == []
    assert capsys.readouterr().out == "2 x 2 rib: 90 of 108 stitches are in the pattern\n"  # all but the cast-on row
    run(*words, "--overwrite")
    assert capsys.readouterr().out.splitlines() == [
        "2 x 2 rib: 80 of 108 stitches are in the pattern",
        "left out: 10 stitches (rows 1-5, wales 0-1): these loops are left over beside whole repeats of the pattern "
        "and keep their stitches",
    ]
    run("pattern", folder / "tube.h5", "feather-and-fan", "--face", FACE, "-o", tmp_path / "lace.h5")
    expected = apply_pattern(tube(18, 6), read_pattern("feather-and-fan"), face=FACE)
    assert differing(read_stitches(tmp_path / "lace.h5"), expected) == []


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["rib2x3"], "did you mean rib3x3 or rib2x2"),
        (["rib2x2", "--remainder", "crop"], "remainder 'crop'"),
        (["rib2x2", "--face", 999], "face 999: does not exist"),
    ],
)
def test_bad_options_of_a_pattern_are_refused(folder, tmp_path, capsys, words, message):
    words = ["pattern", folder / "tube.h5", *words, "-o", tmp_path / "made.h5"]
    assert message in refused_without_files(capsys, tmp_path, *words)


@pytest.mark.parametrize("suffix", [".knit", ".png"])
def test_a_part_is_captured_as_a_pattern(folder, tmp_path, capsys, suffix):
    ribbed, own, whole = tmp_path / "ribbed.h5", tmp_path / f"own{suffix}", tmp_path / f"whole{suffix}"
    run("pattern", folder / "tube.h5", "rib3x3", "-o", ribbed)
    capsys.readouterr()
    run("capture", ribbed, "--on", "rows 1-4", "-o", own)
    assert capsys.readouterr().out == f"Wrote {own}: 6 loops x 1 rows, one repeat of 18 x 4.\n"
    assert len(read_pattern(own).rows) == 1 and read_pattern(own).width == 6
    run("capture", ribbed, "--on", "rows 1-4", "--whole", "-o", whole)
    assert (read_pattern(whole).width, read_pattern(whole).height) == (18, 4)


def test_a_part_that_is_no_pattern_is_refused_and_nothing_is_written(folder, tmp_path, capsys):
    words = ["capture", folder / "tube.h5", "-o", tmp_path / "own.knit"]
    assert "face 0, 1, 2 (+15 more): is cast-on" in refused_without_files(capsys, tmp_path, *words)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("row 1 RS: k2tgo", "line 1, column 11: got 'k2tgo'"),
        ("chart:\nk k k\nk k", "got 2 columns where the chart's first line has 3"),
        ("row 1 RS: k4 yo\nrow 2 WS: p4", "row 2: its tile is worked on 4 loops, but the row below leaves 5"),
        ("row 1 RS: k2\nrow 2 WS: c4f", "row 2: its tile is worked on 4 loops, but the row below leaves 2"),
        ("row 1 RS: cross(2 2 0 1; 1 1 0 0: k4)", "are crossed to one place"),
        ("row 1 RS: k100 p100", "its 200 columns are more than any first row"),
    ],
)
def test_a_bad_pattern_gives_a_message_of_one_line(folder, tmp_path, capsys, text, message):
    (tmp_path / "bad.knit").write_text(text)
    words = ["pattern", folder / "tube.h5", tmp_path / "bad.knit", "-o", tmp_path / "out.h5"]
    assert message in refused_without_files(capsys, tmp_path, *words)


@pytest.mark.parametrize("name", ["missing.knit", "missing.png", "empty.knit", "binary.png", "folder.png"])
def test_a_pattern_file_that_cannot_be_read_gives_a_message_of_one_line(folder, capsys, monkeypatch, name):
    monkeypatch.chdir(folder)
    assert f"FileError: {name}: " in refused_without_files(capsys, folder, "pattern", "tube.h5", name, "-o", "out.h5")


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (("change_stitch", {"faces": [FACE], "stitch": "zz"}), "stitch 'zz': is unknown; expected one of k, p"),
        (("collapse_course_edge", {"side": 4 * 36 + 2}), "face 36: would have 1 bottom and 0 top sides"),
        (("paste_pattern", {"pattern": "rib2x2", "face": 0}), "a pattern starts from a plain stitch"),
        (("frobnicate", {}), "is unknown; expected change_stitch"),
        (("flip_row", {"face": "a"}), 'face is "a"; expected a whole number'),
    ],
)
def test_the_error_of_a_bad_edit_names_its_line_and_nothing_is_written(folder, tmp_path, capsys, edit, message):
    path = log(tmp_path / "bad.jsonl", ("change_stitch", {"faces": [FACE], "stitch": "p"}), edit)
    words = ["edit", folder / "flat.h5", "--replay", path, "-o", tmp_path / "out.h5"]
    said = refused_without_files(capsys, tmp_path, *words)
    assert "bad.jsonl line 2: " in said and message in said


def test_each_edit_applies_to_the_result_of_the_previous_one(folder, tmp_path, capsys):
    gone = ("remove_row", {"face": FACE}), ("change_stitch", {"faces": [107], "stitch": "p"})
    words = ["edit", folder / "tube.h5", "--replay", log(tmp_path / "bad.jsonl", *gone), "-o", tmp_path / "out.h5"]
    assert "face 107: does not exist" in refused_without_files(capsys, tmp_path, *words)


def test_a_file_that_is_not_a_log_gives_a_message_of_one_line(folder, tmp_path, capsys):
    (tmp_path / "deep.jsonl").write_text("[" * 100_000)
    for path in (tmp_path / "deep.jsonl", folder / "missing.jsonl", folder / "binary.jsonl", folder / "folder.jsonl"):
        words = ["edit", folder / "tube.h5", "--replay", path, "-o", tmp_path / "out.h5"]
        assert path.name in refused_without_files(capsys, tmp_path, *words)


def test_a_bad_finish_is_an_error_before_the_computation(folder, tmp_path, capsys):
    output = ["-o", tmp_path / "out.h5", "--cast-on", "long-tail"]
    between = ["--before", folder / "tube.h5", "--after", folder / "tube.h5"]
    message = "cast on: got 'long-tail'; expected one of backward, open"
    assert message in refused_without_files(capsys, tmp_path, "yarns", folder / "missing.h5", *output)
    assert message in refused_without_files(capsys, tmp_path, "relax-edited", folder / "missing.h5", *between, *output)


def test_the_options_of_the_finish_reach_the_yarns(folder, tmp_path):
    words = ["yarns", folder / "flat.h5", *DRAFT, "-o", tmp_path / "yarns.h5"]
    run(*words, "--bind-off", "chain", "--cast-on", "open")
    finish = YarnFinish(bind_off="chain", cast_on="open")
    expected = generate_yarns(read_stitches(folder / "flat.h5"), quality="draft", finish=finish)
    np.testing.assert_array_equal(read_yarns(tmp_path / "yarns.h5").points, expected.points)


def test_knit_makes_a_spiral_of_a_tube(tmp_path):
    """Without a spiral, each ring and the bind-off is a yarn; a spiral and its chain bind-off are one yarn."""
    write_mesh(tmp_path / "tube.obj", coarse_tube(8, 1, radius=2.0, height=3.0))
    words = ["knit", tmp_path / "tube.obj", "--stitch-width", "1", *DRAFT, "--device", "cpu", "--no-picture",
             "--max-iterations", "5", "--bind-off", "chain", "--spiral", "-o", tmp_path / "out"]  # fmt: skip
    run(*words)
    fabric, yarns = (read(tmp_path / "out" / name) for read, name in
                     ((read_stitches, "stitches.h5"), (read_yarns, "yarns.h5")))  # fmt: skip
    expected = generate_yarns(fabric, quality="draft", finish=YarnFinish(bind_off="chain"))
    assert fabric.row.max() > 1 and yarns.yarn_count == expected.yarn_count == 1
    assert json.loads((tmp_path / "out" / "report.json").read_text())["spiral"]["spirals"] == 1


def test_relax_samples_yarns_evenly_on_request(folder, tmp_path):
    words = ["relax", folder / "yarns.h5", "--even", *DRAFT, "--device", "cpu", "--max-iterations", "5",
             "-o", tmp_path / "free.h5"]  # fmt: skip
    run(*words)
    quality = replace(quality_named("draft"), max_iterations=5)
    start = sample_evenly(read_yarns(folder / "yarns.h5"))
    expected = relax_yarns(start, quality=quality, device="cpu", run=Run(False))
    np.testing.assert_array_equal(read_yarns(tmp_path / "free.h5").points, expected.yarns.points)


@pytest.fixture(scope="module")
def edited(folder) -> tuple[StitchMesh, YarnSet]:
    """Return the tube with a purl stitch, and the yarns of the original tube after a few steps of relaxation."""
    run("edit", folder / "tube.h5", "--replay", folder / "purl.jsonl", "-o", folder / "edited.h5")
    words = ["relax", folder / "yarns.h5", "--keep-shape", folder / "tube.h5", *DRAFT, "--device", "cpu",
             "--rest-length-factor", "1.05", "--max-iterations", "40", "-o", folder / "rested.h5"]  # fmt: skip
    run(*words)
    return read_stitches(folder / "edited.h5"), read_yarns(folder / "rested.h5")


def test_relax_edited_starts_from_the_relaxed_yarns(folder, tmp_path, edited, capsys):
    fabric, rested = edited
    words = ["relax-edited", folder / "rested.h5", "--before", folder / "tube.h5", "--after", folder / "edited.h5",
             *DRAFT, "--device", "cpu", "--max-iterations", "5", "--json", "--report", tmp_path / "report",
             "-o", tmp_path / "again.h5"]  # fmt: skip
    capsys.readouterr()
    run(*words)
    report = json.loads(capsys.readouterr().out)
    assert report["iterations"] == 5 and json.loads((tmp_path / "report" / "report.json").read_text()) == report
    made, start = regenerate_yarns(rested, read_stitches(folder / "tube.h5"), fabric, quality="draft")
    again = read_yarns(tmp_path / "again.h5")
    np.testing.assert_array_equal(again.rest_length, made.rest_length)  # With the factor of the first relaxation.
    quality = replace(quality_named("draft"), max_iterations=5)
    expected = relax_yarns(made, quality=quality, device="cpu", keep_shape=fabric, run=Run(start=start))
    np.testing.assert_array_equal(again.points, expected.yarns.points)


def test_relax_edited_checks_that_its_files_belong_together(folder, tmp_path, capsys, edited):
    at = {name: folder / f"{name}.h5" for name in ("rested", "tube", "edited", "flat")}
    output = ["-o", tmp_path / "out.h5", "--device", "cpu"]
    words = ["relax-edited", at["rested"], "--before", at["flat"], "--after", at["edited"], *DRAFT, *output]
    assert "with which the yarns were generated" in refused_without_files(capsys, tmp_path, *words)
    words = ["relax-edited", at["rested"], "--before", at["tube"], "--after", at["edited"], *output]
    # the quality differs
    assert "with which the yarns were generated" in refused_without_files(capsys, tmp_path, *words)
    words = ["relax-edited", at["tube"], "--before", at["tube"], "--after", at["flat"], *DRAFT, *output]
    assert "holds 'stitchmesh stitches'; expected 'stitchmesh yarns'" in refused_without_files(capsys, tmp_path, *words)


def test_relax_edited_relaxes_anew_where_no_stitch_is_as_before(folder, tmp_path, capsys, caplog, edited):
    words = ["relax-edited", folder / "rested.h5", "--before", folder / "tube.h5", "--after", folder / "flat.h5",
             *DRAFT, "--device", "cpu", "--max-iterations", "5", "--json", "-o", tmp_path / "again.h5"]  # fmt: skip
    capsys.readouterr()
    run(*words)
    report = json.loads(capsys.readouterr().out)
    assert report["warm"] == 0.0 and "hardly any stitch is where it was before the edit" in report["notes"][0]
    assert report["notes"][0] in caplog.text
    expected = generate_yarns(flat(12, 8), quality="draft")
    np.testing.assert_array_equal(read_yarns(tmp_path / "again.h5").start, expected.start)


def test_relax_edited_evens_out_crowded_stitches_and_writes_their_fabric(folder, tmp_path, capsys, caplog, edited):
    """A bobble in a stitch that is a quarter as high as it was has yarns that are too close to each other."""
    caplog.set_level("INFO")
    log(tmp_path / "rows.jsonl", *[("insert_row", {"face": FACE})] * 2, ("bobble", {"face": FACE}))
    run("edit", folder / "tube.h5", "--replay", tmp_path / "rows.jsonl", "-o", tmp_path / "rows.h5")
    words = ["relax-edited", folder / "rested.h5", "--before", folder / "tube.h5", "--after", tmp_path / "rows.h5",
             *DRAFT, "--device", "cpu", "--max-iterations", "5", "--json", "-o", tmp_path / "again.h5"]  # fmt: skip
    capsys.readouterr()
    run(*words)
    report = json.loads(capsys.readouterr().out)
    assert "evened out the stitches around the edit, because" in report["notes"][0]
    evened, crowded = read_stitches(tmp_path / "again.stitches.h5"), read_stitches(tmp_path / "rows.h5")
    assert "again.stitches.h5: the fabric of these yarns" in caplog.text
    assert evened.side_length[evened.is_wale].min() > 1.5 * crowded.side_length[crowded.is_wale].min()
    assert generate_yarns(evened, quality="draft").yarn_count == read_yarns(tmp_path / "again.h5").yarn_count


def test_info_describes_stitches_marks_and_yarns(folder, tmp_path, capsys):
    edits = [
        ("change_stitch", {"faces": [FACE], "stitch": "p"}),
        ("twist_loop", {"side": 4 * FACE + 2, "twist": 1}),
        ("cross_cable", {"side": 4 * 46 + 2, "left": 2, "right": 2, "front": "right"}),
        ("stripe", {"yarn": 1, "rows": [4]}),
    ]
    made = tmp_path / "made.smobj"
    log(tmp_path / "log.jsonl", *edits)
    words = ["edit", folder / "tube.h5", "--replay", tmp_path / "log.jsonl", "-o", made]
    run(*words)
    capsys.readouterr()
    run("info", made)
    described = dict(line.split(": ", 1) for line in capsys.readouterr().out.splitlines())
    assert described["rows"] == "6" and described["stitches"] == "89 knit, 18 cast-on, 1 purl"
    assert described["twisted loops"] == "1" and described["cables"] == "1 of 4 loops"
    assert described["colours"] == "2 (90 stitches of 0, 18 stitches of 1)"


def test_patterns_lists_the_library(capsys):
    run("patterns")
    _, *lines = capsys.readouterr().out.splitlines()
    assert tuple(line.split()[0] for line in lines) == (*pattern_names(), *weave_names())
    assert next(line.split()[1:5] for line in lines if line.startswith("twill-4x1 ")) == ["5", "x", "5", "woven"]
    assert next(line.split()[1:5] for line in lines if line.startswith("checks ")) == ["4", "x", "4", "2"]


def test_a_closed_output_pipe_is_not_an_error():
    read, write = os.pipe()
    os.close(read)
    words = [sys.executable, "-m", "stitchmesh", "patterns"]
    done = subprocess.run(words, stdout=write, stderr=subprocess.PIPE, cwd=ROOT)
    os.close(write)
    assert done.returncode == 0 and done.stderr == b""
