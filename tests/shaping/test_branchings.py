# SPDX-FileCopyrightText: StitchMesh contributors
# SPDX-License-Identifier: Apache-2.0
"""Limbs that join and part within one row: one more row lies between, and every hole of the surface stays."""

from __future__ import annotations

import numpy as np
import pytest

import stitchmesh as sm
from stitchmesh.mesh import FloatArray, Mesh
from stitchmesh.shaping.branchings import branchings, with_joins_and_parts_apart
from stitchmesh.shaping.ends import End, Ends
from stitchmesh.shaping.level_lines import LevelLines, level_lines
from stitchmesh.shaping.triangle_surface import TriangleSurface, divided
from stitchmesh.yarngen.loop_check.loop_linking import check_loops
from tests.shaping.surfaces import double_sheet, sheet, surface_of, tube_with_holes

CHEESE_TUBE = tube_with_holes("############ ##.####.###. #####.###.## #.#######.## ############", 3.5)
"""Holes that begin where others end."""
CHEESE = double_sheet("######### ##.###.## ####.#### ##.###.## #########", 3.0, 4.0)
"""Tubes that join at the height at which others part."""


@pytest.mark.decides
@pytest.mark.parametrize(("mesh", "width"), [(CHEESE_TUBE, 1.6), (CHEESE, 2.2)], ids=["holes", "equally high"])
def test_limbs_that_join_and_part_in_one_row_are_knitted(mesh, width):
    shaped = sm.shape_fabric(mesh, stitch_width=width, progress=False)
    assert not shaped.report.lost  # as many borders, handles and parts as the surface has
    relaxed = sm.make_room(sm.relax_mesh(shaped.fabric, surface=shaped.surface_mesh).fabric, quality="draft").fabric
    check_loops(relaxed, sm.generate_yarns(relaxed, quality="draft"))


def upright(mesh: Mesh, middle: float, join: float, part: float) -> tuple[TriangleSurface, FloatArray, Ends]:
    """A surface with its height as the time, from its lowest to its highest border.

    The time is a little smaller beside the middle at the height of a join, and larger at that of a part, so that their
    level sides are saddles at one vertex.
    """
    surface = divided(surface_of(mesh), 0.3)
    height = surface.vertices[:, 1]
    tilt = -0.02 * np.cos(np.pi * (height - join) / (part - join))
    time = height + tilt * (np.abs(surface.vertices[:, 0] - middle) - np.abs(surface.vertices[:, 2]))
    ends = [np.flatnonzero(height == side) for side in (height.min(), height.max())]
    for vertices in ends:
        time[vertices] = height[vertices]
    return surface, time, Ends((End(ends[0]),), (End(ends[1]),))


def is_mixed(levels: LevelLines) -> bool:
    return any(len(band.below) > 1 and len(band.above) > 1 for band in levels.bands)


def test_a_join_and_a_part_are_told_at_a_border():
    # A hole from 1.5 to 3 in a frame of 5: one line parts into two at its foot, and two join at its head.
    surface, time, ends = upright(sheet("### #.# ### ###", 1.5), 2.25, join=4.5, part=3.0)
    found = branchings(surface, time, ends, 3)
    assert not len(found.joins) and surface.vertices[found.parts, 1].tolist() == [3.0]
    found = branchings(surface, time, ends, 4)
    assert not len(found.parts) and surface.vertices[found.joins, 1].tolist() == [4.5]


def test_a_level_comes_between_a_join_and_a_part_of_one_row():
    # Two legs join at 1.2 and part at 1.8: the bar between them lies in the row from 1 to 2.
    mesh = double_sheet("##..## ##..## ##..## ###### ##..## ##..##", 0.6, 0.5)
    surface, time, ends = upright(mesh, 1.8, join=1.2, part=1.8)
    time[ends.others[0].vertices] = 4.0  # a whole number, 0.4 above the highest border
    assert is_mixed(level_lines(surface, time, ends))
    levels, stretched = with_joins_and_parts_apart(surface, time, ends, 1.0)
    assert not is_mixed(levels)
    # One more row in all; what is earlier stays earlier, and the ends of rows stay at whole numbers.
    assert stretched.min() == 0.0 and stretched.max() == 5.0
    assert (np.diff(stretched[np.argsort(time, kind="stable")]) >= 0.0).all()


def test_a_time_without_such_rows_stays():
    surface, time, ends = upright(sheet("### #.# ### ###", 1.5), 2.25, join=4.5, part=3.0)
    assert with_joins_and_parts_apart(surface, time, ends, 1.0)[1] is time
