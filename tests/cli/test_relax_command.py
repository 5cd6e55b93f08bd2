# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command that relaxes yarns: the effect of each option; a bad option gives one line and the exit status 2."""

from __future__ import annotations

import json
import logging
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from stitchmesh.cli import main as cli
from stitchmesh.io import read_stitches, read_yarns, write_mesh, write_yarns
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.rest_length import stitch_lengths
from tests.cli.calls import refused, refused_without_files
from tests.gallery import ROOT, tube
from tests.output_files import visible

QUICK = ["--quality", "draft", "--device", "cpu", "--max-iterations", "20"]


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Path:
    """Return a folder with a stitch mesh of about a hundred stitches and its generated yarns."""
    folder = tmp_path_factory.mktemp("made")
    write_mesh(folder / "tube.obj", tube(8, 2, radius=2.0, height=1.5))
    at = {name: str(folder / f"{name}.h5") for name in ("rows", "stitches", "yarns")}
    assert cli.main(["label", str(folder / "tube.obj"), "-o", at["rows"]]) == 0
    assert cli.main(["tessellate", at["rows"], "--stitch-width", "1", "-o", at["stitches"]]) == 0
    assert cli.main(["yarns", at["stitches"], "--quality", "draft", "-o", at["yarns"]]) == 0
    return folder


def printed_by(monkeypatch, capsys, *words: object) -> str:
    """Return the standard error of a command in a new process, in which the command configures logging itself."""
    with monkeypatch.context() as patch:
        patch.setattr(logging.root, "handlers", [])
        assert cli.main(["relax", *map(str, words)]) == 0
    return capsys.readouterr().err


def relax(made: Path, output: Path, *words: object) -> YarnSet:
    assert cli.main(["relax", str(made / "yarns.h5"), "-o", str(output), *QUICK, *map(str, words)]) == 0
    return read_yarns(output)


def test_a_report_is_written_only_if_its_option_is_given(made, tmp_path, capsys):
    relaxed = relax(made, tmp_path / "alone" / "relaxed.h5")
    assert visible(tmp_path / "alone") == {"relaxed.h5"}
    first, second, last = capsys.readouterr().out.splitlines()
    assert first.startswith(f"Relaxed {relaxed.yarn_count} yarns, ") and first.endswith(" cm.")
    assert second == "Not good: the yarns are not at rest after 20 iterations; raise --max-iterations."
    assert last == f"Wrote {tmp_path / 'alone' / 'relaxed.h5'}; --report DIR writes all numbers."
    relax(made, tmp_path / "out" / "relaxed.h5", "--report", tmp_path / "report", "--json")
    assert visible(tmp_path / "out") == {"relaxed.h5"}
    assert visible(tmp_path / "report") == {
        "report.json", "convergence.csv", "convergence.png",
    }  # fmt: skip
    report = json.loads((tmp_path / "report" / "report.json").read_text())
    assert report == json.loads(capsys.readouterr().out)
    assert report["iterations"] == 20 and report["device"] == "cpu"


def test_an_estimated_radius_is_logged_once_and_a_given_one_is_not(made, tmp_path, capsys, monkeypatch):
    write_yarns(tmp_path / "curves.bcc", read_yarns(made / "yarns.h5"))
    words = [tmp_path / "curves.bcc", "-o", tmp_path / "relaxed.h5", *QUICK]
    assert printed_by(monkeypatch, capsys, *words).count("yarn radius: ") == 1
    assert "yarn radius" not in printed_by(monkeypatch, capsys, *words, "--yarn-radius", "0.11")
    np.testing.assert_array_equal(read_yarns(tmp_path / "relaxed.h5").radius, 0.11)


