# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A history is read as it was written; other tables are refused at their line."""

from __future__ import annotations

import pytest

from stitchmesh.errors import FileError
from stitchmesh.io.history import HistoryEntry, read_history, write_history

ENTRIES = [
    HistoryEntry(iteration=0, seconds=0.1, residual=1.0, energies={"stretch": 1 / 3, "contact": 2e-17}),
    HistoryEntry(iteration=25, seconds=0.7, residual=0.25, energies={"stretch": 0.1}),
]


def test_a_history_is_read_as_it_was_written(tmp_path):
    write_history(tmp_path / "convergence.csv", ENTRIES)
    assert read_history(tmp_path / "convergence.csv") == ENTRIES


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a,b\n1,2\n", "got columns a, b; expected the convergence of a relaxation: iteration, seconds, residual"),
        ("iteration,seconds,residual,bend_erg\n0,0.1,x,3\n", "line 2: got '0,0.1,x,3'; expected 4 numbers"),
        ("iteration,seconds,residual,bend_erg\n0,0.1,1,3\n0,1\n", "line 3: got '0,1'; expected 4 numbers"),
    ],
)
def test_another_table_is_refused(tmp_path, text, message):
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(FileError) as error:
        read_history(tmp_path / "a.csv")
    assert message in str(error.value)
