# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The command that relaxes swatches: its files; bad input gives one line, the exit status 2 and no files."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path

import numpy as np
import pytest

from stitchmesh.cli import main as cli
from stitchmesh.io import read_yarns
from stitchmesh.mesh.palette import STOCK
from stitchmesh.patterns import read_pattern
from stitchmesh.periodic.relaxation.continuation import size_of
from stitchmesh.render.pattern_sheet import swatch_sheet
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.tiling import tile_yarns
from stitchmesh.yarn.yarn_presets import Gauge, Yarn
from tests.cli.calls import refused_without_files
from tests.output_files import visible
from tests.periodic.free_cells import from_generated_yarns

DRAFT = ["--quality", "draft", "--device", "cpu"]
QUICK = [*DRAFT, "--no-picture"]


@pytest.fixture(scope="module")
def files(tmp_path_factory) -> Path:
    """Return a folder of valid and invalid charts and weaves."""
    folder = tmp_path_factory.mktemp("files")
    for name, text in {
        "ragged.leaf": "KKP\nKK\n", "open.knit": 'pattern "x"\nround 1: k3 yo\n',
        "empty.leaf": "", "slipped.leaf": "KB\n", "letters.weave": "0a\n10\n", "loose.weave": "01\n11\n",
        "apart.weave": "0111\n1011\n0001\n0010\n", "matrix.txt": "01\n10\n",
        "stated.txt": 'weave "plain"\n01\n10\n',
    }.items():  # fmt: skip
        (folder / name).write_text(text)
    (folder / "folder.weave").mkdir()
    (folder / "binary.knit").write_bytes(b"\x00\x01\xff\xfe" * 50)
    return folder


FREE = ["--relax-cell", "--relaxation", "frictionless"]


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Path:
    """Return the output folder of a relaxed repeat of stockinette, with all optional files."""
    folder = tmp_path_factory.mktemp("made") / "deep" / "out"
    words = [*FREE, "--tile", "3", "2", "--texture", "16", "24", "--gamma", "1.1"]
    with from_generated_yarns():
        assert cli.main(["swatch", "stockinette", *words, *DRAFT, "-o", str(folder)]) == 0
    return folder


def swatch(folder: Path, *words: object) -> YarnSet:
    assert cli.main(["swatch", *map(str, words), *QUICK, "-o", str(folder)]) == 0
    return read_yarns(folder / "cell.h5")


def test_swatch_writes_its_files(made):
    assert visible(made) == {
        "cell.h5", "cell.pyp", "tiled.bcc", "preview.png", "report.json", "convergence.csv", "convergence.png",
        "textures",
    }  # fmt: skip
    maps = {"colour.png", "height.png", "normal.png", "opacity.png", "tangent.png", "textures.json"}
    assert visible(made / "textures") == maps
    assert json.loads((made / "textures" / "textures.json").read_text())["pixels"] == [16, 24]


def test_the_report_holds_the_options_and_the_results(made):
    report = json.loads((made / "report.json").read_text())
    assert (report["pattern"], report["name"], report["source"]) == ("stockinette", "Stockinette", "Common knowledge")
    assert report["version"] and report["options"]["gamma"] == 1.1 and report["options"]["relax_cell"] is True
    # Its loops are 16.67 / 1.1 diameters long.
    assert [entry["kind"] for entry in report["ranges"]] == ["not validated"] and report["expected_error"] is None
    assert "loops of 15.2 core diameters" in report["ranges"][0]["text"]
    cell = read_yarns(made / "cell.h5")
    assert size_of(cell.lattice) == pytest.approx((report["width"], report["height"]), rel=1e-12)  # All digits.
    assert np.abs(cell.strain).max() == pytest.approx(report["max_strain"], rel=1e-6)  # Scaled by gamma and back.
    with (made / "convergence.csv").open() as file:
        *_, last = csv.DictReader(file)
    assert float(last["residual"]) == report["residual"]


def test_the_files_agree_with_each_other(made):
    cell = read_yarns(made / "cell.h5")
    pieces = read_yarns(made / "tiled.bcc", radius=0.125)
    assert pieces.yarn_count == tile_yarns(cell, 3, 2).yarn_count
    # The file holds knots in float32; the curves differ by some thousandths between the knots.
    assert pieces.lengths.sum() == pytest.approx(6 * cell.lengths.sum(), rel=0.01)
    again = read_yarns(made / "cell.pyp")
    assert again.lengths.sum() == pytest.approx(cell.lengths.sum(), rel=1e-9)  # All digits.


