# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""The picture of a partly labeled mesh shows rows, unlabeled faces, faults and seams in their colours."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from stitchmesh.labeling import PartialLabeling, start_labeling
from stitchmesh.render.labeling_drawing import FAULT_COLOUR, MISMATCH_COLOUR
from stitchmesh.render.labeling_picture import render_labeling
from tests.gallery import grid, odd_corner, tube

pytestmark = pytest.mark.usefixtures("display")
SIZE = (480, 300)


def near(path: Path, colour: tuple[int, int, int], tolerance: int = 60) -> int:
    """Number of pixels near a colour outside the legend; light changes the colours of faces."""
    pixels = np.asarray(Image.open(path).convert("RGB"), dtype=int)[:, : int(0.78 * SIZE[0])]
    return int(np.count_nonzero(np.abs(pixels - np.array(colour)).max(axis=2) < tolerance))


def drawn(labeling: PartialLabeling, path: Path, **more: bool) -> Path:
    render_labeling(labeling, path, size=SIZE, **more)
    assert Image.open(path).size == SIZE
    return path


def test_faults_are_red(tmp_path):
    faulty = start_labeling(odd_corner()).label_all()
    assert faulty.faults
    assert near(drawn(faulty, tmp_path / "faults.png"), FAULT_COLOUR) > 300
    assert near(drawn(start_labeling(odd_corner()), tmp_path / "empty.png"), FAULT_COLOUR) == 0


def test_seams_that_do_not_match_are_marked(tmp_path):
    labeling = start_labeling(tube(8, 5)).label_all()
    matching = near(drawn(labeling, tmp_path / "match.png"), MISMATCH_COLOUR)  # A few pixels of a violet row.
    assert near(drawn(labeling.flip_row(16), tmp_path / "flipped.png"), MISMATCH_COLOUR) > 100 + matching


def test_a_flat_piece_has_one_view_and_a_tube_two(tmp_path):
    """In the picture of a tube there are two objects, separated by a column or a line of background."""
    for mesh, count in ((grid(6, 5), 1), (tube(12, 9), 2)):
        path = drawn(start_labeling(mesh).label_rows(1), tmp_path / "picture.png")
        pixels = np.asarray(Image.open(path).convert("RGB"), dtype=int)[: int(0.9 * SIZE[1]), : int(0.78 * SIZE[0])]
        empty = np.abs(pixels - pixels[0, 0]).max(axis=2) < 4
        runs = [np.count_nonzero(np.diff((~empty.all(axis=axis)).astype(int), prepend=0) == 1) for axis in (0, 1)]
        assert max(runs) == count
