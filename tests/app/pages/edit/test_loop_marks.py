# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Lines that show crossed and twisted loops."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.app.pages.edit.fabric_view import loop_lines
from stitchmesh.editing.edit import Edit, apply_edit
from tests.app.pages.edit.opened import WIDE
from tests.editing.fabrics import top_of

SIDE = top_of(WIDE, 43)


def pieces(lines: np.ndarray) -> list[np.ndarray]:
    """The lines joined where one ends and the next begins: the points of each piece."""
    found = [[*lines[0]]]
    for start, end in lines[1:]:
        if np.allclose(found[-1][-1], start):
            found[-1].append(end)
        else:
            found.append([start, end])
    return [np.array(piece) for piece in found]


def test_plain_loops_have_no_lines():
    assert loop_lines(WIDE, 0.1).shape == (0, 2, 3)


@pytest.mark.parametrize(("front", "whole"), [("left", 1.0), ("right", -1.0)])
def test_the_loops_in_front_are_whole_and_those_behind_are_broken(front, whole):
    cable = Edit("cross_cable", {"side": SIDE, "left": 2, "right": 2, "front": front})
    found = pieces(loop_lines(apply_edit(WIDE, cable).fabric, 0.1))
    assert len(found) == 2 + 2 * 2  # Two loops in front, and two behind in two pieces each.
    lengths = np.array([np.ptp(piece[:, 0]) for piece in found])
    long = [found[number] for number in np.argsort(lengths)[-2:]]
    assert all(np.sign(piece[-1, 0] - piece[0, 0]) == whole for piece in long)  # Loops in front go to their side.


def test_lines_begin_below_their_loop_and_end_above_its_new_place():
    cable = Edit("cross_cable", {"side": SIDE, "left": 1, "right": 1, "front": "left"})
    lines = loop_lines(apply_edit(WIDE, cable).fabric, 0.0)
    front = pieces(lines)[0]
    middle = WIDE.corner_position[[SIDE, WIDE.side_next[SIDE]]].mean(axis=0)
    assert front[0, 1] < middle[1] < front[-1, 1] and np.isclose(front[0, 0], middle[0])
    assert np.isclose(front[-1, 0], middle[0] + 1.0)  # One stitch to the right; stitches are 1 cm wide.


@pytest.mark.parametrize("twist", [1, -1])
def test_the_leg_in_front_of_a_twisted_loop_is_whole(twist):
    lines = loop_lines(apply_edit(WIDE, Edit("twist_loop", {"side": SIDE, "twist": twist})).fabric, 0.1)
    found = pieces(lines)
    assert len(found) == 3
    long = max(found, key=lambda piece: np.ptp(piece[:, 0]))
    assert np.sign(long[-1, 0] - long[0, 0]) == twist  # At twist 1 the leg that comes from the left is in front.