def test_the_fabric_covers_the_whole_picture(made):
    """No part of the picture is empty: each ninth of it contains shadows of yarns."""
    from PIL import Image

    pixels = np.asarray(Image.open(made / "preview.png").convert("L")).astype(int)
    assert max(pixels.shape) == 1400
    for band in np.array_split(pixels, 3, axis=0):
        for part in np.array_split(band, 3, axis=1):
            assert np.ptp(part) > 100


def test_options_reach_the_yarns(tmp_path):
    width = 1.2
    words = ["--yarn-radius", 0.1, "--spacing", 0.5, 0.6, "--rest-length", "warp=0.9", "--rest-length", "weft=1.1"]
    brief = ["--max-iterations", 5]
    cell = swatch(tmp_path / "a", "plain", *words, *brief, "--period", width, "free")
    plain = swatch(tmp_path / "b", "plain", *words[:5], *brief)
    assert visible(tmp_path / "b") == {
        "cell.h5", "cell.pyp", "tiled.bcc", "report.json", "convergence.csv", "convergence.png",
    }  # fmt: skip
    assert read_yarns(tmp_path / "b" / "tiled.bcc").yarn_count == tile_yarns(plain, 5, 5).yarn_count == 20
    assert set(cell.radius.tolist()) == {0.1}
    assert size_of(cell.lattice) == pytest.approx((width, 1.2), rel=1e-5)  # float32
    weft = cell.lattice_step[cell.segment_yarn, 0] != 0
    np.testing.assert_allclose(cell.rest_length / plain.rest_length, np.where(weft, 1.1, 0.9), rtol=1e-12)  # products
    knit = swatch(tmp_path / "c", "rib1x1", "--loop-length", 3.5, "--columns", 2, "--rows", 2, *brief)
    report = json.loads((tmp_path / "c" / "report.json").read_text())
    assert (report["wales"], report["courses"], report["iterations"]) == (4, 4, 5)
    assert knit.rest_length.sum() == pytest.approx(16 * 3.5, rel=1e-12)  # A sum


def test_digits_in_a_text_file_are_a_chart_of_colours_unless_it_states_a_weave(files, tmp_path, caplog):
    chart = swatch(tmp_path / "chart", files / "matrix.txt", "--colour", "1=#aa2233", "--max-iterations", 5)
    assert set(chart.colour.tolist()) == {0, 1} and (chart.face >= 0).all()
    np.testing.assert_array_equal(chart.palette, [STOCK[0], [0xAA, 0x22, 0x33]])
    assert caplog.text.count("read as a chart of yarn colours") == 1
    assert "name a matrix of a weave .weave" in caplog.text
    cell = swatch(tmp_path / "weave", files / "stated.txt", "--max-iterations", 5)
    assert cell.yarn_count == 4 and set(map(tuple, cell.lattice_step.tolist())) == {(1, 0), (0, 1)}


