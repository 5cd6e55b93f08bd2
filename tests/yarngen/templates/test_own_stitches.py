# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stitches of the user's own: their files, their checks, their words in patterns, and their yarn in a swatch."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.cli import main as cli
from stitchmesh.errors import FileError, ParameterError, PatternError, YarnError
from stitchmesh.io.own_stitches import read_own_drawings
from stitchmesh.mesh.own_stitch import FIRST_OWN
from stitchmesh.mesh.stitch import CODES, SIDE_COUNTS
from stitchmesh.patterns import format_pattern, parse_pattern, read_pattern
from stitchmesh.periodic.repeat.torus import torus_mesh
from stitchmesh.yarngen import generate_yarns
from stitchmesh.yarngen.loop_check.loop_linking import check_loops
from stitchmesh.yarngen.templates.own_checks import check_own_stitch, read_own_stitches
from stitchmesh.yarngen.templates.table import drawings, template
from tests.gallery import ROOT

FOLDER = ROOT / "examples" / "stitches"


@pytest.fixture(scope="module")
def daisy():
    (stitch,) = read_own_drawings(FOLDER / "daisy.json")
    return stitch


def drawn(code, makes=None, name="mine"):
    """A built-in drawing as a stitch of one's own, which has all its facts."""
    content = {name: {"makes": makes or code, "parts": drawings()[code]}}
    return json.dumps(content)


def test_the_drawing_of_a_built_in_stitch_is_accepted_for_its_code(tmp_path):
    (tmp_path / "own.json").write_text(drawn("d12k"))
    (stitch,) = read_own_stitches(tmp_path / "own.json")
    known = CODES["d12k"]
    for one, other in zip(template(stitch, *SIDE_COUNTS[known]).parts, template(known, *SIDE_COUNTS[known]).parts,
                          strict=True):  # fmt: skip
        assert (one.start, one.end, one.is_head) == (other.start, other.end, other.is_head)
        np.testing.assert_array_equal(one.curve, other.curve)


CONTRADICTIONS = {
    "purled": ("ky", "py", r"part 2 passes 1 times through the loop of part 1, .*'py' of its code makes it -1"),
    "other order": ("d12k", "d21k", r"loop 2 below .* does not lie in front of loop 1 .* throughout"),
    "too few loops": ("ky", "k", r"the face has no such crossing"),
    "too many loops": ("ky", "kyk", r"0 parts end at top 3"),
}  # fmt: skip


@pytest.mark.parametrize("case", CONTRADICTIONS)
def test_a_drawing_that_contradicts_its_code_is_refused_in_one_line(tmp_path, case):
    code, makes, message = CONTRADICTIONS[case]
    (tmp_path / "own.json").write_text(drawn(code, makes))
    with pytest.raises(YarnError, match=message) as error:
        read_own_stitches(tmp_path / "own.json")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"head": False}, "part 1 has head false; expected true, because it is a loop below"),
        ({"through": [[0.9, 0.4, 0.5], [0.9, 0.4, 0.5]]}, "part 1: got the point .* twice in a row"),
        ({"through": []}, "part 4 passes 0 times through the loop of part 1"),
        ({"through": [[0.9, 0.4, 1e300]]}, "part 1: got the point .* expected coordinates within 100"),
    ],
)
def test_a_part_that_cannot_be_drawn_is_refused_in_one_line(tmp_path, change, message):
    content = json.loads((FOLDER / "daisy.json").read_text())
    content["daisy"]["parts"][0].update(change)
    (tmp_path / "own.json").write_text(json.dumps(content))
    with pytest.raises((FileError, YarnError), match=message):
        read_own_stitches(tmp_path / "own.json")


def test_yarns_that_come_too_close_and_points_outside_the_face_are_refused(tmp_path, daisy):
    rough = drawings()["ky"]
    parts = daisy.parts
    outside = replace(daisy, parts=(*parts[:-1], replace(parts[-1], through=((5.0, 0.5, 0.0),))))
    with pytest.raises(YarnError, match=r"part 7 leaves the face by .* stitch widths"):
        check_own_stitch(outside)
    flattened = [{**part, "through": [[x, y, 0.3 * z] for x, y, z in part["through"]]} for part in rough]
    (tmp_path / "own.json").write_text(json.dumps({"mine": {"makes": "ky", "parts": flattened}}))
    with pytest.raises(YarnError, match=r"stitch 'mine': .*radi"):
        read_own_stitches(tmp_path / "own.json")


@pytest.mark.parametrize(("content", "message"), [
    ("{}", "holds no stitch"), ("[", "is no JSON"), ('{"mine": {"makes": "k"}}', "parts"),
    ('{"K2": {"makes": "k", "parts": []}}', "expected 2 to 16 letters"),
])  # fmt: skip
def test_a_file_that_holds_no_drawings_is_refused(tmp_path, content, message):
    (tmp_path / "own.json").write_text(content)
    with pytest.raises(FileError, match=message):
        read_own_stitches(tmp_path / "own.json")


def test_its_code_is_a_word_of_patterns_on_the_right_side(daisy):
    pattern = read_pattern(FOLDER / "daisy.knit", [daisy])
    assert pattern.own_stitches == (daisy,) and pattern.closes
    assert parse_pattern(format_pattern(pattern), stitches=[daisy]) == pattern
    assert parse_pattern("chart:\n  daisy k", stitches=[daisy]).rows[0] == pattern.rows[2]
    with pytest.raises(PatternError, match="got 'daisy'; expected a stitch"):
        parse_pattern("round 1: daisy k")
    with pytest.raises(PatternError, match="got daisy in a row on the wrong side"):
        parse_pattern("row 1 WS: daisy k", stitches=[daisy])
    with pytest.raises(ParameterError, match="this code is taken already"):
        parse_pattern("round 1: k", stitches=[daisy, daisy])


def test_its_loops_are_linked_as_its_code_says(daisy):
    fabric = torus_mesh(read_pattern(FOLDER / "daisy.knit", [daisy]), stitch_width=1.0, stitch_height=0.8)
    assert fabric.stitch.max() == FIRST_OWN
    check_loops(fabric, generate_yarns(fabric))


def test_the_command_refuses_a_contradiction_and_writes_nothing(tmp_path, capsys):
    (tmp_path / "own.json").write_text(drawn("ky", "py", "daisy"))
    words = ["swatch", str(FOLDER / "daisy.knit"), "--stitches", str(tmp_path / "own.json")]
    assert cli.main([*words, "-o", str(tmp_path / "out")]) == 2 and not (tmp_path / "out").exists()
    assert capsys.readouterr().err.count("\n") == 1
