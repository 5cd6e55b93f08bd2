# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""A file of any format that was cut short is an error of a line, wherever it was cut."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import pytest
import pyvista

from stitchmesh.io import read_mesh, read_stitches, read_yarns, write_mesh, write_stitches, write_yarns
from stitchmesh.io.yarn_formats.usd_curves import curves_of_stage
from tests.gallery import tube
from tests.io.refusals import refused
from tests.io.stitch_formats.test_smobj import marked
from tests.io.yarn_sets import awkward_yarns


def save_poly_data(path: Path, *, binary: bool) -> None:
    points = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0.5, 0]]
    pyvista.PolyData(points, faces=[4, 0, 1, 2, 3, 3, 1, 4, 2]).save(path, binary=binary)


MESH, STITCHES, YARNS = tube(6, 2), marked(), awkward_yarns()
WHOLE = b"", b"\0no such words"
CASES = {
    "vertices of a mesh.obj": (partial(write_mesh, mesh=MESH), read_mesh, (b"", b"f ")),
    "mesh.ply": (partial(write_mesh, mesh=MESH), read_mesh, WHOLE),
    "mesh.stl": (partial(write_mesh, mesh=MESH), read_mesh, WHOLE),
    "mesh.glb": (partial(write_mesh, mesh=MESH), read_mesh, WHOLE),
    "mesh.vtp": (partial(write_mesh, mesh=MESH), read_mesh, WHOLE),
    "text.vtk": (partial(save_poly_data, binary=False), read_mesh, (b"POINTS", b"METADATA")),
    "binary.vtk": (partial(save_poly_data, binary=True), read_mesh, (b"POINTS", b"METADATA")),
    "stitches.smobj": (partial(write_stitches, fabric=STITCHES), read_stitches, WHOLE),
    "yarns.h5": (partial(write_yarns, yarns=YARNS), read_yarns, WHOLE),
    "yarns.vtp": (partial(write_yarns, yarns=YARNS), read_yarns, WHOLE),
    "yarns.usda": (partial(write_yarns, yarns=YARNS), curves_of_stage, WHOLE),
    "yarns.usdc": (partial(write_yarns, yarns=YARNS), curves_of_stage, WHOLE),
}
"""What writes and reads a file, and the words between which it is cut."""


@pytest.mark.parametrize("name", CASES)
def test_a_file_cut_short_is_an_error_wherever_it_is_cut(tmp_path, capfd, name):
    write, read, (first, last) = CASES[name]
    write(tmp_path / name)
    whole = (tmp_path / name).read_bytes()
    start, end = whole.index(first), whole.find(last) if last in whole else len(whole) - 40
    capfd.readouterr()
    for cut in range(start, end, max(1, (end - start) // 40)):
        path = tmp_path / f"{cut}{Path(name).suffix}"  # USD keeps what it has read of a file of the same name.
        path.write_bytes(whole[:cut])
        with refused(path):
            read(path)
    assert capfd.readouterr() == ("", "")
