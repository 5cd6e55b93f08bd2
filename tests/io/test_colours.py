# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Colour numbers of yarns: in memory, in files and as displayed colours."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stitchmesh.errors import YarnError
from stitchmesh.io.yarns import read_yarns, write_yarns
from stitchmesh.yarn.colours import WOOLS, row_colours, yarn_colours
from tests.io.yarn_sets import awkward_yarns

COLOURS = [2, 0, 1, 2]


def test_yarns_have_colour_0_by_default():
    assert awkward_yarns().colour.tolist() == [0, 0, 0, 0]


@pytest.mark.parametrize("suffix", [".h5", ".usda", ".usdc", ".vtp"])
def test_colours_are_written_and_read(tmp_path, suffix):
    write_yarns(tmp_path / f"y{suffix}", replace(awkward_yarns(), colour=COLOURS))
    assert read_yarns(tmp_path / f"y{suffix}").colour.tolist() == COLOURS


@pytest.mark.parametrize("suffix", [".bcc", ".obj"])
def test_yarns_of_a_file_without_colours_have_colour_0(tmp_path, suffix):
    write_yarns(tmp_path / f"y{suffix}", replace(awkward_yarns(), colour=COLOURS))
    assert read_yarns(tmp_path / f"y{suffix}", radius=0.1).colour.tolist() == [0, 0, 0, 0]


def test_a_file_written_before_colours_is_read(tmp_path):
    import h5py

    write_yarns(tmp_path / "y.h5", awkward_yarns())
    with h5py.File(tmp_path / "y.h5", "a") as file:
        del file["colour"]
    assert read_yarns(tmp_path / "y.h5").colour.tolist() == [0, 0, 0, 0]


def test_invalid_colours_are_errors():
    with pytest.raises(YarnError, match="yarn 1: got colour -1; colours are numbered from 0"):
        replace(awkward_yarns(), colour=[0, -1, 0, 0])
    with pytest.raises(YarnError, match=r"colour: got shape \(2,\); expected \(4,\)"):
        replace(awkward_yarns(), colour=[0, 1])


def test_several_colours_are_displayed_and_otherwise_rows():
    row = np.arange(4)
    np.testing.assert_array_equal(yarn_colours(row, [3, 3, 3, 3]), row_colours(row))
    dyed = yarn_colours(row, [0, 1, 1, len(WOOLS)])
    assert (dyed[1] == dyed[2]).all() and (dyed[0] != dyed[1]).any() and (dyed[0] == dyed[3]).all()
    assert dyed.dtype == np.uint8 and dyed.shape == (4, 3)
