# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""What the size of a mesh says about the unit of its file."""

from __future__ import annotations

import numpy as np
import pytest

from stitchmesh.io.garments import read_garment
from stitchmesh.io.mesh_reading import MeshReading
from stitchmesh.io.meshes import write_mesh
from stitchmesh.io.units import CENTIMETRES, other_units, size_doubt
from tests.gallery import tube

JUMPER = np.array([[0.0, 0.0, 0.0], [62.0, 64.0, 29.0]])
"""Two corners of the box of a jumper [cm]."""


def test_the_size_of_a_garment_raises_no_doubt():
    assert size_doubt(JUMPER, "m", stated=False) == "" and other_units(JUMPER, "m") == {}


@pytest.mark.parametrize(("unit", "wrong"), [("m", "cm"), ("mm", "cm"), ("cm", "dm"), ("inch", "cm")])
def test_the_unit_in_which_a_file_was_written_is_offered_where_another_one_is_odd(unit, wrong):
    """A jumper whose numbers are in one unit, read in another one."""
    read = JUMPER / CENTIMETRES[unit] * CENTIMETRES[wrong]
    offered = other_units(read, wrong)
    if not 10.0 <= read.max() <= 400.0:
        assert offered[unit] == "62.0 x 64.0 x 29.0 cm"
        assert f"in {unit} 62.0 x 64.0 x 29.0 cm: --unit {unit}" in size_doubt(read, wrong, stated=False)
    else:
        assert offered == {}


def test_the_doubt_names_the_size_that_was_read():
    said = size_doubt(JUMPER / 100.0, "cm", stated=False)
    assert said.startswith("the mesh, read in cm, is 0.6 x 0.6 x 0.3 cm, too small for a garment; in ")
    assert size_doubt(np.zeros((2, 3)), "cm", stated=False).endswith("too small for a garment; check its size")


def test_a_file_that_fixes_its_unit_is_scaled_and_not_read_in_another_one(tmp_path):
    """The numbers of a tube 20 cm high are metres in glTF: 2000 cm."""
    in_metres = tube(12, 4, radius=1000.0, height=500.0)
    write_mesh(tmp_path / "tube.glb", in_metres)
    (note,) = read_garment(tmp_path / "tube.glb", MeshReading(), repaired=False).notes
    assert "in m as its file states, is 2000.0 x" in note and "scale it by 0.01 for 20.0 x 20.0 x 20.0 cm" in note
    assert "--unit" not in note
