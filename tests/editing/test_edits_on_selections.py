# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Edits on selections: where they are made, exact undo, and the log."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.cli import main as cli
from stitchmesh.editing.edit import Edit, apply_edit
from stitchmesh.editing.history import History, replay_edits
from stitchmesh.editing.pattern_regions import PatternRegion, lay_patterns
from stitchmesh.errors import ParameterError, StitchMeshError
from stitchmesh.io import read_stitches, write_stitches
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.cable_groups import cable_groups
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.patterns import apply_pattern, read_pattern
from stitchmesh.selection import parse_selection, select
from tests.editing.fabrics import around, flat
from tests.editing.random_edits import arrays_of, bits

ARGUMENTS: dict[str, dict[str, object]] = {
    "change_stitch": {"on": "rows 2-3", "stitch": "p"},
    "twist_loop": {"on": "rows 2-3", "twist": 1},
    "stripe": {"on": "rows 1-4 step 2", "yarn": 1},
    "stripes": {"on": "rows 1-4", "bands": "1 navy, 2 0"},
    "cross_cable": {"on": "rows 2-3", "left": 1, "right": 2, "front": "left"},
    "set_cable": {"on": "row 2", "destinations": [1, 0], "layers": [1, 0]},
    "split_course_edge": {"on": "row 2 and border 0 3- "},
    "insert_wale": {"on": "rectangle 16 2x2", "courses": 2},
    "remove_wale": {"on": "rectangle 2 2x6"},
    "flip_row": {"on": "rows 2-3"},
    "insert_row": {"on": "rows 2-3"},
    "remove_row": {"on": "rows 2-3"},
    "short_rows": {"on": "rectangle 15 4x1"},
    "bobble": {"on": "rectangle 15 1x1 or rectangle 19 1x1"},
    "paste_pattern": {"on": "rows 1-4", "pattern": "rib1x1"},
}
"""Arguments of edits on the flat fabric of 7 x 6 stitches."""
WHOLE = ("spiral", "unspiral", "graft", "ungraft", "recolour")
"""Edits of the whole mesh, or of its palette."""


@pytest.mark.parametrize("name", ARGUMENTS)
def test_undo_and_redo_are_exact_and_the_log_gives_the_same_bits(name, tmp_path):
    start, history = flat(), History(flat())
    history.apply(Edit(name, ARGUMENTS[name]))
    end = bits(history.fabric)
    assert end != bits(start)
    StitchMesh(**arrays_of(history.fabric))
    history.write(tmp_path / "log.jsonl")
    assert bits(replay_edits(start, tmp_path / "log.jsonl")) == end
    assert bits(history.undo()) == bits(start)
    assert bits(history.redo()) == end


def test_edits_that_continue_others_take_selections_too():
    history = History(flat())
    history.apply(Edit("cross_cable", {"on": "rows 2-3", "left": 1, "right": 1, "front": "left"}))
    assert len(cable_groups(history.fabric)) == 6
    history.apply(Edit("clear_cable", {"on": "row 2"}))
    assert len(cable_groups(history.fabric)) == 3
    split = History(flat())
    split.apply(Edit("split_course_edge", {"on": "faces 17"}))
    shaped = bits(split.fabric)
    split.apply(Edit("add_wale_edge", {"on": "increases", "below": 1, "above": 1}))
    assert split.fabric.face_count == flat().face_count + 1
    split.apply(Edit("remove_wale_edge", {"on": "stitch k and wale 17 and row 2"}))
    assert split.fabric.face_count == flat().face_count
    split.undo()
    split.undo()
    split.apply(Edit("collapse_course_edge", {"on": "increases"}))
    assert bits(split.fabric) != shaped and split.fabric.face_count == flat().face_count


def test_edits_of_the_whole_mesh_take_no_selection():
    for name in WHOLE:
        with pytest.raises(ParameterError, match=f"{name}: takes no selection"):
            apply_edit(flat(), Edit(name, {"on": "all"}))


def test_an_edit_of_faces_is_that_of_the_selected_faces():
    fabric = around(12, 5)
    text = "hem 2-3 and front"
    one = apply_edit(fabric, Edit("change_stitch", {"on": text, "stitch": "p"})).fabric
    other = apply_edit(fabric, Edit("change_stitch", {"faces": select(fabric, text), "stitch": "p"})).fabric
    assert bits(one) == bits(other)
    same = apply_edit(fabric, Edit("change_stitch", {"on": parse_selection(text), "stitch": "p"})).fabric
    assert bits(same) == bits(one)