def test_a_pyp_that_cannot_hold_the_yarns_is_left_out_with_a_message(tmp_path, capsys):
    (tmp_path / "two.weave").write_text("warps radius: 1 1.5\n01\n10\n")
    swatch(tmp_path / "out", tmp_path / "two.weave", "--max-iterations", 5)
    assert not (tmp_path / "out" / "cell.pyp").exists() and (tmp_path / "out" / "cell.h5").exists()
    assert "cell.pyp: got yarns of radius 0.125 to 0.1875 cm" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("pattern", "message"),
    [
        ("stokinette", "is not in the library of .* did you mean .*stockinette"),
        ("missing.knit", "missing.knit: there is no such file"),
        ("missing.weave.png", "there is no such file"),
        ("folder.weave", "is a folder"),
        ("binary.knit", "binary"),
        ("ragged.leaf", "line 2, column 1: got 2 columns where the chart's first line has 3"),
        ("empty.leaf", "empty"),
        ("open.knit", "row 1: its tile leaves 4 loops|row 1"),
        ("slipped.leaf", "stitch 2 from the left: slips a loop that every row slips"),
        ("letters.weave", "'0a'|a"),
        ("loose.weave", "passes over every .* and never interlaces|never interlaces"),
        ("apart.weave", "the fabric falls apart"),
    ],
)
def test_a_bad_pattern_gives_a_message_of_one_line(files, capsys, monkeypatch, pattern, message):
    monkeypatch.chdir(files)
    assert re.search(message, refused_without_files(capsys, files, "swatch", pattern, "-o", "out", *QUICK))


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["stockinette", "--gamma", "0"], "gamma: got 0.0; expected 0.1 to 10"),
        (["garter", "--gamma", "10"], "yarn of this radius does not fit"),
        (["stockinette", "--period", "0", "1"], "period width: got 0.0 cm; expected a positive number"),
        (["stockinette", "--period", "free", "1e5"], "period height: got 100000 cm; expected 0.158 to 15.8"),
        (["stockinette", "--loop-length", "0.05"], "yarn of this radius does not fit; take thinner or longer yarn"),
        (["stockinette", "--spacing", "1"], "spacing: got one for a knitted swatch"),
        (["plain", "--spacing", "0"], "spacing: got 0.0 cm; expected a positive number"),
        (["plain", "--loop-length", "4"], "loop length: got one for a weave, which has no loops"),
        (["plain", "--columns", "2"], "the cell of a weave is one repeat"),
        (["stockinette", "--columns", "0"], "columns: got 0; expected at least 1"),
        (["stockinette", "--rest-length", "held=0.5"], "the fabric has no slip or tuck that holds a loop"),
        (["stockinette", "--rest-length", "k=3"], "got a factor of 3; expected 0.1 to 2"),
        (["stockinette", "--stiffness", "k_bent=2"], "is no value of a material; expected k_bend"),
        (["stockinette", "--tile", "0", "5"], "tile: got 0 5; expected whole numbers from 1"),
        (["stockinette", "--texture", "0"], "texture: got 0; expected a width"),
        (["stockinette", "--explore", "0"], "explore: got 0 starts"),
        (["stockinette", "--explore", "2", "--friction", "0.3"], "friction: got 0.3 for"),
        (["stockinette", "--explore", "2", "--tile", "3", "3"], "swatch: tile has no effect beside --explore"),
        (["stockinette", "--blocked", "0"], "expected a positive tension"),
        (["stockinette", "--blocked", "1e7"], "it tears at"),
        (["stockinette", "--relaxation", "dry", "--friction", "9"], "coefficients (9.0, 9.0); expected numbers from 0"),
        (["stockinette", "--relaxation", "dry", "--period", "1", "free"], "relaxation: got a period or blocking"),
        (["stockinette", "--unsupported"], "a repeat of fixed size lies on nothing anyway; add --relax-cell"),
    ],
)  # fmt: skip
def test_a_bad_option_gives_a_message_of_one_line(tmp_path, capsys, monkeypatch, words, message):
    monkeypatch.chdir(tmp_path)
    assert message in refused_without_files(capsys, tmp_path, "swatch", *QUICK, *words, "-o", "out")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--port", "9000"], "swatch: serving has no effect beside -o DIR; add --view"),
        (["--view"], "swatch: output has no effect beside --view"),
    ],
)
def test_an_option_without_effect_is_refused(capsys, tmp_path, words, message):
    assert message in refused_without_files(capsys, tmp_path, "swatch", "stockinette", "-o", tmp_path / "out", *words)


def test_a_folder_that_cannot_be_written_is_an_error_before_the_computation(tmp_path, capsys):
    (tmp_path / "file").touch()
    for folder in (tmp_path / "file", tmp_path / "file" / "out"):
        message = refused_without_files(capsys, tmp_path, "swatch", "plain", "-o", folder, *QUICK)
        assert "choose another folder" in message


def test_convert_writes_tiles(made, tmp_path, capsys):
    assert cli.main(["convert", str(made / "cell.h5"), str(tmp_path / "six.h5"), "--tile", "3", "2"]) == 0
    expected = tile_yarns(read_yarns(made / "cell.h5"), 3, 2)
    np.testing.assert_array_equal(read_yarns(tmp_path / "six.h5").points, expected.points)
    words = ["convert", tmp_path / "six.h5", tmp_path / "more.bcc", "--tile", "2", "2"]
    assert "do not repeat" in refused_without_files(capsys, tmp_path, *words)
    assert "expected a whole number from 1" in refused_without_files(
        capsys, tmp_path, "convert", made / "cell.h5", tmp_path / "none.bcc", "--tile", "0", "2"
    )


