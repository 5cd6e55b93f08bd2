# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Drafts of looms: threading, tie-up and treadling or a lift plan give the weave, and its colours."""

from __future__ import annotations

import pytest

from stitchmesh.errors import PatternError
from stitchmesh.periodic.resolve_pattern import resolve_pattern
from stitchmesh.periodic.weave.wif import parse_wif
from tests.gallery import shared

TWILL = """[WIF]
Version=1.1
[WEAVING]
Rising Shed=true
[WARP]
Threads=4 ; a comment
[WEFT]
Threads=4
[THREADING]
1=1
2=2
3=3
4=4
[TIEUP]
1=1,2
2=2,3
3=3,4
4=1,4
[TREADLING]
1=1
2=2
3=3
4=4
"""
ROWS = ("0011", "1001", "1100", "0110")
"""Wefts on top, the lowest weft first: the first treadle lifts the first two warps."""


def rows(text: str) -> tuple[str, ...]:
    return tuple("".join(map(str, row)) for row in parse_wif(text).matrix[::-1])


def test_the_draft_of_a_public_report_is_its_twill_in_two_colours():
    weave = resolve_pattern(shared("cases/field/10-twill.wif"))
    assert tuple("".join(map(str, row)) for row in weave.matrix[::-1]) == ROWS
    assert {weave.palette[thread.colour] for thread in weave.warps} == {(0x14, 0x1E, 0x5A)}
    assert {weave.palette[thread.colour] for thread in weave.wefts} == {(0xF0, 0xE6, 0xD2)}


def test_a_lift_plan_and_a_falling_shed_give_the_same_weave():
    assert rows(TWILL) == ROWS
    lifts = "[LIFTPLAN]\n1=1,2\n2=2,3\n3=3,4\n4=1,4\n"
    assert rows(TWILL[: TWILL.index("[TIEUP]")] + lifts) == ROWS
    sunk = TWILL.replace("=true", "=FALSE").replace("1=1,2\n2=2,3\n3=3,4\n4=1,4", "1=3,4\n2=1,4\n3=1,2\n4=2,3")
    assert rows(sunk) == ROWS


def test_colours_of_single_threads_belong_to_the_repeat():
    table = "[COLOR PALETTE]\nRange=0,999\n[COLOR TABLE]\n1=999,0,0\n2=0,0,500\n[WEFT COLORS]\n2=2\n"
    text = TWILL.replace("Threads=4", "Threads=4\nColor=1") + table
    weave = parse_wif(text)
    assert weave.palette == ((255, 0, 0), (0, 0, 128))
    assert [thread.colour for thread in weave.wefts] == [0, 0, 1, 0]  # From the top.


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("[THREADING]", "[NOTES]", "has no section [THREADING]; expected a draft"),
        ("[TREADLING]", "[NOTES]", "has no section [TREADLING]"),
        ("Threads=4 ;", "Ends=4 ;", "[WARP]: has no number of threads; expected Threads=8"),
        ("Threads=4", "Threads=9999", "expected at most 4000000 crossings"),
        ("3=3,4", "3=3,x", "[TIEUP]: got 'x'; expected whole numbers"),
        ("1=1,2", "1=1,2,3,4", "never interlaces"),
    ],
)
def test_each_malformed_draft_gets_its_message(old, new, message):
    text = TWILL.replace(old, new)
    if "interlaces" in message:
        text = text[: text.index("2=2,3")] + "2=1,2,3,4\n3=1,2,3,4\n4=1,2,3,4\n" + TWILL[TWILL.index("[TREADLING]"):]
    with pytest.raises(PatternError) as caught:
        parse_wif(text, "m.wif")
    assert str(caught.value).startswith("m.wif: ") and message in str(caught.value)
