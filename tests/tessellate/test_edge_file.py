# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Counts of single edges and marked edges as text."""

from __future__ import annotations

import pytest

from stitchmesh.errors import FileError, ParameterError
from stitchmesh.tessellate.edge_file import (
    EdgeSettings,
    edge_settings_text,
    parse_edge_counts,
    parse_edge_settings,
    read_edge_settings,
)


def test_a_file_holds_counts_marked_edges_and_comments(tmp_path):
    path = tmp_path / "edges.txt"
    path.write_text("# the hem\n0,1=24\n\n 1 , 2 = 12  # beside it\n5,9\n5,9\n2,1=12\n")
    assert read_edge_settings(path) == EdgeSettings({(0, 1): 24, (1, 2): 12}, ((5, 9),))


@pytest.mark.parametrize("word", ["4,7", "4,7=x", "-4,7=12", "4,7=1.5"])
def test_a_count_in_another_form_is_refused(word):
    with pytest.raises(ParameterError, match="expected V,W=COUNT with two vertices and a whole number"):
        parse_edge_counts(["0,1=3", word])


def test_two_counts_for_one_edge_are_refused():
    with pytest.raises(ParameterError, match="got 13 after 12; expected one count"):
        parse_edge_counts(["4,7=12", "7,4=13"])


def test_an_error_in_a_file_names_its_line(tmp_path):
    path = tmp_path / "edges.txt"
    path.write_text("0,1=24\nhem=3\n")
    with pytest.raises(FileError, match=r"edges.txt:2: got 'hem=3'; expected an edge V,W that is marked, or V,W=COUNT"):
        read_edge_settings(path)
    with pytest.raises(FileError, match="no such file"):
        read_edge_settings(tmp_path / "missing.txt")


def test_settings_written_as_text_are_read_again():
    settings = EdgeSettings({(0, 1): 24, (2, 1): 12}, ((5, 9), (9, 10)))
    assert parse_edge_settings(edge_settings_text(settings).splitlines(), "edges") == settings
    assert edge_settings_text(EdgeSettings()) == ""
    with pytest.raises(ParameterError, match="count of side 3: expected an edge"):
        edge_settings_text(EdgeSettings({3: 4}))