def test_rest_lengths_follow_the_options(made, tmp_path):
    before = read_yarns(made / "yarns.h5")
    words = ["--rest-length-factor", "1.1", "--rest-length", "yarn:0=0.9", "--rest-length", "row:1=0.95"]
    after = relax(made, tmp_path / "relaxed.h5", *words)
    row = before.row[before.segment_points[:, 1]]
    asked = 1.1 * np.where(before.segment_yarn == 0, 0.9, 1.0) * np.where(row == 1, 0.95, 1.0)
    np.testing.assert_allclose(after.rest_length, before.rest_length * asked, rtol=1e-12)  # Three products.


def test_a_loop_length_is_that_of_every_plain_stitch(made, tmp_path):
    fabric = read_stitches(made / "stitches.h5")
    words = ["--fabric", made / "stitches.h5", "--loop-length", "3.5", "--rest-length", "k=1.1"]
    after = relax(made, tmp_path / "relaxed.h5", *words)
    inside = np.isin(fabric.row, np.arange(1, fabric.row.max())) & (fabric.stitch == Stitch.KNIT)
    assert inside.any()
    np.testing.assert_allclose(stitch_lengths(after, fabric)[inside], 1.1 * 3.5, rtol=1e-12)  # A sum of 12 products.


@pytest.mark.parametrize(
    ("words", "term"),
    [
        (["--gravity", "0", "-981", "0"], "gravity"),
        (["--friction", "0.3,0.5"], "friction"),
        (["--twist", "1,6.28"], "twist"),
        (["--body", "tube.obj"], "body"),
        (["--body", "tube.obj", "--body-unit", "mm"], "body"),
    ],
)
def test_a_term_is_in_the_report_if_its_option_is_given(made, tmp_path, capsys, monkeypatch, words, term):
    """In centimetres the body touches the yarns; in millimetres it is a tenth as large and inside them."""
    monkeypatch.chdir(made)
    relax(made, tmp_path / "relaxed.h5", "--json", *words)
    energies = json.loads(capsys.readouterr().out)["energies"]
    assert set(energies) == {"stretch", "length", "bend", "contact", term}
    assert (energies[term] == 0.0) == ("mm" in words)


def test_pinned_points_do_not_move(made, tmp_path):
    before = read_yarns(made / "yarns.h5")
    after = relax(made, tmp_path / "relaxed.h5", "--pin-point", "0", "--pin-point", "7", "--pin-face", "9")
    held = np.union1d([0, 7], np.flatnonzero(before.face == 9))
    moved = np.linalg.norm(after.points - before.points, axis=1)
    assert len(held) > 2
    assert moved[held].max() < 1e-6  # The rounding error of float32 is 6e-8 of a few cm.
    assert np.delete(moved, held).max() > 1e-3


