# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What the page Swatch keeps in a project."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

import stitchmesh as sm
from stitchmesh.app.pages.swatch.state import (
    MOST_TILES,
    SHOWN,
    Look,
    first_state,
    read_state,
    repeat_shape,
    state_table,
)
from stitchmesh.errors import ParameterError, PatternError
from tests.chosen_patterns import CHOSEN_PATTERNS


def test_a_state_comes_back_from_json():
    state = replace(first_state(), look=Look(2, 5, "stitch", 0.25), iterations=7)
    state = state.with_chart("round 1: k1 k1 oops").compared(True)
    state = state.with_design(state.design.turned(gamma=1.4))
    table = json.loads(json.dumps(state_table(state)))
    assert state_table(read_state(table)) == table
    assert [design.dials.gamma for design in read_state(table).designs] == [1.0, 1.4]
    assert read_state(table).charts == ("round 1: k1 k1 oops",) * 2


def test_a_second_variant_begins_as_a_copy_and_the_edited_one_stays():
    both = first_state().compared(True)
    assert both.designs[0] == both.designs[1] and both.edited == 1
    other = both.with_design(both.design.turned(gamma=1.2))
    assert other.compared(False).design.dials.gamma == 1.2
    assert replace(other, edited=0).compared(False).design.dials.gamma == 1.0
    assert other.compared(True) is other


@pytest.mark.parametrize(
    ("change", "error"),
    [
        ({"designs": []}, ParameterError),
        ({"designs": "none"}, ParameterError),
        ({"designs": [{"kind": "knit", "text": "round 1: zz"}]}, PatternError),
        ({"edited": 3}, ParameterError),
        ({"edited": "A"}, ParameterError),
        ({"look": {"columns": 0}}, ParameterError),
        ({"look": {"colour_by": "taste"}}, ParameterError),
        ({"look": {"blend": 2.0}}, ParameterError),
        ({"charts": [1]}, ParameterError),
    ],
    ids=str,
)
def test_a_damaged_table_is_refused(change, error):
    with pytest.raises(error):
        read_state(state_table(first_state()) | change)


@pytest.mark.parametrize("name", (*CHOSEN_PATTERNS, "plain", "satin-3x2"))
def test_a_pattern_is_shown_in_as_many_repeats_as_make_a_square_piece(name):
    source = sm.resolve_pattern(name)
    look = Look().fitted(source)
    for shown, own, wanted in zip((look.columns, look.rows), repeat_shape(source), SHOWN, strict=True):
        # The nearest whole number of repeats is at most half a repeat off; at least one is shown.
        assert shown == MOST_TILES or abs(shown * own - wanted) <= max(own / 2, own - wanted)
