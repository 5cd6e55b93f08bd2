# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Edits as data: undo, redo, the log and its replay, and the command line."""

from __future__ import annotations

import json

import pytest

from stitchmesh.cli import main as cli
from stitchmesh.editing.edit import EDITS, Edit, apply_edit
from stitchmesh.editing.history import History, read_log, replay_edits, write_log
from stitchmesh.errors import FileError, ParameterError
from stitchmesh.io import write_stitches
from tests.editing.fabrics import flat, top_of
from tests.editing.random_edits import bits

EDITED = (
    Edit("change_stitch", {"faces": [10], "stitch": "p"}),
    Edit("insert_row", {"face": 20}),
    Edit("bobble", {"face": 17}),
)


def history_of(edits: tuple[Edit, ...] = EDITED) -> History:
    history = History(flat())
    for edit in edits:
        history.apply(edit)
    return history


def test_undo_and_redo_restore_every_mesh_of_the_history():
    history = history_of()
    assert history.edits == EDITED and history.undone == ()
    history.undo()
    history.undo()
    assert history.edits == EDITED[:1] and history.undone == EDITED[1:]
    assert bits(history.redo()) == bits(history_of(EDITED[:2]).fabric)


def test_a_refused_edit_changes_nothing_and_after_a_new_edit_undone_edits_cannot_be_redone():
    history = history_of()
    history.undo()
    before = history.fabric
    with pytest.raises(ParameterError, match="face 9999: does not exist"):
        history.apply(Edit("bobble", {"face": 9999}))
    assert history.fabric is before and history.edits == EDITED[:2] and history.undone == EDITED[2:]
    history.apply(Edit("flip_row", {"face": 20}))
    assert history.undone == ()
    with pytest.raises(ParameterError, match="redo: there is no edit to redo"):
        history.redo()


def test_a_log_holds_one_edit_in_each_line(tmp_path):
    history = history_of()
    history.write(tmp_path / "log.jsonl")
    lines = (tmp_path / "log.jsonl").read_text().splitlines()
    assert json.loads(lines[1]) == {"edit": "insert_row", "arguments": {"face": 20}}
    assert tuple(read_log(tmp_path / "log.jsonl")) == EDITED
    assert bits(replay_edits(flat(), tmp_path / "log.jsonl")) == bits(history.fabric)


BAD_LINES = {
    "no JSON": ("{", "line 2: is no JSON .*expected one edit a line"),
    "a number": ('{"edit": 3, "arguments": {}}', "line 2: is no edit; expected .* edit is 3; expected a text"),
    "unknown edit": ('{"edit": "bobbel", "arguments": {}}', "line 2: edit 'bobbel': is unknown; expected bobble"),
    "missing": ('{"edit": "bobble", "arguments": {}}', "line 2: bobble: needs 'face'; got nothing"),
    "misspelt": ('{"edit": "bobble", "arguments": {"faces": 1}}', "has no key 'faces'; did you mean 'face'\\?"),
    "beside": ('{"edit": "bobble", "arguments": {}, "argument": 1}', "no key 'argument'; did you mean 'arguments'\\?"),
    "truth": ('{"edit": "bobble", "arguments": {"face": true}}', "face is true; expected a whole number"),
    "huge": ('{"edit": "bobble", "arguments": {"face": 1e400}}', "line 2: is no JSON .*out of range"),
    "list": ('{"edit": "stripe", "arguments": {"yarn": 1, "rows": [1, "a"]}}', r'rows\[1\] is "a"; expected a whole'),
    "too large": ('{"edit": "bobble", "arguments": {"face": 4294967296}}', "expected a whole number <= 2147483647"),
}


@pytest.mark.parametrize(("line", "message"), BAD_LINES.values(), ids=BAD_LINES)
def test_the_message_gives_the_number_of_a_bad_line(tmp_path, line, message):
    log = tmp_path / "log.jsonl"
    log.write_text('{"edit": "flip_row", "arguments": {"face": 1}}\n' + line + "\n")
    with pytest.raises(FileError, match=message):
        replay_edits(flat(), log)


def test_arguments_made_in_python_are_checked_as_those_of_a_log():
    """A value that JSON cannot hold is named by its type."""
    for value, shown in ((object(), "builtins.object"), ("all", '"all"')):
        with pytest.raises(ParameterError, match=f"stripe: rows is .*{shown}"):
            apply_edit(flat(), Edit("stripe", {"yarn": 1, "rows": value}))


def test_the_message_gives_the_line_of_an_edit_that_is_refused_in_a_replay(tmp_path):
    log = tmp_path / "log.jsonl"
    write_log(log, [*EDITED, Edit("bobble", {"face": 0})])
    with pytest.raises(ParameterError, match=r"log\.jsonl line 4: bobble: face 0: does not work one loop to one loop"):
        replay_edits(flat(), log)


def test_the_message_of_every_edit_gives_a_missing_argument():
    for name in sorted(set(EDITS) - {"spiral", "unspiral"}):
        with pytest.raises(ParameterError, match=f"{name}: needs '"):
            apply_edit(flat(), Edit(name))


@pytest.fixture
def files(tmp_path):
    write_stitches(tmp_path / "flat.h5", flat())
    write_log(tmp_path / "log.jsonl", EDITED)
    return tmp_path


def test_a_refused_replay_writes_nothing(files, capsys):
    write_log(files / "log.jsonl", [*EDITED, Edit("twist_loop", {"side": top_of(flat(), 10), "twist": 3})])
    words = ["edit", str(files / "flat.h5"), "--replay", str(files / "log.jsonl"), "-o", str(files / "edited.h5")]
    assert cli.main(words) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "line 4: twist_loop: side 42" in line and "twist 3; expected -1, 0 or 1" in line
    assert not (files / "edited.h5").exists()


def test_with_an_output_and_without_edits_the_command_prints_what_it_needs(files, capsys):
    """Without an output too, it opens the application, which runs until the user ends it."""
    assert cli.main(["edit", str(files / "flat.h5"), "-o", str(files / "edited.h5")]) == 2
    assert "edit: needs one edit or one log, and -o FILE; give --apply EDIT or --replay LOG" in capsys.readouterr().err
