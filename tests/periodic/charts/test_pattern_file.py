# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Patterns are written as text and as pictures, and read again."""

from __future__ import annotations

import pytest

from stitchmesh.errors import FileError
from stitchmesh.patterns import read_pattern
from stitchmesh.periodic.charts.pattern_file import write_pattern
from tests.chosen_patterns import CHOSEN_PATTERNS

DRAWN = ("feather-and-fan", "half-cardigan", "horseshoe-cable", "jacquard3", "twisted-rib")
"""Patterns with each kind of mark: increases, tucks, cables, colours and twists."""


@pytest.mark.parametrize("name", CHOSEN_PATTERNS)
def test_a_pattern_is_read_from_its_text(tmp_path, name):
    write_pattern(tmp_path / "own.knit", read_pattern(name))
    assert read_pattern(tmp_path / "own.knit") == read_pattern(name)


@pytest.mark.parametrize("name", DRAWN)
def test_a_pattern_is_read_from_the_picture_of_its_chart(tmp_path, name):
    write_pattern(tmp_path / "own.png", read_pattern(name))
    assert read_pattern(tmp_path / "own.png") == read_pattern(name)


def test_another_suffix_is_refused(tmp_path):
    with pytest.raises(FileError, match=r"\.knit"):
        write_pattern(tmp_path / "own.svg", read_pattern("seed"))
    assert not list(tmp_path.iterdir())
