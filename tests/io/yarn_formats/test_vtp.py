# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""VTP files hold polylines on the yarns; the tests read the files with VTK's own reader."""

from __future__ import annotations

import numpy as np
import pytest
import pyvista

from stitchmesh.io import read_yarns, write_yarns
from tests.io.refusals import refused
from tests.io.yarn_sets import awkward_yarns

SAMPLES = 4


def lines_of(data: pyvista.PolyData) -> list[np.ndarray]:
    cells = data.lines
    lines = []
    while len(cells):
        lines.append(cells[1 : cells[0] + 1])
        cells = cells[cells[0] + 1 :]
    return lines


def test_each_yarn_is_a_polyline_and_closed_ones_end_with_their_first_point(tmp_path):
    yarns = awkward_yarns()
    write_yarns(tmp_path / "y.vtp", yarns)
    data = pyvista.read(tmp_path / "y.vtp")
    lines = lines_of(data)
    assert len(lines) == yarns.yarn_count
    assert [line[0] == line[-1] for line in lines] == yarns.closed.tolist()
    for line, sampled in zip(lines, yarns.sampled(SAMPLES), strict=True):
        tolerance = 1e-13 * np.abs(sampled).max()  # The same sums in another order.
        np.testing.assert_allclose(data.points[line[: len(sampled)]], sampled, rtol=0, atol=tolerance)


def test_points_have_the_arrays_of_their_yarns(tmp_path):
    yarns = awkward_yarns()
    write_yarns(tmp_path / "y.vtp", yarns)
    data = pyvista.read(tmp_path / "y.vtp")
    np.testing.assert_array_equal(data.cell_data["yarn"], [0, 1, 2, 3])
    for yarn, line in enumerate(lines_of(data)):
        assert set(data.point_data["yarn"][line]) == {yarn}
        assert set(data.point_data["radius"][line]) == {yarns.radius[yarn]}
        # Segment k starts near its second control point, which is k + 1 of its yarn.
        first = yarns.start[yarn] + 1
        own = line[:-1:SAMPLES] if yarns.closed[yarn] else line[::SAMPLES]
        expected = first + np.arange(len(own))
        if yarns.closed[yarn]:
            expected[-1] = yarns.start[yarn]
        for name in ("row", "face", "part"):
            np.testing.assert_array_equal(data.point_data[name][own], getattr(yarns, name)[expected])
        segments = np.arange(yarns.segment_start[yarn], yarns.segment_start[yarn + 1])
        strain = data.point_data["strain"][line[: SAMPLES * len(segments)]]
        np.testing.assert_array_equal(strain, np.repeat(yarns.strain[segments], SAMPLES))


def test_polylines_are_read_with_their_radius(tmp_path):
    yarns = awkward_yarns()
    write_yarns(tmp_path / "y.vtp", yarns, unit="inch")
    again = read_yarns(tmp_path / "y.vtp", unit="inch")
    np.testing.assert_array_equal(again.closed, yarns.closed)
    np.testing.assert_allclose(again.radius, yarns.radius, rtol=1e-15)  # The conversion to inches and back.
    for read, written in zip(again.sampled(1), yarns.sampled(SAMPLES), strict=True):
        np.testing.assert_allclose(read, written, atol=1e-12 * np.abs(written).max())  # A linear system in float64.
    np.testing.assert_array_equal(read_yarns(tmp_path / "y.vtp", unit="inch", radius=0.5).radius, [0.5] * 4)


def vtp(connectivity: str = "0 1 2 3", offsets: str = "2 4", points: str = "0 0 0 1 0 0 0 1 0 1 1 0") -> str:
    """Return a file of four points with radii, the last of them negative, on two lines."""
    array = '<DataArray type="{}" Name="{}" NumberOfComponents="{}" format="ascii">{}</DataArray>'
    return f"""<VTKFile type="PolyData" version="1.0"><PolyData>
<Piece NumberOfPoints="4" NumberOfVerts="0" NumberOfLines="2" NumberOfStrips="0" NumberOfPolys="0">
<PointData>{array.format("Float64", "radius", 1, "1 1 1 -1")}</PointData>
<Points>{array.format("Float64", "Points", 3, points)}</Points>
<Lines>{array.format("Int64", "connectivity", 1, connectivity)}{array.format("Int64", "offsets", 1, offsets)}</Lines>
</Piece></PolyData></VTKFile>"""


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("garbage", "is not a valid VTP file; it was cut short or altered"),
        (vtp(connectivity="0 1 3 2"), "radius 1: got -1.0; expected a positive number of cm"),
        (vtp(connectivity="0 1 0 3", offsets="3 4"), "line 0 has 3 points; expected at least 4"),
        (vtp(offsets="3 4"), "line 1 has 1 points; expected at least 2"),
        (vtp(connectivity="0 1 2 4"), "a line names point 4; the file has 4 points"),
        (vtp(connectivity="0 1 -2 3"), "a line names point -2; the file has 4 points"),
        (vtp(offsets="5 4"), "is not a valid VTP file"),
        (vtp(offsets="2 9"), "is not a valid VTP file"),
        (vtp(points="0 0 0 1 0 0 0 nan 0 1 1 0"), "point 2 is [0.0, nan, 0.0]; coordinates must be finite"),
    ],
)
def test_each_invalid_file_gets_its_message(tmp_path, text, message):
    (tmp_path / "y.vtp").write_text(text)
    with refused(tmp_path / "y.vtp", message):
        read_yarns(tmp_path / "y.vtp")