def test_convert_tiles_yarns_only(tmp_path, capsys):
    (tmp_path / "face.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    words = ["convert", tmp_path / "face.obj", tmp_path / "face.ply", "--tile", "2", "2"]
    assert "is a polygon mesh; only periodic yarns can be tiled" in refused_without_files(capsys, tmp_path, *words)


@pytest.mark.nightly
def test_explore_writes_and_prints_the_states_of_rest(tmp_path, capsys):
    words = ["stockinette", "--explore", "1", "--relaxation", "frictionless", *DRAFT, "-o", str(tmp_path)]
    with from_generated_yarns():
        assert cli.main(["swatch", *words]) == 0
    report = json.loads((tmp_path / "rests.json").read_text())
    states = len(report["rests"])
    assert report["starts"] == 2 and sum(rest["count"] for rest in report["rests"]) + report["not_at_rest"] == 2
    yarns = {f"rest-{number}.h5" for number in range(1, states + 1)}
    assert visible(tmp_path) == {"rests.json", "rests.png", *yarns}
    printed = capsys.readouterr().out.splitlines()
    assert printed[-3].startswith("The starts differ by ") and len(report["spread"]) == 2
    assert len(printed) == states + 4 and printed[-2].startswith(f"Found {states} state")
    width = size_of(read_yarns(tmp_path / "rest-1.h5").lattice)[0]
    assert width == pytest.approx(report["rests"][0]["wale_spacing"], rel=1e-6)


def test_a_blocked_repeat_is_pulled_and_an_unsupported_one_lies_on_nothing(tmp_path):
    brief = ["--max-iterations", "5"]
    reports = {}
    for name, words in (("flat", FREE), ("loose", [*FREE, "--unsupported"]), ("blocked", ["--blocked", "50"])):
        with from_generated_yarns():
            swatch(tmp_path / name, "stockinette", *words, *brief)
        reports[name] = json.loads((tmp_path / name / "report.json").read_text())
    assert "confinement" in reports["flat"]["energies"] and "confinement" not in reports["loose"]["energies"]
    assert reports["blocked"]["options"]["blocked"] == 50.0 and "tension" in reports["blocked"]["energies"]


def test_a_knit_off_the_needles_writes_its_path(tmp_path) -> None:
    swatch(tmp_path / "out", "stockinette", "--relaxation", "wet", "--friction", "0.3")
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    assert (report["relaxation"], report["friction"], report["options"]["relaxation"]) == ("wet", 0.3, "wet")
    history = list(csv.DictReader((tmp_path / "out" / "convergence.csv").open()))
    assert "friction_erg" in history[0]
    assert int(history[-1]["iteration"]) == report["iterations"]


def test_torque_and_steam_reach_the_yarns_and_the_summary(tmp_path, capsys) -> None:
    words = ["--residual-twist", "-4", "--steamed", "0.5", "--relax-cell", "--relaxation", "frictionless"]
    with from_generated_yarns():
        yarns = swatch(tmp_path / "out", "stockinette", *words)
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    assert report["spirality"] < 0.0 and report["torque"] < 0.0 and report["steamed"] == 0.5
    assert (report["options"]["residual_twist"], report["options"]["steamed"]) == (-4.0, 0.5)
    assert "degrees to the left under a torque of" in capsys.readouterr().out
    assert yarns.natural_curvature.any()


def test_a_pattern_to_take_home_is_written_where_it_is_asked_for(tmp_path):
    """It states the size of the report and all yarn of the repeat, by colour."""
    yarns = swatch(tmp_path / "out", "checks", "--sheet", "--yarn", "dk", "--max-iterations", 5)
    assert (tmp_path / "out" / "pattern.pdf").read_bytes().startswith(b"%PDF-")
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    gauge, dk = Gauge.of_stitch(report["wale_spacing"], report["course_spacing"]), Yarn.named("dk")
    sheet = swatch_sheet(read_pattern("checks"), yarns, gauge, yarn=dk)
    size = f"{report['width']:.3g} x {report['height']:.3g} cm"
    assert size in dict(sheet.facts)["One repeat"] and dict(sheet.facts)["Gauge"] == str(gauge)
    metres = sum(one.metres for one in sheet.amounts)
    assert len(sheet.amounts) == 2 and metres == pytest.approx(yarns.lengths.sum() / 100.0, rel=1e-12)  # rounding
