# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stitches of the user's own on a fabric: laid with a pattern, edited, undone, stored, written, drawn and relaxed."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.cli import main as cli
from stitchmesh.editing.edit import Edit, apply_changes, apply_edit
from stitchmesh.errors import FileError, ParameterError
from stitchmesh.hand_knitting import knitting_instructions
from stitchmesh.io import read_stitches, write_stitches
from stitchmesh.io.own_stitches import format_own_drawings, parse_own_drawings, read_own_drawings
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.own_stitch import FIRST_OWN
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.meshrelax import relax_mesh
from stitchmesh.patterns import apply_pattern, capture_pattern, lay_pattern, parse_pattern, read_pattern
from stitchmesh.render.colouring import stitch_key
from stitchmesh.yarngen import generate_yarns
from stitchmesh.yarngen.loop_check.loop_linking import check_loops
from stitchmesh.yarnrelax import relax_yarns
from tests.editing.fabrics import around, flat
from tests.editing.random_edits import bits
from tests.gallery import ROOT, grid

FOLDER = ROOT / "examples" / "stitches"
(DAISY,) = read_own_drawings(FOLDER / "daisy.json")
PATTERN = read_pattern(FOLDER / "daisy.knit", [DAISY])


def with_daisies(fabric: StitchMesh) -> StitchMesh:
    return lay_pattern(fabric, PATTERN).fabric


@pytest.mark.parametrize("make", [lambda: flat(10, 8), lambda: around(12, 6)], ids=["flat", "around"])
def test_a_pattern_with_it_is_laid_and_undone_exactly(make):
    fabric = make()
    laid = lay_pattern(fabric, PATTERN)
    assert laid.fabric.own_stitches == (DAISY,) and (laid.fabric.stitch == FIRST_OWN).sum() > 5
    edited = apply_changes(fabric, laid.changes)
    undone = apply_changes(edited.fabric, edited.inverse).fabric
    assert bits(edited.fabric) == bits(laid.fabric)
    assert bits(undone) == bits(fabric) and undone.own_stitches == ()


@pytest.mark.nightly
def test_its_yarns_are_linked_as_its_code_says_and_come_to_rest():
    surface = grid(6, 6, height=0.72)
    fabric = relax_mesh(with_daisies(flat(6, 6)), surface=surface).fabric
    yarns = generate_yarns(fabric, quality="draft")
    check_loops(fabric, yarns)
    report = relax_yarns(yarns, quality="draft", keep_shape=fabric).report
    assert report["converged"] and report["pull_throughs"] == 0


def test_a_second_stitch_gets_the_next_type_code():
    other = parse_own_drawings("text", format_own_drawings((DAISY,)).replace(b'"daisy"', b'"aster"'))
    pattern = parse_pattern("round 1: k4\nround 2: aster k1\nround 3: k4\nround 4: daisy k1", stitches=[DAISY, *other])
    fabric = apply_pattern(apply_pattern(around(12, 6), PATTERN), pattern)
    assert [stitch.code for stitch in fabric.own_stitches] == ["daisy", "aster"]
    rows = [set(fabric.stitch[fabric.row == row].tolist()) for row in range(1, 6)]
    assert rows[1] == {int(Stitch.KNIT), FIRST_OWN + 1} and rows[3] == {int(Stitch.KNIT), FIRST_OWN}


def test_it_is_captured_with_its_region():
    fabric = with_daisies(around(12, 6))
    captured = capture_pattern(fabric, faces=np.flatnonzero((fabric.row > 0) & (fabric.row < 5)))
    assert captured.own_stitches == (DAISY,)


def test_hdf5_keeps_its_drawing(tmp_path):
    fabric = with_daisies(flat(10, 8))
    write_stitches(tmp_path / "own.h5", fabric)
    again = read_stitches(tmp_path / "own.h5")
    assert bits(again) == bits(fabric) and again.own_stitches == fabric.own_stitches
    assert parse_own_drawings("text", format_own_drawings((DAISY,))) == (DAISY,)


def test_a_damaged_drawing_in_hdf5_is_one_line(tmp_path):
    path = tmp_path / "own.h5"
    write_stitches(path, with_daisies(flat(10, 8)))
    content = path.read_bytes()
    path.write_bytes(content.replace(b'"makes":"d123kyk"', b'"makes":"d123kyq"'))
    with pytest.raises(FileError, match="makes 'd123kyq'") as error:
        read_stitches(path)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(("name", "message"), [("own.smobj", "write an .h5 file"), ("own.k", "cannot make .* daisy")])
def test_files_that_cannot_hold_it_are_not_written(tmp_path, name, message):
    with pytest.raises(ParameterError, match=message):
        write_stitches(tmp_path / name, with_daisies(around(12, 6)))
    assert not list(tmp_path.iterdir())


def test_instructions_and_pictures_name_it():
    fabric = with_daisies(around(12, 6))
    text = knitting_instructions(fabric)
    assert f"daisy: {DAISY.instruction}" in text and "Round 1: [daisy, k1] 3 times." in text
    assert [name for name, _ in stitch_key(fabric, fabric.stitch)] == ["knit", "cast-on", "daisy"]


def test_edits_beside_it_keep_it():
    fabric = with_daisies(flat(10, 8))
    face = int(np.flatnonzero(fabric.row == 2)[0])
    more = apply_edit(fabric, Edit("insert_row", {"face": face})).fabric
    assert (more.stitch == FIRST_OWN).sum() == (fabric.stitch == FIRST_OWN).sum()


def test_the_command_lays_it(tmp_path):
    write_stitches(tmp_path / "plain.h5", around(12, 6))
    words = ["pattern", str(tmp_path / "plain.h5"), str(FOLDER / "daisy.knit"), "-o", str(tmp_path / "daisies.h5")]
    assert cli.main(words) == 2 and not (tmp_path / "daisies.h5").exists()
    assert cli.main([*words, "--stitches", str(FOLDER / "daisy.json")]) == 0
    assert read_stitches(tmp_path / "daisies.h5").own_stitches == (DAISY,)
