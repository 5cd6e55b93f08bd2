# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Stitch mesh files: all fields are written and read, with twins that do not follow from the vertex numbers."""

from __future__ import annotations

import dataclasses

import h5py
import numpy as np
import pytest

from stitchmesh.errors import FileError
from stitchmesh.io import read_stitches, write_stitches, write_yarns
from stitchmesh.lattice import Lattice
from stitchmesh.mesh import StitchMesh
from stitchmesh.mesh.stitch import Stitch
from stitchmesh.yarn import YarnSet
from tests.io.refusals import refused


def increase_on_a_decrease() -> StitchMesh:
    """Return two faces: a decrease (two bottom sides) below an increase (two top sides)."""
    vertices = np.array(
        [[0, 0, 0], [1, 0, 0], [2, 0, 0], [2, 1, 1 / 3], [0, 1, 0], [2, 2, 0], [1, 2, np.pi], [0, 2, 0]]
    )
    face_vertex = [0, 1, 2, 3, 4, 4, 3, 5, 6, 7]
    twin = np.full(10, -1)
    twin[3], twin[5] = 5, 3
    return StitchMesh(
        vertices, [0, 5, 10], face_vertex, twin, n_bottom=[2, 1], n_top=[1, 2],
        stitch=[Stitch.D12K, Stitch.KY], row=[0, 1], stretch=np.linspace(0.9, 1.1, 9),
    )  # fmt: skip


def one_stitch_torus() -> StitchMesh:
    """Return a torus of one face: all corners are the same vertex, and each side is the twin of the opposite side."""
    image = [[0, 0], [1, 0], [1, 1], [0, 1]]
    return StitchMesh(
        np.array([[1 / 3, 0, 0]]), [0, 4], [0, 0, 0, 0], [2, 3, 0, 1], lattice=Lattice([[1, 0, 0], [0, 0.77, 0]]),
        corner_image=image, n_bottom=[1], n_top=[1], stitch=[Stitch.KNIT], row=[0],
    )  # fmt: skip


@pytest.mark.parametrize("make", [increase_on_a_decrease, one_stitch_torus])
def test_round_trip_is_the_identity(tmp_path, make):
    fabric = make()
    write_stitches(tmp_path / "s.h5", fabric)
    again = read_stitches(tmp_path / "s.h5")
    assert type(again) is StitchMesh
    for field in dataclasses.fields(StitchMesh):
        written, read = getattr(fabric, field.name), getattr(again, field.name)
        if field.name == "lattice" and written is not None:
            written, read = written.periods, read.periods
        np.testing.assert_array_equal(read, written, err_msg=field.name)
        np.testing.assert_array_equal(getattr(make(), field.name) is None, read is None, err_msg=field.name)


@pytest.mark.parametrize(
    ("name", "values", "message"),
    [
        ("twin", None, "dataset 'twin' is missing"),
        ("twin", [-1, -1, -1, 4, -1, 3, -1, -1, -1, -1], "is not the same edge reversed"),
        ("stitch", [1, 1], "knit on 2 bottom and 1 top sides"),
        ("face_vertex", [0, 1, 2, 3, 4, 4, 3, 5, 6, 99], "vertex 99 does not exist"),
        ("stretch", [1.0], "stretch: got shape (1,)"),
        ("row", ["a", "b"], "dataset 'row' holds object; expected int64"),
    ],
)
def test_each_damaged_file_gets_its_message(tmp_path, name, values, message):
    path = tmp_path / "s.h5"
    write_stitches(path, increase_on_a_decrease())
    with h5py.File(path, "r+") as file:
        del file[name]
        if values is not None:
            file[name] = values
    with refused(path, message):
        read_stitches(path)


def test_a_group_instead_of_a_dataset_is_an_error(tmp_path):
    write_stitches(tmp_path / "s.h5", increase_on_a_decrease())
    with h5py.File(tmp_path / "s.h5", "r+") as file:
        del file["row"]
        file.create_group("row")
    with pytest.raises(FileError, match="'row' is a group; expected a dataset"):
        read_stitches(tmp_path / "s.h5")


def test_reading_yarns_as_stitches_is_an_error(tmp_path):
    write_yarns(tmp_path / "y.h5", YarnSet.from_curves([np.eye(3)], closed=[True], radius=0.1))
    with pytest.raises(FileError, match="holds 'stitchmesh yarns'; expected 'stitchmesh stitches'"):
        read_stitches(tmp_path / "y.h5")


def test_other_suffixes_are_errors(tmp_path):
    with pytest.raises(FileError, match=r"unknown format '.obj'; expected one of .h5"):
        write_stitches(tmp_path / "s.obj", increase_on_a_decrease())
    with pytest.raises(FileError, match="no such file"):
        read_stitches(tmp_path / "s.h5")
