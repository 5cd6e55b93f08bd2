# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Options for counts of edges, the height of courses and mesh relaxation."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.io import read_stitches, write_stitches
from stitchmesh.labeling import label
from tests.cli.calls import refused_without_files, run
from tests.gallery import grid


@pytest.fixture
def labeled(tmp_path):
    write_stitches(tmp_path / "rows.h5", label(grid(12, 3)))
    return tmp_path / "rows.h5"


def test_counts_marks_and_a_file_set_the_stitches_of_edges(labeled, tmp_path, capsys):
    (tmp_path / "edges.txt").write_text("1,2=3  # one edge of the hem\n")
    words = ["tessellate", labeled, "-o", tmp_path / "out.h5", "--stitch-width", "0.5", "--course-height", "0.25",
             "--count", "0,1=5", "--mark", "0,13", "--edges", tmp_path / "edges.txt"]  # fmt: skip
    run(*words)
    made = read_stitches(tmp_path / "out.h5")
    # 3 rows of 1 cm in courses of 0.25 cm; 12 edges of 1 cm have 2 stitches each, but two of them have 5 and 3.
    assert made.row.max() + 1 == 12
    assert np.count_nonzero(made.row == 0) >= 24 and made.n_bottom[made.row == 0].sum() == 10 * 2 + 5 + 3
    assert "stitch width: 0.5 cm (median)" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["tessellate", "rows.h5", "-o", "o.h5", "--count", "0=5"], "count '0=5': expected V,W=COUNT"),
        (["tessellate", "rows.h5", "-o", "o.h5", "--count", "0,99=5"], "edge (0, 99): no edge joins these vertices"),
        (["tessellate", "rows.h5", "-o", "o.h5", "--mark", "0,1"], "is a course edge"),
        (["tessellate", "rows.h5", "-o", "o.h5", "--edges", "none.txt"], "there is no such file"),
        (["tessellate", "rows.h5", "-o", "o.h5", "--course-height", "-1"], "got -1"),
        (["relax-mesh", "rows.h5", "--surface", "rows.h5", "-o", "o.h5", "--alpha", "1.5"], "alpha: got 1.5"),
        (["relax-mesh", "rows.h5", "--surface", "rows.h5", "-o", "o.h5", "--aspect", "0"], "aspect: got 0.0"),
    ],
)  # fmt: skip
def test_a_bad_value_gives_one_line_and_writes_nothing(labeled, tmp_path, capsys, monkeypatch, words, message):
    monkeypatch.chdir(tmp_path)
    assert message in refused_without_files(capsys, tmp_path, *words)
