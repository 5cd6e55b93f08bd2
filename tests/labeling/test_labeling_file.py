# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Files of partly labeled meshes lose nothing, and damaged files are refused."""

from __future__ import annotations

from dataclasses import replace

import h5py
import numpy as np
import pytest

from stitchmesh.errors import FileError
from stitchmesh.io import write_stitches
from stitchmesh.labeling import label, start_labeling
from stitchmesh.labeling.labeling_file import holds_labeling, read_labeling, write_labeling
from stitchmesh.lattice import Lattice
from stitchmesh.mesh import Mesh
from tests.gallery import tube
from tests.labeling.test_partial_labeling import bits


def test_a_labeling_is_read_as_it_was_written(tmp_path):
    mesh = tube(8, 5)
    labeling = start_labeling(mesh).set_edge((0, 8), "wale").label_rows(2).flip_row(8).set_edge((9, 17), None)
    write_labeling(tmp_path / "part.h5", labeling)
    found = read_labeling(tmp_path / "part.h5")
    assert bits(found) == bits(labeling)
    assert (found.mesh.face_vertex == mesh.face_vertex).all() and (found.mesh.twin == mesh.twin).all()
    assert bits(found.label_all().finish()) == bits(labeling.label_all().finish())


def test_a_lattice_is_kept(tmp_path):
    flat = tube(4, 2)
    image = np.zeros((flat.side_count, 2), dtype=np.int64)
    lattice = Lattice(np.array([[100.0, 0.0, 0.0], [0.0, 100.0, 0.0]]))
    mesh = Mesh(flat.vertices, flat.face_start, flat.face_vertex, flat.twin, lattice, image)
    write_labeling(tmp_path / "part.h5", start_labeling(mesh).label_rows(1))
    found = read_labeling(tmp_path / "part.h5").mesh
    assert found.lattice is not None and (found.lattice.periods == lattice.periods).all()


def test_files_of_another_kind_are_told_apart(tmp_path):
    write_stitches(tmp_path / "rows.h5", label(tube(8, 3)))
    write_labeling(tmp_path / "part.h5", start_labeling(tube(8, 3)))
    assert holds_labeling(tmp_path / "part.h5") and not holds_labeling(tmp_path / "rows.h5")
    assert not holds_labeling("mesh.obj")
    with pytest.raises(FileError, match="expected 'stitchmesh labeling'"):
        read_labeling(tmp_path / "rows.h5")
    with pytest.raises(FileError, match=r"unknown format '.obj'"):
        write_labeling(tmp_path / "part.obj", start_labeling(tube(8, 3)))


@pytest.mark.parametrize("name", ["row", "seeded"])
def test_a_file_whose_datasets_contradict_each_other_is_refused(tmp_path, name):
    labeling = start_labeling(tube(8, 3)).label_rows(2)
    path = tmp_path / "part.h5"
    write_labeling(path, labeling)
    with h5py.File(path, "a") as file:
        values = file[name][()]
        del file[name]
        file[name] = np.concatenate([values, values])[: len(values) + 3] if name == "seeded" else values + 500
    with pytest.raises(FileError, match=r"part\.h5"):
        read_labeling(path)


def test_a_value_with_other_numbers_is_another_file(tmp_path):
    """The test of the round trip would not see a field that is never written; here each field is read back changed."""
    labeling = start_labeling(tube(8, 3)).label_rows(2)
    for name in ("by_hand", "seeded", "held_direction", "fault_side"):
        values = np.array(getattr(labeling, name))
        values[-1] = not values[-1] if values.dtype == bool else 1
        changed = replace(labeling, **{name: values})
        write_labeling(tmp_path / "part.h5", changed)
        assert bits(read_labeling(tmp_path / "part.h5")) == bits(changed) != bits(labeling)
