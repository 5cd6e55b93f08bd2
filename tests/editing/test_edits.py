# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Edits as functions make what the same edits of files make."""

from __future__ import annotations

import inspect
from typing import Any

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh import edits
from stitchmesh.editing.edit import EDITS, Edited
from stitchmesh.errors import ParameterError
from tests.editing.fabrics import flat


def functions() -> dict[str, Any]:
    return {name: value for name, value in vars(edits).items() if hasattr(value, "__wrapped__")}


def test_every_edit_is_a_function_and_every_function_an_edit():
    assert set(functions()) == set(EDITS)
    for name, function in functions().items():
        assert function.__wrapped__ is EDITS[name]
        assert inspect.signature(function).return_annotation is Edited


def test_a_function_makes_what_the_edit_of_a_file_makes():
    edited = sm.edits.stripe(flat(), yarn=1, rows=[2])
    written = sm.apply_edit(flat(), sm.Edit("stripe", {"yarn": 1, "rows": [2]}))
    np.testing.assert_array_equal(edited.fabric.yarn, written.fabric.yarn)
    history = sm.History(flat())
    np.testing.assert_array_equal(history.apply(sm.edits.stripe, yarn=1, rows=[2]).yarn, edited.fabric.yarn)
    assert [edit.name for edit in history.edits] == ["stripe"]


def test_a_function_takes_a_selection_in_the_place_of_its_place():
    by_words = sm.edits.insert_row(flat(), on="row 3").fabric
    by_number = sm.edits.insert_row(flat(), face=int(np.flatnonzero(flat().row == 3)[0])).fabric
    np.testing.assert_array_equal(by_words.row, by_number.row)


def test_a_wrong_argument_is_refused_by_its_name():
    with pytest.raises(ParameterError, match=r"unknown|colour"):
        sm.edits.stripe(flat(), yarn=1, rows=[2], colour="red")
