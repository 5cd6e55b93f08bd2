# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""VTK's XML files: what VTK writes in any encoding is read, and no damage costs more than an error."""

from __future__ import annotations

import base64
import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
import pyvista

from stitchmesh.io.vtk_xml import read_vtk_points
from tests.io.refusals import refused


def surface() -> pyvista.PolyData:
    sphere = pyvista.Sphere(theta_resolution=8, phi_resolution=8)
    sphere.point_data["radius"] = np.linspace(0.1, 0.7, sphere.n_points)
    sphere.point_data["rgb"] = np.arange(3 * sphere.n_points, dtype=np.uint8).reshape(-1, 3)
    return sphere


@pytest.mark.parametrize("kind", ["PolyData", "UnstructuredGrid"])
@pytest.mark.parametrize("mode", ["Ascii", "Binary", "Appended"])
def test_files_that_vtk_writes_are_read(tmp_path, kind, mode):
    from vtkmodules import vtkIOXML

    data = surface()
    section = "Polys" if kind == "PolyData" else "Cells"
    writer = getattr(vtkIOXML, f"vtkXML{kind}Writer")()
    writer.SetInputData(data if kind == "PolyData" else data.cast_to_unstructured_grid())
    writer.SetFileName(str(tmp_path / "m.vtp"))
    getattr(writer, f"SetDataModeTo{mode}")()
    writer.SetBlockSize(512)  # Each array has several blocks.
    for compressor, order, header, encoded in (("None", 0, 32, 1), ("ZLib", 1, 64, 0), ("LZMA", 0, 64, 1)):
        getattr(writer, f"SetCompressorTypeTo{compressor}")()
        writer.SetByteOrder(order)
        writer.SetHeaderType(header)
        writer.SetEncodeAppendedData(encoded)
        writer.Write()
        found = read_vtk_points(tmp_path / "m.vtp", kind, [section])
        # VTK writes texts with 6 to 9 digits; binary numbers keep all bits.
        np.testing.assert_allclose(found.points, data.points, atol=1e-6 if mode == "Ascii" else 0.0)
        np.testing.assert_allclose(found.at_points["radius"], data.point_data["radius"], rtol=1e-6)
        np.testing.assert_array_equal(found.at_points["rgb"], data.point_data["rgb"])
        np.testing.assert_array_equal(found.cells[section].point, data.regular_faces.ravel())
        np.testing.assert_array_equal(found.cells[section].start, 3 * np.arange(data.n_cells + 1))


def piece(start: int) -> str:
    """Return a piece of one triangle."""
    array = '<DataArray type="{}" Name="{}" NumberOfComponents="{}" format="ascii">{}</DataArray>'
    points = f"{start} 0 0 {start} 1 0 {start} 0 1"
    return (
        f'<Piece NumberOfPoints="3" NumberOfPolys="1"><Points>{array.format("Float64", "Points", 3, points)}</Points>'
        f"<Polys>{array.format('Int64', 'connectivity', 1, '0 1 2')}{array.format('Int64', 'offsets', 1, '3')}</Polys>"
        "</Piece>"
    )


def vtp(body: str, attributes: str = "", before: str = "") -> str:
    head = f'<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" {attributes}>'
    return f"{before}{head}<PolyData>{body}</PolyData></VTKFile>"


def test_pieces_are_joined(tmp_path):
    (tmp_path / "m.vtp").write_text(vtp(piece(0) + piece(7)))
    found = read_vtk_points(tmp_path / "m.vtp", "PolyData", ["Polys"])
    np.testing.assert_array_equal(found.points[:, 0], [0, 0, 0, 7, 7, 7])
    np.testing.assert_array_equal(found.cells["Polys"].point, range(6))
    np.testing.assert_array_equal(found.cells["Polys"].start, [0, 3, 6])


def compressed_points(count: int, size: int) -> str:
    """Return a piece with ``count`` points whose compressed numbers are ``size`` bytes of zeros."""
    packed = zlib.compress(bytes(size))
    text = b"".join(map(base64.b64encode, (struct.pack("<4I", 1, size, 0, len(packed)), packed))).decode()
    array = f'<DataArray type="Float64" NumberOfComponents="3" format="binary">{text}</DataArray>'
    return f'<Piece NumberOfPoints="{count}"><Points>{array}</Points></Piece>'


ZLIB = 'compressor="vtkZLibDataCompressor"'
ENTITIES = '<!DOCTYPE bomb [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>'


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (vtp(piece(0).replace('Points="3"', 'Points="99999999999"', 1)), "got 3 points, expected 99999999999"),
        (vtp(piece(0).replace('Points="3"', 'Points="-3"', 1)), "got 3 points, expected -3"),
        (vtp(piece(0).replace(">3<", ">99999999999<")), "the offsets of Polys do not fit its 1 cells"),
        (vtp(piece(0).replace(">3<", f">{'9' * 5000}<")), "is not a valid VTP file"),
        (vtp(piece(0).replace("0 1 2", "0 1 9")), "a face names point 9; the file has 3 points"),
        (vtp(compressed_points(10**7, 24 * 10**7), ZLIB), "states 240000000 bytes of numbers"),
        (vtp(compressed_points(1, 48).replace('Points="1"', 'Points="2"'), ZLIB)[:-60], "is not a valid VTP file"),
        (vtp(piece(0), 'compressor="vtkLZ4DataCompressor"'), "it is compressed by vtkLZ4DataCompressor"),
        (vtp(piece(0), before=ENTITIES), "it declares a document type"),
        (vtp("<a>" * 5000 + "</a>" * 5000), "elements lie more than 20 deep"),
        (vtp(piece(0)).replace("PolyData", "ImageData"), "the root is VTKFile of type ImageData"),
        (vtp(piece(0).replace("ascii", "appended")), "'offset'"),
    ],
)
def test_each_damage_is_an_error_of_one_line(tmp_path, text, message):
    path: Path = tmp_path / "m.vtp"
    path.write_text(text)
    with refused(path, message):
        read_vtk_points(path, "PolyData", ["Polys"])
