# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A labeling step as data does what the method does, and a log of steps makes the same labeling again."""

from __future__ import annotations

import json
from dataclasses import fields

import numpy as np
import pytest

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.labeling import PartialLabeling, start_labeling
from stitchmesh.labeling.steps import (
    LABEL_STEPS,
    LabelStep,
    apply_label_step,
    read_label_steps,
    replay_label_steps,
    write_label_steps,
)
from stitchmesh.mesh.orientation import turn_inside_out
from tests.gallery import grid, tube


def bits(labeling: PartialLabeling) -> dict[str, bytes]:
    """Every array of a labeling and of its mesh as bytes."""
    arrays = {part.name: getattr(labeling, part.name) for part in fields(labeling) if part.name != "mesh"}
    arrays |= {"vertices": labeling.mesh.vertices, "face_vertex": labeling.mesh.face_vertex}
    return {name: np.asarray(array).tobytes() for name, array in arrays.items()}


@pytest.mark.parametrize("name", ["start_at_border", "start_at_edge"])
def test_a_start_names_its_edge_by_a_side_or_by_two_vertices(name):
    mesh = tube(8, 5)
    side = int(mesh.boundary_loops[0][0])
    ends = mesh.face_vertex[[side, mesh.side_next[side]]]
    method = getattr(start_labeling(mesh), name)
    for edge in (side, ends, tuple(ends.tolist())):
        assert bits(apply_label_step(start_labeling(mesh), LabelStep(name, {"edge": edge}))) == bits(method(side))


def test_a_log_of_all_kinds_of_steps_makes_the_labeling_that_the_methods_make(tmp_path):
    mesh = tube(8, 5)
    edge = mesh.face_vertex[mesh.boundary_loops[1][:2]]
    steps = [
        LabelStep("start_at_border", {"edge": edge}),
        LabelStep("label_all"),
        LabelStep("clear_labels"),
        LabelStep("turn_inside_out"),
        LabelStep("start_at_edge", {"edge": [24, 25]}),
        LabelStep("label_row_at", {"edge": [16, 17]}),
        LabelStep("set_edge", {"edge": [0, 8], "label": "wale"}),
        LabelStep("label_rows", {"count": 2}),
        LabelStep("flip_row", {"face": 16}),
    ]
    assert {step.name for step in steps} == set(LABEL_STEPS)
    write_label_steps(tmp_path / "steps.jsonl", steps)
    lines = (tmp_path / "steps.jsonl").read_text().splitlines()
    assert json.loads(lines[0]) == {"step": "start_at_border", "arguments": {"edge": edge.tolist()}}
    assert read_label_steps(tmp_path / "steps.jsonl") == steps
    expected = start_labeling(turn_inside_out(mesh)).start_at_edge((24, 25)).label_row_at((16, 17))
    expected = expected.set_edge((0, 8), "wale").label_rows(2).flip_row(16)
    assert bits(replay_label_steps(mesh, read_label_steps(tmp_path / "steps.jsonl"))) == bits(expected)


BAD_LINES = {
    "no JSON": ("{", "line 2: is no JSON .*expected one step a line"),
    "an edit": ('{"edit": "flip_row", "arguments": {}}', "line 2: is no step; .*has no key 'edit'"),
    "unknown step": ('{"step": "label_row", "arguments": {}}', "step 'label_row': is unknown; expected label_rows"),
    "missing": ('{"step": "flip_row", "arguments": {}}', "step flip_row: needs 'face'; got nothing"),
    "text": ('{"step": "flip_row", "arguments": {"face": "one"}}', 'face is "one"; expected a whole number'),
    "label": ('{"step": "set_edge", "arguments": {"edge": 3, "label": "seam"}}', 'label is "seam"; expected|Invalid'),
    "three": ('{"step": "start_at_edge", "arguments": {"edge": [1, 2, 3]}}', r"edge is \[1, 2, 3\]"),
}


@pytest.mark.parametrize(("line", "message"), BAD_LINES.values(), ids=BAD_LINES)
def test_the_message_gives_the_line_of_a_bad_step(tmp_path, line, message):
    log = tmp_path / "steps.jsonl"
    log.write_text('{"step": "label_all", "arguments": {}}\n' + line + "\n")
    with pytest.raises(FileError, match=message):
        read_label_steps(log)


def test_a_missing_log_is_an_error(tmp_path):
    with pytest.raises(FileError, match=r"none\.jsonl: there is no such file"):
        read_label_steps(tmp_path / "none.jsonl")


def test_a_refused_step_is_named_by_its_number():
    steps = [LabelStep("label_all"), LabelStep("flip_row", {"face": 10_000})]
    with pytest.raises(ParameterError, match="step 2: flip_row: flip: face 10000 does not exist"):
        replay_label_steps(grid(3, 3), steps)


def test_arguments_without_names_are_refused():
    for value in (3, {1: 2}):
        with pytest.raises(ParameterError, match="expected arguments by name"):
            LabelStep("flip_row", value)
