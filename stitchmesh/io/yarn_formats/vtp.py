# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Yarns as polylines in VTK's XML format of poly data (``.vtp``), for example for ParaView.

The polyline of a closed yarn ends with its first point. The points have the arrays ``yarn``, ``colour``, ``rgb``,
``row``, ``face``, ``part``, ``radius``, ``drawn_radius`` and ``strain``, by which ParaView can colour them and give
tubes their radius; polylines have ``yarn`` and ``colour``. ``rgb`` is the sRGB colour of the yarn in three bytes.
"""

from __future__ import annotations

from dataclasses import dataclass
from os import fspath
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stitchmesh.errors import FileError
from stitchmesh.io.atomic import write_text
from stitchmesh.io.contents import FilePath, check_points
from stitchmesh.io.vtk_xml import VtkPoints, read_vtk_points
from stitchmesh.mesh import FloatArray, IntArray
from stitchmesh.mesh.palette import colours_of
from stitchmesh.yarn import YarnSet
from stitchmesh.yarn.polyline import polylines_of_segments

if TYPE_CHECKING:
    import pyvista

POINTS_PER_SEGMENT = 4
"""Number of points for each spline segment where yarns are polylines."""
COLUMNS: dict[str, tuple[int, ...]] = {"radius": (), "drawn_radius": (), "colour": (), "rgb": (3,)}
"""Arrays of the points that are read, and their components, if they have more than one."""


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


def write_vtp(path: FilePath, yarns: YarnSet, scale: float) -> None:
    """Write yarns as polylines.

    Args:
        path: a ``.vtp`` file.
        yarns: a set without a lattice.
        scale: number of centimetres in the file's unit.

    Raises:
        FileError: the file cannot be written.
    """
    write_poly_data(path, poly_data_of_yarns(yarns, scale))


def poly_data_of_yarns(yarns: YarnSet, scale: float) -> pyvista.PolyData:
    """Return yarns as polylines; the arguments are the same as for ``write_vtp``."""
    import pyvista

    curves = polylines_of_segments(yarns, np.arange(len(yarns.segment_points)), POINTS_PER_SEGMENT)
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
    return data


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


def read_vtp(path: FilePath) -> VtpPolylines:
    """Read the polylines of a VTP file.

    Raises:
        FileError: the file cannot be read, is malformed, or has no polylines.
    """
    name, data = fspath(path), read_vtk_points(path, "PolyData", ["Lines"])
    points, lines = data.points, data.cells["Lines"]
    if len(lines.start) < 2:
        raise FileError(f"{name}: has no lines; expected polylines, one for each yarn")
    check_points(f"{name}: point", points)
    curves: list[FloatArray] = []
    closed: list[bool] = []
    for index, line in enumerate(np.split(lines.point, lines.start[1:-1])):
        returns = len(line) > 2 and line[0] == line[-1]
        least = 4 if returns else 2
        if len(line) < least:
            raise FileError(f"{name}: line {index} has {len(line)} points; expected at least {least}")
        curves.append(points[line[:-1] if returns else line])
        closed.append(bool(returns))
    first = lines.point[lines.start[:-1]]
    of_line = {label: data.at_points[label][first] for label in COLUMNS if _is_held(data, label)}
    colour, rgb = of_line.get("colour"), of_line.get("rgb")
    return VtpPolylines(
        curves,
        closed,
        radius=of_line.get("radius"),
        # Up to 2**53, float64 holds every whole number.
        colour=None if colour is None else _whole(name, "colour", colour, 2**53).astype(np.int64),
        drawn_radius=of_line.get("drawn_radius"),
        rgb=None if rgb is None else _whole(name, "rgb", rgb, 255).astype(np.uint8),
    )


def _is_held(data: VtkPoints, label: str) -> bool:
    """Return whether the points have an array of a name, of the expected shape."""
    return label in data.at_points and data.at_points[label].shape[1:] == COLUMNS[label]


def _whole(name: str, label: str, values: FloatArray, largest: int) -> FloatArray:
    """Check whole numbers from 0."""
    bad = values[~((values >= 0) & (values <= largest) & (values == np.round(values)))]
    if bad.size:
        raise FileError(f"{name}: {label} is {bad.flat[0]:g}; expected whole numbers from 0 to {largest}")
    return values


def _cells(curves: list[FloatArray], closed: list[bool]) -> IntArray:
    """Return VTK's array of cells: for each polyline the number of its points, and then the points."""
    cells: list[int] = []
    first = 0
    for points, returns in zip(curves, closed, strict=True):
        end = first + len(points)
        cells += [len(points) + returns, *range(first, end), *([first] if returns else [])]
        first = end
    return np.array(cells, dtype=np.int64)
