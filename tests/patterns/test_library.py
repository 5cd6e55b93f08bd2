# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The library: every pattern can be read, closes and agrees with its name; bad paths raise errors."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.errors import FileError, ParameterError, PatternError
from stitchmesh.mesh.stitch import Stitch, from_wrong_side
from stitchmesh.patterns import format_pattern, parse_pattern, pattern_names, read_pattern
from tests.gallery import ROOT
from tests.patterns.fabrics import is_shift_of, stitches

PATTERNS = ROOT / "assets" / "patterns"
DOCUMENT = (ROOT / "docs" / "patterns.md").read_text()
TURNS_WITHOUT_CHANGE = ("garter", "moss", "rib2x2")


def turned(cells: np.ndarray) -> np.ndarray:
    """Return the chart of a fabric as seen from its wrong side."""
    return np.vectorize(lambda stitch: int(from_wrong_side(Stitch(stitch))))(cells[:, ::-1])


def test_the_document_lists_every_pattern_of_the_folder():
    assert set(pattern_names()) == {path.stem for path in PATTERNS.glob("*.knit")}
    missing = [name for name in pattern_names() if f"`{name}`" not in DOCUMENT]
    assert not missing


def test_the_gallery_shows_every_pattern():
    page = (ROOT / "docs" / "gallery.md").read_text()
    assert not [name for name in pattern_names() if f"| ![{name}](gallery/{name}.jpg) | `{name}` |" not in page]
    assert {path.stem for path in (ROOT / "docs" / "gallery").glob("*.jpg")} >= set(pattern_names())


@pytest.mark.parametrize("name", pattern_names())
def test_every_pattern_repeats_and_equals_the_pattern_read_from_its_text(name):
    pattern = read_pattern(name)
    assert pattern.closes
    assert pattern.source
    assert parse_pattern(format_pattern(pattern)) == pattern
    assert read_pattern(PATTERNS / f"{name}.knit") == pattern


@pytest.mark.parametrize("name", TURNS_WITHOUT_CHANGE)
def test_reversible_fabrics_look_the_same_from_behind_and_stockinette_does_not(name):
    assert is_shift_of(turned(stitches(name)), stitches(name))
    assert np.array_equal(turned(stitches("stockinette")), stitches("reverse-stockinette"))
    assert not is_shift_of(turned(stitches("stockinette")), stitches("stockinette"))


@pytest.mark.parametrize(("name", "hint"), [("rib2x", "did you mean rib2x2"), ("xyz", "a file needs its suffix")])
def test_an_unknown_name_is_refused(name, hint):
    with pytest.raises(ParameterError, match=f"pattern '{name}': is not in the library of .*{hint}"):
        read_pattern(name)


def test_bad_files_are_refused(tmp_path):
    with pytest.raises(FileError, match=r"a\.knit: there is no such file"):
        read_pattern(tmp_path / "a.knit")
    with pytest.raises(FileError, match="is a folder"):
        read_pattern(tmp_path)
    (tmp_path / "b.knit").write_bytes(b"")
    with pytest.raises(FileError, match="the file is empty"):
        read_pattern(tmp_path / "b.knit")
    (tmp_path / "c.knit").write_bytes(b"row 1 RS: k\0\1")
    with pytest.raises(FileError, match="holds binary data"):
        read_pattern(tmp_path / "c.knit")
    (tmp_path / "d.knit").write_text("row 1 RS: k\nrow 2 WS: q\n")
    with pytest.raises(PatternError, match=r"d\.knit: line 2, column 11: got 'q'; expected a stitch"):
        read_pattern(tmp_path / "d.knit")


def test_line_ends_and_byte_order_marks_of_other_systems(tmp_path):
    (tmp_path / "e.knit").write_bytes(b"\xef\xbb\xbfrow 1 RS: k\r\nrow 2 WS: p\r\n")
    assert read_pattern(tmp_path / "e.knit").rows == read_pattern("stockinette").rows
