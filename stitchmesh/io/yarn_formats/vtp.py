# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns as polylines in VTK's XML format of poly data (``.vtp``), for example for ParaView.

The polyline of a closed yarn ends with its first point. The points have the arrays ``yarn``, ``colour``, ``rgb``,
``row``, ``face``, ``part``, ``radius``, ``drawn_radius`` and ``strain``, by which ParaView can colour them and give
tubes their radius; polylines have ``yarn`` and ``colour``. ``rgb`` is the sRGB colour of the yarn in three bytes.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from os import fspath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import FileError
from stitchmesh.io.atomic import write_text
from stitchmesh.io.contents import FilePath, read_bytes
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mesh.palette import colours_of
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.polyline import polylines_of_segments

READ_ARRAYS = ("radius", "drawn_radius", "colour", "rgb")
"""Arrays of the points that are read."""


@dataclass(frozen=True)
class VtpPolylines:
    """The polylines of a VTP file."""

    curves: list[FloatArray]
    """Points of each polyline in the file's unit, shape (n, 3) each; a closed one does not repeat its first point."""
    closed: list[bool]
    """Whether each polyline is closed."""
    radius: FloatArray | None
    """Radius of each polyline in the file's unit; None if the points have no such array."""
    colour: IntArray | None
    """Number of the colour of each polyline; None if the points have no such array."""
    drawn_radius: FloatArray | None
    """Apparent radius of each polyline in the file's unit; None if the points have no such array."""
    rgb: NDArray[np.uint8] | None
    """sRGB colour of each polyline, shape (c, 3); None if the points have no such array."""


def write_vtp(path: FilePath, yarns: YarnSet, scale: float, samples: int) -> None:
    """Write yarns as polylines.

    Args:
        path: a ``.vtp`` file.
        yarns: a set without a lattice.
        scale: number of centimetres in the file's unit.
        samples: number of points for each spline segment.

    Raises:
        FileError: the file cannot be written.
    """
    import pyvista

    curves = polylines_of_segments(yarns, np.arange(len(yarns.segment_points)), samples)
    data = pyvista.PolyData(np.concatenate(curves.points) / scale, lines=_cells(curves.points, curves.closed))
    yarn = yarns.segment_yarn[curves.segment]
    data.point_data["yarn"] = yarn
    data.point_data["colour"] = yarns.colour[yarn]
    data.point_data["rgb"] = colours_of(yarns.colour, yarns.palette)[yarn]
    for name in ("row", "face", "part"):
        data.point_data[name] = getattr(yarns, name)[curves.control_point]
    data.point_data["radius"] = yarns.radius[yarn] / scale
    data.point_data["drawn_radius"] = yarns.drawn_radius[yarn] / scale
    data.point_data["strain"] = yarns.strain[curves.segment]
    data.cell_data["yarn"] = curves.yarn
    data.cell_data["colour"] = yarns.colour[curves.yarn]
    write_poly_data(path, data)


def write_poly_data(path: FilePath, data: Any) -> None:
    """Write an object of VTK's class ``vtkPolyData``.

    Raises:
        FileError: the file cannot be written.
    """
    from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter

    writer = vtkXMLPolyDataWriter()
    writer.SetInputData(data)
    writer.SetDataModeToBinary()
    writer.WriteToOutputStringOn()
    writer.Write()
    write_text(path, writer.GetOutputString())


def poly_data(path: FilePath) -> Any:
    """Read an object of VTK's class ``vtkPolyData``.

    Raises:
        FileError: the file cannot be read or is malformed.
    """
    from vtkmodules.vtkIOXML import vtkXMLPolyDataReader

    name = fspath(path)
    read_bytes(path)
    reader = vtkXMLPolyDataReader()
    reader.SetFileName(name)
    with _quiet():
        whole = reader.GetExecutive().Update()
    if not whole or reader.GetErrorCode():
        raise FileError(f"{name}: is not a valid VTP file; it was cut short or altered")
    return reader.GetOutput()


def read_vtp(path: FilePath) -> VtpPolylines:
    """Read the polylines of a VTP file.

    Raises:
        FileError: the file cannot be read, is malformed, or has no polylines.
    """
    name = fspath(path)
    points, starts, corners, numbers = _content(path)
    if len(starts) < 2:
        raise FileError(f"{name}: has no lines; expected polylines, one for each yarn")
    unknown = corners[(corners < 0) | (corners >= len(points))]
    if len(unknown):
        raise FileError(f"{name}: a line names point {unknown[0]}; the file has {len(points)} points")
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        raise FileError(f"{name}: point {bad[0]} is {points[bad[0]].tolist()}; coordinates must be finite")
    curves: list[FloatArray] = []
    closed: list[bool] = []
    for index, line in enumerate(np.split(corners, starts[1:-1])):
        returns = len(line) > 2 and line[0] == line[-1]
        least = 4 if returns else 2
        if len(line) < least:
            raise FileError(f"{name}: line {index} has {len(line)} points; expected at least {least}")
        curves.append(points[line[:-1] if returns else line])
        closed.append(bool(returns))
    of_line = {label: values[corners[starts[:-1]]] for label, values in numbers.items()}
    colour = of_line.get("colour")
    rgb = of_line.get("rgb")
    return VtpPolylines(
        curves, closed, of_line.get("radius"), None if colour is None else colour.astype(np.int64),
        of_line.get("drawn_radius"), None if rgb is None or rgb.ndim != 2 else rgb.astype(np.uint8),
    )  # fmt: skip


def _cells(curves: list[FloatArray], closed: list[bool]) -> IntArray:
    """Return VTK's array of cells: for each polyline the number of its points, and then the points."""
    cells: list[int] = []
    first = 0
    for points, returns in zip(curves, closed, strict=True):
        end = first + len(points)
        cells += [len(points) + returns, *range(first, end), *([first] if returns else [])]
        first = end
    return np.array(cells, dtype=np.int64)


def _content(path: FilePath) -> tuple[FloatArray, IntArray, IntArray, dict[str, FloatArray]]:
    """Read a VTP file.

    Returns:
        Points, shape (P, 3); the start of each line in the next array, with its end, shape (L + 1,); the points of all
        lines, shape (C,); and the arrays of ``READ_ARRAYS`` of the points that the file has.
    """
    from vtkmodules.util.numpy_support import vtk_to_numpy

    data = poly_data(path)
    lines = data.GetLines()
    if data.GetPoints() is None or lines.GetNumberOfCells() == 0:
        return np.empty((0, 3)), np.zeros(1, dtype=np.int64), np.empty(0, dtype=np.int64), {}
    points = vtk_to_numpy(data.GetPoints().GetData()).astype(np.float64)
    starts = vtk_to_numpy(lines.GetOffsetsArray()).astype(np.int64)
    corners = vtk_to_numpy(lines.GetConnectivityArray()).astype(np.int64)
    arrays = {name: data.GetPointData().GetArray(name) for name in READ_ARRAYS}
    numbers = {name: vtk_to_numpy(array).astype(np.float64) for name, array in arrays.items() if array is not None}
    return points, starts, corners, numbers


@contextmanager
def _quiet() -> Iterator[None]:
    """Suppress VTK's warnings, which are several pages long for a malformed file."""
    from vtkmodules.vtkCommonCore import vtkObject

    before = vtkObject.GetGlobalWarningDisplay()
    vtkObject.GlobalWarningDisplayOff()
    try:
        yield
    finally:
        vtkObject.SetGlobalWarningDisplay(before)