def test_a_row_is_inserted_above_each_selected_row_once():
    fabric = around(12, 5)
    assert apply_edit(fabric, Edit("insert_row", {"on": "hem 3"})).fabric.face_count == fabric.face_count + 3 * 12
    assert apply_edit(fabric, Edit("remove_row", {"on": "hem 2-3"})).fabric.face_count == fabric.face_count - 2 * 12


def test_crossings_lie_side_by_side_along_each_row():
    made = apply_edit(flat(), Edit("cross_cable", {"on": "rows 2-3", "left": 1, "right": 2, "front": "left"})).fabric
    assert sorted(int(made.side_face[group.sides[0]]) for group in cable_groups(made)) == [14, 17, 21, 24]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"on": "hemm 3", "yarn": 1}, "'hemm' is unknown; did you mean 'hem'"),
        ({"on": "stitch p", "yarn": 1}, "is empty"),
        ({"on": 3, "yarn": 1}, "selection '3'"),
        ({"on": "row 2", "faces": [3], "yarn": 1}, "has no key 'faces'"),
    ],
)
def test_bad_selections_of_edits_are_refused_in_one_line(arguments, message):
    with pytest.raises(StitchMeshError) as refused:
        apply_edit(flat(), Edit("stripe", arguments))
    assert message in str(refused.value) and "\n" not in str(refused.value)


def test_the_command_applies_one_edit(tmp_path, capsys):
    write_stitches(tmp_path / "flat.h5", flat())
    words = ["edit", str(tmp_path / "flat.h5"), "-o", str(tmp_path / "out.h5"), "--apply", "stripe", "--on", "rows 2-3"]
    assert cli.main([*words, "yarn=1", "--log", str(tmp_path / "log.jsonl")]) == 0
    made = read_stitches(tmp_path / "out.h5")
    assert set(made.row[made.yarn == 1]) == {2, 3} and np.count_nonzero(made.yarn) == 14
    assert capsys.readouterr().out == "42 stitches before, 42 after\n"
    assert cli.main(["edit", str(tmp_path / "flat.h5"), "--replay", str(tmp_path / "log.jsonl"), "-o",
                     str(tmp_path / "again.h5")]) == 0  # fmt: skip
    assert bits(read_stitches(tmp_path / "again.h5")) == bits(made)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--apply", "stripe", "--on", "row 2", "yarn=1", "yarn=2"], "got 'yarn=2'; expected NAME=VALUE, each name"),
        (["--apply", "stripe", "--on", "row 2", "yarn=red"], 'yarn is "red"; expected a whole number'),
        (["--apply", "stripe", "--replay", "log.jsonl"], "needs one edit or one log"),
        (["--replay", "log.jsonl", "--on", "row 2"], "a log holds whole edits; leave --on"),
    ],
)
def test_bad_words_of_the_command_are_refused_and_nothing_is_written(tmp_path, capsys, words, message):
    write_stitches(tmp_path / "flat.h5", flat())
    assert cli.main(["edit", str(tmp_path / "flat.h5"), "-o", str(tmp_path / "out.h5"), *words]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert message in line and not (tmp_path / "out.h5").exists()


def test_patterns_on_separate_regions_do_not_move_each_other():
    """A lace below replaces faces and renumbers the others; the rib above still lies where it was selected."""
    fabric = flat(16, 24)
    lace, rib = read_pattern("eyelet-lace"), read_pattern("rib1x1")
    both = lay_patterns(fabric, [PatternRegion(lace, parse_selection("rows 1-9")),
                                 PatternRegion(rib, parse_selection("rows 12-19"))])[-1].fabric  # fmt: skip
    alone = apply_pattern(fabric, rib, faces=select(fabric, "rows 12-19"))
    assert (
        set(both.row[both.stitch == Stitch.PURL]) == set(alone.row[alone.stitch == Stitch.PURL]) == set(range(12, 20))
    )
    assert np.count_nonzero(both.stitch == Stitch.YARN_OVER) or (both.n_top != both.n_bottom).any()


def test_two_patterns_on_one_face_are_refused():
    regions = [PatternRegion(read_pattern("rib1x1"), parse_selection("rows 1-4")),
               PatternRegion(read_pattern("moss"), parse_selection("wale 17"))]  # fmt: skip
    with pytest.raises(ParameterError) as refused:
        lay_patterns(flat(), regions)
    expected = "1 x 1 rib on 'rows 1-4' and Moss stitch on 'wale 17' both cover 4 faces, such as face 10; add \"and not"
    assert expected in str(refused.value)
    with pytest.raises(ParameterError, match="both cover 6 faces, such as face 3"):
        lay_patterns(flat(), [PatternRegion(read_pattern("rib1x1")), regions[1]])