def test_a_term_that_is_off_is_not_imported():
    code = (
        "import sys; from stitchmesh.cli.arguments import parse; from stitchmesh.cli.main import COMMANDS;"
        "words = ['relax', 'y.h5', '-o', 'z.h5', '--gravity', '0', '-981', '0'];"
        "made = parse(COMMANDS, words, program='stitchmesh', description='');"
        "made.physics.terms(); print(' '.join(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    loaded = {name.removeprefix("stitchmesh.yarnrelax.") for name in done.stdout.split()}
    assert "stitchmesh.simulation.dead_load" in loaded
    assert not loaded & {"energies.friction", "energies.twist", "energies.body", "constraints.pins"}


def test_solver_and_material_follow_the_options(made, tmp_path, capsys):
    relax(made, tmp_path / "relaxed.h5", "--json", "--solver", "dynamics")
    assert json.loads(capsys.readouterr().out)["solver"] == "dynamics"
    relax(made, tmp_path / "relaxed.h5", "--json", "--material", "kaldor-simulation")
    report = json.loads(capsys.readouterr().out)
    assert report["solver"] == "quasistatic"
    assert report["energies"].get("length", 0.0) == 0.0  # The material of Kaldor et al. has no length penalty.


def test_a_relaxation_that_was_stopped_continues_to_the_same_bits(made, tmp_path):
    words = ["--quality", "standard", "--checkpoint-every", "20"]
    relax(made, tmp_path / "first.h5", *words)
    checkpoint = tmp_path / "first.checkpoints" / "checkpoint.smc"
    resumed = relax(made, tmp_path / "second.h5", *words, "--max-iterations", "60", "--resume", checkpoint)
    whole = relax(made, tmp_path / "whole.h5", "--quality", "standard", "--max-iterations", "60")
    np.testing.assert_array_equal(resumed.points, whole.points)


def test_an_interrupt_writes_the_last_good_state(made, tmp_path, capsys, monkeypatch):
    from stitchmesh.pipeline import yarn_relaxation

    def strike(*_args, run, **_options):
        run.on_state(read_yarns(made / "yarns.h5"))
        raise KeyboardInterrupt

    monkeypatch.setattr(yarn_relaxation, "relax_yarns", strike)
    words = ["relax", str(made / "yarns.h5"), "-o", str(tmp_path / "out.h5"), *QUICK, "--report", str(tmp_path / "how")]
    assert cli.main(words) == 130
    assert "interrupted" in capsys.readouterr().err
    np.testing.assert_array_equal(read_yarns(tmp_path / "out.h5").points, read_yarns(made / "yarns.h5").points)
    assert json.loads((tmp_path / "how" / "report.json").read_text()) == {"unfinished": True}


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--max-iterations", "0"], "max iterations: got 0; expected at least 1"),
        (["--material", "wool"], "material: got 'wool'; expected one of"),
        (["--rest-length-factor", "0"], "rest length factor: got 0.0; expected a positive number"),
        (["--loop-length", "3"], "loop length: got no fabric"),
        (["--rest-length", "k=1.1"], "rest length k: got no fabric"),
        (["--rest-length", "k"], "rest length: got 'k'; expected CODE=FACTOR"),
        (["--rest-length", "row:999=1.1"], "no yarn is in that row"),
        (["--rest-length", "yarn:999=1.1"], "there is no such yarn"),
        (["--friction", "-1"], "friction: got coefficients"),
        (["--twist", "0"], "twist: got k_twist 0.0"),
        (["--body", "nothing.obj"], "nothing.obj: there is no such file"),
        (["--pin-point", "999999"], "pins: got control point 999999"),
        (["--pin-face", "-1"], "pins: got stitch face -1"),
        (["--checkpoint-every", "0"], "checkpoint: got one every 0 iterations"),
        (["--resume", "nothing.smc"], "nothing.smc"),
        (["--fabric", "nothing.h5", "--loop-length", "3"], "nothing.h5: there is no such file"),
        (["--fabric", "nothing.h5"], "fabric: no rest length asks for it"),
        (["--body-unit", "mm"], "body unit: got 'mm' without a body; give the body, or leave it out"),
    ],
)
def test_a_bad_option_gives_a_message_of_one_line_and_writes_nothing(made, tmp_path, capsys, words, message):
    words = ["relax", made / "yarns.h5", "-o", tmp_path / "out" / "relaxed.h5", *QUICK, *words]
    assert message in refused_without_files(capsys, tmp_path, *words)


def test_an_output_that_cannot_be_written_is_an_error_before_the_computation(made, tmp_path, capsys, monkeypatch):
    from stitchmesh.pipeline import yarn_relaxation

    monkeypatch.setattr(yarn_relaxation, "relax_yarns", None)  # A call would raise an error.
    source, folder, file = made / "yarns.h5", tmp_path / "folder.h5", tmp_path / "file"
    folder.mkdir()
    file.write_text("in the way")
    assert "unknown format '.xyz'" in refused(capsys, "relax", source, "-o", tmp_path / "relaxed.xyz")
    assert "is a folder" in refused(capsys, "relax", source, "-o", folder)
    assert "cannot be written" in refused(capsys, "relax", source, "-o", file / "relaxed.h5")
    assert "cannot be written" in refused(capsys, "relax", source, "-o", tmp_path / "relaxed.h5", "--report", file)
