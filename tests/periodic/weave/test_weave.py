# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Valid and invalid weaves: a weave must be a matrix of 0 and 1 whose yarns hang together."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from stitchmesh.errors import PatternError
from stitchmesh.periodic.weave.weave import Thread, Weave, top_sheet

PLAIN = ((0, 1), (1, 0))
TWO_PLAIN_CLOTHS = ((1, 1, 0, 1), (0, 1, 0, 0), (0, 1, 1, 1), (0, 0, 0, 1))
"""Threads that alternate between two layers."""
IN_TURN = (Thread(layer=0), Thread(layer=1)) * 2


def stitching(weave: Weave) -> list[list[int]]:
    """Weft and warp of each crossing at which a yarn passes over a yarn of a layer in front."""
    weft, warp = (np.array([thread.layer for thread in threads]) for threads in (weave.wefts, weave.warps))
    behind = weft[:, None] - warp[None, :]
    return np.argwhere(np.where(weave.over, behind > 0, behind < 0)).tolist()


def with_sign(matrix, weft: int, warp: int, sign: int):
    changed = [list(row) for row in matrix]
    changed[weft][warp] = sign
    return changed


def lies_over_all_others(over: np.ndarray, chosen: np.ndarray) -> bool:
    """Whether the chosen wefts and warps pass over the other yarns at all crossings with them."""
    wefts, warps = chosen[: len(over)], chosen[len(over) :]
    return bool(over[np.ix_(wefts, ~warps)].all() and not over[np.ix_(~wefts, warps)].any())


def test_a_fabric_hangs_together_if_no_set_of_its_yarns_can_be_lifted_off():
    """The result equals the definition, tested with all sets of yarns."""
    random = np.random.default_rng(0)
    fallen = 0
    for _ in range(25):
        over = random.random((3, 4)) < 0.5
        sets = np.array(list(product([False, True], repeat=7))[1:-1])
        lifting = [chosen for chosen in sets if lies_over_all_others(over, chosen)]
        top = top_sheet(over)
        assert top.all() == (not lifting)
        fallen += bool(lifting)
        if lifting:
            assert lies_over_all_others(over, top)
    assert 0 < fallen < 25  # both kinds of fabrics occurred


def test_two_layers_fall_apart_unless_they_are_stitched():
    with pytest.raises(PatternError, match=r"falls apart: wefts 1, 3 and warps 1, 3 lie over all other yarns"):
        Weave(TWO_PLAIN_CLOTHS)
    with pytest.raises(PatternError, match=r"falls apart: wefts 1\.1, 1\.2 and warps 1\.1, 1\.2 lie over"):
        Weave(TWO_PLAIN_CLOTHS, wefts=IN_TURN, warps=IN_TURN)
    stitched = Weave(with_sign(TWO_PLAIN_CLOTHS, 0, 1, 0), wefts=IN_TURN, warps=IN_TURN)
    assert stitching(stitched) == [[0, 1]]
    assert stitched.layer_count == 2


def test_a_stitch_of_a_weft_binds_like_a_stitch_of_a_warp():
    """A back weft passes over a front warp."""
    stitched = Weave(with_sign(TWO_PLAIN_CLOTHS, 1, 2, 1), wefts=IN_TURN, warps=IN_TURN)
    assert stitching(stitched) == [[1, 2]]


@pytest.mark.parametrize(
    ("matrix", "message"),
    [
        ((), "got an empty matrix"),
        (((), ()), "got an empty matrix"),
        (((0, 1), (1, 0, 1)), r"row 2: got 3 numbers where row 1 has 2"),
        (((0, 1), (1, 2)), r"row 2, column 2: got 2; expected 1 \(weft over\) or 0 \(warp over\)"),
        (((0, 1), (0.5, 1)), r"row 2, column 1: got 0\.5"),
        (((1,),), "weft 1 passes over every warp and never interlaces"),
        (((0, 1, 0), (1, 1, 1), (1, 0, 1)), "weft 2 passes over every warp.*let one warp pass over it"),
        (((0, 1), (0, 0)), "weft 2 passes under every warp.*let one warp pass under it"),
        (((0, 1, 0), (1, 0, 0)), "warp 3 passes over every weft.*let one weft pass over it"),
        (((0, 1, 1), (1, 0, 1)), "warp 3 passes under every weft.*let one weft pass under it"),
    ],
)
def test_invalid_weaves_are_refused(matrix, message):
    with pytest.raises(PatternError, match=message):
        Weave(matrix)


def test_there_is_one_thread_for_each_weft_and_warp():
    assert Weave(PLAIN).warps == (Thread(), Thread())
    with pytest.raises(PatternError, match="got 3 warps for 2 in the matrix"):
        Weave(PLAIN, warps=(Thread(),) * 3)


@pytest.mark.parametrize(
    ("what", "value"),
    [("radius", 0.0), ("spacing", -1.0), ("length", np.nan), ("length", np.inf), ("layer", -1), ("colour", -2)],
)
def test_bad_threads_are_refused(what, value):
    with pytest.raises(PatternError, match=f"{what} of a yarn: got {value}"):
        Thread(**{what: value})


def test_a_name_with_quotes_or_line_ends_is_refused():
    with pytest.raises(PatternError, match="expected one line without quotes"):
        Weave(PLAIN, name='the "best"')
